// SPDX-License-Identifier: Apache-2.0
#pragma once
// The values printed by Ki and Oh (2007): frames per second at 512 x 512 on a Radeon X1900 GTX, with buffers kept and
// not kept. Only ratios can be compared with today's hardware.

#include <array>

namespace gnomon::bench {

struct PrintedRates {
    double kept, not_kept;
};

/// Table 1, Cornell box, thresholds 0.05 and 0.9, by limit level.
struct PrintedLevel {
    int level;
    PrintedRates rates;
};
inline constexpr std::array<PrintedLevel, 3> k_printed_levels{
    {{6, {204.20, 107.58}}, {5, {73.71, 47.96}}, {4, {20.57, 14.42}}}};

/// Table 2, level 5, kept, by thresholds.
struct PrintedThresholds {
    double depth, normal, cornell, buddha;
};
inline constexpr std::array<PrintedThresholds, 3> k_printed_thresholds{
    {{0.45, 0.3, 82.76, 46.50}, {0.25, 0.6, 76.03, 46.45}, {0.05, 0.9, 73.71, 40.70}}};

/// Table 3, Cornell box: sampling, by samples.
struct PrintedSampling {
    int samples;
    PrintedRates rates;
};
inline constexpr std::array<PrintedSampling, 2> k_printed_sampling{{{256, {183.92, 95.38}}, {2040, {26.58, 15.88}}}};

/// Figure 9: clusters and samples of the same quality, samples of the same speed.
inline constexpr int k_printed_clusters = 147;
inline constexpr PrintedRates k_printed_clusters_rates{204.70, 108.34};
inline constexpr PrintedSampling k_printed_same_quality{2040, {26.58, 15.88}};
inline constexpr PrintedSampling k_printed_same_speed{216, {203.91, 107.64}};
inline constexpr double k_printed_photons_seconds = 62;   // photon mapping, which our reference replaces

}   // namespace gnomon::bench
