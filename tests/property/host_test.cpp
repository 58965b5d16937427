// SPDX-License-Identifier: Apache-2.0
// A scene that a host hands over, frame by frame, gives the same bytes and leaves out as many shadow rays as the same
// scene with the same declarations loaded from a file.
#include <gtest/gtest.h>

#include <fstream>

#include "host_copy.h"
#include "io/load.h"
#include "same_frames.h"
#include "scene/builtin/builtin.h"
#include "scene/defaults/emissive_lights.h"
#include "support.h"

namespace gnomon {
namespace {

// Renders frames of a scene by its tracks, and as a host would, and compares them.
void compare_frames(const std::shared_ptr<const scene::Scene>& read, const RenderOptions& options, int first, int last,
                    int step = 1)
{
    // Give the file's scene what load() gives it.
    auto completed = std::make_shared<scene::Scene>(*read);
    scene::add_emitter_lights(*completed);
    scene::add_default_light(*completed);
    scene::add_default_camera(*completed);
    const Scene from_file = api::public_scene(completed);
    test::HostCopy copy(read);
    const Scene from_host = copy.builder().finish({.default_light = true});

    Renderer of_file(options), of_host(options);
    for (int frame = first; frame <= last; frame += step) {
        const Frame expected = of_file.render(from_file, frame);
        FrameInput input = copy.input_at(from_file.time_of(frame));
        input.camera = of_file.camera();
        const Frame got = of_host.render(from_host, input);
        ASSERT_NO_FATAL_FAILURE(test::expect_same(got, expected)) << frame;
        EXPECT_EQ(got.counters.shadow.rays, expected.counters.shadow.rays) << frame;
        EXPECT_EQ(got.counters.shadow.rays_skipped, expected.counters.shadow.rays_skipped) << frame;
        EXPECT_EQ(got.counters.shadow.rays_dynamic_only, expected.counters.shadow.rays_dynamic_only) << frame;
        EXPECT_EQ(got.counters.indirect.rays, expected.counters.indirect.rays) << frame;
        EXPECT_EQ(got.counters.update.began_anew, frame == first) << frame;
    }
}

std::shared_ptr<const scene::Scene> read_file(const std::filesystem::path& file)
{
    return std::make_shared<const scene::Scene>(io::load_scene(file.string(), {}));
}

RenderOptions small(int width, int height)
{
    RenderOptions options;
    options.size = {width, height};
    options.layers = true;
    return options;
}

TEST(Host, SameBytesAndShadowRaysAsTheBuiltInBox)
{
    compare_frames(std::make_shared<const scene::Scene>(scene::make_builtin("cornell")), small(80, 80), 1, 12);
}

TEST(Host, SameBytesAsTheBuiltInBoxWithTheLightQuadTree)
{
    RenderOptions options = small(64, 64);
    options.indirect = Indirect::quadtree;
    compare_frames(std::make_shared<const scene::Scene>(scene::make_builtin("cornell")), options, 1, 6);
}

TEST(Host, SameBytesAndShadowRaysAsBoxAnimated)
{
    GNOMON_NEED_SCENE(file, "gltf/BoxAnimated.glb");
    compare_frames(read_file(file), small(96, 64), 1, 40, 3);
}

TEST(Host, SameBytesAndShadowRaysAsABendingTube)
{
    GNOMON_NEED_SCENE(file, "real/RiggedSimple/RiggedSimple.gltf");
    // Light that the tube sends to itself is resolved by light views, which cover the clip of a file. A host has not
    // told of what comes.
    compare_frames(read_file(file), small(64, 96), 1, 1);
    RenderOptions direct = small(64, 96);
    direct.indirect = Indirect::off;
    compare_frames(read_file(file), direct, 1, 12, 2);
}

// A tetrahedron that grows, and one whose morph never changes.
std::filesystem::path morphing_file(const test::ScratchFolder& folder)
{
    const std::vector<float> floats = {0, 0, 0, 1,    0, 0, 0, 1, 0,    0, 0,    1,   // positions
                                       0, 0, 0, 0.5f, 0, 0, 0, 1, 0.3f, 0, 0.2f, 1,   // offsets of the target
                                       0, 1,                                          // times
                                       0, 1};                                         // weights
    const std::vector<std::uint16_t> indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    std::ofstream(folder / "morph.bin", std::ios::binary)
        .write(reinterpret_cast<const char*>(floats.data()), std::ssize(floats) * 4)
        .write(reinterpret_cast<const char*>(indices.data()), std::ssize(indices) * 2);
    std::ofstream(folder / "morph.gltf")
        << R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":136,"uri":"morph.bin"}],
        "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":48},
            {"buffer":0,"byteOffset":96,"byteLength":8},{"buffer":0,"byteOffset":104,"byteLength":8},
            {"buffer":0,"byteOffset":112,"byteLength":24}],
        "accessors":[{"bufferView":0,"type":"VEC3","componentType":5126,"count":4,"min":[0,0,0],"max":[1,1,1]},
            {"bufferView":1,"type":"VEC3","componentType":5126,"count":4,"min":[0,0,0],"max":[0.5,1,1]},
            {"bufferView":2,"type":"SCALAR","componentType":5126,"count":2,"min":[0],"max":[1]},
            {"bufferView":3,"type":"SCALAR","componentType":5126,"count":2},
            {"bufferView":4,"type":"SCALAR","componentType":5123,"count":12}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":4,"targets":[{"POSITION":1}]}],"weights":[0.25]}],
        "nodes":[{"mesh":0},{"mesh":0,"translation":[-2,0,0]}],
        "animations":[{"channels":[{"sampler":0,"target":{"node":0,"path":"weights"}}],
            "samplers":[{"input":2,"output":3}]}]})";
    return folder / "morph.gltf";
}

TEST(Host, SameBytesAndShadowRaysAsAMorphingMesh)
{
    const test::ScratchFolder folder;
    compare_frames(read_file(morphing_file(folder)), small(64, 48), 1, 25, 3);
}

TEST(Host, SameBytesAndShadowRaysAsKitchen)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    compare_frames(read_file(file), small(48, 48), 118, 130, 2);
}

TEST(HostFull, SameBytesAndShadowRaysAsAllOfKitchen)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    compare_frames(read_file(file), small(48, 48), 1, 800);
}

}   // namespace
}   // namespace gnomon
