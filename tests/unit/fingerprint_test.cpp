// SPDX-License-Identifier: Apache-2.0
// The fingerprint of a video: --resume must not reuse frames that were rendered before an edit.
#include <gtest/gtest.h>

#include "api/scene_access.h"

#include <functional>
#include <map>

#include "scene/environment.h"
#include "scene/keyframe_track.h"
#include "scene/material_layers.h"
#include "scene/value_tracks.h"
#include "scene_helpers.h"
#include "video/frames_folder.h"

namespace gnomon::test {
namespace {

using scene::KeyframeTrack;

std::shared_ptr<const KeyframeTrack> slide(double height_in_the_middle)
{
    scene::KeyChannel<glm::dvec3> keys{
        scene::KeyInterpolation::linear, {0, 0.5, 0.6, 0.7, 2}, {{}, {}, {0, height_in_the_middle, 0}, {}, {}}};
    return std::make_shared<KeyframeTrack>(scene::TransformParts{}, keys, std::nullopt, std::nullopt);
}

std::shared_ptr<const scene::KeyframeWeights> weights(double in_the_middle)
{
    return std::make_shared<scene::KeyframeWeights>(scene::KeyInterpolation::linear, std::vector<double>{0, 0.6, 2},
                                                    std::vector<double>{0, in_the_middle, 0}, 1);
}

scene::Texture texture(std::uint8_t value, const scene::Sampler& sampler = {})
{
    Image8 image(2, 2, 3);
    image.data[7] = value;
    return {"image", image, true, sampler};
}

std::shared_ptr<const scene::Environment> surroundings(float value)
{
    ImageF image(4, 2, 3);
    image.data[5] = value;
    return std::make_shared<const scene::Environment>(image);
}

// A scene with one of everything.
scene::Scene everything()
{
    scene::Scene made;
    made.textures.push_back(texture(1));
    scene::Material material;
    material.base_color_texture.texture = 0;
    made.materials.push_back(material);

    scene::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.normals.assign(3, {0, 0, 1});
    mesh.tangents.assign(3, {1, 0, 0, 1});
    mesh.texcoords[0].assign(3, {0, 0});
    mesh.texcoords[1].assign(3, {0, 0});
    mesh.colors.assign(3, glm::vec4(1));
    mesh.triangles = {{0, 1, 2}};
    mesh.parts = {{0, 0, 1}};
    mesh.morph_targets.push_back({std::vector<glm::vec3>(3), std::vector<glm::vec3>(3), std::vector<glm::vec3>(3)});
    mesh.morph_weights = {0};
    mesh.skin.emplace();
    mesh.skin->joints[0].assign(3, {0, 0, 0, 0});
    mesh.skin->weights[0].assign(3, {1, 0, 0, 0});
    made.meshes.push_back(mesh);
    mesh.skin.reset(), mesh.morph_targets.clear(), mesh.morph_weights.clear();
    mesh.vertex_keys = scene::VertexKeys{{0, 1}, {mesh.positions, mesh.positions}, {mesh.normals, mesh.normals}};
    made.meshes.push_back(mesh);

    const scene::NodeId root = made.add_node("root", scene::none);
    for (const scene::MeshId m : {0u, 1u}) {
        const scene::NodeId node = made.add_node("thing", root);
        made.nodes[node].mesh = m;
        made.nodes[node].morph_weights.assign(1 - m, 0.0f);
    }
    made.nodes[1].skin = 0, made.nodes[1].weights = weights(0);
    made.nodes[2].transform = slide(0), made.nodes[2].visibility = visibility({1, 1.5}, {true, false});
    made.skins.push_back({"skin", {root}, {glm::dmat4(1)}});
    made.lights.emplace_back();
    made.lights[0].node = root;
    made.cameras.emplace_back();
    made.cameras[0].node = root;
    made.background.environment = surroundings(1);
    made.timeline.end = 2, made.timeline.frames = 49;
    return made;
}

using Edit = std::function<void(scene::Scene&)>;

// Edits that each change the image.
const std::map<std::string, Edit>& edits()
{
    // LONG: a table, one row for each member of a scene.
    static const std::map<std::string, Edit> all{
        {"nothing", [](scene::Scene&) {}},
        {"a position", [](scene::Scene& s) { s.meshes.edit(0).positions[1].x = 2; }},
        {"a normal",
         [](scene::Scene& s) {
             s.meshes.edit(0).normals[1] = {0, 1, 0};
         }},
        {"a tangent",
         [](scene::Scene& s) {
             s.meshes.edit(0).tangents[1] = {0, 1, 0, 1};
         }},
        {"a texture coordinate", [](scene::Scene& s) { s.meshes.edit(0).texcoords[0][1].x = 0.5f; }},
        {"one of the second set", [](scene::Scene& s) { s.meshes.edit(0).texcoords[1][1].x = 0.5f; }},
        {"a vertex colour", [](scene::Scene& s) { s.meshes.edit(0).colors[1].y = 0.5f; }},
        {"a triangle",
         [](scene::Scene& s) {
             s.meshes.edit(0).triangles[0] = {0, 2, 1};
         }},
        {"a morphed position", [](scene::Scene& s) { s.meshes.edit(0).morph_targets[0].positions[1].x = 2; }},
        {"a morphed normal", [](scene::Scene& s) { s.meshes.edit(0).morph_targets[0].normals[1].x = 2; }},
        {"a morphed tangent", [](scene::Scene& s) { s.meshes.edit(0).morph_targets[0].tangents[1].x = 2; }},
        {"a morph weight", [](scene::Scene& s) { s.meshes.edit(0).morph_weights[0] = 0.5f; }},
        {"a node's morph weight", [](scene::Scene& s) { s.nodes[1].morph_weights[0] = 0.5f; }},
        {"morph weights on their way", [](scene::Scene& s) { s.nodes[1].weights = weights(0.5); }},
        {"a skin weight", [](scene::Scene& s) { s.meshes.edit(0).skin->weights[0][1].x = 0.5f; }},
        {"a joint", [](scene::Scene& s) { s.skins[0].joints[0] = 1; }},
        {"a skin's rest", [](scene::Scene& s) { s.skins[0].inverse_bind[0][3].x = 1; }},
        {"a vertex key's time", [](scene::Scene& s) { s.meshes.edit(1).vertex_keys->times[1] = 1.5; }},
        {"a vertex key's position", [](scene::Scene& s) { s.meshes.edit(1).vertex_keys->positions[1][1].x = 2; }},
        {"a vertex key's normal", [](scene::Scene& s) { s.meshes.edit(1).vertex_keys->normals[1][1].x = 2; }},
        {"a node's place", [](scene::Scene& s) { s.nodes[0].local[3].x = 1; }},
        {"a key between the start and the middle", [](scene::Scene& s) { s.nodes[2].transform = slide(1); }},
        {"when something hides",
         [](scene::Scene& s) {
             s.nodes[2].visibility = visibility({1, 1.6}, {true, false});
         }},
        {"what a thing's shape is", [](scene::Scene& s) { s.nodes[2].mesh = scene::none; }},
        {"the clip's length", [](scene::Scene& s) { s.timeline.frames = 48; }},
        {"the rate", [](scene::Scene& s) { s.timeline.fps = 25; }},
        {"two sides", [](scene::Scene& s) { s.materials[0].double_sided = true; }},
        {"the model", [](scene::Scene& s) { s.materials[0].model = scene::ShadingModel::unlit; }},
        {"the base colour", [](scene::Scene& s) { s.materials[0].base_color.y = 0.5f; }},
        {"the alpha mode", [](scene::Scene& s) { s.materials[0].alpha_mode = scene::AlphaMode::mask; }},
        {"the alpha cutoff", [](scene::Scene& s) { s.materials[0].alpha_cutoff = 0.6f; }},
        {"alpha", [](scene::Scene& s) { s.materials[0].alpha = 0.6f; }},
        {"emission", [](scene::Scene& s) { s.materials[0].emissive.z = 0.5f; }},
        {"the ambient colour", [](scene::Scene& s) { s.materials[0].ambient.z = 0.5f; }},
        {"the specular colour", [](scene::Scene& s) { s.materials[0].specular.z = 0.5f; }},
        {"metallic", [](scene::Scene& s) { s.materials[0].metallic = 0.3f; }},
        {"roughness", [](scene::Scene& s) { s.materials[0].roughness = 0.3f; }},
        {"the strength of occlusion", [](scene::Scene& s) { s.materials[0].occlusion_strength = 0.3f; }},
        {"transmission", [](scene::Scene& s) { s.materials[0].transmission = 0.3f; }},
        {"shine", [](scene::Scene& s) { s.materials[0].shine = 20; }},
        {"transmittance", [](scene::Scene& s) { s.materials[0].transmittance = 0.3f; }},
        {"the index of refraction", [](scene::Scene& s) { s.materials[0].ior = 1.3f; }},
        {"an outline", [](scene::Scene& s) { s.materials[0].outline = true; }},
        {"a catcher of shadows", [](scene::Scene& s) { s.materials[0].catches_shadows = true; }},
        {"a clear coat",
         [](scene::Scene& s) {
             scene::MaterialLayers layers;
             layers.clearcoat = 0.5f;
             s.materials[0].layers = std::make_shared<scene::MaterialLayers>(layers);
         }},
        {"a scale of a texture", [](scene::Scene& s) { s.materials[0].base_color_texture.scale.y = 2; }},
        {"a map of roughness", [](scene::Scene& s) { s.materials[0].metallic_roughness_texture.texture = 0; }},
        {"a map of occlusion", [](scene::Scene& s) { s.materials[0].occlusion_texture.texture = 0; }},
        {"a map of emission", [](scene::Scene& s) { s.materials[0].emissive_texture.texture = 0; }},
        {"the depth of a normal map", [](scene::Scene& s) { s.materials[0].normal_scale = 2; }},
        {"a normal map", [](scene::Scene& s) { s.materials[0].normal_texture.texture = 0; }},
        {"where a texture lies", [](scene::Scene& s) { s.materials[0].base_color_texture.offset.x = 0.5f; }},
        {"a texture's turn", [](scene::Scene& s) { s.materials[0].base_color_texture.rotation = 0.5f; }},
        {"a texture's set", [](scene::Scene& s) { s.materials[0].base_color_texture.texcoord = 1; }},
        {"a texel", [](scene::Scene& s) { s.textures.edit(0) = texture(2); }},
        {"a texture's edges", [](scene::Scene& s) { s.textures.edit(0) = texture(1, {.wrap_u = scene::Wrap::clamp}); }},
        {"a texture's filter", [](scene::Scene& s) { s.textures.edit(0) = texture(1, {.mipmaps = false}); }},
        {"a light's colour", [](scene::Scene& s) { s.lights[0].color.x = 2; }},
        {"a light's type", [](scene::Scene& s) { s.lights[0].type = scene::LightType::spot; }},
        {"a light's falloff", [](scene::Scene& s) { s.lights[0].falloff = scene::Falloff::constant; }},
        {"a light's inner angle", [](scene::Scene& s) { s.lights[0].inner_angle = 0.1f; }},
        {"a light's outer angle", [](scene::Scene& s) { s.lights[0].outer_angle = 0.3f; }},
        {"a light's range", [](scene::Scene& s) { s.lights[0].range = 3; }},
        {"a spot's angle on its way",
         [](scene::Scene& s) {
             auto track = std::make_shared<scene::LightTrack>();
             track->outer_angle = weights(0.5);
             s.lights[0].track = track;
         }},
        {"a light's range on its way",
         [](scene::Scene& s) {
             auto track = std::make_shared<scene::LightTrack>();
             track->range = weights(0.5);
             s.lights[0].track = track;
         }},
        {"the ambient light", [](scene::Scene& s) { s.ambient.x = 0.5f; }},
        {"the background's colour", [](scene::Scene& s) { s.background.color.x = 0.5f; }},
        {"a light's intensity on its way",
         [](scene::Scene& s) {
             auto track = std::make_shared<scene::LightTrack>();
             track->intensity = weights(0.5);
             s.lights[0].track = track;
         }},
        {"the roughness on its way",
         [](scene::Scene& s) {
             auto track = std::make_shared<scene::MaterialTrack>();
             track->roughness = weights(0.5);
             s.materials[0].track = track;
         }},
        {"a lens on its way",
         [](scene::Scene& s) {
             auto track = std::make_shared<scene::CameraTrack>();
             track->vertical_fov = weights(0.5);
             s.cameras[0].track = track;
         }},
        {"a light's node", [](scene::Scene& s) { s.lights[0].node = 1; }},
        {"the zenith", [](scene::Scene& s) { s.background.zenith.x = 1; }},
        {"the horizon", [](scene::Scene& s) { s.background.horizon.x = 1; }},
        {"the ground", [](scene::Scene& s) { s.background.ground.x = 1; }},
        {"where the sun is", [](scene::Scene& s) { s.background.sun_direction.y = 1; }},
        {"the sun's light", [](scene::Scene& s) { s.background.sun_radiance.x = 1; }},
        {"the surroundings", [](scene::Scene& s) { s.background.environment = surroundings(2); }},
        {"a lens", [](scene::Scene& s) { s.cameras[0].vertical_fov = 0.7; }},
        {"a camera's node", [](scene::Scene& s) { s.cameras[0].node = 2; }},
        {"a camera's far plane", [](scene::Scene& s) { s.cameras[0].far = 50; }},
        {"a camera without perspective", [](scene::Scene& s) { s.cameras[0].orthographic_height = 2; }},
        {"a camera's near plane", [](scene::Scene& s) { s.cameras[0].near = 0.5; }},
        {"a camera's name", [](scene::Scene& s) { s.cameras[0].name = "other"; }},
    };
    return all;
}

TEST(Fingerprint, ChangesWithEveryEdit)
{
    std::map<std::uint64_t, std::string> found;
    for (const auto& [name, edit] : edits()) {
        auto edited = std::make_shared<scene::Scene>(everything());
        edit(*edited);
        edited->finish();
        const auto [place, fresh] = found.emplace(video::fingerprint_of(api::public_scene(edited), {}), name);
        EXPECT_TRUE(fresh) << name << " as " << place->second;
    }
}

// Options that each change the image of some scene.
const std::map<std::string, std::function<void(RenderOptions&)>>& choices()
{
    static const std::map<std::string, std::function<void(RenderOptions&)>> all{
        {"nothing", [](RenderOptions&) {}},
        {"width", [](RenderOptions& o) { o.size.width = 64; }},
        {"height", [](RenderOptions& o) { o.size.height = 64; }},
        {"camera", [](RenderOptions& o) { o.camera = "1"; }},
        {"turntable", [](RenderOptions& o) { o.turntable_seconds = 2; }},
        {"renderer", [](RenderOptions& o) { o.renderer = RenderMethod::raster; }},
        {"max_depth", [](RenderOptions& o) { o.max_depth = 3; }},
        {"samples", [](RenderOptions& o) { o.samples = 4; }},
        {"exposure", [](RenderOptions& o) { o.exposure = 1; }},
        {"exposure of none", [](RenderOptions& o) { o.exposure = 0; }},
        {"tonemap", [](RenderOptions& o) { o.tonemap = ToneMap::agx; }},
        {"background", [](RenderOptions& o) { o.background = BackgroundKind::color; }},
        {"background_color", [](RenderOptions& o) { o.background_color[2] = 0.5f; }},
        {"shadow_culling", [](RenderOptions& o) { o.shadow_culling = ShadowCulling::paper; }},
        {"as_printed", [](RenderOptions& o) { o.as_printed = true; }},
        {"indirect off", [](RenderOptions& o) { o.indirect = Indirect::off; }},
        {"indirect quadtree", [](RenderOptions& o) { o.indirect = Indirect::quadtree; }},
        {"shadow_textures", [](RenderOptions& o) { o.shadow_textures = ShadowTextures::depth; }},
        {"shadow_filter", [](RenderOptions& o) { o.shadow_filter = 3; }},
        {"sun_size", [](RenderOptions& o) { o.sun_size = 0.5; }},
        {"bounces", [](RenderOptions& o) { o.bounces = 1; }},
        {"reference", [](RenderOptions& o) { o.reference = ReferenceLightOptions{}; }},
        {"reference spp", [](RenderOptions& o) { o.reference = ReferenceLightOptions{.spp = 7}; }},
        {"reference bounces", [](RenderOptions& o) { o.reference = ReferenceLightOptions{.bounces = 3}; }},
        {"reference seed", [](RenderOptions& o) { o.reference = ReferenceLightOptions{.seed = 5}; }},
        {"rsm_samples", [](RenderOptions& o) { o.rsm_samples = 100; }},
        {"indirect_level", [](RenderOptions& o) { o.indirect_level = 4; }},
        {"indirect_at_every_pixel", [](RenderOptions& o) { o.indirect_at_every_pixel = true; }},
        {"indirect_on", [](RenderOptions& o) { o.indirect_on = IndirectOn::cpu; }},
        {"depth_threshold", [](RenderOptions& o) { o.depth_threshold = 0.1; }},
        {"normal_threshold", [](RenderOptions& o) { o.normal_threshold = 0.8; }},
        {"validity_margin", [](RenderOptions& o) { o.validity_margin = 0.5; }},
        {"separate_trees", [](RenderOptions& o) { o.separate_trees = true; }},
        {"cluster_shadows", [](RenderOptions& o) { o.cluster_shadows = true; }},
        {"accelerator", [](RenderOptions& o) { o.accelerator = Accelerator::kdtree; }},
        {"ids", [](RenderOptions& o) { o.ids = true; }},
        {"motion", [](RenderOptions& o) { o.motion = true; }},
        {"overlay", [](RenderOptions& o) { o.overlay = Overlay::shadow_states; }},
        {"overlay_light", [](RenderOptions& o) { o.overlay_light = 0; }},
    };
    return all;
}

TEST(Fingerprint, ChangesWithEveryOptionThatChangesImages)
{
    auto made = std::make_shared<scene::Scene>(everything());
    made->finish();
    const Scene scene = api::public_scene(made);
    std::map<std::uint64_t, std::string> found;
    for (const auto& [name, choose] : choices()) {
        RenderOptions options;
        choose(options);
        const auto [place, fresh] = found.emplace(video::fingerprint_of(scene, options), name);
        EXPECT_TRUE(fresh) << name << " as " << place->second;
    }
}

TEST(Fingerprint, IgnoresOptionsThatChangeNoImage)
{
    auto made = std::make_shared<scene::Scene>(everything());
    made->finish();
    const Scene scene = api::public_scene(made);
    RenderOptions options;
    const std::uint64_t plain = video::fingerprint_of(scene, options);
    options.threads = 3;
    options.indirect_memory = 4;
    options.shadow_culling = ShadowCulling::off;
    EXPECT_EQ(video::fingerprint_of(scene, options), plain);
}

TEST(Fingerprint, IgnoresNames)
{
    const auto of = [](const char* name) {
        auto made = std::make_shared<scene::Scene>(everything());
        made->nodes[0].name = made->meshes.edit(0).name = made->materials[0].name = made->lights[0].name = name;
        made->finish();
        return video::fingerprint_of(api::public_scene(made), {});
    };
    EXPECT_EQ(of("a"), of("b"));
}

// A clip that numbers its own frames is the same at any rate, unless its camera turns by the second.
TEST(Fingerprint, DependsOnTheFrameRateOfATurntableOnly)
{
    auto made = std::make_shared<scene::Scene>(everything());
    made->timeline.own_frames = true;
    made->finish();
    const Scene scene = api::public_scene(made);
    for (const double seconds : {0.0, 2.0}) {
        RenderOptions options;
        options.turntable_seconds = seconds;
        EXPECT_EQ(video::fingerprint_of(scene, options) == video::fingerprint_of(scene.at_rate(12), options),
                  seconds == 0);
    }
}

// An endless video costs no more here than one of a minute.
TEST(Fingerprint, IsFastForAnEndlessClip)
{
    auto made = std::make_shared<scene::Scene>(everything());
    made->timeline.end = 1e9, made->timeline.frames = scene::k_most_frames;
    made->nodes[2].transform = std::make_shared<SwayTrack>(glm::dvec3(0), 1);
    made->finish();
    EXPECT_NE(video::fingerprint_of(api::public_scene(made), {}), 0u);
}

}   // namespace
}   // namespace gnomon::test
