// SPDX-License-Identifier: Apache-2.0
#include "viewer/reprojection.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/check.h"
#include "viewer/projection.h"

namespace gnomon::viewer {

namespace {

constexpr float k_least_depth = 1e-4f;   // of the depth before
constexpr int k_steps = 5;
constexpr float k_found_pixels = 0.5f;   // a search that misses its place by less has found it
constexpr float k_start_pixels = 3;      // between places at which searches begin
constexpr int k_most_starts = 8;         // degrees of nearness between these, at most
constexpr std::size_t k_cell = 4;        // pixels in x and y for each search

// From fractions of the image's width and height to a direction in camera space whose depth is 1.
glm::dmat3 direction_of_place(const ImagePlane& plane)
{
    return {glm::dvec3(2 * plane.half.x, 0, 0), glm::dvec3(0, -2 * plane.half.y, 0),
            glm::dvec3(plane.centre.x - plane.half.x, plane.centre.y + plane.half.y, -1)};
}

glm::dmat3 axes_of(const Camera& camera)
{
    glm::dmat3 axes(matrix_of(camera.transform));
    for (int axis = 0; axis < 3; ++axis)
        if (glm::length(axes[axis]) > 0) axes[axis] = glm::normalize(axes[axis]);
    return axes;
}

glm::dvec3 origin_of(const Camera& camera)
{
    return glm::dvec3(matrix_of(camera.transform)[3]);
}

// Between 0 and `last`, whatever a camera without a width or a depth makes of a place.
float clamped(float value, float last)
{
    return value > 0 ? std::min(value, last) : 0;
}

// The colour between four pixels' centres.
// @param at  in pixels, from the centre of the first one
void sample(const Image8& image, const glm::vec2& at, std::uint8_t* to)
{
    constexpr int k_whole = 256;
    const auto fixed = [](float value, int last) {
        return static_cast<int>(k_whole * clamped(value, static_cast<float>(last)));
    };
    const int x = fixed(at.x, image.width - 1), y = fixed(at.y, image.height - 1);
    const int right = x % k_whole, below = y % k_whole;
    const std::uint8_t* const upper = image.pixel(x / k_whole, y / k_whole);
    const std::size_t across = right ? 3 : 0, down = below ? 3 * static_cast<std::size_t>(image.width) : 0;
    const std::uint8_t* const lower = upper + down;
    for (std::size_t channel = 0; channel < 3; ++channel) {
        const int above = upper[channel] * (k_whole - right) + upper[channel + across] * right;
        const int under = lower[channel] * (k_whole - right) + lower[channel + across] * right;
        to[channel] = static_cast<std::uint8_t>((above * (k_whole - below) + under * below + k_whole * k_whole / 2) /
                                                (k_whole * k_whole));
    }
}

}   // namespace

// Where searches begin, if what is found there is about as near.
struct Reprojection::Start {
    glm::mat3 back{1};   // from places of the other image back, as if all that the image shows were so near
    float least = 0, most = 0;
};

// The nearness of the pixel at a place.
struct Reprojection::Nearness {
    const std::vector<float>& values;
    std::size_t width, height;
    float at(const glm::vec2& place) const
    {
        const auto pixel = [](float fraction, std::size_t count) {
            return static_cast<std::size_t>(
                clamped(fraction * static_cast<float>(count), static_cast<float>(count - 1)));
        };
        return values[pixel(place.y, height) * width + pixel(place.x, width)];
    }
    float pixels(const glm::vec2& way) const { return glm::length(way * glm::vec2(width, height)); }
};

std::optional<Reprojection> Reprojection::between(const Camera& from, const Camera& to, const glm::vec2& size)
{
    const ImagePlane seen = image_plane_of(from, size), shown = image_plane_of(to, size);
    if (seen.orthographic || shown.orthographic) return std::nullopt;
    const glm::dmat3 place_of_direction = glm::inverse(direction_of_place(shown));
    const glm::dmat3 to_other = glm::transpose(axes_of(to));
    Reprojection made;
    made.turn_ = glm::mat3(place_of_direction * to_other * axes_of(from) * direction_of_place(seen));
    made.step_ = glm::vec3(place_of_direction * to_other * (origin_of(from) - origin_of(to)));
    return made;
}

std::optional<glm::vec2> Reprojection::moved(const glm::vec2& place, float nearness) const
{
    const glm::vec3 seen = turn_ * glm::vec3(place, 1) + nearness * step_;
    if (!(seen.z > k_least_depth)) return std::nullopt;
    return glm::vec2(seen) / seen.z;
}

// Where searches begin: some degrees of nearness, so that the places that they lead to are some pixels apart at most.
std::vector<Reprojection::Start> Reprojection::starts(const Image8& image, const std::vector<float>& nearness) const
{
    const float most = *std::max_element(nearness.begin(), nearness.end());
    const glm::vec2 size(image.width, image.height);
    float apart = 0;
    for (const glm::vec2& place : {glm::vec2(0.5f), glm::vec2(0), glm::vec2(1)})
        if (const auto near = moved(place, most), far = moved(place, 0); near && far)
            apart = std::max(apart, glm::length((*near - *far) * size));
    const int count = std::clamp(static_cast<int>(std::ceil(apart / k_start_pixels)), 1, k_most_starts);
    const float step = most / static_cast<float>(count);
    std::vector<Start> starts;
    for (int i = count; i >= 0; --i) {
        const float as_near = step * static_cast<float>(i);
        starts.push_back({glm::inverse(glm::mat3(turn_[0], turn_[1], turn_[2] + as_near * step_)),
                          as_near - 1.5f * step, as_near + 1.5f * step});
    }
    return starts;
}

// Searches for the place that moves to a place of the other image: of several, the nearest to the camera, which is
// before the others. Where there is none, of what comes closest.
glm::vec2 Reprojection::found(const glm::vec2& place, std::span<const Start> starts, const Nearness& nearness) const
{
    glm::vec2 best = place;
    float least_miss = k_infinity;
    for (const bool all : {false, true}) {
        for (const Start& start : starts) {
            const glm::vec3 back = start.back * glm::vec3(place, 1);
            if (!(back.z > k_least_depth)) continue;
            glm::vec2 at = glm::vec2(back) / back.z;
            float near = nearness.at(at);
            if (!all && (near < start.least || near > start.most)) continue;   // another start leads there
            for (int step = 0; step < k_steps; ++step) {
                const auto there = moved(at, near);
                if (!there) break;
                const float miss = nearness.pixels(place - *there);
                if (miss < k_found_pixels) return at;
                at += place - *there;
                near = nearness.at(at);
                if (miss < least_miss) best = at, least_miss = miss;
            }
        }
    }
    return best;
}

Image8 Reprojection::moved(const Image8& image, const std::vector<float>& nearness) const
{
    const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
    GNOMON_CHECK(image.channels == 3 && nearness.size() == width * height);
    Image8 out = image;
    if (nearness.empty()) return out;
    // Search for every k_cell-th pixel's place, the rows of which are made as they are needed.
    const Nearness known{nearness, width, height};
    const std::vector<Start> begin_at = starts(image, nearness);
    const glm::vec2 size(image.width, image.height);
    const std::size_t columns = (width + k_cell - 1) / k_cell + 1;
    std::vector<glm::vec2> upper(columns), lower(columns);
    const auto search_row = [&](std::size_t row, std::vector<glm::vec2>& to) {
        for (std::size_t column = 0; column < columns; ++column)
            to[column] = found((glm::vec2(column * k_cell, row * k_cell) + 0.5f) / size, begin_at, known) * size - 0.5f;
    };
    search_row(0, lower);
    for (std::size_t y = 0; y < height; ++y) {
        if (y % k_cell == 0) {
            upper.swap(lower);
            search_row(y / k_cell + 1, lower);
        }
        const float down = static_cast<float>(y % k_cell) / static_cast<float>(k_cell);
        std::uint8_t* const row = out.data.data() + 3 * y * width;
        for (std::size_t column = 0; column + 1 < columns; ++column) {
            const glm::vec2 first = glm::mix(upper[column], lower[column], down);
            const glm::vec2 step =
                (glm::mix(upper[column + 1], lower[column + 1], down) - first) / static_cast<float>(k_cell);
            const std::size_t begin = column * k_cell, end = std::min(begin + k_cell, width);
            for (std::size_t x = begin; x < end; ++x)
                sample(image, first + static_cast<float>(x - begin) * step, row + 3 * x);
        }
    }
    return out;
}

}   // namespace gnomon::viewer
