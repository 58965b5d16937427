// SPDX-License-Identifier: Apache-2.0
#pragma once
// Random animations for tests of light views: objects that start, stop, jump away and return, appear, vanish and
// deform, exact duplicates of others, and lights of every type, some of which move or blink.

#include "scene_helpers.h"

namespace gnomon::test {

/// Rests at one of a few placements, sways around it, or jumps to another; a new phase starts every few frames.
class ScriptTrack final : public scene::TransformTrack {
 public:
    /// @param places  resting placements; phases start at whole frames, `fps` of them per second
    ScriptTrack(std::vector<glm::dmat4> places, int frames, double fps, std::uint64_t seed)
        : places_(std::move(places)), fps_(fps)
    {
        Random random(seed);
        for (int frame = 0; frame <= frames;) {
            phases_.push_back({frame, random.below(static_cast<std::uint32_t>(places_.size())), random.below(5) < 2});
            frame += 1 + static_cast<int>(random.below(random.below(3) == 0 ? 40 : 8));
        }
    }
    glm::dmat4 evaluate(double time) const override
    {
        const double frame = std::max(0.0, time * fps_);
        auto next = std::upper_bound(phases_.begin(), phases_.end(), frame,
                                     [](double f, const Phase& phase) { return f < phase.first_frame; });
        const Phase& phase = *std::prev(next);
        const glm::dmat4& place = places_[phase.place];
        if (!phase.sways) return place;
        const double t = frame - phase.first_frame;
        return glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(0.15 * t, 0.3 * std::sin(t), -0.1 * t)) * place,
                           0.2 * t, glm::dvec3(0, 1, 0));
    }
    std::vector<scene::Interval> changing() const override
    {
        std::vector<scene::Interval> intervals;
        for (std::size_t i = 0; i < phases_.size(); ++i) {
            const double begin = phases_[i].first_frame / fps_;
            const double end = i + 1 < phases_.size() ? phases_[i + 1].first_frame / fps_ : 1e9;
            intervals.push_back({begin, phases_[i].sways ? end : begin});
        }
        return intervals;
    }

 private:
    struct Phase {
        int first_frame;
        std::uint32_t place;
        bool sways;
    };
    std::vector<Phase> phases_;
    std::vector<glm::dmat4> places_;
    double fps_;
};

struct LightScript {
    std::shared_ptr<const scene::Scene> scene;
    int frames = 0;
    double fps = 24;
    double time(int frame) const { return frame / fps; }   // from 0
};

inline std::shared_ptr<scene::VisibilityTrack> blinking(int frames, double fps, int longest, Random& random)
{
    std::vector<double> times;
    std::vector<bool> visible;
    bool on = random.below(2) == 0;
    for (int frame = 1; frame < frames;
         frame += 1 + static_cast<int>(random.below(static_cast<std::uint32_t>(longest)))) {
        times.push_back(frame / fps);
        visible.push_back(on);
        on = !on;
    }
    return visibility(std::move(times), std::move(visible));
}

