// SPDX-License-Identifier: Apache-2.0
#pragma once
// Light maps on a Vulkan device as bench indirect measures them: the quad-tree and sampling, drawn, built and gathered
// there. There whether Vulkan is built in or not.
//
// Times are the device's, of light map, tree, cut and gather; surfaces are sent and light is read back outside of them.

#include "bench/indirect/methods.h"

namespace gnomon::bench {

/// @throws MissingError  built without Vulkan, no suitable device, or too little memory
std::unique_ptr<IndirectMethod> make_vulkan_map_method(const light_quadtree::MapLightOptions& options,
                                                       const scene::SceneState& state, const ray::RayScene& rays,
                                                       Tasks& tasks);

inline constexpr Size k_large_gather_size{1920, 1080};

/// The gather alone at every pixel of a large image.
struct LargeGather {
    Size size;
    int clusters = 1024;
    double ms = 0;
};
/// The clusters are those of limit level 4, repeated up to that number.
/// @throws MissingError  as above
LargeGather measure_large_gather(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                                 Tasks& tasks);

/// @throws MissingError  as above
std::string vulkan_device_name();

}   // namespace gnomon::bench
