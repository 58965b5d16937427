// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/window.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "base/check.h"
#include "bench/culling/summary.h"
#include "gnomon/error.h"

namespace gnomon::bench {

std::string name_of(const CullingWindow& window)
{
    const CullingBenchOptions& o = window.options;
    if (o.step > 0)
        return fmt::format("{}, {} frames {:g} s apart{}", std::filesystem::path(window.scene).filename().string(),
                           o.frames.count(), o.step, o.start ? fmt::format(" from {:g} s on", *o.start) : "");
    return fmt::format("{}, frames {} to {}", std::filesystem::path(window.scene).filename().string(),
                       window.options.frames.first, window.options.frames.last);
}

CullingWindow beginning_of(const CullingWindow& window, int frames)
{
    GNOMON_CHECK(frames >= 1 && frames <= static_cast<int>(window.result.frames.size()));
    CullingWindow shorter{window.scene, window.command, window.moving_lights, window.lights, window.options, {}, {}};
    shorter.options.frames.last = window.options.frames.first + frames - 1;
    shorter.result.frames.assign(window.result.frames.begin(), window.result.frames.begin() + frames);
    shorter.result.bytes = window.result.bytes;
    shorter.result.mask_bytes = window.result.mask_bytes;
    shorter.result.most_evidence_bytes = window.result.most_evidence_bytes;
    shorter.result.paper_bytes = window.result.paper_bytes;
    shorter.result.readings = window.result.readings;
    shorter.result.tree_nodes = window.result.tree_nodes;
    shorter.result.tree_group_splits = window.result.tree_group_splits;
    shorter.result.visible_triangles = window.result.visible_triangles;
    shorter.result.bytes_per_triangle_light = window.result.bytes_per_triangle_light;
    summarise(shorter.options, shorter.result);
    return shorter;
}

int frames_between(double step, double seconds)
{
    const double frames = step / seconds;
    if (!(step > 0) || !(frames > 0.5) || std::abs(frames - std::round(frames)) > 1e-6 * frames)
        throw UsageError(fmt::format("the largest step, {:g} s, is not a multiple of {:g} s", step, seconds));
    return static_cast<int>(std::lround(frames));
}

CullingStep measure_step(const std::shared_ptr<const scene::Scene>& scene, const CullingWindow& window, double seconds,
                         const Progress& progress)
{
    CullingStep step{seconds, window.options, {}};
    step.options.between = frames_between(window.options.step, seconds);
    step.options.certified = step.options.images = false;
    step.options.repeat = 1;
    if (step.options.between == 1 && !window.result.frames.empty()) {
        step.result = window.result;
        step.result.images.reset();
    } else {
        step.result = bench_culling(scene, step.options, progress);
    }
    return step;
}

}   // namespace gnomon::bench
