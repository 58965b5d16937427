// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where a frame's time goes, and how much of its work memory saves, as figures of a report and as data.

#include <nlohmann/json_fwd.hpp>

#include <functional>
#include <string>
#include <vector>

#include "bench/report/chart.h"
#include "bench/report/page.h"
#include "gnomon/frame.h"

namespace gnomon::bench {

/// What one frame says of itself.
struct FrameWork {
    double ms = 0;
    FrameTimes times;
    FrameCounters::Shadow shadow;
    FrameCounters::Indirect indirect;
};
FrameWork work_of(const Frame& image);

/// The frames of one way to render, the first of which had nothing to remember.
struct WayWork {
    std::string name;
    std::vector<FrameWork> frames;
};

/// Of the frames from the second on: those that had something to remember. A single frame stands for itself.
double steady_median(const WayWork& way, const std::function<double(const FrameWork&)>& value);

/// A row a stage, a column a way: milliseconds, steady medians. Stages in which no way spent time are left out.
ReportTable stage_table(const std::vector<WayWork>& ways);
/// The stages of one way on top of each other, from the second frame on.
Chart stage_chart(const WayWork& way, int first_frame);
/// Per cent of the work that was not done, from the second frame on: shadow rays that memory answered, those that were
/// asked of the dynamic objects alone, and rays of bounced light that the first frame cast and this one did not need.
Chart saved_chart(const WayWork& way, int first_frame);
/// The same shares over all frames from the second on.
struct SavedWork {
    double shadow_skipped = 0, shadow_dynamic_only = 0;   // per cent of the shadow rays that were asked for
    double indirect = 0;                                  // per cent of the first frame's rays; 0 if it cast none
};
SavedWork saved_of(const WayWork& way);
SavedWork saved_of(const FrameWork& frame, const FrameWork& first);

/// Milliseconds by the stage's name.
nlohmann::ordered_json stages_json(const FrameTimes& times);
/// By frame, with the names of `render --json`.
nlohmann::ordered_json work_json(const std::vector<FrameWork>& frames, int first_frame);

}   // namespace gnomon::bench
