// SPDX-License-Identifier: Apache-2.0
// Random sequences of everything that a host can do to a scene, rendered by one renderer, give the same bytes as a new
// renderer for each frame, with the declarations of mobility as they are then.
#include <gtest/gtest.h>

#include <cmath>
#include <list>
#include <map>
#include <set>

#include "base/random.h"
#include "gnomon/renderer.h"
#include "gnomon/scene_builder.h"
#include "same_frames.h"

namespace gnomon {
namespace {

constexpr Size k_size{24, 20};

struct Grid {
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> indices;
};

// A sphere of few triangles, or a bumpy plate.
Grid sphere(int rings, int sides, float radius)
{
    Grid grid;
    for (int y = 0; y <= rings; ++y)
        for (int x = 0; x < sides; ++x) {
            const float v = 3.14159265f * static_cast<float>(y) / static_cast<float>(rings);
            const float u = 6.2831853f * static_cast<float>(x) / static_cast<float>(sides);
            const Vec3 n{std::sin(v) * std::cos(u), std::cos(v), std::sin(v) * std::sin(u)};
            grid.normals.push_back(n);
            grid.positions.push_back({radius * n.x, radius * n.y, radius * n.z});
        }
    for (int y = 0; y < rings; ++y)
        for (int x = 0; x < sides; ++x) {
            const auto at = [&](int dx, int dy) {
                return static_cast<std::uint32_t>((y + dy) * sides + (x + dx) % sides);
            };
            for (const std::uint32_t i : {at(0, 0), at(1, 0), at(0, 1), at(1, 0), at(1, 1), at(0, 1)})
                grid.indices.push_back(i);
        }
    return grid;
}

/// What a host does beside handing over values: nothing; it adds and removes parts that may move; it adds and removes
/// parts of all kinds, changes what it declared fixed, and surface classes and types of lights.
enum class Edits : std::uint8_t { none, movable, all };

// A host: what it has built, and all values that it has handed over so far.
class Host {
 public:
    Host(std::uint64_t seed, Edits edits)
        : random_(seed, 11), edits_(edits == Edits::all), adds_and_removes_(edits != Edits::none)
    {
        for (int m = 0; m < 4; ++m) {
            Material material = random_material();
            // Parts that emit light and come or go bring lights, and so a new scene.
            if (edits == Edits::movable) material.emissive = {};
            materials_.push_back(builder_.material(material));
        }
        const Grid ball = sphere(6, 8, 0.5f), flat = sphere(2, 4, 0.7f);
        vertex_count_ = ball.positions.size();
        meshes_.push_back(
            builder_.mesh({.positions = ball.positions, .indices = ball.indices, .normals = ball.normals}));
        meshes_.push_back(builder_.mesh({.positions = flat.positions, .indices = flat.indices}));
        std::vector<Vec3> offsets(ball.positions.size(), Vec3{0.2f, 0.1f, 0});
        const MorphTarget target{.positions = offsets};
        morph_ = builder_.mesh({.positions = ball.positions,
                                .indices = ball.indices,
                                .normals = ball.normals,
                                .morph_targets = {&target, 1}});
        ball_ = ball.positions;

        // A floor and a wall that stay, and things that may go.
        for (const Transform& place : {Transform::translation(0, -2, 0) * Transform::scaling(9, 0.4, 9),
                                       Transform::translation(0, 1, -4) * Transform::scaling(9, 6, 0.4)})
            builder_.instance(meshes_[1], materials_[0], place);
        for (int i = 0; i < 6; ++i) add_instance();
        for (int i = 0; i < 2; ++i) add_light();
        camera_.transform = Transform::look_at({0, 1, 7}, {0, 0, 0});
        scene_ = builder_.finish();
    }

    /// Does a few things, and returns what to hand over.
    FrameInput act()
    {
        FrameInput input;
        bool built = false;
        for (std::uint32_t n = 1 + random_.below(4); n > 0; --n) built = act_once(input) || built;
        if (built) scene_ = builder_.finish();
        note_promotions(input);
        input.time = 0.0;
        input.camera = camera_;
        return input;
    }
    /// Everything that is in force.
    FrameInput all() const
    {
        FrameInput input;
        input.time = 0.0;
        input.camera = camera_;
        for (const auto& [index, t] : transforms_) input.transforms.push_back(t);
        for (const auto& [index, v] : visibility_) input.visibility.push_back(v);
        for (const auto& [index, v] : vertices_) input.vertices.push_back({v.first, v.second});
        for (const auto& [index, w] : weights_) input.morph_weights.push_back(w);
        for (const auto& [index, l] : light_values_) input.lights.push_back(l);
        for (const auto& [index, m] : material_values_) input.materials.push_back(m);
        return input;
    }
    /// The scene with what was promoted declared so.
    Scene declared() const
    {
        SceneBuilder builder(*scene_);
        for (const auto& [index, id] : promoted_) builder.set_mobility(id, id_mobility_.at(index));
        return builder.finish();
    }
    const Scene& scene() const { return *scene_; }
    const RenderOptions& options() const { return options_; }

