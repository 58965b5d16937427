// SPDX-License-Identifier: Apache-2.0
// Random calls of the public interface, with values that are valid, invalid or extreme: nothing but gnomon::Error is
// thrown, and no internal check fails.
#include <gtest/gtest.h>

#include <limits>

#include "base/random.h"
#include "gnomon/gnomon.h"
#include "host_scene.h"

namespace gnomon {
namespace {

class Caller {
 public:
    explicit Caller(std::uint64_t seed) : random_(seed) {}

    void call()
    {
        try {
            act();
        } catch (const InternalError& error) {
            ADD_FAILURE() << error.what();
        } catch (const Error& error) {
            const std::string message = error.what();
            EXPECT_FALSE(message.empty());
            EXPECT_EQ(message.find('\n'), std::string::npos) << message;
            ++refused_;
        }
        ++calls_;
    }
    int refused() const { return refused_; }
    int rendered() const { return rendered_; }

 private:
    std::uint32_t below(std::uint32_t count) { return random_.below(count); }
    bool rarely() { return below(12) == 0; }
    double number()
    {
        constexpr double special[] = {0, -0.0, 1, -1, 1e-300, 1e-30, 1e9, 1e30, 1e38, 1e200, -1e30};
        if (rarely()) return rarely() ? std::numeric_limits<double>::quiet_NaN() : special[below(11)];
        return (below(2001) - 1000.0) / 250;
    }
    float small() { return static_cast<float>(number()); }
    Vec3 color()
    {
        const auto one = [&] { return rarely() ? small() : static_cast<float>(below(100)) / 25; };
        return {one(), one(), one()};
    }
    Vec3 point() { return {small(), small(), small()}; }
    Transform transform()
    {
        Transform t = Transform::translation(number(), number(), number() - 4);
        if (below(2)) t = t * Transform::scaling(number(), number(), number());
        if (below(4) == 0) t = t * Transform::rotation(point(), number());
        if (rarely()) t.m[below(16)] = number();
        return t;
    }
    // One of the ids so far, of removed parts and of other scenes, too.
    template <class Id>
    Id one_of(const std::vector<Id>& ids)
    {
        return ids.empty() || rarely() ? Id() : ids[below(static_cast<std::uint32_t>(ids.size()))];
    }
    template <class Id>
    const Id& keep(std::vector<Id>& ids, const Id& id)
    {
        if (ids.size() < 40) return ids.emplace_back(id);
        return ids[below(40)] = id;
    }
    Mobility mobility() { return static_cast<Mobility>(below(rarely() ? 5 : 3)); }
    NodeOptions node_options() { return {mobility(), below(2) ? one_of(nodes_) : NodeId(), names_[below(3)]}; }
    TextureUse texture_use()
    {
        TextureUse use;
        if (below(3) == 0) use.texture = one_of(textures_);
        if (rarely()) use.texcoord = static_cast<int>(below(4)) - 1, use.rotation = small(), use.offset.x = small();
        return use;
    }
    Material material()
    {
        Material m;
        m.name = names_[below(3)];
        m.base_color = color(), m.emissive = rarely() ? color() : Vec3();
        m.base_color_texture = texture_use(), m.normal_texture = texture_use();
        m.double_sided = below(2) != 0;
        m.model = static_cast<ShadingModel>(below(rarely() ? 5 : 3));
        m.alpha_mode = static_cast<AlphaMode>(below(3));
        m.alpha = static_cast<float>(below(11)) / 10, m.roughness = static_cast<float>(below(11)) / 10;
        if (rarely()) m.ior = small(), m.transmission = small(), m.metallic = small(), m.transmittance = small();
        return m;
    }
    Light light()
    {
        Light l;
        l.type = static_cast<LightType>(below(3));
        l.color = color();
        if (below(4) == 0) l.inner_angle = small(), l.outer_angle = small(), l.range = small();
        return l;
    }
    Camera camera()
    {
        Camera c = test::camera_along_z();
        if (below(2)) c.transform = transform();
        if (below(4) == 0) c.vertical_fov = number(), c.near = number(), c.far = number(), c.shift_x = number();
        if (rarely()) c.orthographic_height = number();
        if (rarely()) c.intrinsics = Intrinsics{number(), number(), number(), number(), {4, 4}};
        if (rarely()) c.matrix = transform();
        return c;
    }
    void add_mesh(const MeshId* replaced = nullptr)
    {
        test::Shape shape = below(2) ? test::cube(1) : test::square(1);
        if (below(3) == 0) shape.positions[below(4)] = point();
        if (rarely()) shape.indices[below(6)] = below(20);
        if (rarely()) shape.indices.pop_back();
        const std::size_t count = shape.positions.size() - (rarely() ? 1 : 0);
        const std::vector<Vec3> normals(count, point()), offsets(count, point());
        const std::vector<MorphTarget> targets{{offsets, {}, {}}};
        const std::vector<Joints> joints(count);
        const std::vector<Vec4> weights(count, Vec4{1, 0, 0, 0});
        const std::vector<MeshPart> parts{{one_of(materials_), 0, 1},
                                          {{}, 1, static_cast<std::uint32_t>(shape.indices.size() / 3) - 1}};
        Mesh mesh = shape.mesh();
        if (below(2)) mesh.normals = normals;
        if (below(3) == 0) mesh.morph_targets = targets;
        if (below(3) == 0) mesh.joints[0] = joints, mesh.weights[0] = weights;
        if (below(3) == 0) mesh.parts = parts;
        replaced ? builder_.set_mesh(*replaced, mesh) : void(keep(meshes_, builder_.mesh(mesh)));
    }
    void add()
    {
        switch (below(9)) {
            case 0:
                return add_mesh();
            case 1:
                return void(keep(materials_, builder_.material(material())));
            case 2: {
                const std::vector<std::uint8_t> pixels(12 + below(8), 100);
                return void(
                    keep(textures_, builder_.texture({.width = 2, .height = 2, .channels = 3, .pixels = pixels})));
            }
            case 3:
                return void(keep(nodes_, builder_.node(transform(), node_options())));
            case 4:
                return void(keep(skins_, builder_.skin({{one_of(nodes_)}, {transform()}})));
            case 5:
                return void(keep(lights_, builder_.light(light(), transform(), node_options())));
            case 6:
                return void(keep(cameras_, builder_.camera(camera(), node_options())));
            default: {
                InstanceOptions options;
                options.mobility = mobility();
                if (below(3) == 0) options.parent = one_of(nodes_);
                if (below(4) == 0) options.skin = one_of(skins_);
                if (rarely()) options.reach = {point(), point()};
                const MaterialId of = below(2) ? one_of(materials_) : MaterialId();
                const InstanceId id = below(5) ? builder_.instance(one_of(meshes_), of, transform(), options)
                                               : builder_.attach(one_of(nodes_), one_of(meshes_), of, options);
                keep(instances_, id);
                keep(nodes_, NodeId(id));
            }
        }
    }
    void change()
    {
        switch (below(7)) {
            case 0: {
                const MeshId id = one_of(meshes_);
                return add_mesh(&id);
            }
            case 1:
                return builder_.set_material(one_of(materials_), material());
            case 2:
                return builder_.set_material(one_of(instances_), one_of(materials_));
            case 3:
                return builder_.set_light(one_of(lights_), light());
            case 4:
                return builder_.set_camera(one_of(cameras_), camera());
            case 5:
                return builder_.set_transform(one_of(nodes_), transform());
            default:
                return builder_.set_mobility(one_of(nodes_), mobility());
        }
    }
    void remove()
    {
        switch (below(7)) {
            case 0:
                return builder_.remove(one_of(nodes_));
            case 1:
                return builder_.remove(one_of(lights_));
            case 2:
                return builder_.remove(one_of(cameras_));
            case 3:
                return builder_.remove(one_of(meshes_));
            case 4:
                return builder_.remove(one_of(materials_));
            case 5:
                return builder_.remove(one_of(textures_));
            default:
                return builder_.remove(one_of(skins_));
        }
    }
    void surround()
    {
        const std::vector<float> sky(3 * 8 * 4, small());
        switch (below(4)) {
            case 0:
                return builder_.environment({8, 4, sky}, static_cast<int>(below(9)));
            case 1:
                return builder_.background(color());
            case 2:
                return builder_.ambient(color());
            default:
                return builder_.clip(number(), number() + 3, number() + 10);
        }
    }
    void set_options()
    {
        RenderOptions o;
        o.size = {8, 8};
        o.samples = below(4) == 0 ? 2 : 1;
        o.indirect = static_cast<Indirect>(below(4));
        o.shadow_culling = static_cast<ShadowCulling>(below(3));
        o.accelerator = rarely() ? Accelerator::kdtree : Accelerator::embree;
        o.layers = below(2) != 0, o.ids = below(2) != 0, o.motion = below(2) != 0, o.report_changes = below(2) != 0;
        o.threads = static_cast<int>(below(3));
        if (rarely()) o.overlay = static_cast<Overlay>(below(5));
        if (rarely()) o.exposure = number();
        renderer_.set_options(o);
    }
    void render()
    {
        FrameInput in;
        if (below(2)) in.time = number();
        if (below(4)) in.camera = camera();
        if (rarely()) in.turn = number();
        std::vector<Vec3> vertices(below(2) ? 8 : 4, point());
        vertices[0] = point(), vertices[1] = point();
        if (below(2)) in.transforms = {{one_of(nodes_), transform()}, {one_of(nodes_), transform()}};
        if (below(4) == 0) in.visibility = {{one_of(nodes_), below(2) != 0}};
        if (below(4) == 0) in.vertices = {{one_of(instances_), vertices}};
        if (below(4) == 0) in.morph_weights = {{one_of(instances_), {small()}}};
        if (below(3) == 0) in.lights = {{one_of(lights_), light()}};
        if (below(3) == 0) in.materials = {{one_of(materials_), material()}};
        if (below(4) == 0) in.released_nodes = {one_of(nodes_)};
        if (below(4) == 0) in.released_lights = {one_of(lights_)};
        if (below(4) == 0) in.released_materials = {one_of(materials_)};
        if (rarely()) in.indirect_ray_limit = below(1000);
        in.preview = rarely();
        renderer_.render(scene_, in);
        ++rendered_;
    }
    void ask()
    {
        const NodeId node = one_of(nodes_);
        switch (below(6)) {
            case 0:
                return void(renderer_.pick(static_cast<int>(below(10)) - 1, static_cast<int>(below(9))));
            case 1:
                return void(renderer_.report());
            case 2:
                return void((renderer_.transform(node), renderer_.visible(node), scene_.moving_node(node)));
            case 3:
                return void((renderer_.camera(), renderer_.bounds(), scene_.info()));
            case 4:
                return void((scene_.material(one_of(materials_)), scene_.mobility(node)));
            default:
                return void((scene_.light(one_of(lights_)), scene_.camera(one_of(cameras_))));
        }
    }
    void act()
    {
        const std::uint32_t what = below(100);
        if (what < 35) return add();
        if (what < 50) return change();
        if (what < 58) return remove();
        if (what < 61) return surround();
        if (what < 72) return void(scene_ = builder_.finish({below(4) == 0, below(4) == 0}));
        if (what < 77) return set_options();
        if (what < 90) return render();
        if (what < 98) return ask();
        if (what == 98) return renderer_.forget();
        builder_ = SceneBuilder(scene_);
    }

    const std::string names_[3] = {"", "a", "two\nlines"};
    Random random_;
    SceneBuilder builder_;
    Scene scene_ = builder_.finish();
    Renderer renderer_{test::plain({8, 8})};
    std::vector<MeshId> meshes_;
    std::vector<MaterialId> materials_;
    std::vector<TextureId> textures_;
    std::vector<SkinId> skins_;
    std::vector<NodeId> nodes_;
    std::vector<InstanceId> instances_;
    std::vector<LightId> lights_;
    std::vector<CameraId> cameras_;
    int calls_ = 0, refused_ = 0, rendered_ = 0;
};

TEST(ApiFuzz, RandomCallsThrowErrorsOnly)
{
    int refused = 0, rendered = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE(seed);
        Caller caller(seed);
        for (int i = 0; i < 200; ++i) caller.call();
        refused += caller.refused(), rendered += caller.rendered();
    }
    // Both happen often.
    EXPECT_GT(refused, 100);
    EXPECT_GT(rendered, 20);
}

}   // namespace
}   // namespace gnomon
