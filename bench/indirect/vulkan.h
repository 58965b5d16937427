// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs the quad-tree and sampling on a Vulkan device for bench indirect: draws the light maps, builds the trees and
// gathers there. Without Vulkan, every function throws MissingError.
//
// Times are the device's, for light map, tree, cut and gather; they exclude uploading surfaces and reading back light.

#include "bench/indirect/methods.h"

namespace gnomon::bench {

/// @throws MissingError  if built without Vulkan, without a suitable device, or with too little memory
std::unique_ptr<IndirectMethod> make_vulkan_map_method(const light_quadtree::MapLightOptions& options,
                                                       const scene::SceneState& state, const ray::RayScene& rays,
                                                       Tasks& tasks);

inline constexpr Size k_large_gather_size{1920, 1080};

/// The time of the gather alone at every pixel of a large image.
struct LargeGather {
    Size size;
    int clusters = 1024;
    double ms = 0;
};
/// Measures it with the clusters of limit level 4, repeated up to LargeGather::clusters.
/// @throws MissingError  as above
LargeGather measure_large_gather(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                                 Tasks& tasks);

/// @throws MissingError  as above
std::string vulkan_device_name();

}   // namespace gnomon::bench
