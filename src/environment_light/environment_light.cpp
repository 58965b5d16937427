// SPDX-License-Identifier: Apache-2.0
#include "environment_light/environment_light.h"

#include <algorithm>
#include <bit>
#include <mutex>
#include <utility>

#include "base/check.h"

namespace gnomon::environment_light {

// An image and what is known of it.
struct EnvironmentLight::Image {
    std::shared_ptr<const scene::Environment> environment;
    DirectionCells cells;
    CellLight light;
    std::unique_ptr<CellVisibility> visibility;
    std::once_flag mirrored_made;
    std::unique_ptr<MirroredCells> mirrored;

    Image(std::shared_ptr<const scene::Environment> of, const EnvironmentOptions& options)
        : environment(std::move(of)), cells(*environment, options.cells), light(cells, environment.get(), options.light)
    {
    }
};

EnvironmentLight::EnvironmentLight(const EnvironmentOptions& options) : options_(options) {}
EnvironmentLight::~EnvironmentLight() = default;

void EnvironmentLight::follow(const scene::SceneState& state, const ray::RayScene& rays, Tasks* tasks)
{
    // Neither the occluders nor the cells of an image need each other.
    const std::shared_ptr<const scene::Environment> lights = lighting_image(state);
    std::unique_ptr<Image> image;
    bool anew = !surroundings_;
    const auto make = [&](std::size_t part, int) {
        if (part == 1)
            image = std::make_unique<Image>(lights, options_);
        else if (!surroundings_)
            surroundings_ = std::make_unique<Surroundings>(state, rays);
        else
            anew = surroundings_->follow(state, rays);
    };
    const std::size_t parts = lights && (!image_ || image_->environment != lights) ? 2 : 1;
    if (tasks)
        tasks->for_each(parts, make);
    else
        for (std::size_t part = 0; part < parts; ++part) make(part, 0);
    follow_image(lights, std::move(image), anew);
    follow_suns(state, anew);
}

// The image that lights the scene, if there is one.
std::shared_ptr<const scene::Environment> EnvironmentLight::lighting_image(const scene::SceneState& state) const
{
    const scene::Background& background = state.scene().background;
    if (!options_.image || background.kind != scene::Background::Kind::image ||
        background.environment->flux() == glm::vec3(0))
        return nullptr;
    return background.environment;
}

// @param lights  the image that lights the scene
// @param made    of it, if that is another one than before
// @param anew    static triangles changed: nothing is proven of them
void EnvironmentLight::follow_image(const std::shared_ptr<const scene::Environment>& lights,
                                    std::unique_ptr<Image> made, bool anew)
{
    if (image_) image_->visibility->forget_other();
    before_.reset();
    if (!lights) {
        if (image_) ++version_;
        image_.reset();
        return;
    }
    if (!made && !anew) return;

    before_ = std::exchange(image_, nullptr);
    image_ = made ? std::move(made) : std::move(before_);
    auto visibility = std::make_unique<CellVisibility>(*surroundings_, image_->cells, options_.proofs);
    if (before_ && !anew)
        visibility->take_over(*before_->visibility);
    else
        ++version_, before_.reset();
    image_->visibility = std::move(visibility);
}

void EnvironmentLight::follow_suns(const scene::SceneState& state, bool anew)
{
    std::vector<std::unique_ptr<Sun>> before = std::exchange(suns_, {});
    const scene::Scene& scene = state.scene();
    bool same = !anew;
    for (scene::LightId l = 0; l < scene.lights.size() && options_.sun_diameter > 0; ++l) {
        const scene::Light& light = scene.lights[l];
        const scene::LightState& at = state.light(l);
        if (light.type != scene::LightType::directional || light.of_environment || !at.visible ||
            light.color == glm::vec3(0))
            continue;
        auto sun = std::make_unique<Sun>(
            Sun{l, DirectionCells(-at.direction, options_.sun_diameter, glm::vec3(1), options_.cells), nullptr});
        // Keep what is known of one at the same place.
        const auto old = std::ranges::find_if(before, [&](const std::unique_ptr<Sun>& other) {
            return other && !anew && other->cells.same_directions(sun->cells);
        });
        if (old != before.end()) {
            same = same && old - before.begin() == static_cast<std::ptrdiff_t>(suns_.size());
            suns_.push_back(std::move(*old));
            suns_.back()->light = l;
            continue;
        }
        same = false;
        sun->visibility = std::make_unique<CellVisibility>(*surroundings_, sun->cells, options_.proofs);
        suns_.push_back(std::move(sun));
    }
    if (!same || before.size() != suns_.size()) ++suns_version_;
}

float EnvironmentLight::visible_share(const Sun& sun, const glm::vec3& normal, std::span<const std::uint64_t> seen)
{
    const std::size_t leaves = sun.cells.leaves();
    std::size_t visible = 0;
    for (const std::uint64_t word : seen) visible += static_cast<std::size_t>(std::popcount(word));
    if (visible == 0 || visible == leaves) return visible == 0 ? 0.0f : 1.0f;
    float part = 0, whole = 0;
    for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
        const float cosine = std::max(glm::dot(normal, sun.cells.direction(leaf)), 0.0f);
        whole += cosine;
        if (seen[leaf / 64] >> (leaf % 64) & 1) part += cosine;
    }
    return whole > 0 ? part / whole : 0;
}

const CellLight& EnvironmentLight::light() const
{
    GNOMON_CHECK(image_);
    return image_->light;
}

const CellVisibility& EnvironmentLight::visibility() const
{
    GNOMON_CHECK(image_);
    return *image_->visibility;
}

const MirroredCells& EnvironmentLight::mirrored() const
{
    GNOMON_CHECK(image_);
    std::call_once(image_->mirrored_made, [&] { image_->mirrored = std::make_unique<MirroredCells>(image_->cells); });
    return *image_->mirrored;
}

glm::vec3 EnvironmentLight::irradiance(CellVisibility::Scratch& scratch, const visibility::ShadowPoint& point,
                                       const glm::vec3& normal, PointMemory* memory) const
{
    constexpr std::uint32_t k_first = 0;
    SeenCells seen;
    visibility().find(scratch, {&point, 1}, {&k_first, 1}, {}, memory, seen);
    return light().irradiance(normal, seen.of(0), seen.partial_of(0));
}

std::size_t EnvironmentLight::bytes() const
{
    std::size_t bytes = surroundings_ ? surroundings_->bytes() : 0;
    if (image_) bytes += image_->cells.bytes() + image_->light.bytes() + image_->visibility->proofs().bytes();
    for (const auto& sun : suns_) bytes += sun->cells.bytes() + sun->visibility->proofs().bytes();
    return bytes;
}

}   // namespace gnomon::environment_light