inline LightScript make_light_script(std::uint64_t seed, int frames, int still = 14, int dynamic_objects = 6)
{
    LightScript script;
    script.frames = frames;
    scene::Scene scene;
    add_materials(scene);
    Random random(seed);
    for (scene::MaterialId m = 0; m < material_count; ++m) scene.meshes.push_back(ball(m, 4, 6, seed + m));
    scene.meshes.push_back(patchwork(seed));
    const auto rigid_meshes = static_cast<std::uint32_t>(scene.meshes.size());
    scene.meshes.push_back(patchwork(seed + 100));
    scene::Mesh& keyed = scene.meshes.edit(rigid_meshes);
    add_vertex_keys(keyed);
    keyed.vertex_keys->times = {0.2 * frames / script.fps, 0.3 * frames / script.fps, 0.5 * frames / script.fps};

    // A floor below everything else, seen by all lights.
    const scene::NodeId floor =
        add_object(scene, 0, scene::none, translation(0, -6, 0) * glm::scale(glm::dmat4(1), glm::dvec3(9, 0.2, 9)));
    (void)floor;
    std::vector<glm::dmat4> static_places;
    std::vector<scene::MeshId> static_meshes;
    for (int i = 0; i < still; ++i) {
        static_places.push_back(random_placement(random, 5));
        static_meshes.push_back(random.below(rigid_meshes));
        const scene::NodeId node = add_object(scene, static_meshes.back(), scene::none, static_places.back());
        if (i % 5 == 4) scene.nodes[node].visibility = blinking(frames, script.fps, 30, random);
    }
    // Every second dynamic object may rest exactly where a static object with the same mesh stands, so that all depths
    // are equal.
    for (int i = 0; i < dynamic_objects; ++i) {
        const std::uint32_t same = random.below(static_cast<std::uint32_t>(still));
        std::vector<glm::dmat4> places{random_placement(random, 5), random_placement(random, 5),
                                       translation(60, 3 * i, 0)};
        if (i % 2) places.push_back(static_places[same]);
        const scene::NodeId node = add_object(scene, i % 2 ? static_meshes[same] : random.below(rigid_meshes));
        scene.nodes[node].transform =
            std::make_shared<ScriptTrack>(places, frames, script.fps, seed * 77 + static_cast<std::uint64_t>(i));
        if (i % 3 == 2) scene.nodes[node].visibility = blinking(frames, script.fps, 20, random);
    }
    // Two dynamic objects that rest at the same places.
    for (int i = 0; i < 2; ++i) {
        const scene::NodeId node = add_object(scene, 0);
        scene.nodes[node].transform =
            std::make_shared<ScriptTrack>(std::vector<glm::dmat4>{translation(1, 1, 1), translation(-2, 0, 1)}, frames,
                                          script.fps, seed + static_cast<std::uint64_t>(i));
    }
    add_object(scene, rigid_meshes, scene::none, random_placement(random, 4));   // deforms

    const auto add_light = [&](scene::LightType type, const glm::dmat4& local, float angle = 0.6f) {
        scene::Light light;
        light.type = type;
        light.outer_angle = angle;
        light.node = scene.add_node("", scene::none, local);
        scene.lights.push_back(light);
        return light.node;
    };
    const auto look_at = [](const glm::dvec3& eye, const glm::dvec3& at) {
        return glm::inverse(glm::lookAt(eye, at, glm::dvec3(0.1, 1, 0.3)));
    };
    add_light(scene::LightType::spot, look_at({2, 14, 3}, {0, 0, 0}));
    add_light(scene::LightType::directional, look_at({1, 2, 0.5}, {0, 0, 0}));
    add_light(scene::LightType::point, translation(0.3, 0.2, -0.4));   // among the objects
    const scene::NodeId dynamic_object = add_light(scene::LightType::spot, glm::dmat4(1));
    scene.nodes[dynamic_object].transform = std::make_shared<ScriptTrack>(
        std::vector<glm::dmat4>{look_at({-9, 6, 2}, {0, 0, 0}), look_at({4, 10, -6}, {0, 0, 0})}, frames, script.fps,
        seed + 9);
    const scene::NodeId blinking_light = add_light(scene::LightType::point, translation(3, 2, 2));
    scene.nodes[blinking_light].visibility = blinking(frames, script.fps, 25, random);
    add_light(scene::LightType::spot, look_at({0, 9, 0.1}, {0, 0, 0}), 1.4f);   // so wide that it needs six faces
    const scene::NodeId sun = add_light(scene::LightType::directional, glm::dmat4(1));
    scene.nodes[sun].transform = std::make_shared<ScriptTrack>(
        std::vector<glm::dmat4>{look_at({3, 5, 1}, {0, 0, 0}), look_at({0, 5, -1}, {0, 0, 0})}, frames, script.fps,
        seed + 10);

    scene.timeline = {0, (frames - 1) / script.fps, frames, script.fps, false};
    script.scene = finished(scene);
    return script;
}

}   // namespace gnomon::test
