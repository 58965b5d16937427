// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/readings.h"

#include <fmt/format.h>

#include "gnomon/error.h"

namespace gnomon::bench {

namespace {

constexpr int k_part_levels = 6;   // at most 4^6 parts of a triangle

}   // namespace

std::vector<PaperReading> all_readings()
{
    using shadow_culling::PaperMobility;
    using shadow_culling::PaperOptions;
    std::vector<PaperReading> readings;
    const auto add = [&](const char* name, const char* label) -> PaperReading& {
        readings.push_back({name, label, {}, false});
        return readings.back();
    };
    add("as-printed", "by the letter").options = PaperOptions::as_printed();
    add("by-clip", "dynamic is what may move in the clip").options.mobility = PaperMobility::by_clip;
    add("partial-stays", "PARTIALLY_OCCLUDED stays for ever").options.set_modes.partially_occluded_stays = true;
    add("dynamic-blockers", "shadows of dynamic objects are remembered").options.set_modes.remember_dynamic_blockers =
        true;
    add("marked-again", "marks of the frame are tested again").options.occlusion_test.test_marked = true;
    add("cached", "and the last static occluder, asked first").caches_occluders = true;
    add("parts", "on parts of triangles").options.part_levels = k_part_levels;
    return readings;
}

PaperReading reading_named(std::string_view name)
{
    for (PaperReading& reading : all_readings())
        if (reading.name == name) return std::move(reading);
    throw UsageError(fmt::format("no reading is called {}", name));
}

ray::KdLayout layout_named(std::string_view name)
{
    for (const auto layout : {ray::KdLayout::separate, ray::KdLayout::hierarchy, ray::KdLayout::mixed})
        if (name == name_of(layout)) return layout;
    throw UsageError(fmt::format("no kd-tree is called {}", name));
}

std::string name_of(ray::KdLayout layout)
{
    switch (layout) {
        case ray::KdLayout::hierarchy:
            return "hierarchy";
        case ray::KdLayout::mixed:
            return "mixed";
        case ray::KdLayout::separate:
            break;
    }
    return "separate";
}

}   // namespace gnomon::bench
