// SPDX-License-Identifier: Apache-2.0
#include "reference/emitter_sampler.h"

#include <algorithm>

#include "base/interruption.h"

namespace gnomon::reference {

namespace {

constexpr int k_looks = 4;               // per side, at which a textured triangle's mean emission is looked up
constexpr float k_least_share = 0.05f;   // of the emission that its factor promises

bool may_emit(const scene::Material& material)
{
    return material.emissive != glm::vec3(0) && material.model != scene::ShadingModel::unlit;
}

// Mean luminance of a triangle's emission.
float mean_emission(const scene::Scene& scene, const ray::ObjectGeometry& geometry, std::uint32_t triangle,
                    const scene::Material& material)
{
    const float promised = luminance(material.emissive);
    const scene::TextureUse& use = material.emissive_texture;
    if (!use.used() || geometry.mesh->texcoords[use.texcoord].empty()) return promised;
    const auto& coordinates = geometry.mesh->texcoords[use.texcoord];
    const glm::uvec3 index = geometry.mesh->triangles[triangle];
    float sum = 0;
    int count = 0;
    for (int i = 0; i < k_looks; ++i)
        for (int j = 0; i + j < k_looks; ++j, ++count) {
            const float u = (static_cast<float>(i) + 1.0f / 3) / k_looks,
                        v = (static_cast<float>(j) + 1.0f / 3) / k_looks;
            const glm::vec2 at =
                (1 - u - v) * coordinates[index[0]] + u * coordinates[index[1]] + v * coordinates[index[2]];
            sum += luminance(material.emissive * glm::vec3(scene.textures[use.texture].sample(use.apply(at), 0)));
        }
    return std::max(sum / static_cast<float>(count), k_least_share * promised);
}

}   // namespace

EmitterSampler::EmitterSampler(const scene::SceneState& state, const ray::RayScene& rays)
{
    const scene::Scene& scene = state.scene();
    double total = 0;
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) {
        if (!state.object_there(o)) continue;
        const ray::ObjectGeometry& geometry = rays.geometry(o);
        for (const scene::MeshPart& part : geometry.mesh->parts) {
            const scene::Material& material = scene.materials[part.material];
            if (!may_emit(material)) continue;
            interruption_point();
            std::vector<float>& densities = densities_[o];
            densities.resize(geometry.mesh->triangles.size(), 0.0f);
            for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
                Triangle triangle{o, t, {}, 0};
                geometry.corners(t, triangle.corners);
                const glm::vec3 cross =
                    glm::cross(triangle.corners[1] - triangle.corners[0], triangle.corners[2] - triangle.corners[0]);
                const double area = 0.5 * glm::length(glm::dvec3(cross));
                triangle.density = mean_emission(scene, geometry, t, material);   // divided by the total below
                const double weight = area * static_cast<double>(triangle.density);
                if (!(weight > 0) || !std::isfinite(weight)) continue;
                total += weight;
                triangles_.push_back(triangle);
                sums_.push_back(total);
            }
        }
    }
    for (Triangle& triangle : triangles_) {
        triangle.density = static_cast<float>(static_cast<double>(triangle.density) / total);
        densities_[triangle.object][triangle.triangle] = triangle.density;
    }
}

EmitterPoint EmitterSampler::sample(float u, float v, float w) const
{
    const double wanted = static_cast<double>(u) * sums_.back();
    const auto at = std::min<std::ptrdiff_t>(std::upper_bound(sums_.begin(), sums_.end(), wanted) - sums_.begin(),
                                             static_cast<std::ptrdiff_t>(sums_.size()) - 1);
    const Triangle& triangle = triangles_[static_cast<std::size_t>(at)];
    // Map the square to the triangle [Turk 1990].
    const float root = std::sqrt(v);
    const float a = 1 - root, b = root * (1 - w), c = root * w;
    return {triangle.object, triangle.triangle,
            a * triangle.corners[0] + b * triangle.corners[1] + c * triangle.corners[2], triangle.density};
}

float EmitterSampler::density(scene::ObjectId object, std::uint32_t triangle) const
{
    const auto at = densities_.find(object);
    return at == densities_.end() ? 0 : at->second[triangle];
}

glm::vec3 EmitterSampler::emission(const shading::SurfacePoint& surface, const scene::Material& material)
{
    if (!may_emit(material) || (material.one_sided() && !surface.front)) return glm::vec3(0);
    return surface.emissive * surface.coverage;
}

}   // namespace gnomon::reference
