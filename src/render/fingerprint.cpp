// SPDX-License-Identifier: Apache-2.0
// A hash of what the pixels of a film depend on. It need not be perfect: it guards against mistakes, and the manifest
// beside it names the scene and the size for people.
#include <array>

#include "base/hash.h"
#include "render/frames_folder.h"
#include "scene/environment.h"
#include "scene/state.h"

namespace gnomon::render {

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
    void add(const glm::vec3& v) { add(v.x), add(v.y), add(v.z); }
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

void add_geometry(Fingerprint& print, const scene::Scene& scene)
{
    for (const scene::Mesh& mesh : scene.meshes) {
        print.add_all(mesh.positions);
        print.add_all(mesh.triangles);
        for (const scene::MeshPart& part : mesh.parts) print.add(part.material);
    }
    for (const scene::Texture& texture : scene.textures) {
        print.add(texture.srgb());
        print.add_all(texture.levels().front().data);
    }
    for (const scene::Material& material : scene.materials) {
        for (const glm::vec3& color : {material.base_color, material.emissive, material.ambient, material.specular})
            print.add(color);
        for (const float value : {material.alpha, material.metallic, material.roughness, material.transmission,
                                  material.shine, material.transmittance, material.ior})
            print.add(value);
        print.add(material.base_color_texture.texture);
        print.add(material.surface_class());
    }
}

void add_lights(Fingerprint& print, const scene::Scene& scene)
{
    for (const scene::Light& light : scene.lights) {
        print.add(light.type), print.add(light.falloff), print.add(light.profile);
        print.add(light.color), print.add(light.of_environment);
        print.add(light.inner_angle), print.add(light.outer_angle), print.add(light.range);
    }
    print.add(scene.background.kind);
    print.add(scene.background.color);
    if (scene.background.environment) print.add_all(scene.background.environment->image().data);
    print.add(scene.ambient);
    for (const scene::Camera& camera : scene.cameras)
        print.add(camera.vertical_fov), print.add(camera.orthographic_height);
}
}   // namespace

std::uint64_t fingerprint_of(const Scene& shown, const RenderOptions& options)
{
    Fingerprint print;
    const scene::Scene& scene = *shown.inside();
    add_geometry(print, scene);
    add_lights(print, scene);

    // The clip: the times of its frames, and where everything is at its start, middle and end.
    const int frames = shown.frame_count();
    print.add(frames);
    scene::SceneState state(shown.inside(), shown.time_of(1));
    for (const int frame : {1, 1 + frames / 2, frames}) {
        print.add(shown.time_of(frame));
        state.advance(shown.time_of(frame));
        for (scene::NodeId node = 0; node < scene.nodes.size(); ++node) {
            print.add(state.visible(node));
            for (int column = 0; column < 4; ++column)
                for (int row = 0; row < 3; ++row) print.add(state.world(node)[column][row]);
        }
    }

    print.add(options.size.width), print.add(options.size.height);
    print.add(options.camera);
    print.add(options.turntable_seconds);
    print.add(options.max_depth), print.add(options.samples);
    print.add(options.exposure.has_value()), print.add(options.exposure.value_or(0));
    print.add(options.tonemap);
    print.add(options.accelerator);
    // Certified culling and none give the same pixels; what the published one gives depends on its history, too.
    print.add(options.shadow_culling == ShadowCulling::paper);
    print.add(options.indirect), print.add(options.indirect_on);
    print.add(options.renderer), print.add(options.shadow_textures), print.add(options.shadow_filter);
    print.add(options.rsm_samples), print.add(options.indirect_level), print.add(options.indirect_at_every_pixel);
    print.add(options.depth_threshold), print.add(options.normal_threshold);
    print.add(options.overlay), print.add(options.overlay_light.value_or(-1));
    if (options.reference)
        print.add(options.reference->spp), print.add(options.reference->bounces), print.add(options.reference->seed);
    return print.value();
}

}   // namespace gnomon::render
