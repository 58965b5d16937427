// SPDX-License-Identifier: Apache-2.0
// The pixels that motion blur and depth of field touch (blur.h).
#include <algorithm>
#include <cmath>

#include "base/interruption.h"
#include "trace/blur.h"
#include "visibility/dynamic_bounds.h"

namespace gnomon::trace {

namespace {

constexpr int k_block = 8;   // pixels a side that are tested together

// A rectangle of pixels: low inclusive, high exclusive.
struct Rectangle {
    glm::ivec2 low{0}, high{0};
};

Rectangle whole(Size size)
{
    return {{0, 0}, {size.width, size.height}};
}

bool met(const shading::CentreSample& sample)
{
    return sample.object != scene::none;
}

float depth_of(const shading::CentreSample& sample, const scene::View& view)
{
    return met(sample) ? glm::dot(sample.position - view.eye, view.forward) : k_infinity;
}

Box3 grown(const Box3& box, float by)
{
    return {box.low - by, box.high + by};
}

// The rectangle in which an image may show a box, and the box's least depth.
Rectangle rectangle_of(const Box3& box, const scene::View& view, const scene::Lens& lens, float& nearest)
{
    glm::dvec2 low(1e30), high(-1e30);
    nearest = k_infinity;
    float spread = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 at(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                           corner & 4 ? box.high.z : box.low.z);
        const float depth = glm::dot(at - view.eye, view.forward);
        const std::optional<glm::dvec2> seen = view.project(glm::dvec3(at));
        nearest = std::min(nearest, depth);
        if (!seen || depth <= view.near) return nearest = 0, whole(view.size);
        spread = std::max(spread, scene::circle_of_confusion(view, lens, depth));
        low = glm::min(low, *seen), high = glm::max(high, *seen);
    }
    const double more = 0.5 * static_cast<double>(spread) + 1;
    low = glm::clamp(low - more, glm::dvec2(0), glm::dvec2(view.size.width, view.size.height));
    high = glm::clamp(high + more, glm::dvec2(0), glm::dvec2(view.size.width, view.size.height));
    return {glm::ivec2(glm::floor(low)), glm::ivec2(glm::ceil(high))};
}

// The squared distance of a point from a box.
float square_distance(const Box3& box, const glm::vec3& point)
{
    const glm::vec3 apart = glm::max(glm::max(box.low - point, point - box.high), glm::vec3(0));
    return glm::dot(apart, apart);
}

// A light, as far as its shadows go.
struct Caster {
    glm::vec3 at{0};   // position, or for a directional light the direction towards it
    bool directional = false;
    Box3 box;   // of a light with size; empty: none
};

std::vector<Caster> casters_of(const scene::SceneState& state, const scene::SizedLights* sized)
{
    std::vector<Caster> casters;
    const scene::Scene& scene = state.scene();
    for (scene::LightId l = 0; l < scene.lights.size(); ++l) {
        const scene::LightState& at = state.light(l);
        if (!at.visible || (sized && scene.lights[l].of_surface)) continue;
        const bool directional = scene.lights[l].type == scene::LightType::directional;
        casters.push_back({directional ? -at.direction : at.position, directional, {}});
    }
    if (!sized) return casters;
    for (const scene::SizedLight& light : sized->lights())
        casters.push_back({light.centre, false, grown({light.centre, light.centre}, light.radius)});
    return casters;
}

bool may_shadow(const Box3& blocker, const Box3& points, const Caster& light)
{
    if (!light.box.empty()) return visibility::may_shadow(blocker, points, light.box);
    return visibility::may_shadow(blocker, points, light.at, light.directional);
}

}   // namespace

void Blur::select(const shading::CentreSamples& centres, const scene::SceneState& state, const scene::View& view,
                  const scene::SizedLights* sized, Tasks& tasks)
{
    size_ = view.size;
    rounds_ = Image8(size_.width, size_.height, 1);
    if (motion_.everything) {
        std::fill(rounds_.data.begin(), rounds_.data.end(), std::uint8_t{1});
    } else {
        if (!motion_.boxes.empty()) touch_moving(centres, view, tasks), touch_lit(centres, state, sized, tasks);
        if (!options_.lens.sharp()) touch_unsharp(centres, view, tasks);
        widen(tasks);
    }
    any_ = std::ranges::any_of(rounds_.data, [](std::uint8_t r) { return r != 0; });
}

// Touches the pixels in which a moving object may be seen, at once or in a mirror.
void Blur::touch_moving(const shading::CentreSamples& centres, const scene::View& view, Tasks& tasks)
{
    struct Seen {
        Rectangle where;
        float nearest;
    };
    std::vector<Seen> seen;
    for (const Box3& box : motion_.boxes) {
        float nearest = 0;
        const Rectangle where = rectangle_of(box, view, options_.lens, nearest);
        seen.push_back({where, nearest});
    }
    tasks.for_each(static_cast<std::size_t>(size_.height), [&](std::size_t row, int) {
        interruption_point();
        const int y = static_cast<int>(row);
        for (int x = 0; x < size_.width; ++x)
            if (centres.at(x, y).mirrors) *rounds_.pixel(x, y) = 1;
        for (const Seen& s : seen) {
            if (y < s.where.low.y || y >= s.where.high.y) continue;
            for (int x = s.where.low.x; x < s.where.high.x; ++x) {
                const shading::CentreSample& centre = centres.at(x, y);
                // What is nearer hides it.
                if (depth_of(centre, view) + 2 * centre.width >= s.nearest) *rounds_.pixel(x, y) = 1;
            }
        }
    });
}

