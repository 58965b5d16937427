// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/window.h"

#include <fmt/format.h>

#include <filesystem>

#include "base/check.h"
#include "bench/culling/summary.h"

namespace gnomon::bench {

std::string name_of(const CullingWindow& window)
{
    return fmt::format("{}, frames {} to {}", std::filesystem::path(window.scene).filename().string(),
                       window.options.frames.first, window.options.frames.last);
}

CullingWindow beginning_of(const CullingWindow& window, int frames)
{
    GNOMON_CHECK(frames >= 1 && frames <= static_cast<int>(window.result.frames.size()));
    CullingWindow shorter{window.scene, window.command, window.moving_lights, window.lights, window.options, {}};
    shorter.options.frames.last = window.options.frames.first + frames - 1;
    shorter.result.frames.assign(window.result.frames.begin(), window.result.frames.begin() + frames);
    shorter.result.bytes = window.result.bytes;
    shorter.result.mask_bytes = window.result.mask_bytes;
    shorter.result.most_evidence_bytes = window.result.most_evidence_bytes;
    shorter.result.paper_bytes = window.result.paper_bytes;
    shorter.result.visible_triangles = window.result.visible_triangles;
    shorter.result.bytes_per_triangle_light = window.result.bytes_per_triangle_light;
    summarise(shorter.options, shorter.result);
    return shorter;
}

}   // namespace gnomon::bench
