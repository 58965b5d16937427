// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scenes made in code for tests: tracks, meshes, materials of every surface class, and complete random scenes.

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <string>

#include "base/random.h"
#include "scene/scene.h"
#include "scene/state.h"

namespace gnomon::test {

/// Rotates and sways without end, each instance differently.
class SwayTrack final : public scene::TransformTrack {
 public:
    SwayTrack(const glm::dvec3& centre, std::uint64_t seed, double size = 1) : centre_(centre), size_(size)
    {
        Random random(seed);
        for (double* value : {&axis_.x, &axis_.y, &axis_.z, &phase_.x, &phase_.y, &phase_.z})
            *value = 0.1 + random.uniform();
        axis_ = glm::normalize(axis_);
    }
    glm::dmat4 evaluate(double time) const override
    {
        const glm::dvec3 sway(std::sin(time + 6 * phase_.x), std::sin(1.3 * time + 6 * phase_.y),
                              std::sin(0.7 * time + 6 * phase_.z));
        const glm::dmat4 turn = glm::rotate(glm::dmat4(1), time * (0.5 + phase_.x), axis_);
        return glm::translate(glm::dmat4(1), centre_ + size_ * sway) * turn;
    }
    std::vector<scene::Interval> changing() const override { return {{-1e9, 1e9}}; }

 private:
    glm::dvec3 centre_, axis_{0}, phase_{0};
    double size_;
};

/// One matrix before a time, another from that time on.
class JumpTrack final : public scene::TransformTrack {
 public:
    JumpTrack(double time, const glm::dmat4& before, const glm::dmat4& after)
        : time_(time), before_(before), after_(after)
    {
    }
    glm::dmat4 evaluate(double time) const override { return time < time_ ? before_ : after_; }
    std::vector<scene::Interval> changing() const override { return {{time_, time_}}; }

 private:
    double time_;
    glm::dmat4 before_, after_;
};

inline std::shared_ptr<scene::VisibilityTrack> visibility(std::vector<double> times, std::vector<bool> visible)
{
    auto track = std::make_shared<scene::VisibilityTrack>();
    track->times = std::move(times);
    track->visible = std::move(visible);
    return track;
}

/// The materials of add_materials(), by index.
enum MaterialIndex : scene::MaterialId { two_sided, one_sided, cut_out, cut_out_one_sided, glass, material_count };

/// A chessboard mask of 8 x 8 squares, every second one transparent.
inline scene::Texture chessboard()
{
    Image8 image(8, 8, 4);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
            std::uint8_t* pixel = image.pixel(x, y);
            pixel[0] = pixel[1] = pixel[2] = 200, pixel[3] = (x + y) % 2 ? 255 : 0;
        }
    scene::Sampler sampler;
    sampler.magnify = sampler.minify = scene::Filter::nearest;
    return {"chessboard", image, true, sampler};
}

inline void add_materials(scene::Scene& scene)
{
    scene.textures.push_back(chessboard());
    scene.materials.resize(material_count);
    for (const auto i : {two_sided, cut_out, glass}) scene.materials[i].double_sided = true;
    for (const auto i : {cut_out, cut_out_one_sided}) {
        scene.materials[i].alpha_mode = scene::AlphaMode::mask;
        scene.materials[i].base_color_texture.texture = 0;
        scene.materials[i].base_color_texture.scale = {3, 2};
    }
    scene.materials[glass].transmission = 1;
}

