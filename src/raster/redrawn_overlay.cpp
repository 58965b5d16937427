// SPDX-License-Identifier: Apache-2.0
#include "raster/redrawn_overlay.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "base/math.h"

namespace gnomon::raster {

namespace {

// Brightness of the image below the colours. The floor keeps marked objects visible in the dark.
constexpr float k_grey_share = 0.6f, k_mark_floor = 0.25f;

glm::vec3 tint_of(Redrawn what)
{
    switch (what) {
        case Redrawn::settled:
            return {0.15f, 0.8f, 0.2f};
        case Redrawn::repaired:
            return {1.0f, 0.65f, 0.05f};
        case Redrawn::moved:
            return {1.0f, 0.1f, 0.05f};
        case Redrawn::kept:
            break;
    }
    return glm::vec3(k_grey_share);
}

}   // namespace

void add_redrawn(const light_views::LightViews& views, std::vector<Redrawn>& objects)
{
    GNOMON_CHECK(objects.size() >= views.object_count());
    const auto mark = [&](scene::ObjectId object, Redrawn what) { objects[object] = std::max(objects[object], what); };
    for (const light_views::LightView& view : views.views()) {
        if (!view.shown) continue;
        for (const auto& settle : view.plan.settle) mark(settle.object, Redrawn::settled);
        for (const auto& redraw : view.plan.redraw) mark(redraw.object, Redrawn::repaired);
        // Where the light itself moves, static objects are drawn as if they moved.
        for (const scene::ObjectId object : view.plan.dynamics)
            mark(object, views.is_dynamic(object) ? Redrawn::moved : Redrawn::repaired);
    }
}

void paint_redrawn(const IdImage& ids, const std::vector<Redrawn>& objects, double exposure, ImageF& color)
{
    GNOMON_CHECK(ids.width == color.width && ids.height == color.height);
    const float scale = static_cast<float>(std::exp2(exposure));
    for (int y = 0; y < color.height; ++y)
        for (int x = 0; x < color.width; ++x) {
            float* const rgb = color.pixel(x, y);
            const std::uint32_t id = ids.pixel(x, y)[0];
            const float light = scale * luminance(glm::vec3(rgb[0], rgb[1], rgb[2]));
            const float grey = light > 0 ? light / (1 + light) : 0.0f;
            const Redrawn what = id == 0 ? Redrawn::kept : objects[id - 1];
            const float shade = what == Redrawn::kept ? grey : k_mark_floor + (1 - k_mark_floor) * grey;
            const glm::vec3 tint = tint_of(what);
            for (int c = 0; c < 3; ++c) rgb[c] = tint[c] * shade;
        }
}

}   // namespace gnomon::raster