 private:
    double place(double reach) { return static_cast<double>(random_.uniform(-1, 1)) * reach; }
    float unit() { return random_.uniform(0, 1); }
    Transform random_place()
    {
        Transform t = Transform::translation(place(2.5), place(1.5), place(2)) *
                      Transform::rotation({unit() + 0.1f, unit(), unit()}, place(3));
        if (random_.below(12) == 0) t = t * Transform::scaling(1, random_.below(2), 1);
        if (random_.below(12) == 0) t = Transform::translation(place(30), place(30), place(30)) * t;
        return t;
    }
    Material random_material()
    {
        Material m;
        m.base_color = {unit(), unit(), unit()};
        m.roughness = unit();
        m.metallic = random_.below(4) == 0 ? 1.0f : 0.0f;
        if (edits_ && random_.below(8) == 0) m.transmission = 1;
        if (random_.below(6) == 0) m.emissive = {unit(), unit(), unit()};
        m.double_sided = edits_ && random_.below(2) == 0;
        return m;
    }
    Light random_light()
    {
        Light l;
        l.type = edits_ ? static_cast<LightType>(random_.below(3)) : LightType::spot;
        const float power = l.type == LightType::directional ? 3.0f : 50.0f;
        l.color = {power * unit(), power * unit(), power * unit()};
        l.outer_angle = 0.3f + unit();
        l.range = random_.below(4) == 0 ? 12.0f : 0.0f;
        return l;
    }
    void add_instance()
    {
        const std::uint32_t kind = random_.below(5);
        InstanceOptions options;
        options.mobility = !edits_    ? Mobility::may_deform
                           : kind < 2 ? Mobility::fixed
                           : kind < 4 ? Mobility::may_move
                                      : Mobility::may_deform;
        if (!instances_.empty() && random_.below(3) == 0) options.parent = instances_[below(instances_)];
        const bool morphs = random_.below(4) == 0;
        const MeshId mesh = morphs ? morph_ : meshes_[random_.below(2)];
        const InstanceId id = builder_.instance(mesh, materials_[below(materials_)], random_place(), options);
        instances_.push_back(id);
        parents_[id.index] = options.parent;
        declared_[id.index] = options.mobility;
        (morphs ? morphing_ : mesh == meshes_[0] ? balls_ : plates_).insert(id.index);
    }
    void add_light()
    {
        const LightId id = builder_.light(random_light(), Transform::look_at({static_cast<float>(place(4)), 5, 4}, {}));
        lights_.push_back(id);
    }
    template <class List>
    std::uint32_t below(const List& list)
    {
        return random_.below(static_cast<std::uint32_t>(list.size()));
    }

