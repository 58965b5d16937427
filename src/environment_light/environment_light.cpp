// SPDX-License-Identifier: Apache-2.0
#include "environment_light/environment_light.h"

#include "base/check.h"

namespace gnomon::environment_light {

// An image and what is known of it.
struct EnvironmentLight::Image {
    std::shared_ptr<const scene::Environment> environment;
    DirectionCells cells;
    CellLight light;
    std::unique_ptr<CellVisibility> visibility;

    Image(std::shared_ptr<const scene::Environment> of, const EnvironmentOptions& options)
        : environment(std::move(of)), cells(*environment, options.cells), light(cells, environment.get(), options.light)
    {
    }
};

EnvironmentLight::EnvironmentLight(const EnvironmentOptions& options) : options_(options) {}
EnvironmentLight::~EnvironmentLight() = default;

void EnvironmentLight::follow(const scene::SceneState& state, const ray::RayScene& rays)
{
    const scene::Background& background = state.scene().background;
    if (background.kind != scene::Background::Kind::image || background.environment->flux() == glm::vec3(0)) {
        if (image_) ++version_;
        image_.reset();
        surroundings_.reset();
        return;
    }
    bool anew = false;
    if (!surroundings_)
        surroundings_ = std::make_unique<Surroundings>(state, rays), anew = true;
    else
        anew = surroundings_->follow(state, rays);
    if (image_ && image_->environment == background.environment && !anew) return;

    ++version_;
    std::unique_ptr<Image> before = std::exchange(image_, nullptr);
    if (before && before->environment == background.environment)
        image_ = std::move(before);
    else
        image_ = std::make_unique<Image>(background.environment, options_);
    auto visibility = std::make_unique<CellVisibility>(*surroundings_, image_->cells, options_.proofs);
    if (before && !anew) visibility->proofs().take_over(before->visibility->proofs());
    image_->visibility = std::move(visibility);
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

glm::vec3 EnvironmentLight::irradiance(CellVisibility::Scratch& scratch, const visibility::ShadowPoint& point,
                                       const glm::vec3& normal, PointMemory* memory) const
{
    constexpr std::uint32_t k_first = 0;
    SeenCells seen;
    visibility().find(scratch, {&point, 1}, {&k_first, 1}, {}, memory, seen);
    return light().irradiance(normal, seen.of(0));
}

std::size_t EnvironmentLight::bytes() const
{
    if (!image_) return 0;
    return surroundings_->bytes() + image_->cells.bytes() + image_->light.bytes() + image_->visibility->proofs().bytes();
}

}   // namespace gnomon::environment_light