// Touches the pixels whose surface a moving object may shadow, or is near to.
void Blur::touch_lit(const shading::CentreSamples& centres, const scene::SceneState& state,
                     const scene::SizedLights* sized, Tasks& tasks)
{
    const std::vector<Caster> casters = casters_of(state, sized);
    std::vector<float> reach;   // of each box, squared
    for (const Box3& box : motion_.boxes) {
        const glm::vec3 diagonal = options_.near * (box.high - box.low);
        reach.push_back(glm::dot(diagonal, diagonal));
    }
    const int columns = (size_.width + k_block - 1) / k_block, rows = (size_.height + k_block - 1) / k_block;
    tasks.for_each(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), [&](std::size_t index, int) {
        const int left = static_cast<int>(index) % columns * k_block, top = static_cast<int>(index) / columns * k_block;
        const int right = std::min(left + k_block, size_.width), bottom = std::min(top + k_block, size_.height);
        const auto each = [&](const auto& act) {
            for (int y = top; y < bottom; ++y)
                for (int x = left; x < right; ++x)
                    if (met(centres.at(x, y)) && *rounds_.pixel(x, y) == 0) act(x, y);
        };
        Box3 block;
        each([&](int x, int y) {
            const shading::CentreSample& s = centres.at(x, y);
            block.add(s.position - s.width), block.add(s.position + s.width);
        });
        if (block.empty()) return;
        for (std::size_t b = 0; b < motion_.boxes.size(); ++b) {
            const Box3& box = motion_.boxes[b];
            each([&](int x, int y) {
                if (square_distance(box, centres.at(x, y).position) < reach[b]) *rounds_.pixel(x, y) = 1;
            });
            for (const Caster& light : casters) {
                if (!may_shadow(box, block, light)) continue;
                each([&](int x, int y) {
                    const shading::CentreSample& s = centres.at(x, y);
                    if (may_shadow(box, {s.position - s.width, s.position + s.width}, light)) *rounds_.pixel(x, y) = 1;
                });
            }
        }
    });
}

// Touches the pixels that show something out of focus, and those over which something nearer may spread.
void Blur::touch_unsharp(const shading::CentreSamples& centres, const scene::View& view, Tasks& tasks)
{
    const int columns = (size_.width + k_block - 1) / k_block, rows = (size_.height + k_block - 1) / k_block;
    std::vector<float> spread(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0.0f);
    tasks.for_each(spread.size(), [&](std::size_t index, int) {
        const int left = static_cast<int>(index) % columns * k_block, top = static_cast<int>(index) / columns * k_block;
        for (int y = top; y < std::min(top + k_block, size_.height); ++y)
            for (int x = left; x < std::min(left + k_block, size_.width); ++x) {
                const float depth = depth_of(centres.at(x, y), view);
                const float circle = scene::circle_of_confusion(view, options_.lens, depth);
                if (circle < options_.blurred_from && !centres.at(x, y).mirrors) continue;
                *rounds_.pixel(x, y) = 1;
                // What lies behind the plane of focus does not spread over what is sharp there.
                if (depth < options_.lens.focus) spread[index] = std::max(spread[index], circle);
            }
    });
    // Spread the blocks by what is blurred most in them.
    for (std::size_t index = 0; index < spread.size(); ++index) {
        if (spread[index] == 0) continue;
        const int left = static_cast<int>(index) % columns * k_block, top = static_cast<int>(index) / columns * k_block;
        const int more = static_cast<int>(std::min(std::ceil(0.5f * spread[index]), 1e6f)) + 1;
        for (int y = std::max(top - more, 0); y < std::min(top + k_block + more, size_.height); ++y) {
            std::uint8_t* const row = rounds_.pixel(0, y);
            std::fill(row + std::max(left - more, 0), row + std::min(left + k_block + more, size_.width),
                      std::uint8_t{1});
        }
    }
}

// Touches the neighbours of touched pixels, too, because a pixel is more than its centre.
void Blur::widen(Tasks& tasks)
{
    const Image8 before = rounds_;
    tasks.for_each(static_cast<std::size_t>(size_.height), [&](std::size_t row, int) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < size_.width; ++x) {
            if (*before.pixel(x, y) != 0) continue;
            for (int v = std::max(y - 1, 0); v <= std::min(y + 1, size_.height - 1); ++v)
                for (int u = std::max(x - 1, 0); u <= std::min(x + 1, size_.width - 1); ++u)
                    if (*before.pixel(u, v) != 0) *rounds_.pixel(x, y) = 1;
        }
    });
}

}   // namespace gnomon::trace