    // Finds what is declared fixed and changes all the same.
    void note_promotions(const FrameInput& input)
    {
        for (const NodeTransform& t : input.transforms) promote(t.node, Mobility::may_move);
        for (const NodeVisibility& v : input.visibility) {
            bool& before = shown_.try_emplace(v.node.index, true).first->second;
            if (before != v.visible) promote(v.node, Mobility::may_move);
            before = v.visible;
        }
        for (const NodeId& id : input.released_nodes) shown_.erase(id.index);
        for (const InstanceVertices& v : input.vertices) promote(v.instance, Mobility::may_deform);
        for (const MorphWeights& w : input.morph_weights) promote(w.instance, Mobility::may_deform);
    }
    void promote(const NodeId& id, Mobility mobility)
    {
        if (declared_.at(id.index) >= mobility) return;
        promoted_[id.index] = id;
        Mobility& now = id_mobility_.try_emplace(id.index, mobility).first->second;
        now = std::max(now, mobility);
    }
    void move(FrameInput& input)
    {
        if (instances_.empty()) return;
        const InstanceId id = instances_[below(instances_)];
        if (random_.below(6) == 0 && transforms_.contains(id.index)) {
            input.released_nodes.push_back(id);
            transforms_.erase(id.index), visibility_.erase(id.index), vertices_.erase(id.index);
            weights_.erase(id.index);
            std::erase_if(input.transforms, [&](const NodeTransform& t) { return t.node == id; });
            std::erase_if(input.visibility, [&](const NodeVisibility& v) { return v.node == id; });
            std::erase_if(input.vertices, [&](const InstanceVertices& v) { return v.instance == id; });
            std::erase_if(input.morph_weights, [&](const MorphWeights& w) { return w.instance == id; });
            return;
        }
        const NodeTransform t{id, random_.below(8) == 0 && transforms_.contains(id.index)
                                      ? transforms_.at(id.index).transform
                                      : random_place()};
        transforms_.insert_or_assign(id.index, t);
        input.transforms.push_back(t);
    }
    void deform(FrameInput& input)
    {
        if (balls_.empty()) return;
        const InstanceId id = with_index(balls_);
        std::vector<Vec3> shape = ball_;
        const float bump = unit();
        for (Vec3& p : shape) p.y += 0.2f * std::sin(bump * 9 + 5 * p.x), p.z *= 0.7f + 0.5f * bump;
        shapes_.push_back(std::move(shape));
        vertices_.insert_or_assign(id.index, std::pair(id, std::span<const Vec3>(shapes_.back())));
        input.vertices.push_back({id, shapes_.back()});
    }
    InstanceId with_index(const std::set<std::uint32_t>& of)
    {
        auto at = of.begin();
        std::advance(at, below(of));
        for (const InstanceId& id : instances_)
            if (id.index == *at) return id;
        return {};
    }
    bool act_once(FrameInput& input)
    {
        constexpr std::uint32_t k_kinds = 16, k_of_lights = 2, k_edits = 4;
        const std::uint32_t first = edits_ ? 0 : adds_and_removes_ ? k_of_lights : k_edits;
        switch (first + random_.below(k_kinds - first)) {
            case 0:
                if (lights_.size() < 4) add_light();
                return true;
            case 1:
                return remove_light(input);
            case 2:
                if (instances_.size() < 12) add_instance();
                return true;
            case 3:
                return remove_instance(input);
            case 4: {
                if (instances_.empty()) return false;
                const InstanceId id = instances_[below(instances_)];
                const NodeVisibility v{id, random_.below(3) > 0};
                visibility_.insert_or_assign(id.index, v);
                input.visibility.push_back(v);
                return false;
            }
            case 5:
                deform(input);
                return false;
            case 6: {
                if (morphing_.empty()) return false;
                const MorphWeights w{with_index(morphing_), {unit()}};
                weights_.insert_or_assign(w.instance.index, w);
                input.morph_weights.push_back(w);
                return false;
            }
            case 7: {
                if (lights_.empty()) return false;
                Light values = random_light();
                const LightId id = lights_[below(lights_)];
                light_values_.insert_or_assign(id.stamp, LightValues{id, values});
                input.lights.push_back({id, values});
                return false;
            }
            case 8: {
                const MaterialId id = materials_[below(materials_)];
                const MaterialValues m{id, random_material()};
                material_values_.insert_or_assign(id.index, m);
                input.materials.push_back(m);
                return false;
            }
            case 9:
                camera_.transform = Transform::look_at({static_cast<float>(place(3)), 2, 7}, {0, 0, 0});
                camera_.orthographic_height.reset();
                if (random_.below(3) == 0) camera_.orthographic_height = 5.0;
                camera_.shift_x = random_.below(2) ? 0.2 : 0;
                return false;
            case 10:
                change_options();
                return false;
            default:
                move(input);
                return false;
        }
    }
    void change_options()
    {
        options_.indirect = static_cast<Indirect>(random_.below(4));
        options_.shadow_culling = random_.below(3) ? ShadowCulling::certified : ShadowCulling::off;
        options_.samples = 1 + static_cast<int>(random_.below(2));
        options_.max_depth = static_cast<int>(random_.below(4));
    }
    template <class Values>
    static void forget_index(Values& values, std::uint32_t index)
    {
        values.erase(index);
    }
    bool remove_instance(FrameInput& input)
    {
        if (instances_.empty()) return false;
        const InstanceId root = instances_[below(instances_)];
        builder_.remove(NodeId(root));
        // What is below goes as well.
        std::set<std::uint32_t> gone{root.index};
        for (bool more = true; more;) {
            more = false;
            for (const InstanceId& id : instances_)
                if (const NodeId parent = parents_[id.index]; parent && gone.contains(parent.index))
                    more = gone.insert(id.index).second || more;
        }
        const auto is_gone = [&](const NodeId& id) { return gone.contains(id.index); };
        std::erase_if(instances_, is_gone);
        for (const std::uint32_t index : gone) {
            transforms_.erase(index), visibility_.erase(index), vertices_.erase(index), weights_.erase(index);
            promoted_.erase(index), id_mobility_.erase(index), parents_.erase(index), declared_.erase(index),
                shown_.erase(index);
            balls_.erase(index), plates_.erase(index), morphing_.erase(index);
        }
        std::erase_if(input.transforms, [&](const NodeTransform& t) { return is_gone(t.node); });
        std::erase_if(input.visibility, [&](const NodeVisibility& v) { return is_gone(v.node); });
        std::erase_if(input.vertices, [&](const InstanceVertices& v) { return is_gone(v.instance); });
        std::erase_if(input.morph_weights, [&](const MorphWeights& w) { return is_gone(w.instance); });
        std::erase_if(input.released_nodes, is_gone);
        return true;
    }
    bool remove_light(FrameInput& input)
    {
        if (lights_.size() < 2) return false;
        const std::uint32_t at = below(lights_);
        const LightId id = lights_[at];
        builder_.remove(id);
        lights_.erase(lights_.begin() + at);
        light_values_.erase(id.stamp);
        std::erase_if(input.lights, [&](const LightValues& l) { return l.light == id; });
        return true;
    }

