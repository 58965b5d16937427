// SPDX-License-Identifier: Apache-2.0
// A hash of everything that the pixels of a video depend on: the scene except names, and the options that affect
// images. It ensures that frames from before an edit are not reused after it.
#include <algorithm>
#include <functional>

#include "api/scene_access.h"
#include "base/hash.h"
#include "gnomon/renderer.h"
#include "scene/environment.h"
#include "scene/material_layers.h"
#include "scene/scene.h"
#include "scene/value_tracks.h"
#include "video/identity.h"

namespace gnomon::video {

namespace {
class Fingerprint {
 public:
    template <class T>
    requires std::is_arithmetic_v<T> || std::is_enum_v<T>
    void add(T value) { hash_ = hash_bytes(&value, sizeof value, hash_); }
    void add(const std::string& text)
    {
        add(text.size());
        hash_ = hash_bytes(text.data(), text.size(), hash_);
    }
    template <int N, class T, glm::qualifier Q>
    void add(const glm::vec<N, T, Q>& v)
    {
        for (int i = 0; i < N; ++i) add(v[i]);
    }
    void add(const glm::dmat4& m)
    {
        for (int column = 0; column < 4; ++column) add(m[column]);
    }
    /// @param values  of a type without padding
    template <class T>
    void add_all(const std::vector<T>& values)
    {
        add(values.size());
        hash_ = hash_bytes(values.data(), values.size() * sizeof(T), hash_);
    }
    std::uint64_t value() const { return hash_; }

