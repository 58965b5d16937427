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
    std::vector<Source> sources;
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) {
        if (!state.object_there(o)) continue;
        const ray::ObjectGeometry& geometry = rays.geometry(o);
        for (const scene::MeshPart& part : geometry.mesh->parts) {
            const scene::Material& material = scene.materials[part.material];
            if (!may_emit(material)) continue;
            interruption_point();
            std::vector<std::uint32_t>& numbers = numbers_[o];
            numbers.resize(geometry.mesh->triangles.size(), k_none);
            for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
                Triangle triangle{o, t, {}, 0, 0};
                geometry.corners(t, triangle.corners);
                const glm::vec3 cross =
                    glm::cross(triangle.corners[1] - triangle.corners[0], triangle.corners[2] - triangle.corners[0]);
                const double area = 0.5 * glm::length(glm::dvec3(cross));
                triangle.density = mean_emission(scene, geometry, t, material);   // divided by the total below
                const double weight = area * static_cast<double>(triangle.density);
                if (!(weight > 0) || !std::isfinite(weight)) continue;
                total += weight;
                triangle.area = static_cast<float>(area);
                numbers[t] = static_cast<std::uint32_t>(triangles_.size());
                triangles_.push_back(triangle);
                sums_.push_back(total);
                Source& source = sources.emplace_back();
                for (const glm::vec3& corner : triangle.corners) source.bounds.add(corner);
                source.axis = glm::vec3(glm::dvec3(cross) / (geometry.mirrored ? -2 * area : 2 * area));
                source.reach = static_cast<float>(k_pi / 2);
                source.two_sided = !material.one_sided();
                source.power = static_cast<float>(weight);
            }
        }
    }
    for (Triangle& triangle : triangles_)
        triangle.density = static_cast<float>(static_cast<double>(triangle.density) / total);
    tree_ = SourceTree(sources);
}

EmitterPoint EmitterSampler::sample(float u, float v, float w) const
{
    const double wanted = static_cast<double>(u) * sums_.back();
    const auto at = std::min<std::ptrdiff_t>(std::upper_bound(sums_.begin(), sums_.end(), wanted) - sums_.begin(),
                                             static_cast<std::ptrdiff_t>(sums_.size()) - 1);
    return point_of(triangles_[static_cast<std::size_t>(at)], v, w);
}

// A point of a triangle, uniformly [Turk 1990].
EmitterPoint EmitterSampler::point_of(const Triangle& triangle, float v, float w)
{
    const float root = std::sqrt(v);
    const float a = 1 - root, b = root * (1 - w), c = root * w;
    return {triangle.object,
            triangle.triangle,
            b,
            c,
            a * triangle.corners[0] + b * triangle.corners[1] + c * triangle.corners[2],
            triangle.density};
}

std::uint32_t EmitterSampler::number_of(scene::ObjectId object, std::uint32_t triangle) const
{
    const auto at = numbers_.find(object);
    return at == numbers_.end() ? k_none : at->second[triangle];
}

float EmitterSampler::density(scene::ObjectId object, std::uint32_t triangle) const
{
    const std::uint32_t number = number_of(object, triangle);
    return number == k_none ? 0 : triangles_[number].density;
}

EmitterPoint EmitterSampler::sample_for(const glm::vec3& position, const glm::vec3& normal, double u, float v,
                                        float w) const
{
    const SourceTree::Choice choice = tree_.choose(position, normal, u);
    if (!(choice.chance > 0)) return {};
    const Triangle& triangle = triangles_[choice.source];
    EmitterPoint point = point_of(triangle, v, w);
    point.density = choice.chance / triangle.area;
    return point;
}

float EmitterSampler::density_for(const glm::vec3& position, const glm::vec3& normal, scene::ObjectId object,
                                  std::uint32_t triangle) const
{
    const std::uint32_t number = number_of(object, triangle);
    return number == k_none ? 0 : tree_.chance(number, position, normal) / triangles_[number].area;
}

glm::vec3 EmitterSampler::emission(const shading::SurfacePoint& surface, const scene::Material& material)
{
    if (!may_emit(material) || (material.one_sided() && !surface.front)) return glm::vec3(0);
    return surface.emissive * surface.coverage;
}

}   // namespace gnomon::reference