    Random random_;
    bool edits_, adds_and_removes_;
    SceneBuilder builder_;
    std::optional<Scene> scene_;
    RenderOptions options_{.size = k_size, .threads = 1, .layers = true};
    Camera camera_;
    std::vector<MaterialId> materials_;
    std::vector<MeshId> meshes_;
    MeshId morph_;
    std::vector<Vec3> ball_;
    std::size_t vertex_count_ = 0;
    std::vector<InstanceId> instances_;
    std::map<std::uint32_t, NodeId> parents_;
    std::map<std::uint32_t, Mobility> declared_;
    std::map<std::uint32_t, bool> shown_;
    std::vector<LightId> lights_;
    std::set<std::uint32_t> balls_, plates_, morphing_;   // indices of instances by mesh
    std::map<std::uint32_t, NodeTransform> transforms_;
    std::map<std::uint32_t, NodeVisibility> visibility_;
    std::map<std::uint32_t, std::pair<InstanceId, std::span<const Vec3>>> vertices_;
    std::map<std::uint32_t, MorphWeights> weights_;
    std::map<std::uint32_t, LightValues> light_values_;
    std::map<std::uint32_t, MaterialValues> material_values_;
    std::map<std::uint32_t, NodeId> promoted_;
    std::map<std::uint32_t, Mobility> id_mobility_;
    std::list<std::vector<Vec3>> shapes_;   // that vertices_ points to
};

// @return the number of frames for which the kept renderer began anew
int compare_sequences(std::uint64_t first, std::uint64_t last, int steps, Edits edits)
{
    int anew = 0;
    for (std::uint64_t seed = first; seed <= last; ++seed) {
        Host host(seed, edits);
        Renderer kept(host.options());
        for (int step = 0; step < steps; ++step) {
            const FrameInput input = host.act();
            RenderOptions options = host.options();
            options.threads = 2;
            Renderer fresh(options);
            kept.set_options(host.options());
            const Frame got = kept.render(host.scene(), input);
            const Frame expected = fresh.render(host.declared(), host.all());
            anew += got.counters.update.began_anew;
            test::expect_same(got, expected);
            if (testing::Test::HasFailure()) {
                ADD_FAILURE() << "seed " << seed << ", step " << step;
                return anew;
            }
        }
    }
    return anew;
}

TEST(HostSequence, SameBytesAsANewRendererInEachStep)
{
    compare_sequences(1, 3, 6, Edits::all);
}

TEST(HostSequence, SameBytesWithoutEditsWithoutBeginningAnew)
{
    constexpr int k_seeds = 3, k_steps = 7;
    EXPECT_EQ(compare_sequences(1, k_seeds, k_steps, Edits::none), k_seeds);   // in each first frame
}

TEST(HostSequence, SameBytesWhilePartsThatMayMoveComeAndGoWithoutBeginningAnew)
{
    constexpr int k_seeds = 3, k_steps = 7;
    EXPECT_EQ(compare_sequences(1, k_seeds, k_steps, Edits::movable), k_seeds);
}

TEST(HostSequenceFull, SameBytesAsANewRendererInEachStepOfAThousandSequences)
{
    compare_sequences(1, 1000, 12, Edits::all);
}

TEST(HostSequenceFull, SameBytesWithoutEditsInAThousandSequences)
{
    compare_sequences(1, 1000, 12, Edits::none);
}

TEST(HostSequenceFull, SameBytesWhilePartsThatMayMoveComeAndGoInAThousandSequences)
{
    compare_sequences(1, 1000, 16, Edits::movable);
}

}   // namespace
}   // namespace gnomon