/// A closed, bumpy ball of radius 1, wound counter-clockwise, with texture coordinates by angle and one material.
inline scene::Mesh ball(scene::MaterialId material, int rings = 6, int segments = 9, std::uint64_t seed = 1)
{
    scene::Mesh mesh;
    Random random(seed);
    for (int r = 0; r <= rings; ++r)
        for (int s = 0; s <= segments; ++s) {
            const double up = k_pi * r / rings, around = 2 * k_pi * (s % segments) / segments;
            const double ring = r == 0 || r == rings ? 0 : std::sin(up);
            const bool seam = s == segments || ring == 0;
            const float bump = seam ? 1.0f : random.uniform(0.8f, 1.2f);
            const glm::vec3 p(ring * std::cos(around), std::cos(up), -ring * std::sin(around));
            mesh.positions.push_back(seam && s > 0 ? mesh.positions[mesh.positions.size() - static_cast<std::size_t>(s)]
                                                   : bump * p);
            mesh.texcoords[0].emplace_back(static_cast<float>(s) / static_cast<float>(segments),
                                           static_cast<float>(r) / static_cast<float>(rings));
        }
    mesh.normals = mesh.positions;
    for (glm::vec3& n : mesh.normals) n = glm::normalize(n);
    const auto at = [&](int r, int s) { return static_cast<std::uint32_t>(r * (segments + 1) + s); };
    for (int r = 0; r < rings; ++r)
        for (int s = 0; s < segments; ++s) {
            if (r > 0) mesh.triangles.emplace_back(at(r, s), at(r + 1, s), at(r, s + 1));
            if (r + 1 < rings) mesh.triangles.emplace_back(at(r, s + 1), at(r + 1, s), at(r + 1, s + 1));
        }
    mesh.parts = {{material, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    return mesh;
}

/// A ball with one part of each material, in an order that finish() has to sort.
inline scene::Mesh patchwork(std::uint64_t seed = 1)
{
    scene::Mesh mesh = ball(two_sided, 7, 10, seed);
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    mesh.parts.clear();
    std::uint32_t begin = 0;
    const scene::MaterialId order[] = {glass, cut_out, one_sided, cut_out_one_sided, two_sided};
    for (std::uint32_t i = 0; i < 5; ++i) {
        const std::uint32_t end = count * (i + 1) / 5;
        mesh.parts.push_back({order[i], begin, end - begin});
        begin = end;
    }
    return mesh;
}

/// Adds vertex keys: the mesh changes between two shapes over times 0 to 2 and 2 to 5.
inline void add_vertex_keys(scene::Mesh& mesh)
{
    scene::VertexKeys keys;
    keys.times = {0, 2, 5};
    keys.positions.assign(3, mesh.positions);
    for (glm::vec3& p : keys.positions[1]) p = {1.5f * p.x, 0.4f * p.y, p.z + 0.3f * p.y};
    for (glm::vec3& p : keys.positions[2]) p = {0.6f * p.x, 1.6f * p.y + 0.2f * p.x, p.z};
    mesh.vertex_keys = std::move(keys);
}

inline scene::NodeId add_object(scene::Scene& scene, scene::MeshId mesh, scene::NodeId parent = scene::none,
                                const glm::dmat4& local = glm::dmat4(1))
{
    const scene::NodeId node = scene.add_node("", parent, local);
    scene.nodes[node].mesh = mesh;
    return node;
}

/// A placement in a cube of half-width `reach`, rotated, scaled, and mirrored for every third seed.
inline glm::dmat4 random_placement(Random& random, float reach)
{
    const auto coordinate = [&] { return static_cast<double>(random.uniform(-reach, reach)); };
    const auto stretch = [&] { return static_cast<double>(random.uniform(0.5f, 1.5f)); };
    const glm::dvec3 place(coordinate(), coordinate(), coordinate());
    const double angle = 6.0 * static_cast<double>(random.uniform());
    const glm::dvec3 axis = glm::normalize(glm::dvec3(1, coordinate(), coordinate()));
    const glm::dvec3 size(random.below(3) == 0 ? -stretch() : stretch(), stretch(), stretch());
    return glm::scale(glm::rotate(glm::translate(glm::dmat4(1), place), angle, axis), size);
}

inline glm::dmat4 translation(double x, double y, double z)
{
    return glm::translate(glm::dmat4(1), glm::dvec3(x, y, z));
}

/// A scene with the materials above, one ball mesh and no objects yet.
inline scene::Scene scene_with_balls()
{
    scene::Scene scene;
    add_materials(scene);
    scene.meshes.push_back(ball(two_sided));
    return scene;
}

inline std::shared_ptr<const scene::Scene> finished(scene::Scene& scene)
{
    scene.finish();
    return std::make_shared<const scene::Scene>(std::move(scene));
}

struct RandomSceneOptions {
    int still = 12;
    int dynamic_objects = 5;   // each a rigid group of two objects
    int deforming = 2;         // one of them on a moving node
    float reach = 6;
};

inline std::shared_ptr<const scene::Scene> make_random_scene(std::uint64_t seed, const RandomSceneOptions& options = {})
{
    scene::Scene scene;
    add_materials(scene);
    Random random(seed);
    for (scene::MaterialId m = 0; m < material_count; ++m) scene.meshes.push_back(ball(m, 5, 8, seed + m));
    scene.meshes.push_back(patchwork(seed));
    const auto rigid_meshes = static_cast<std::uint32_t>(scene.meshes.size());
    for (int i = 0; i < options.deforming; ++i) {
        scene.meshes.push_back(patchwork(seed + 100 + static_cast<std::uint64_t>(i)));
        add_vertex_keys(scene.meshes.edit(scene.meshes.size() - 1));
    }

    const scene::NodeId shelf = scene.add_node("shelf", scene::none, glm::translate(glm::dmat4(1), glm::dvec3(0.1)));
    for (int i = 0; i < options.still; ++i)
        add_object(scene, random.below(rigid_meshes), shelf, random_placement(random, options.reach));
    for (int i = 0; i < options.dynamic_objects; ++i) {
        const glm::dmat4 placement = random_placement(random, options.reach);
        const scene::NodeId anchor = scene.add_node("dynamic object", shelf);
        scene.nodes[anchor].transform =
            std::make_shared<SwayTrack>(glm::dvec3(placement[3]), seed * 1000 + static_cast<std::uint64_t>(i), 2);
        const scene::NodeId arm = scene.add_node("arm", anchor, random_placement(random, 1));
        add_object(scene, random.below(rigid_meshes), arm);
        add_object(scene, random.below(rigid_meshes), arm, random_placement(random, 1.5f));
    }
    for (int i = 0; i < options.deforming; ++i) {
        const glm::dmat4 placement = random_placement(random, options.reach);
        const scene::NodeId node =
            add_object(scene, rigid_meshes + static_cast<std::uint32_t>(i), scene::none, placement);
        if (i == 1)
            scene.nodes[node].transform = std::make_shared<SwayTrack>(glm::dvec3(placement[3]), seed * 1000 + 500, 2);
    }
    return finished(scene);
}

}   // namespace gnomon::test
