// SPDX-License-Identifier: Apache-2.0
#pragma once
// Hands a scene that was read from a file over as a host would: through a SceneBuilder, with the values of its tracks
// frame by frame.

#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "api/convert.h"
#include "api/scene_access.h"
#include "gnomon/renderer.h"
#include "gnomon/scene_builder.h"
#include "scene/scene.h"
#include "scene/state.h"

namespace gnomon::test {

class HostCopy {
 public:
    /// @param read  as the reader gives it, without default light and camera
    explicit HostCopy(const std::shared_ptr<const scene::Scene>& read)
        : read_(read), tracks_(read, read->timeline.start)
    {
        add_textures();
        for (const scene::Material& material : read_->materials)
            materials_.push_back(builder_.material(converted(material)));
        for (const scene::Mesh& mesh : read_->meshes) meshes_.push_back(add_mesh(mesh));
        for (const scene::Node& node : read_->nodes)
            nodes_.push_back(builder_.node(api::transform_of(local_at(node, read_->timeline.start)),
                                           {.mobility = node.may_move() ? Mobility::may_move : Mobility::fixed,
                                            .parent = node.parent == scene::none ? NodeId{} : nodes_[node.parent],
                                            .name = node.name}));
        for (const scene::Skin& skin : read_->skins) {
            Skin own;
            for (const scene::NodeId joint : skin.joints) own.joints.push_back(nodes_[joint]);
            for (const glm::dmat4& bind : skin.inverse_bind) own.inverse_bind.push_back(api::transform_of(bind));
            skins_.push_back(builder_.skin(own));
        }
        for (std::size_t n = 0; n < nodes_.size(); ++n)
            if (read_->nodes[n].mesh != scene::none) attach(n);
        for (const scene::Light& light : read_->lights)
            builder_.light(api::from_scene(light), {}, {.parent = nodes_[light.node]});
        for (const scene::Camera& camera : read_->cameras)
            builder_.camera(api::from_scene(camera, glm::dmat4(1)), {.parent = nodes_[camera.node]});
        builder_.background(api::vec(read_->background.color));
        builder_.ambient(api::vec(read_->ambient));
    }

    SceneBuilder& builder() { return builder_; }

    /// Everything that tracks say about a time.
    FrameInput input_at(double time)
    {
        tracks_.advance(time);
        FrameInput input;
        input.time = time;
        for (std::size_t n = 0; n < nodes_.size(); ++n) {
            const scene::Node& node = read_->nodes[n];
            if (node.transform)
                input.transforms.push_back({nodes_[n], api::transform_of(node.transform->evaluate(time))});
            if (node.visibility) input.visibility.push_back({nodes_[n], node.visibility->evaluate(time)});
            if (node.mesh == scene::none) continue;
            const scene::Mesh& mesh = read_->meshes[node.mesh];
            const InstanceId instance(nodes_[n]);
            if (node.weights) {
                std::vector<float> weights(mesh.morph_targets.size());
                node.weights->evaluate(time, weights);
                input.morph_weights.push_back({instance, weights});
            }
            if (mesh.vertex_keys) add_keyed(instance, static_cast<scene::NodeId>(n), input);
        }
        return input;
    }

 private:
    static glm::dmat4 local_at(const scene::Node& node, double time)
    {
        return node.transform ? node.transform->evaluate(time) : node.local;
    }
    template <class To, class From>
    static std::span<const To> as(const std::vector<From>& from)
    {
        static_assert(sizeof(To) == sizeof(From));
        return {reinterpret_cast<const To*>(from.data()), from.size()};
    }

