// SPDX-License-Identifier: Apache-2.0
// LONG: tables of misuses, one line each.
//
// Misuse of the public interface by a host: each call is answered with the documented exception and one short line, and
// leaves the builder and the renderer usable. Also what is unusual, and allowed.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>

#include "gnomon/gnomon.h"
#include "host_scene.h"
#include "sanitized.h"

namespace gnomon {
namespace {

constexpr float k_nan = std::numeric_limits<float>::quiet_NaN(), k_inf = std::numeric_limits<float>::infinity();
constexpr double k_nan64 = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t k_billion = 1'000'000'000;

// A span over memory that is far smaller: reading beyond it is an error that a sanitizer reports.
template <class T>
std::span<const T> claiming(const std::vector<T>& memory, std::size_t count)
{
    return {memory.data(), count};
}

// A scene with a part of each kind, a renderer that has rendered it, and ids that are not of the scene.
struct Host {
    SceneBuilder builder, other;
    MeshId mesh, foreign_mesh, removed_mesh;
    MaterialId material, foreign_material, removed_material;
    TextureId texture, foreign_texture, removed_texture;
    NodeId joint, foreign_node, removed_node;
    SkinId skin, foreign_skin, removed_skin;
    InstanceId instance, morphed, empty;
    LightId light, foreign_light, removed_light;
    CameraId camera, foreign_camera, removed_camera;
    Scene scene;
    Renderer renderer;
    Frame frame;