 private:
    std::uint64_t hash_ = hash_bytes(nullptr, 0);
};

void add_mesh(Fingerprint& print, const scene::Mesh& mesh)
{
    print.add_all(mesh.positions), print.add_all(mesh.normals), print.add_all(mesh.tangents);
    for (const auto& set : mesh.texcoords) print.add_all(set);
    print.add_all(mesh.colors);
    print.add_all(mesh.triangles);
    for (const scene::MeshPart& part : mesh.parts) print.add(part.material), print.add(part.triangle_count);

    // Add the data that deforms it.
    print.add(mesh.morph_targets.size()), print.add(mesh.skin.has_value()), print.add(mesh.vertex_keys.has_value());
    for (const scene::MorphTarget& target : mesh.morph_targets)
        print.add_all(target.positions), print.add_all(target.normals), print.add_all(target.tangents);
    print.add_all(mesh.morph_weights);
    if (mesh.skin) {
        for (const auto& joints : mesh.skin->joints) print.add_all(joints);
        for (const auto& weights : mesh.skin->weights) print.add_all(weights);
    }
    if (mesh.vertex_keys) {
        print.add_all(mesh.vertex_keys->times);
        for (const auto& positions : mesh.vertex_keys->positions) print.add_all(positions);
        for (const auto& normals : mesh.vertex_keys->normals) print.add_all(normals);
    }
}

void add_material(Fingerprint& print, const scene::Material& material)
{
    print.add(material.catches_shadows);
    print.add(material.model), print.add(material.double_sided), print.add(material.alpha_mode);
    for (const glm::vec3& color : {material.base_color, material.emissive, material.ambient, material.specular})
        print.add(color);
    for (const float value :
         {material.alpha, material.alpha_cutoff, material.metallic, material.roughness, material.normal_scale,
          material.occlusion_strength, material.transmission, material.shine, material.transmittance, material.ior})
        print.add(value);
    if (material.outline) print.add(material.outline);
    if (material.layers) {
        for (const auto member : scene::k_layer_numbers) print.add(*material.layers.*member);
        for (const auto member : scene::k_layer_colors) print.add(*material.layers.*member);
        print.add(material.layers->thin_walled);
    }
    for (const scene::TextureUse* use : scene::texture_uses(material)) {
        print.add(use->texture), print.add(use->texcoord);
        print.add(use->offset), print.add(use->scale), print.add(use->rotation);
    }
}

void add_texture(Fingerprint& print, const scene::Texture& texture)
{
    const scene::Sampler& sampler = texture.sampler();
    print.add(texture.width()), print.add(texture.height()), print.add(texture.srgb());
    print.add(sampler.wrap_u), print.add(sampler.wrap_v);
    print.add(sampler.magnify), print.add(sampler.minify), print.add(sampler.mipmaps);
    print.add_all(texture.levels().front().data);
}

void add_light_values(Fingerprint& print, const scene::Light& light)
{
    print.add(light.color);
    print.add(light.inner_angle), print.add(light.outer_angle), print.add(light.range);
}

void add_lights(Fingerprint& print, const scene::Scene& scene)
{
    print.add(scene.lights.size());
    for (const scene::Light& light : scene.lights) {
        print.add(light.type), print.add(light.falloff), print.add(light.profile), print.add(light.node);
        print.add(light.of_environment), print.add(light.by_default), print.add(light.of_surface);
        add_light_values(print, light);
    }
    const scene::Background& background = scene.background;
    print.add(background.kind);
    for (const glm::vec3& color : {background.color, background.zenith, background.horizon, background.ground,
                                   background.sun_direction, background.sun_radiance})
        print.add(color);
    if (background.environment) {
        const ImageF& image = background.environment->image();
        print.add(image.width), print.add(image.height), print.add_all(image.data);
    }
    print.add(scene.ambient);
}

void add_nodes(Fingerprint& print, const scene::Scene& scene)
{
    print.add(scene.nodes.size());
    for (const scene::Node& node : scene.nodes) {
        print.add(node.parent), print.add(node.local);
        print.add(node.mesh), print.add(node.skin), print.add_all(node.morph_weights);
    }
    for (const scene::Skin& skin : scene.skins) {
        print.add_all(skin.joints);
        for (const glm::dmat4& inverse_bind : skin.inverse_bind) print.add(inverse_bind);
    }
    for (const scene::Camera& camera : scene.cameras) {
        print.add(camera.name), print.add(camera.node);   // --camera selects by name
        print.add(camera.vertical_fov), print.add(camera.orthographic_height);
        print.add(camera.near), print.add(camera.far);
        if (camera.fit) print.add(camera.fit->eye(1)), print.add(camera.fit->eye(scene::CameraFit::k_node_aspect));
    }
}

// Calls `evaluate` at the first time, and at each time that follows a change.
void at_each_change(const std::vector<double>& times, const std::vector<scene::Interval>& changing,
                    const std::function<void(double)>& evaluate)
{
    std::size_t next = 0;
    for (std::size_t i = 0; i < times.size(); ++i) {
        while (i > 0 && next < changing.size() && changing[next].last < times[i - 1]) ++next;
        if (i == 0 || (next < changing.size() && changing[next].first <= times[i])) evaluate(times[i]);
    }
}

// Adds the values that tracks give lights, materials or cameras.
template <class T>
void add_value_tracks(Fingerprint& print, const std::vector<T>& parts, const std::vector<double>& times,
                      const std::function<void(const T&)>& add_values)
{
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (!parts[i].track) continue;
        print.add(i);
        T now = parts[i];
        at_each_change(times, now.track->changing(), [&](double t) {
            now.track->apply(t, now);
            add_values(now);
        });
    }
}

// Adds the values of tracks at the frames' times, or at some of them, evenly spaced, for a long clip.
void add_tracks(Fingerprint& print, const scene::Scene& scene)
{
    constexpr int k_most_times = 1024;
    const scene::Timeline& timeline = scene.timeline;
    const int count = std::min(std::max(timeline.frames, 1), k_most_times);
    std::vector<double> times;
    for (int i = 0; i < count; ++i)
        times.push_back(timeline.time_of(
            count == 1 ? 1 : 1 + static_cast<int>(std::int64_t{timeline.frames - 1} * i / (count - 1))));
    print.add(timeline.frames), print.add_all(times);

    std::vector<float> weights;
    for (const std::uint32_t n : scene.track_nodes) {
        const scene::Node& node = scene.nodes[n];
        print.add(n);
        if (node.transform)
            at_each_change(times, node.transform->changing(),
                           [&](double t) { print.add(node.transform->evaluate(t)); });
        if (node.weights && node.mesh != scene::none) {
            weights.resize(scene.meshes[node.mesh].morph_targets.size());
            at_each_change(times, node.weights->changing(), [&](double t) {
                node.weights->evaluate(t, weights);
                print.add_all(weights);
            });
        }
        if (node.visibility) {
            print.add_all(node.visibility->times);
            for (const bool visible : node.visibility->visible) print.add(visible);
        }
    }
    add_value_tracks<scene::Light>(print, scene.lights, times,
                                   [&](const scene::Light& light) { add_light_values(print, light); });
    add_value_tracks<scene::Material>(print, scene.materials, times,
                                      [&](const scene::Material& material) { add_material(print, material); });
    add_value_tracks<scene::Camera>(print, scene.cameras, times, [&](const scene::Camera& camera) {
        print.add(camera.vertical_fov), print.add(camera.orthographic_height);
        print.add(camera.near), print.add(camera.far);
    });
}
}   // namespace

