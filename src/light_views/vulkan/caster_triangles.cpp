// SPDX-License-Identifier: Apache-2.0
#include "light_views/vulkan/caster_triangles.h"

#include <fmt/format.h>

#include "gnomon/error.h"

namespace gnomon::light_views {

// Assigns a range to every object.
void CasterTriangles::number(const scene::Scene& scene)
{
    std::vector<std::uint32_t> of_mesh;
    for (const scene::Mesh& mesh : scene.meshes) {
        std::uint32_t count = 0;
        for (const scene::MeshPart& part : mesh.parts)
            if (scene.materials[part.material].surface_class() != scene::SurfaceClass::transparent)
                count += part.triangle_count;
        of_mesh.push_back(count);
    }
    std::size_t count = 0;
    for (const scene::Object& object : scene.objects) {
        first_.push_back(static_cast<std::uint32_t>(count));
        count += of_mesh[object.mesh];
    }
    first_.push_back(static_cast<std::uint32_t>(count));
    written_at_.assign(scene.objects.size(), k_not_written);
    const std::size_t bytes = std::max<std::size_t>(count, 1) * sizeof(shared::CellTriangle);
    if (bytes > device_->limits().maxStorageBufferRange)
        throw MissingError(
            fmt::format("Vulkan: the triangles for hard shadows need {} MB, but the device's buffers "
                        "hold only {} MB; use --shadow-filter 1 instead",
                        bytes >> 20, device_->limits().maxStorageBufferRange >> 20));
    buffer_ = vk::Buffer(device_, "caster triangles", bytes);
}

void CasterTriangles::write(const CasterGeometry& casters, const scene::SceneState& state, scene::ObjectId object)
{
    const scene::Scene& scene = state.scene();
    const scene::Mesh& mesh = scene.meshes[scene.objects[object].mesh];
    const auto& positions = scene.objects[object].deforming ? state.deformed(object).positions : mesh.positions;
    const glm::mat4 to_world = state.object_matrix(object);
    world_.clear();
    for (const glm::vec3& p : positions) world_.emplace_back(to_world * glm::vec4(p, 1));

    const auto add_part = [&](const scene::MeshPart& part, std::uint32_t first, std::uint32_t material) {
        for (std::uint32_t t = 0; t < part.triangle_count; ++t) {
            const auto& triangle = mesh.triangles[part.first_triangle + t];
            written_.push_back(
                {world_[triangle[0]], world_[triangle[1]], world_[triangle[2]], object, first + t, material});
        }
    };
    // Use the order of CasterGeometry.
    std::uint32_t opaque = casters.opaque(object).first_index / 3;
    std::size_t masked = 0;
    for (const scene::MeshPart& part : mesh.parts) {
        const scene::SurfaceClass surface = scene.materials[part.material].surface_class();
        if (surface == scene::SurfaceClass::opaque) {
            add_part(part, opaque, scene::none);
            opaque += part.triangle_count;
        } else if (surface == scene::SurfaceClass::masked && part.triangle_count > 0) {
            const CasterGeometry::Part& drawn = casters.masked(object)[masked++];
            add_part(part, drawn.first_index / 3, drawn.material);
        }
    }
}

CasterTriangles::Run CasterTriangles::of(const CasterGeometry& casters, const scene::SceneState& state,
                                         scene::ObjectId object)
{
    if (first_.empty()) number(state.scene());
    if (written_at_[object] == k_not_written) {
        written_at_[object] = written_.size();
        to_send_.push_back(object);
        write(casters, state, object);
    }
    const std::uint32_t count = first_[object + 1] - first_[object];
    return {first_[object], std::span(written_).subspan(written_at_[object], count)};
}

void CasterTriangles::send(vk::Commands& commands)
{
    if (!buffer_) buffer_ = vk::Buffer(device_, "caster triangles", sizeof(shared::CellTriangle));
    std::vector<vk::Upload> uploads;
    for (const scene::ObjectId object : to_send_) {
        const std::span<const shared::CellTriangle> run =
            std::span(written_).subspan(written_at_[object], first_[object + 1] - first_[object]);
        written_at_[object] = k_not_written;
        if (!run.empty()) uploads.push_back(vk::upload_of(buffer_, run, first_[object] * sizeof(shared::CellTriangle)));
    }
    if (!uploads.empty()) commands.upload("caster triangles", uploads);
    to_send_.clear();
    written_.clear();
}

}   // namespace gnomon::light_views
