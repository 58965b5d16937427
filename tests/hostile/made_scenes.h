// SPDX-License-Identifier: Apache-2.0
#pragma once
// Hundreds of malformed scenes made by code, each with the expected outcome. Each starts as a small valid scene that
// covers all features; then one thing in it is made wrong. So a refused scene is refused for that one reason, and an
// accepted scene has a camera, a light and a visible surface.

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace gnomon::test {

enum class Expected {
    image,     // exit code 0, all values in the OpenEXR finite
    refused,   // exit code 3, one line
    either     // image or refused; or one line and exit code 4 (memory) or 2 (too many lights for an .exr)
};

struct MadeScene {
    std::string name;   // "gltf/cycle of two nodes"
    Expected expected = Expected::either;
    std::string main;   // "scene.gltf", "aff/scene.aff"
    /// File contents by name; made on demand, because some are large.
    std::function<std::map<std::string, std::string>()> files;
};

std::vector<MadeScene> made_gltf_scenes();
std::vector<MadeScene> made_obj_scenes();
std::vector<MadeScene> made_aff_scenes();

/// A PNG with the given size in its header; its pixels are complete only if `whole`.
std::string made_png(unsigned width, unsigned height, bool whole);
/// The same as PPM.
std::string made_ppm(unsigned width, unsigned height, bool whole);

}   // namespace gnomon::test
