// SPDX-License-Identifier: Apache-2.0
#include "bench/indirect/quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gnomon::bench {

namespace {

using Of = double Sampled::*;

// Interpolates the list where the member `of` has the wanted value. `of` must fall or rise along the list.
SampledAt between(const std::vector<Sampled>& list, double wanted, Of of)
{
    const bool rises = list.back().*of > list.front().*of;
    const auto before = [&](const Sampled& s) { return rises ? wanted < s.*of : wanted > s.*of; };
    if (before(list.front())) return {list.front(), "< "};
    std::size_t i = 1;
    while (i < list.size() && !before(list[i])) ++i;
    if (i == list.size()) return {list.back(), "> "};
    const Sampled &a = list[i - 1], &b = list[i];
    const double t = std::clamp(std::log(wanted / (a.*of)) / std::log(b.*of / (a.*of)), 0.0, 1.0);
    const auto mix = [&](double x, double y) { return x * std::pow(y / x, t); };
    return {{mix(a.samples, b.samples), mix(a.error, b.error), mix(a.kept, b.kept), mix(a.not_kept, b.not_kept)}};
}

}   // namespace

std::string quadtree_name(int level)
{
    return fmt::format("quadtree:{}", level);
}

std::string rsm_name(int samples, double radius)
{
    return radius == k_published_radius ? fmt::format("rsm:{}", samples) : fmt::format("rsm:{}:{}", samples, radius);
}

const IndirectRow* find_row(const std::vector<IndirectRow>& rows, const std::string& method,
                            const IndirectSettings& settings)
{
    for (const IndirectRow& row : rows)
        if (row.method == method && row.settings.depth_threshold == settings.depth_threshold &&
            row.settings.normal_threshold == settings.normal_threshold)
            return &row;
    return nullptr;
}

std::vector<Sampled> sampled_rows(const std::vector<IndirectRow>& rows, const IndirectSettings& settings)
{
    std::vector<Sampled> list;
    for (const int samples : k_indirect_samples)
        if (const IndirectRow* r = find_row(rows, rsm_name(samples, k_wide_radius), settings); r && r->nrmse_brute)
            list.push_back({static_cast<double>(samples), *r->nrmse_brute, r->cpu_ms_static, r->cpu_ms_moving});
    return list;
}

SampledAt sampled_of_error(const std::vector<Sampled>& list, double error)
{
    return between(list, error, &Sampled::error);
}

SampledAt sampled_of_time(const std::vector<Sampled>& list, double ms)
{
    return between(list, ms, &Sampled::not_kept);
}

}   // namespace gnomon::bench
