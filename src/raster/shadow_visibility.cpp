// SPDX-License-Identifier: Apache-2.0
#include "raster/shadow_visibility.h"

#include <algorithm>

namespace gnomon::raster {

namespace {

// Allows for rounding of planes and boxes, relative to the distances of corners from the planes' origin.
constexpr float k_sight_slack = 1e-5f;

// Whether a box meets the space inside all planes; it may also say so of one that lies just outside.
bool meets(const Box3& box, const glm::mat4& to_world, std::span<const glm::vec4, 6> planes)
{
    glm::vec3 corners[8];
    for (int i = 0; i < 8; ++i)
        corners[i] = glm::vec3(to_world * glm::vec4(i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y,
                                                    i & 4 ? box.high.z : box.low.z, 1));
    return std::all_of(planes.begin(), planes.end(), [&](const glm::vec4& plane) {
        const glm::vec3 normal(plane);
        return std::any_of(std::begin(corners), std::end(corners), [&](const glm::vec3& corner) {
            const float slack = k_sight_slack * (glm::dot(glm::abs(normal), glm::abs(corner)) + std::abs(plane.w));
            return glm::dot(normal, corner) + plane.w >= -slack;
        });
    });
}

light_views::LightViewsOptions view_options(const ShadowOptions& options)
{
    light_views::LightViewsOptions result;
    result.atlas = options.atlas;
    result.of_surfaces = false;   // lights with size light in closed form (sized_direct.h)
    result.of_environment = !options.image_apart, result.directional = !options.suns_apart;
    return shadow_textures::view_options(options.method, result);
}

}   // namespace

ShadowVisibility::ShadowVisibility(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                                   const ShadowOptions& options)
    : device_(device), options_(options), views_(state, view_options(options)), casters_(device, state)
{
    make_buffers();
}

// Makes what depends on the layout of the views.
void ShadowVisibility::make_buffers()
{
    layout_version_ = views_.layout_version();
    hard_.reset(), method_.reset(), visibility_.reset();   // first, because memory may be scarce
    const bool hard = options_.look_up.filter == 0 && !options_.look_up.as_printed;
    method_ = std::make_unique<shadow_textures::MethodTextures>(device_, views_, options_.method, !hard);
    visibility_ = std::make_unique<shadow_textures::GpuVisibility>(device_, views_);
    if (hard) hard_ = std::make_unique<shadow_textures::HardVisibility>(device_, views_);
}

void ShadowVisibility::update(vk::Commands& commands, const scene::SceneState& state,
                              std::span<const glm::vec4, 6> planes)
{
    views_.update(state);
    if (layout_version_ != views_.layout_version()) make_buffers();
    casters_.update(commands, state);
    method_->record_views(commands, views_, casters_);
    if (hard_) hard_->update(commands, views_, casters_, state);
    method_->record_textures(commands, views_, casters_, state, [&](scene::ObjectId object) {
        return meets(views_.casters().box(object), state.object_matrix(object), planes);
    });
    if (options_.look_up.as_printed) visibility_->begin_counts(commands);
}

void ShadowVisibility::fill(vk::Commands& commands, const GBuffer& surfaces, std::uint32_t first, std::uint32_t count,
                            const vk::Image& visibility)
{
    const shadow_textures::ImageInputs image{&surfaces.position, &surfaces.geometric, &surfaces.ids,
                                             surfaces.smooth ? &surfaces.smooth : nullptr};
    if (hard_)
        hard_->record(commands, views_, casters_, image, visibility, first, count);
    else
        visibility_->record(commands, views_, method_->buffers(), method_->textures(), image, visibility,
                            options_.look_up, first, count);
}

void ShadowVisibility::end_frame(vk::Commands& commands)
{
    if (options_.look_up.as_printed) counts_ = visibility_->read_counts(commands);
}

void ShadowVisibility::count(FrameCounters& counters) const
{
    const shadow_textures::TextureCounts textures = method_->counts();
    counters.draws += views_.counts().draws + textures.draws;
    counters.shadow.textures = textures.updated;
    counters.shadow.textures_waiting = textures.waiting;
    if (!options_.look_up.as_printed) return;
    const auto& counted = counts_.as<shadow_textures::shared::LookupCounts>()[0];
    counters.shadow.looked_up = counted.results;
    counters.shadow.looked_up_wrong = counted.wrong;
}

}   // namespace gnomon::raster
