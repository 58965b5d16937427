// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tables, charts and JSON of the time that frames take by stage and of the work that caching saves.

#include <nlohmann/json_fwd.hpp>

#include <functional>
#include <string>
#include <vector>

#include "bench/report/chart.h"
#include "bench/report/page.h"
#include "gnomon/frame.h"

namespace gnomon::bench {

/// Times and counters of one frame.
struct FrameWork {
    double ms = 0;
    FrameTimes times;
    FrameCounters::Shadow shadow;
    FrameCounters::Indirect indirect;
};
FrameWork work_of(const Frame& image);

/// The frames of one way to render. The first frame starts with empty caches.
struct WayWork {
    std::string name;
    std::vector<FrameWork> frames;
};

/// The median from the second frame on, when caches are filled; of a single frame, its value.
double steady_median(const WayWork& way, const std::function<double(const FrameWork&)>& value);

/// A table of steady medians in milliseconds: one row per stage, one column per way. Stages without any time are
/// omitted.
ReportTable stage_table(const std::vector<WayWork>& ways);
/// The stages of one way, stacked, from the second frame on.
Chart stage_chart(const WayWork& way, int first_frame);
/// Percentage of work saved, from the second frame on: shadow rays culled, shadow rays traced against dynamic objects
/// only, and rays for indirect light saved in comparison with the first frame.
Chart saved_chart(const WayWork& way, int first_frame);
/// The same percentages, of one frame or over all frames from the second on.
struct SavedWork {
    double shadow_skipped = 0, shadow_dynamic_only = 0;   // percent of all shadow rays
    double indirect = 0;                                  // percent of the first frame's rays; 0 if it cast none
};
SavedWork saved_of(const WayWork& way);
SavedWork saved_of(const FrameWork& frame, const FrameWork& first);

/// Milliseconds by name of the stage.
nlohmann::ordered_json stages_json(const FrameTimes& times);
/// An array with one object per frame, with the keys of `render --json`.
nlohmann::ordered_json work_json(const std::vector<FrameWork>& frames, int first_frame);

}   // namespace gnomon::bench