    void add_textures()
    {
        for (const scene::Texture& texture : read_->textures) {
            const Image8& rgba = texture.levels().front();
            const int channels = texture.has_alpha() ? 4 : 3;
            std::vector<std::uint8_t> pixels;
            for (std::size_t i = 0; i < rgba.data.size(); ++i)
                if (static_cast<int>(i % 4) < channels) pixels.push_back(rgba.data[i]);
            const scene::Sampler& s = texture.sampler();
            textures_.push_back(builder_.texture({.width = rgba.width,
                                                  .height = rgba.height,
                                                  .channels = channels,
                                                  .pixels = pixels,
                                                  .srgb = texture.srgb(),
                                                  .wrap_u = static_cast<Wrap>(s.wrap_u),
                                                  .wrap_v = static_cast<Wrap>(s.wrap_v),
                                                  .magnify = static_cast<Filter>(s.magnify),
                                                  .minify = static_cast<Filter>(s.minify),
                                                  .mipmaps = s.mipmaps}));
        }
    }
    Material converted(scene::Material material)
    {
        // Convert without textures, whose ids are the builder's, then set them.
        std::vector<scene::TextureUse> uses;
        for (scene::TextureUse* use :
             {&material.base_color_texture, &material.metallic_roughness_texture, &material.normal_texture,
              &material.occlusion_texture, &material.emissive_texture}) {
            uses.push_back(*use);
            use->texture = scene::none;
        }
        Material result = api::from_scene(material, api::SceneStamps());
        std::size_t at = 0;
        for (TextureUse* use : {&result.base_color_texture, &result.metallic_roughness_texture, &result.normal_texture,
                                &result.occlusion_texture, &result.emissive_texture}) {
            const scene::TextureUse& own = uses[at++];
            if (own.used()) use->texture = textures_[own.texture];
        }
        return result;
    }
    MeshId add_mesh(const scene::Mesh& from)
    {
        Mesh mesh;
        mesh.name = from.name;
        mesh.positions = as<Vec3>(from.positions);
        mesh.indices = {reinterpret_cast<const std::uint32_t*>(from.triangles.data()), from.triangles.size() * 3};
        mesh.normals = as<Vec3>(from.normals);
        mesh.tangents = as<Vec4>(from.tangents);
        for (std::size_t set = 0; set < 2; ++set) mesh.texcoords[set] = as<Vec2>(from.texcoords[set]);
        mesh.colors = as<Vec4>(from.colors);
        std::vector<MeshPart> parts;
        for (const scene::MeshPart& part : from.parts)
            parts.push_back({materials_[part.material], part.first_triangle, part.triangle_count});
        mesh.parts = parts;
        std::vector<MorphTarget> targets;
        for (const scene::MorphTarget& target : from.morph_targets)
            targets.push_back({as<Vec3>(target.positions), as<Vec3>(target.normals), as<Vec3>(target.tangents)});
        mesh.morph_targets = targets;
        mesh.morph_weights = from.morph_weights;
        if (from.skin)
            for (std::size_t group = 0; group < 2; ++group) {
                mesh.joints[group] = as<Joints>(from.skin->joints[group]);
                mesh.weights[group] = as<Vec4>(from.skin->weights[group]);
            }
        return builder_.mesh(mesh);
    }
    void attach(std::size_t n)
    {
        const scene::Node& node = read_->nodes[n];
        const scene::Mesh& mesh = read_->meshes[node.mesh];
        InstanceOptions options;
        if (mesh.vertex_keys || (!mesh.morph_targets.empty() && node.weights)) options.mobility = Mobility::may_deform;
        if (node.skin != scene::none && mesh.skin) options.skin = skins_[node.skin];
        options.morph_weights = node.morph_weights;
        options.reach = reach_of(n);
        builder_.attach(nodes_[n], meshes_[node.mesh], {}, options);
    }
    // Where tracks take an instance, as the light views of the file's scene have it.
    Box reach_of(std::size_t n) const
    {
        const scene::Mesh& mesh = read_->meshes[read_->nodes[n].mesh];
        Box3 own = mesh.bounds(), reach;
        if (own.empty()) return {};
        if (mesh.vertex_keys)
            for (const auto& key : mesh.vertex_keys->positions)
                for (const glm::vec3& p : key) own.add(p);
        const int frames = std::max(read_->timeline.frames, 1), times = std::min(frames, 256);
        for (int i = 0; i < times; ++i) {
            const int frame = times > 1 ? 1 + static_cast<int>(std::int64_t{frames - 1} * i / (times - 1)) : 1;
            const glm::dmat4 world = read_->world_matrix(static_cast<scene::NodeId>(n), read_->timeline.time_of(frame));
            for (int corner = 0; corner < 8; ++corner)
                reach.add(glm::vec3(transform_point(
                    world, glm::dvec3(corner & 1 ? own.high.x : own.low.x, corner & 2 ? own.high.y : own.low.y,
                                      corner & 4 ? own.high.z : own.low.z))));
        }
        return {api::vec(reach.low), api::vec(reach.high)};
    }
    void add_keyed(const InstanceId& instance, scene::NodeId node, FrameInput& input)
    {
        for (std::size_t o = 0; o < read_->objects.size(); ++o) {
            if (read_->objects[o].node != node) continue;
            const scene::DeformedMesh& shape = tracks_.deformed(static_cast<scene::ObjectId>(o));
            input.vertices.push_back({instance, as<Vec3>(shape.positions), as<Vec3>(shape.normals)});
        }
    }

    std::shared_ptr<const scene::Scene> read_;
    scene::SceneState tracks_;
    SceneBuilder builder_;
    std::vector<TextureId> textures_;
    std::vector<MaterialId> materials_;
    std::vector<MeshId> meshes_;
    std::vector<NodeId> nodes_;
    std::vector<SkinId> skins_;
};

}   // namespace gnomon::test
