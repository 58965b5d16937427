// SPDX-License-Identifier: Apache-2.0
#pragma once
// Compares the quad-tree with sampling at equal error and at equal time, the main result of [Ki and Oh 2007, Figure 9].

#include <string>

#include "bench/indirect/bench.h"

namespace gnomon::bench {

inline constexpr int k_indirect_levels[] = {6, 5, 4};
inline constexpr int k_indirect_samples[] = {8, 24, 64, 128, 256, 512, 1024, 2040};
inline constexpr double k_published_radius = 0.3;   // radius of the disk [Dachsbacher and Stamminger 2005]
inline constexpr double k_wide_radius = 1;          // covers the map from nearly every point of it

/// Names of methods, as bench indirect takes them.
std::string quadtree_name(int level);
std::string rsm_name(int samples, double radius);

/// @return null if there is none
const IndirectRow* find_row(const std::vector<IndirectRow>& rows, const std::string& method,
                            const IndirectSettings& settings);

/// Sampling with a number of samples; times in milliseconds of process CPU time.
struct Sampled {
    double samples = 0, error = 0, kept = 0, not_kept = 0;
};
/// The measured rows of sampling within k_wide_radius, fewest samples first.
std::vector<Sampled> sampled_rows(const std::vector<IndirectRow>& rows, const IndirectSettings& settings);

/// Sampling interpolated between two measured numbers of samples, linearly in the logarithms.
struct SampledAt {
    Sampled at;
    const char* beyond = "";   // "< " or "> " if the value lies beyond that end of the measured range
};
/// Sampling whose error against all texels is `error`. @param list  two or more entries
SampledAt sampled_of_error(const std::vector<Sampled>& list, double error);
/// Sampling whose time is `ms` with buffers not kept.
SampledAt sampled_of_time(const std::vector<Sampled>& list, double ms);

}   // namespace gnomon::bench