std::uint64_t fingerprint_of(const scene::Scene& scene)
{
    Fingerprint print;
    print.add(scene.meshes.size()), print.add(scene.materials.size()), print.add(scene.textures.size());
    for (const scene::Mesh& mesh : scene.meshes) add_mesh(print, mesh);
    for (const scene::Material& material : scene.materials) add_material(print, material);
    for (const scene::Texture& texture : scene.textures) add_texture(print, texture);
    add_lights(print, scene);
    add_nodes(print, scene);
    add_tracks(print, scene);
    return print.value();
}

std::uint64_t fingerprint_of(const Scene& scene, const RenderOptions& options)
{
    return fingerprint_of(fingerprint_of(*api::scene_of(scene)), scene, options);
}

std::uint64_t fingerprint_of(std::uint64_t of_scene, const Scene& scene, const RenderOptions& options)
{
    Fingerprint print;
    print.add(of_scene);
    print.add(options.size.width), print.add(options.size.height);
    print.add(options.camera);
    print.add(options.turntable_seconds);
    // The turntable's angle per frame. A clip that numbers its own frames has the same times at any rate.
    if (options.turntable_seconds > 0) print.add(scene.fps());
    print.add(options.max_depth), print.add(options.samples), print.add(options.filter);
    // Frames without either have the fingerprint that they always had.
    if (options.shutter > 0) print.add(std::string("shutter")), print.add(options.shutter), print.add(scene.fps());
    if (options.f_number > 0 || options.aperture > 0) {
        print.add(std::string("lens")), print.add(options.f_number), print.add(options.aperture);
        print.add(options.focus.value_or(0));
    }
    print.add(options.exposure.has_value()), print.add(options.exposure.value_or(0));
    print.add(options.tonemap);
    print.add(options.background);
    for (const float channel : options.background_color) print.add(channel);
    print.add(options.accelerator);
    // Certified culling gives the same pixels as none; the published method's depend on its history, too.
    print.add(options.shadow_culling == ShadowCulling::paper);
    print.add(options.sun_size);
    print.add(options.indirect), print.add(options.indirect_on), print.add(options.bounces);
    print.add(options.renderer), print.add(options.shadow_textures), print.add(options.shadow_filter);
    print.add(options.as_printed), print.add(options.validity_margin), print.add(options.cluster_shadows);
    print.add(options.separate_trees);
    print.add(options.rsm_samples), print.add(options.indirect_level), print.add(options.indirect_at_every_pixel);
    print.add(options.depth_threshold), print.add(options.normal_threshold);
    print.add(options.ids), print.add(options.motion);
    print.add(options.overlay), print.add(options.overlay_light.value_or(-1));
    if (options.reference)
        print.add(options.reference->spp), print.add(options.reference->bounces), print.add(options.reference->seed);
    return print.value();
}

}   // namespace gnomon::video
