// SPDX-License-Identifier: Apache-2.0
#include "raster/thinned_shadows.h"

#include <cmath>

#include "ray/origin.h"
#include "scene/light_reach.h"

namespace gnomon::raster {

void ThinnedShadows::update(vk::Commands& commands, const scene::SceneState& state,
                            std::span<const glm::vec4, 6> planes)
{
    state_ = &state;
    others_->update(commands, state, planes);
}

void ThinnedShadows::fill(vk::Commands& commands, const GBuffer& surfaces, std::uint32_t first, std::uint32_t count,
                          const vk::Image& visibility)
{
    others_->fill(commands, surfaces, first, count, visibility);
    const vk::Buffer positions = commands.read_back(surfaces.position),
                     geometric = commands.read_back(surfaces.geometric), ids = commands.read_back(surfaces.ids);
    std::vector<vk::Buffer> layers;
    for (std::uint32_t l = 0; l < count; ++l) layers.push_back(commands.read_back(visibility, l));
    commands.submit();

    const auto width = static_cast<std::size_t>(visibility.width()),
               height = static_cast<std::size_t>(visibility.height());
    const std::size_t pixels = width * height;
    const std::size_t stride = (pixels + 3) / 4 * 4;   // offsets of copies are multiples of four bytes
    std::vector<std::uint8_t> lit(stride * count);
    const std::span<const glm::vec4> at = positions.as<glm::vec4>(), faces = geometric.as<glm::vec4>();
    const std::span<const glm::uvec2> id = ids.as<glm::uvec2>();
    tasks_.for_each(height * count, [&](std::size_t task, int) {
        const std::size_t l = task / height, y = task % height;
        const auto light = static_cast<scene::LightId>(first + l);
        const scene::LightReach reach(state_->scene().lights[light], state_->light(light));
        const float end = reach.directional() ? k_infinity : ray::k_shadow_ray_end;
        const std::uint8_t* from = layers[l].as<std::uint8_t>().data() + y * width;
        std::uint8_t* to = &lit[l * stride + y * width];
        ray::RayQueue queue;
        std::vector<std::size_t> column;
        for (std::size_t x = 0; x < width; ++x) {
            to[x] = from[x];
            const std::size_t i = y * width + x;
            if (id[i].x == 0 || from[x] == 0) continue;
            glm::vec3 corners[3];
            rays_.geometry(id[i].x - 1).corners(id[i].y, corners);
            const glm::vec3 normal(faces[i]), origin = glm::vec3(at[i]) + ray::origin_lift(corners) * normal;
            const glm::vec3 to_light = reach.from(origin);
            if (!reach.faces(to_light, normal)) continue;
            queue.push(origin, 0, to_light, end);
            column.push_back(x);
        }
        std::vector<glm::vec3> passes(queue.size());
        rays_.let_through(queue, 0, queue.size(), passes.data());
        for (std::size_t k = 0; k < column.size(); ++k) {
            const float part = static_cast<float>(to[column[k]]) * luminance(passes[k]);
            to[column[k]] = static_cast<std::uint8_t>(std::lround(part));
        }
    });

    if (sent_.bytes() != lit.size()) sent_ = vk::Buffer(device_, "thinned shadows", lit.size());
    const vk::Upload upload = vk::upload_of(sent_, std::span<const std::uint8_t>(lit));
    commands.upload("send thinned shadows", {&upload, 1});
    commands.pass("thinned shadows to image")
        .reads(sent_, vk::Use::copy_source)
        .writes(visibility, vk::Use::copy_target)
        .copy([&, count, stride](vk::Recorder& r) {
            for (std::uint32_t l = 0; l < count; ++l) {
                VkBufferImageCopy layer{};
                layer.bufferOffset = l * stride;
                layer.imageSubresource = {visibility.aspect(), 0, l, 1};
                layer.imageExtent = {visibility.width(), visibility.height(), 1};
                r.copy(sent_, visibility, {&layer, 1});
            }
        });
}

}   // namespace gnomon::raster
