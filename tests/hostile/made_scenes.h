// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scenes that are bad in a way that happens, or that somebody would think of: made by code, hundreds of them, each with
// what must come of it.
//
// Each begins as a small scene that is sound and holds something of everything; then one thing in it is made wrong. So
// what is refused is refused for that one thing, and what is accepted has a camera, a light and a surface to show.

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace gnomon::test {

enum class Expected {
    image,     // exit code 0, every number in the OpenEXR finite
    refused,   // exit code 3, one line
    either     // one of them, or one line and exit code 4 for want of memory, or 2 for lights an .exr has no room for
};

struct MadeScene {
    std::string name;   // "gltf/cycle of two nodes"
    Expected expected = Expected::either;
    std::string main;   // "scene.gltf", "aff/scene.aff"
    /// By their names; made when they are asked for, since some are large.
    std::function<std::map<std::string, std::string>()> files;
};

std::vector<MadeScene> made_gltf_scenes();
std::vector<MadeScene> made_obj_scenes();
std::vector<MadeScene> made_aff_scenes();

/// PNG of a size that its header claims; its pixels are there only if `whole`.
std::string made_png(unsigned width, unsigned height, bool whole);
/// PPM, the same.
std::string made_ppm(unsigned width, unsigned height, bool whole);

}   // namespace gnomon::test
