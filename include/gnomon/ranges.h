// SPDX-License-Identifier: Apache-2.0
#pragma once
// The ranges of numeric options, both ends included. Renderer, comparison and command line check against these.

#include <cstdint>

namespace gnomon {

/// A range of numbers, both ends included.
struct Range {
    double low = 0, high = 0;
    /// Whether the value is in the range; false for NaN.
    constexpr bool contains(double value) const { return value >= low && value <= high; }
};

/// The ranges, named as the members of RenderOptions, ReferenceLightOptions and CompareOptions.
namespace ranges {
inline constexpr Range image_side{1, 32768};                    // pixels
inline constexpr std::int64_t k_max_pixels = 256'000'000;       // of one image: 3 GB of colour alone
inline constexpr std::int64_t k_most_vertices = 1 << 28;        // of one mesh: 3 GB of positions
inline constexpr std::int64_t k_most_triangles = 1 << 28;       // likewise
inline constexpr std::int64_t k_most_mesh_parts = 1 << 24;      // of one mesh
inline constexpr std::int64_t k_most_morph_targets = 1 << 16;   // of one mesh
inline constexpr Range turntable_seconds{0.001, 1e6};           // and 0: off
inline constexpr Range sun_size{0, 45};                         // degrees
inline constexpr Range max_depth{0, 64};                        // reflections and refractions
inline constexpr Range samples{1, 4096};                        // per pixel
inline constexpr Range shutter{0, 360};                         // degrees
inline constexpr Range f_number{0.1, 1000};                     // and 0: none
inline constexpr Range aperture{0.001, 10000};                  // millimetres, and 0: none
inline constexpr Range focus{1e-6, 1e9};                        // metres
inline constexpr Range exposure{-100, 100};                     // stops
inline constexpr Range shadow_filter{0, 64};                    // texels
inline constexpr Range spp{1, 1 << 24};                         // paths per pixel
inline constexpr Range bounces{1, 1000};                        // diffuse bounces
inline constexpr Range reference_bounces{0, 1000};              // of the reference
inline constexpr Range rsm_samples{1, 65536};                   // per receiver
inline constexpr Range indirect_level{1, 7};                    // 1: every texel of a map of 512 x 512; 7: coarse
inline constexpr Range validity_margin{0, 1};                   // fraction of the thresholds
inline constexpr Range depth_threshold{0, 1};                   // fraction of the depth range
inline constexpr Range normal_threshold{-1, 1};                 // cosine
inline constexpr Range indirect_memory{1, 65536};               // MB
inline constexpr Range memory{0, 1 << 24};                      // MB; 0: no limit
inline constexpr Range time_limit{0.001, 1e9};                  // seconds
inline constexpr Range threads{0, 1024};                        // 0: all
}   // namespace ranges

}   // namespace gnomon
