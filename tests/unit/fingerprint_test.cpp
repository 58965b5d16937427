// SPDX-License-Identifier: Apache-2.0
// The fingerprint of a video: --resume must not reuse frames that were rendered before an edit.
#include <gtest/gtest.h>

#include "api/scene_access.h"

#include <functional>
#include <map>

#include "scene/environment.h"
#include "scene/keyframe_track.h"
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
        {"the depth of a normal map", [](scene::Scene& s) { s.materials[0].normal_scale = 2; }},
        {"a normal map", [](scene::Scene& s) { s.materials[0].normal_texture.texture = 0; }},
        {"where a texture lies", [](scene::Scene& s) { s.materials[0].base_color_texture.offset.x = 0.5f; }},
        {"a texture's turn", [](scene::Scene& s) { s.materials[0].base_color_texture.rotation = 0.5f; }},
        {"a texture's set", [](scene::Scene& s) { s.materials[0].base_color_texture.texcoord = 1; }},
        {"a texel", [](scene::Scene& s) { s.textures.edit(0) = texture(2); }},
        {"a texture's edges", [](scene::Scene& s) { s.textures.edit(0) = texture(1, {.wrap_u = scene::Wrap::clamp}); }},
        {"a texture's filter", [](scene::Scene& s) { s.textures.edit(0) = texture(1, {.mipmaps = false}); }},
        {"a light's colour", [](scene::Scene& s) { s.lights[0].color.x = 2; }},
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