    static MeshId morphing(SceneBuilder& b)
    {
        const test::Shape shape = test::square(1);
        const std::vector<Vec3> offsets(4, Vec3{0, 0, 1});
        const std::vector<MorphTarget> targets{{offsets, {}, {}}};
        Mesh mesh = shape.mesh();
        mesh.morph_targets = targets;
        return b.mesh(mesh);
    }
    static TextureId pixel(SceneBuilder& b)
    {
        const std::vector<std::uint8_t> pixels(4, 200);
        return b.texture({.width = 1, .height = 1, .pixels = pixels});
    }
    Host()
        : mesh(builder.mesh(test::square(1).mesh())),
          foreign_mesh(other.mesh(test::square(1).mesh())),
          removed_mesh(builder.mesh({})),
          material(builder.material({})),
          foreign_material(other.material({})),
          removed_material(builder.material({})),
          texture(pixel(builder)),
          foreign_texture(pixel(other)),
          removed_texture(pixel(builder)),
          joint(builder.node()),
          foreign_node(other.node()),
          removed_node(builder.node()),
          skin(builder.skin({{joint}, {Transform()}})),
          foreign_skin(other.skin({{foreign_node}, {Transform()}})),
          removed_skin(builder.skin({})),
          instance(builder.instance(mesh, material, Transform::translation(0, 0, -5))),
          morphed(builder.instance(morphing(builder), {}, Transform::translation(2, 0, -5))),
          empty(builder.instance(builder.mesh({}))),
          light(builder.light({.color = {50, 50, 50}})),
          foreign_light(other.light({})),
          removed_light(builder.light({})),
          camera(builder.camera(test::camera_along_z())),
          foreign_camera(other.camera({})),
          removed_camera(builder.camera({})),
          scene(finished()),
          renderer(options()),
          frame(renderer.render(scene, 1))
    {
    }
    Scene finished()
    {
        builder.remove(removed_mesh);
        builder.remove(removed_material);
        builder.remove(removed_texture);
        builder.remove(removed_skin);
        builder.remove(removed_node);
        builder.remove(removed_light);
        builder.remove(removed_camera);
        return builder.finish();
    }
    static RenderOptions options()
    {
        RenderOptions options;
        options.size = {8, 8};
        options.ids = true;
        return options;
    }
    void render(const std::function<void(FrameInput&)>& change)
    {
        FrameInput input;
        change(input);
        renderer.render(scene, input);
    }
    // Whether all works as before.
    void expect_usable()
    {
        const Frame again = renderer.render(scene, 1);
        const auto now = again.layers.front().values(), before = frame.layers.front().values();
        EXPECT_TRUE(std::equal(now.begin(), now.end(), before.begin(), before.end()));
        EXPECT_EQ(builder.finish().nodes(), scene.nodes());
        EXPECT_EQ(builder.finish().materials(), scene.materials());
        EXPECT_EQ(builder.finish().lights(), scene.lights());
    }
};

void expect_one_line(const std::string& message, const std::string& of)
{
    EXPECT_FALSE(message.empty()) << of << ": no UsageError";
    EXPECT_LE(message.size(), 200u) << of;
    EXPECT_EQ(message.find_first_of("\n\r"), std::string::npos) << of;
}

struct Misuse {
    const char* name;
    std::function<void(Host&)> call;
};

void expect_all_refused(const std::vector<Misuse>& all)
{
    Host host;
    for (const Misuse& misuse : all) {
        expect_one_line(test::usage_error([&] { misuse.call(host); }), misuse.name);
        host.expect_usable();
        if (::testing::Test::HasFailure()) FAIL() << misuse.name;
    }
}

TEST(Misuse, IdsOfNothingOfOtherScenesAndOfRemovedParts)
{
    // LONG: a table of misuses.
    std::vector<Misuse> all;
    for (int kind = 0; kind < 3; ++kind) {
        const auto pick = [kind](auto removed, auto foreign) {
            return kind == 0 ? decltype(removed){} : kind == 1 ? foreign : removed;
        };
        const auto node = [pick](Host& h) { return pick(h.removed_node, h.foreign_node); };
        const auto instance = [node](Host& h) { return InstanceId(node(h)); };
        const auto mesh = [pick](Host& h) { return pick(h.removed_mesh, h.foreign_mesh); };
        const auto material = [pick](Host& h) { return pick(h.removed_material, h.foreign_material); };
        const auto light = [pick](Host& h) { return pick(h.removed_light, h.foreign_light); };
        const auto camera = [pick](Host& h) { return pick(h.removed_camera, h.foreign_camera); };
        const auto texture = [pick](Host& h) { return pick(h.removed_texture, h.foreign_texture); };
        const auto skin = [pick](Host& h) { return pick(h.removed_skin, h.foreign_skin); };
        const std::vector<Misuse> of_kind{
            {"instance of a mesh", [=](Host& h) { h.builder.instance(mesh(h)); }},
            {"attach", [=](Host& h) { h.builder.attach(node(h), h.mesh); }},
            {"attached mesh", [=](Host& h) { h.builder.attach(h.joint, mesh(h)); }},
            {"set_mesh", [=](Host& h) { h.builder.set_mesh(mesh(h), test::square(1).mesh()); }},
            {"set_material", [=](Host& h) { h.builder.set_material(material(h), Material()); }},
            {"material of an instance", [=](Host& h) { h.builder.set_material(h.instance, material(h)); }},
            {"instance of a material", [=](Host& h) { h.builder.set_material(instance(h), h.material); }},
            {"set_light", [=](Host& h) { h.builder.set_light(light(h), {}); }},
            {"set_camera", [=](Host& h) { h.builder.set_camera(camera(h), {}); }},
            {"set_transform", [=](Host& h) { h.builder.set_transform(node(h), {}); }},
            {"set_mobility", [=](Host& h) { h.builder.set_mobility(node(h), Mobility::may_move); }},
            {"remove node", [=](Host& h) { h.builder.remove(node(h)); }},
            {"remove light", [=](Host& h) { h.builder.remove(light(h)); }},
            {"remove camera", [=](Host& h) { h.builder.remove(camera(h)); }},
            {"remove mesh", [=](Host& h) { h.builder.remove(mesh(h)); }},
            {"remove material", [=](Host& h) { h.builder.remove(material(h)); }},
            {"remove texture", [=](Host& h) { h.builder.remove(texture(h)); }},
            {"remove skin", [=](Host& h) { h.builder.remove(skin(h)); }},
            {"joint",
             [=](Host& h) {
                 h.builder.skin({{node(h)}, {Transform()}});
             }},
            {"name", [=](Host& h) { h.scene.name(node(h)); }},
            {"parent", [=](Host& h) { h.scene.parent(node(h)); }},
            {"mobility", [=](Host& h) { h.scene.mobility(node(h)); }},
            {"moving node", [=](Host& h) { h.scene.moving_node(node(h)); }},
            {"transform", [=](Host& h) { h.scene.transform(node(h)); }},
            {"mesh of", [=](Host& h) { h.scene.mesh(instance(h)); }},
            {"node of a light", [=](Host& h) { h.scene.node(light(h)); }},
            {"node of a camera", [=](Host& h) { h.scene.node(camera(h)); }},
            {"light", [=](Host& h) { h.scene.light(light(h)); }},
            {"camera", [=](Host& h) { h.scene.camera(camera(h)); }},
            {"material", [=](Host& h) { h.scene.material(material(h)); }},
            {"renderer's transform", [=](Host& h) { h.renderer.transform(node(h)); }},
            {"renderer's world transform", [=](Host& h) { h.renderer.world_transform(node(h)); }},
            {"visible", [=](Host& h) { h.renderer.visible(node(h)); }},
            {"input transform", [=](Host& h) { h.render([&](FrameInput& in) {
                                                   in.transforms = {{node(h), {}}};
                                               }); }},
            {"input visibility",
             [=](Host& h) { h.render([&](FrameInput& in) {
                                in.visibility = {{node(h), false}};
                            }); }},
            {"input vertices", [=](Host& h) { h.render([&](FrameInput& in) {
                                                  in.vertices = {{instance(h), {}}};
                                              }); }},
            {"input weights",
             [=](Host& h) { h.render([&](FrameInput& in) {
                                in.morph_weights = {{instance(h), {}}};
                            }); }},
            {"input light", [=](Host& h) { h.render([&](FrameInput& in) {
                                               in.lights = {{light(h), {}}};
                                           }); }},
            {"input material", [=](Host& h) { h.render([&](FrameInput& in) {
                                                  in.materials = {{material(h), {}}};
                                              }); }},
            {"released node", [=](Host& h) { h.render([&](FrameInput& in) { in.released_nodes = {node(h)}; }); }},
            {"released light", [=](Host& h) { h.render([&](FrameInput& in) { in.released_lights = {light(h)}; }); }},
            {"released material",
             [=](Host& h) { h.render([&](FrameInput& in) { in.released_materials = {material(h)}; }); }},
        };
        all.insert(all.end(), of_kind.begin(), of_kind.end());
        if (kind == 0) continue;   // where an id is optional, none is no misuse
        const std::vector<Misuse> optional{
            {"parent", [=](Host& h) { h.builder.node({}, {.parent = node(h)}); }},
            {"material of a new instance", [=](Host& h) { h.builder.instance(h.mesh, material(h)); }},
            {"skin of a new instance", [=](Host& h) { h.builder.instance(h.mesh, {}, {}, {.skin = skin(h)}); }},
            {"texture of a material",
             [=](Host& h) {
                 Material m;
                 m.emissive_texture.texture = texture(h);
                 h.builder.material(m);
             }},
            {"material of a part",
             [=](Host& h) {
                 const test::Shape shape = test::square(1);
                 const std::vector<MeshPart> parts{{material(h), 0, 2}};
                 Mesh m = shape.mesh();
                 m.parts = parts;
                 h.builder.mesh(m);
             }},
        };
        all.insert(all.end(), optional.begin(), optional.end());
    }
    expect_all_refused(all);
}

TEST(Misuse, ValuesThatAreNotFiniteOrOutOfRange)
{
    // LONG: a table of misuses.
    std::vector<Misuse> all;
    const auto material = [&](auto member, auto... values) {
        for (const auto value : {values...})
            all.push_back({"material", [=](Host& h) {
                               Material m;
                               m.*member = value;
                               const bool by_frame = test::usage_error([&] { h.builder.material(m); }).empty();
                               if (!by_frame) h.render([&](FrameInput& in) { in.materials = {{h.material, m, {}}}; });
                           }});
    };
    for (const auto color : {&Material::base_color, &Material::emissive, &Material::ambient, &Material::specular})
        material(color, Vec3{k_nan, 0, 0}, Vec3{0, k_inf, 0}, Vec3{0, 0, -1});
    for (const auto fraction : {&Material::alpha, &Material::metallic, &Material::roughness, &Material::transmission,
                                &Material::transmittance, &Material::occlusion_strength})
        material(fraction, k_nan, k_inf, -0.5f, 1.5f);
    material(&Material::alpha_cutoff, k_nan, k_inf, -1.0f);
    material(&Material::shine, k_nan, k_inf, -1.0f);
    material(&Material::ior, k_nan, k_inf, 0.5f);
    material(&Material::normal_scale, k_nan, k_inf, -k_inf);
    material(&Material::model, static_cast<ShadingModel>(3), static_cast<ShadingModel>(255));
    material(&Material::alpha_mode, static_cast<AlphaMode>(3));
    for (const auto use : {&Material::base_color_texture, &Material::normal_texture, &Material::occlusion_texture}) {
        material(use, TextureUse{{}, 2, {}, {1, 1}, 0}, TextureUse{{}, -1, {}, {1, 1}, 0});
        material(use, TextureUse{{}, 0, {k_nan, 0}, {1, 1}, 0}, TextureUse{{}, 0, {}, {k_inf, 1}, 0});
        material(use, TextureUse{{}, 0, {}, {1, 1}, k_nan});
    }
    const auto light = [&](auto member, auto... values) {
        for (const auto value : {values...}) {
            Light l;
            l.*member = value;
            all.push_back({"light", [=](Host& h) { h.builder.light(l); }});
            all.push_back({"set_light", [=](Host& h) { h.builder.set_light(h.light, l); }});
            all.push_back({"input light", [=](Host& h) {
                               h.render([&](FrameInput& in) { in.lights = {{h.light, l}}; });
                           }});
            all.push_back({"closing light", [=](Host& h) {
                               h.render([&](FrameInput& in) { in.lights = {{h.light, {}, l}}; });
                           }});
        }
    };
    light(&Light::color, Vec3{k_nan, 0, 0}, Vec3{0, k_inf, 0}, Vec3{0, 0, -1});
    light(&Light::inner_angle, k_nan, k_inf, -1.0f, 2.0f);
    light(&Light::outer_angle, k_nan, k_inf, -1.0f, 3.0f);
    light(&Light::range, k_nan, k_inf, -1.0f);
    light(&Light::type, static_cast<LightType>(3));
    light(&Light::falloff, static_cast<Falloff>(2));
    light(&Light::profile, static_cast<SpotProfile>(3));
    const auto camera = [&](auto member, auto... values) {
        for (const auto& value : {values...}) {
            Camera c;
            c.*member = value;
            all.push_back({"camera", [=](Host& h) { h.builder.camera(c); }});
            all.push_back({"set_camera", [=](Host& h) { h.builder.set_camera(h.camera, c); }});
            all.push_back({"input camera", [=](Host& h) { h.render([&](FrameInput& in) { in.camera = c; }); }});
            all.push_back(
                {"closing camera", [=](Host& h) { h.render([&](FrameInput& in) { in.camera_closing = c; }); }});
        }
    };
    const double inf = std::numeric_limits<double>::infinity();
    camera(&Camera::vertical_fov, k_nan64, inf, 0.0, -1.0, 3.2);
    camera(&Camera::near, k_nan64, inf, -1.0);
    camera(&Camera::far, k_nan64, inf, 0.005, -1.0);
    camera(&Camera::shift_x, k_nan64, inf);
    camera(&Camera::shift_y, k_nan64, inf);
    camera(&Camera::orthographic_height, std::optional(k_nan64), std::optional(inf), std::optional(0.0),
           std::optional(-1.0));
    using I = std::optional<Intrinsics>;
    camera(&Camera::intrinsics, I({k_nan64, 1, 0, 0, {}}), I({1, 0, 0, 0, {}}), I({1, 1, inf, 0, {}}),
           I({1, 1, 0, k_nan64, {}}), I({1, 1, 0, 0, {-1, -1}}), I({1, 1, 0, 0, {5, 0}}));
    Transform singular, skewed, bad, nan;
    singular.m.fill(0);
    skewed.m[4] = 0.5;
    bad.m[3] = 1;
    nan.m[12] = k_nan64;
    using T = std::optional<Transform>;
    camera(&Camera::matrix, T(singular), T(skewed), T(nan), T(Transform()));
    camera(&Camera::transform, bad, nan, singular);
    camera(&Camera::resolution, Size{-1, -1}, Size{0, 5}, Size{40000, 1}, Size{30000, 30000});
    for (const Transform& t : {bad, nan, singular, Transform::rotation({0, 0, 0}, 1),
                               Transform::look_at({1, 1, 1}, {1, 1, 1}), Transform::scaling(1e300, 1e300, inf)}) {
        all.push_back({"node", [=](Host& h) { h.builder.node(t); }});
        all.push_back({"instance", [=](Host& h) { h.builder.instance(h.mesh, {}, t); }});
        all.push_back({"node of a light", [=](Host& h) { h.builder.light({}, t); }});
        all.push_back({"bind matrix", [=](Host& h) { h.builder.skin({{h.joint}, {t}}); }});
        all.push_back({"set_transform", [=](Host& h) { h.builder.set_transform(h.instance, t); }});
        all.push_back({"input transform", [=](Host& h) {
                           h.render([&](FrameInput& in) { in.transforms = {{h.instance, t}}; });
                       }});
        all.push_back({"closing transform", [=](Host& h) {
                           h.render([&](FrameInput& in) { in.transforms = {{h.instance, {}, t}}; });
                       }});
    }
    for (const double value : {k_nan64, inf, -inf}) {
        all.push_back({"time", [=](Host& h) { h.render([&](FrameInput& in) { in.time = value; }); }});
        all.push_back({"turn", [=](Host& h) { h.render([&](FrameInput& in) { in.turn = value; }); }});
        all.push_back({"clip's start", [=](Host& h) { h.builder.clip(value, 1, 24); }});
        all.push_back({"clip's end", [=](Host& h) { h.builder.clip(0, value, 24); }});
        all.push_back({"clip's rate", [=](Host& h) { h.builder.clip(0, 1, value); }});
        all.push_back({"at_rate", [=](Host& h) { (void)h.scene.at_rate(value); }});
        all.push_back({"lasting", [=](Host& h) { (void)h.scene.lasting(value); }});
    }
    all.push_back({"long clip", [](Host& h) { h.builder.clip(-1e308, 1e308, 24); }});
    for (const Vec3& color : {Vec3{k_nan, 0, 0}, Vec3{0, k_inf, 0}, Vec3{0, 0, -1}}) {
        all.push_back({"background", [=](Host& h) { h.builder.background(color); }});
        all.push_back({"ambient", [=](Host& h) { h.builder.ambient(color); }});
    }
    for (const int mobility : {3, 255}) {
        const auto unknown = static_cast<Mobility>(mobility);
        all.push_back({"mobility", [=](Host& h) { h.builder.set_mobility(h.joint, unknown); }});
        all.push_back({"mobility", [=](Host& h) { h.builder.node({}, {.mobility = unknown}); }});
        all.push_back({"mobility", [=](Host& h) { h.builder.instance(h.mesh, {}, {}, {.mobility = unknown}); }});
        all.push_back({"mobility", [=](Host& h) { h.builder.attach(h.joint, h.mesh, {}, {.mobility = unknown}); }});
    }
    all.push_back({"reach", [](Host& h) {
                       h.builder.instance(h.mesh, {}, {}, {.reach = {{0, 0, 0}, {1, k_nan, 1}}});
                   }});
    all.push_back({"weights", [](Host& h) { h.builder.instance(h.mesh, {}, {}, {.morph_weights = {1}}); }});
    expect_all_refused(all);
}

TEST(Misuse, ArraysOfWrongLengthsAndSizes)
{
    // LONG: a table of misuses.
    const std::vector<Vec2> two(4);
    const std::vector<Vec3> three(4), not_finite{{}, {}, {0, k_nan, 0}, {}};
    const std::vector<Vec4> four(4);
    const std::vector<std::uint32_t> indices{0, 1, 2};
    const std::vector<Joints> joints(4);
    const std::vector<float> floats(4);
    const std::vector<std::uint8_t> bytes(64);
    const std::vector<MorphTarget> targets(1);
    const std::vector<MeshPart> parts(1);
    std::vector<Misuse> all;
    const auto mesh = [&](const char* name, const std::function<void(Mesh&)>& change) {
        const auto call = [change, three, indices](auto&& act) {
            Mesh m;
            m.positions = three;
            m.indices = indices;
            change(m);
            act(m);
        };
        all.push_back({name, [call](Host& h) { call([&](const Mesh& m) { h.builder.mesh(m); }); }});
        all.push_back({name, [call](Host& h) { call([&](const Mesh& m) { h.builder.set_mesh(h.mesh, m); }); }});
    };
    for (const std::size_t count : {std::size_t{3}, std::size_t{5}, k_billion, SIZE_MAX / 64}) {
        mesh("normals", [&, count](Mesh& m) { m.normals = claiming(three, count); });
        mesh("tangents", [&, count](Mesh& m) { m.tangents = claiming(four, count); });
        mesh("texcoords", [&, count](Mesh& m) { m.texcoords[1] = claiming(two, count); });
        mesh("colors", [&, count](Mesh& m) { m.colors = claiming(four, count); });
        mesh("joints", [&, count](Mesh& m) { m.joints[0] = claiming(joints, count), m.weights[0] = four; });
        mesh("weights", [&, count](Mesh& m) { m.joints[0] = joints, m.weights[0] = claiming(four, count); });
        mesh("second joints",
             [&, count](Mesh& m) { m.joints[0] = joints, m.weights[0] = four, m.joints[1] = claiming(joints, count); });
        mesh("morph weights",
             [&, count](Mesh& m) { m.morph_targets = targets, m.morph_weights = claiming(floats, count); });
        mesh("morph positions", [&, count](Mesh& m) {
            static std::vector<MorphTarget> target;   // outlives the call, as the mesh only refers to it
            target = {{claiming(three, count), {}, {}}};
            m.morph_targets = target;
        });
    }
    for (const std::size_t count : {k_billion, SIZE_MAX / 64}) {
        mesh("positions", [&, count](Mesh& m) { m.positions = claiming(three, count); });
        mesh("positions alone", [&, count](Mesh& m) { m.positions = claiming(three, count), m.indices = {}; });
        mesh("indices", [&, count](Mesh& m) { m.indices = claiming(indices, count); });
        mesh("parts", [&, count](Mesh& m) { m.parts = claiming(parts, count); });
        mesh("morph targets", [&, count](Mesh& m) { m.morph_targets = claiming(targets, count); });
    }
    mesh("joints without weights", [&](Mesh& m) { m.joints[0] = joints; });
    mesh("second joints alone", [&](Mesh& m) { m.joints[1] = joints, m.weights[1] = four; });
    mesh("not finite", [&](Mesh& m) { m.positions = not_finite; });
    mesh("normals not finite", [&](Mesh& m) { m.normals = not_finite; });
    mesh("two indices", [&](Mesh& m) { m.indices = claiming(indices, 2); });
    const std::vector<std::uint32_t> beyond{0, 1, 4}, last{0, 1, 0xffffffff};
    mesh("index", [&](Mesh& m) { m.indices = beyond; });
    mesh("largest index", [&](Mesh& m) { m.indices = last; });
    const std::vector<MeshPart> gap{{{}, 1, 1}}, few{{{}, 0, 0}}, many{{{}, 0, 0xffffffff}}, wraps{{{}, 0xffffffff, 2}};
    for (const auto* list : {&gap, &few, &many, &wraps}) mesh("parts", [=](Mesh& m) { m.parts = *list; });

    const auto texture = [&](const char* name, const Texture& t) {
        all.push_back({name, [=](Host& h) { h.builder.texture(t); }});
    };
    texture("no size", {.pixels = bytes});
    texture("negative size", {.width = -4, .height = -4, .pixels = bytes});
    texture("large size", {.width = 1 << 30, .height = 1 << 30, .pixels = bytes});
    texture("many pixels", {.width = 32768, .height = 32768, .pixels = claiming(bytes, k_billion * 5)});
    texture("few pixels", {.width = 4, .height = 5, .pixels = bytes});
    texture("no channels", {.width = 4, .height = 4, .channels = 0, .pixels = bytes});
    texture("five channels", {.width = 2, .height = 2, .channels = 5, .pixels = bytes});
    texture("rows overlap", {.width = 4, .height = 4, .pixels = bytes, .row_bytes = 15});
    texture("rows upwards", {.width = 4, .height = 4, .pixels = bytes, .row_bytes = -16});
    texture("rows far apart", {.width = 4, .height = 4, .pixels = bytes, .row_bytes = PTRDIFF_MAX / 2});
    texture("rows farthest apart", {.width = 4, .height = 4, .pixels = bytes, .row_bytes = PTRDIFF_MAX});
    texture("wrap", {.width = 4, .height = 4, .pixels = bytes, .wrap_v = static_cast<Wrap>(3)});
    texture("filter", {.width = 4, .height = 4, .pixels = bytes, .minify = static_cast<Filter>(2)});
    const auto environment = [&](const char* name, const EnvironmentImage& image, int lights) {
        all.push_back({name, [=](Host& h) { h.builder.environment(image, lights); }});
    };
    const std::vector<float> sky(3 * 8 * 4);
    for (const int lights : {0, -1, 3, 2048}) environment("lights", {8, 4, sky}, lights);
    environment("no size", {0, 0, {}}, 4);
    environment("negative size", {-8, -4, sky}, 4);
    environment("large size", {1 << 30, 1 << 30, claiming(sky, k_billion)}, 4);
    environment("few pixels", {8, 5, sky}, 4);
    environment("many pixels", {8, 4, claiming(sky, k_billion)}, 4);

    for (const std::size_t count : {std::size_t{0}, std::size_t{3}, std::size_t{5}, k_billion}) {
        all.push_back({"input positions", [=, &three](Host& h) {
                           h.render([&](FrameInput& in) { in.vertices = {{h.instance, claiming(three, count)}}; });
                       }});
        if (count == 0) continue;
        all.push_back(
            {"input normals", [=, &three](Host& h) {
                 h.render([&](FrameInput& in) { in.vertices = {{h.instance, three, claiming(three, count)}}; });
             }});
        all.push_back(
            {"closing positions", [=, &three](Host& h) {
                 h.render([&](FrameInput& in) { in.vertices = {{h.instance, three, {}, claiming(three, count)}}; });
             }});
    }
    all.push_back({"vertices not finite", [&](Host& h) {
                       h.render([&](FrameInput& in) { in.vertices = {{h.instance, not_finite}}; });
                   }});
    all.push_back({"vertices of nothing", [&](Host& h) {
                       h.render([&](FrameInput& in) { in.vertices = {{h.empty, {}}}; });
                   }});
    all.push_back({"vertices of a joint", [&](Host& h) {
                       h.render([&](FrameInput& in) { in.vertices = {{InstanceId(h.joint), three}}; });
                   }});
    for (const std::vector<float>& weights : {std::vector<float>{}, {1, 2}, {k_nan}, {k_inf}}) {
        all.push_back({"input weights", [=](Host& h) {
                           h.render([&](FrameInput& in) { in.morph_weights = {{h.morphed, weights}}; });
                       }});
        if (!weights.empty())
            all.push_back({"closing weights", [=](Host& h) {
                               h.render([&](FrameInput& in) { in.morph_weights = {{h.morphed, {1}, weights}}; });
                           }});
    }
    expect_all_refused(all);
}

TEST(Misuse, FramesOutputsAndOptions)
{
    std::vector<Misuse> all;
    for (const int frame : {0, -1, 2, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()})
        all.push_back({"frame", [=](Host& h) { h.renderer.render(h.scene, frame); }});
    static std::vector<float> memory(8 * 8 * 3);
    const std::size_t bytes = memory.size() * sizeof(float);
    const auto output = [&](const char* name, const Output& o) {
        all.push_back({name, [=](Host& h) { h.render([&](FrameInput& in) { in.outputs = {o}; }); }});
    };
    output("no memory", {"", PixelFormat::f32, nullptr, 0, 0, bytes});
    output("too small", {"", PixelFormat::f32, memory.data(), 0, 0, bytes - 1});
    output("no bytes", {"", PixelFormat::f32, memory.data(), 0, 0, 0});
    output("no layer", {"nothing\nat all", PixelFormat::f32, memory.data(), 0, 0, bytes});
    output("a long name", {std::string(10000, 'x'), PixelFormat::f32, memory.data(), 0, 0, bytes});
    output("negative pixels", {"", PixelFormat::f32, memory.data(), -12, 0, bytes});
    output("pixels far apart", {"", PixelFormat::f32, memory.data(), PTRDIFF_MAX, 0, bytes});
    output("rows far apart", {"", PixelFormat::f32, memory.data(), 0, PTRDIFF_MIN, SIZE_MAX / 2});
    output("rows overlap", {"", PixelFormat::f32, memory.data(), 0, 8, bytes});
    output("ids as float", {"id", PixelFormat::f32, memory.data(), 0, 0, bytes});
    output("image as ids", {"", PixelFormat::u32, memory.data(), 0, 0, bytes});
    output("format", {"", static_cast<PixelFormat>(9), memory.data(), 0, 0, bytes});

    const auto options = [&](const char* name, const std::function<void(RenderOptions&)>& change) {
        RenderOptions o = Host::options();
        change(o);
        all.push_back({name, [o](Host& h) {
                           EXPECT_FALSE(test::usage_error([&] { Renderer refused{o}; }).empty());
                           h.renderer.set_options(o);
                       }});
    };
    options("size", [](RenderOptions& o) { o.size = {-8, 8}; });
    options("half a size", [](RenderOptions& o) { o.size = {8, 0}; });
    options("huge size", [](RenderOptions& o) { o.size = {32768, 32768}; });
    options("threads", [](RenderOptions& o) { o.threads = std::numeric_limits<int>::max(); });
    options("samples", [](RenderOptions& o) { o.samples = -1; });
    options("depth", [](RenderOptions& o) { o.max_depth = -1; });
    options("memory", [](RenderOptions& o) { o.memory = -1; });
    options("cache", [](RenderOptions& o) { o.indirect_memory = std::numeric_limits<int>::max(); });
    options("spp", [](RenderOptions& o) { o.reference = {.spp = 0}; });
    options("filter", [](RenderOptions& o) { o.shadow_filter = -1; });
    options("renderer", [](RenderOptions& o) { o.renderer = static_cast<RenderMethod>(2); });
    options("tone mapping", [](RenderOptions& o) { o.tonemap = static_cast<ToneMap>(-1); });
    options("culling", [](RenderOptions& o) { o.shadow_culling = static_cast<ShadowCulling>(3); });
    options("indirect", [](RenderOptions& o) { o.indirect = static_cast<Indirect>(4); });
    options("indirect on", [](RenderOptions& o) { o.indirect_on = static_cast<IndirectOn>(3); });
    options("textures", [](RenderOptions& o) { o.shadow_textures = static_cast<ShadowTextures>(5); });
    options("accelerator", [](RenderOptions& o) { o.accelerator = static_cast<Accelerator>(2); });
    options("overlay", [](RenderOptions& o) { o.overlay = static_cast<Overlay>(1000); });
    // Known only with a scene.
    const auto with_scene = [&](const char* name, const std::function<void(RenderOptions&)>& change) {
        RenderOptions o = Host::options();
        change(o);
        all.push_back({name, [o](Host& h) { Renderer(o).render(h.scene, 1); }});
    };
    with_scene("camera", [](RenderOptions& o) { o.camera = "none\nsuch " + std::string(1000, 'x'); });
    with_scene("camera's number", [](RenderOptions& o) { o.camera = "99999999999999999999"; });
    for (const int light : {-1, 1, std::numeric_limits<int>::max()})
        with_scene("overlay's light", [light](RenderOptions& o) {
            o.overlay = Overlay::shadow_states;
            o.overlay_light = light;
        });
    all.push_back({"pick", [](Host& h) { h.renderer.pick(8, 0); }});
    all.push_back({"pick", [](Host& h) { h.renderer.pick(0, -1); }});
    for (const int count : {-1, std::numeric_limits<int>::min()})
        all.push_back({"lights", [=](Host& h) { (void)h.scene.with_lights(count); }});
    for (const std::string spec : {"", "spot", "point 1 2 3 4 5 nan", "point\n1 2", "tube 1 2 3"})
        all.push_back({"light specs", [=](Host& h) { (void)h.scene.with_light_specs({spec}); }});
    all.push_back({"long light spec",
                   [](Host& h) { (void)h.scene.with_light_specs({"point 1 2 3 4 5 " + std::string(1000, '7')}); }});
    expect_all_refused(all);
}

TEST(Misuse, NamesWithLineBreaksAndOfAnyLengthMakeOneShortLine)
{
    Host host;
    const std::string name = "two\nlines\x1b[31m and " + std::string(100000, 'x');
    const test::Shape shape = test::square(1);
    Mesh mesh = shape.mesh();
    const std::vector<std::uint32_t> beyond{0, 1, 9};
    mesh.indices = beyond;
    mesh.name = name;
    Transform bad;
    bad.m[3] = 1;
    const NodeId named = host.builder.instance(host.mesh, {}, {}, {.name = name});
    const std::function<void()> calls[] = {
        [&] { host.builder.mesh(mesh); },
        [&] { host.builder.material({.name = name, .alpha = 2}); },
        [&] { host.builder.texture({.name = name}); },
        [&] {
            host.builder.skin({{host.joint}, {}, name});
        },
        [&] { host.builder.node(bad, {.name = name}); },
        [&] { host.builder.instance(host.mesh, {}, bad, {.name = name}); },
        [&] { host.builder.attach(named, host.mesh); },
        [&] { host.builder.light({.name = name}, bad); },
        [&] { host.builder.light({.name = name, .range = -1}); },
        [&] { host.builder.camera({.name = name, .transform = bad}); },
        [&] { host.builder.camera({.name = name, .vertical_fov = 0}); },
        [&] {
            host.renderer.render(host.builder.finish(), {.transforms = {{named, bad}}});
        },
    };
    int number = 0;
    for (const auto& call : calls) expect_one_line(test::usage_error(call), "call " + std::to_string(number++));
    const std::vector<std::byte> bytes(7);
    try {
        host.builder.texture(bytes, {.name = name});
        FAIL();
    } catch (const InputError& error) {
        expect_one_line(error.what(), "file in memory");
    }
}

TEST(Misuse, PartsInUseCannotBeRemoved)
{
    expect_all_refused({
        {"mesh", [](Host& h) { h.builder.remove(h.mesh); }},
        {"material", [](Host& h) { h.builder.remove(h.material); }},
        {"joint", [](Host& h) { h.builder.remove(h.joint); }},
        {"second mesh", [](Host& h) { h.builder.attach(h.instance, h.mesh); }},
        {"material of a joint", [](Host& h) { h.builder.set_material(InstanceId(h.joint), h.material); }},
        {"skin of a rigid mesh", [](Host& h) { h.builder.instance(h.mesh, {}, {}, {.skin = h.skin}); }},
    });
}

TEST(Misuse, NothingIsThereBeforeTheFirstFrameAndAfterAMove)
{
    // NOLINTBEGIN(bugprone-use-after-move): this is the behaviour under test
    Host host;
    Renderer fresh(Host::options()), moved(Host::options());
    Renderer taken(std::move(moved));
    SceneBuilder left;
    SceneBuilder builder(std::move(left));
    const std::function<void(Renderer&)> queries[] = {[&](Renderer& r) { r.transform(host.instance); },
                                                      [&](Renderer& r) { r.world_transform(host.instance); },
                                                      [&](Renderer& r) { r.visible(host.instance); },
                                                      [](Renderer& r) { r.camera(); },
                                                      [](Renderer& r) { r.bounds(); },
                                                      [](Renderer& r) { r.pick(0, 0); },
                                                      [](Renderer& r) { r.report(); }};
    for (const auto& query : queries) {
        expect_one_line(test::usage_error([&] { query(fresh); }), "before the first frame");
        expect_one_line(test::usage_error([&] { query(moved); }), "moved from");
    }
    fresh.improve({});
    fresh.forget();
    fresh.cancel();
    EXPECT_EQ(fresh.device(), "");
    EXPECT_EQ(fresh.remembered_bytes(), 0u);
    for (const auto& call : std::vector<std::function<void()>>{
             [&] { moved.improve({}); }, [&] { moved.forget(); }, [&] { moved.cancel(); },
             [&] { moved.set_options({}); }, [&] { moved.remembered_bytes(); }, [&] { moved.render(host.scene, 1); },
             [&] { left.finish(); }, [&] { left.node(); }, [&] { left.mesh({}); }, [&] { left.background({}); },
             [&] { left.clip(0, 1, 24); }, [&] { left.remove(host.instance); }, [&] { left.set_mesh(host.mesh, {}); }})
        expect_one_line(test::usage_error(call), "moved from");
    moved = std::move(taken);
    EXPECT_NO_THROW(moved.render(host.scene, 1));
    left = std::move(builder);
    EXPECT_NO_THROW(left.finish());
    // NOLINTEND(bugprone-use-after-move)
}

TEST(Misuse, ScenesOutliveTheirBuilder)
{
    std::optional<SceneBuilder> builder(std::in_place);
    const InstanceId instance = builder->instance(builder->mesh(test::square(1).mesh()), {}, {});
    const Scene scene = builder->finish();
    builder.reset();
    EXPECT_EQ(scene.instances(), std::vector<InstanceId>{instance});
    Renderer renderer(Host::options());
    EXPECT_NO_THROW(renderer.render(scene, {.camera = Camera()}));
}

TEST(Unusual, EmptyScenesNeedACameraAndGiveAnImage)
{
    SceneBuilder builder;
    const Scene scene = builder.finish();
    RenderOptions options = Host::options();
    options.layers = options.motion = true;
    Renderer renderer(options);
    expect_one_line(test::usage_error([&] { renderer.render(scene, 1); }), "no camera");
    const Frame frame = renderer.render(scene, {.camera = Camera()});
    for (const float value : frame.layers.front().values()) EXPECT_EQ(value, 0);
    EXPECT_TRUE(renderer.bounds().empty());
    EXPECT_FALSE(renderer.pick(0, 0).hit);
    for (const FinishOptions asked :
         {FinishOptions{true, false}, FinishOptions{false, true}, FinishOptions{true, true}})
        EXPECT_NO_THROW(renderer.render(builder.finish(asked), {.camera = Camera()}));
}

TEST(Unusual, SingularAndHugeTransformsAreRendered)
{
    for (const Indirect indirect : {Indirect::off, Indirect::visible}) {
        SceneBuilder builder;
        const MeshId mesh = builder.mesh(test::cube(1).mesh());
        builder.light({.color = {10, 10, 10}}, Transform::translation(0, 3, 0));
        RenderOptions options = test::plain({12, 12});
        options.indirect = indirect;
        options.motion = true;
        Renderer renderer(options);
        for (const Mobility mobility : {Mobility::fixed, Mobility::may_move})
            for (const double scale : {0.0, 1e-300, 1e-30, 1e15, 1e30, 1e200, 1e308}) {
                const InstanceId scaled =
                    builder.instance(mesh, {}, Transform::scaling(scale, 1, 1), {.mobility = mobility});
                const InstanceId away = builder.instance(mesh, {}, Transform::translation(scale, 0, 0),
                                                         {.mobility = mobility, .parent = scaled});
                const Scene scene = builder.finish();
                for (const double x : {0.0, scale, -scale})
                    EXPECT_NO_THROW(renderer.render(scene, {.camera = test::camera_along_z(),
                                                            .transforms = {{away, Transform::translation(0, x, -5)}}}))
                        << scale << " " << x;
                EXPECT_NO_THROW(renderer.bounds());
                EXPECT_NO_THROW(renderer.pick(6, 6));
                builder.remove(scaled);
            }
    }
}

TEST(Unusual, SeveralObjectsAtOnePointAreRendered)
{
    // A float's step at the last of these places is larger than the objects.
    for (const float place : {0.0f, 1e-30f, 1e6f, 2e9f}) {
        SceneBuilder builder;
        test::Shape point = test::square(0);
        for (Vec3& p : point.positions) p = {place, place, -place};
        const MeshId mesh = builder.mesh(point.mesh());
        for (const Mobility mobility : {Mobility::may_move, Mobility::may_deform})
            for (int i = 0; i < 4; ++i) builder.instance(mesh, {}, {}, {.mobility = mobility});
        Renderer renderer(Host::options());
        const Scene scene = builder.finish();
        EXPECT_NO_THROW(renderer.render(scene, {.camera = Camera()})) << place;
        FrameInput moved;
        moved.camera = Camera();
        for (const InstanceId& id : scene.instances())
            moved.transforms.push_back({id, Transform::translation(place, 0, 0)});
        EXPECT_NO_THROW(renderer.render(scene, moved)) << place;
    }
}

TEST(Unusual, DeepHierarchiesNeedNoStack)
{
    const auto start = std::chrono::steady_clock::now();
    SceneBuilder builder;
    NodeId node = builder.node();
    const NodeId root = node;
    const int depth = test::k_sanitized ? 20'000 : 100'000;
    for (int i = 1; i < depth; ++i) node = builder.node(Transform::translation(0, 0, -1e-5), {.parent = node});
    const InstanceId leaf = builder.instance(builder.mesh(test::square(1).mesh()), {}, {}, {.parent = node});
    const Scene scene = builder.finish();
    Renderer renderer(Host::options());
    renderer.render(scene, {.camera = Camera()});
    for (int i = 0; i < 3; ++i) {
        FrameInput input;
        input.camera = Camera();
        input.transforms = {{root, Transform::translation(i, 0, -5)}, {node, Transform::translation(0, i, 0)}};
        renderer.render(scene, input);
    }
    EXPECT_NEAR(renderer.world_transform(leaf).m[14], -5 - 1e-5 * (depth - 2), 1e-6);
    EXPECT_EQ(scene.mobility(leaf), Mobility::fixed);
    builder.remove(root);
    EXPECT_TRUE(builder.finish().nodes().empty());
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    EXPECT_LT(seconds, 20.0 * test::k_patience);
}

}   // namespace
}   // namespace gnomon
