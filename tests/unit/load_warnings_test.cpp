// SPDX-License-Identifier: Apache-2.0
// What a loaded scene says of itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "gnomon/gnomon.h"
#include "support.h"

namespace gnomon {
namespace {

bool warns_of_no_surface(const std::string& nodes)
{
    const test::ScratchFolder folder;
    std::ofstream(folder / "a.gltf") << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)" +
                                            nodes +
                                            R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[0,0,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"a.bin"}]})";
    std::ofstream(folder / "a.bin", std::ios::binary) << std::string(36, '\0');
    const std::vector<std::string> warnings = load(folder / "a.gltf").info().warnings;
    return std::ranges::find(warnings, "no surface in the scene: its images show the background alone") !=
           warnings.end();
}

// A file of an animation alone, for example.
TEST(LoadWarnings, AFileWithoutASurfaceSaysSo)
{
    EXPECT_TRUE(warns_of_no_surface("{}"));
    EXPECT_FALSE(warns_of_no_surface(R"({"mesh":0})"));
}

}   // namespace
}   // namespace gnomon
