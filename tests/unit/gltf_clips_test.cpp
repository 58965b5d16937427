// SPDX-License-Identifier: Apache-2.0
// Which animations of a glTF file play, and the frames that they have.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "gltf_document.h"
#include "gnomon/error.h"
#include "scene/state.h"

namespace gnomon {
namespace {

using test::Document;

// A node's translation along x, between these times.
struct Clips {
    Document d;
    std::string list, nodes;

    void add(const std::string& name, const std::vector<float>& times, int node = 0)
    {
        std::vector<float> places;
        for (std::size_t i = 0; i < times.size(); ++i) places.insert(places.end(), {static_cast<float>(i), 0, 0});
        const int t = d.times(times), v = d.floats(places, "VEC3", 3);
        list +=
            fmt::format(R"({}{{"name":"{}","channels":[{{"sampler":0,"target":{{"node":{},"path":"translation"}}}}],)"
                        R"("samplers":[{{"input":{},"output":{}}}]}})",
                        list.empty() ? "" : ",", name, node, t, v);
    }
    scene::Scene load(const std::string& animation = "", bool strict = false) const
    {
        return d.load("\"nodes\":[{},{},{}],\"animations\":[" + list + "]", "",
                      {.strict = strict, .animation = animation});
    }
};

std::vector<float> keys(int first, int last)
{
    std::vector<float> times;
    for (int i = first; i <= last; ++i) times.push_back(static_cast<float>(i / 24.0));
    return times;
}

TEST(GltfClips, AClipOf48KeyedFramesHas48FramesAndBeginsWithTheFirstKey)
{
    for (const int first : {0, 1, 250, 7919}) {
        Clips c;
        c.add("walk", keys(first, first + 47));
        const scene::Scene s = c.load();
        EXPECT_EQ(s.timeline.frames, 48) << first;
        EXPECT_EQ(s.timeline.time_of(1), static_cast<float>(first / 24.0));
        // Frame i shows key i.
        for (const int frame : {1, 2, 24, 48})
            EXPECT_NEAR(s.nodes[0].transform->evaluate(s.timeline.time_of(frame))[3].x, frame - 1, 1e-3) << first;
        EXPECT_EQ(s.timeline.at_rate(48).frames, 95);
        EXPECT_EQ(s.timeline.at_rate(48).time_of(1), s.timeline.start);
    }
}

TEST(GltfClips, WithoutAChoiceClipsPlayThatMoveDifferentThings)
{
    Clips c;
    c.add("idle", {0, 1});
    c.add("walk", {0, 2});
    c.add("fan", {1, 3}, 1);
    const scene::Scene s = c.load();
    ASSERT_EQ(s.clips.size(), 3u);
    EXPECT_TRUE(s.clips[0].plays && !s.clips[1].plays && s.clips[2].plays);
    EXPECT_EQ(s.clips[2].name, "fan");
    EXPECT_EQ(s.clips[2].start, 1);
    EXPECT_EQ(s.clips[2].end, 3);
    EXPECT_EQ(s.timeline.start, 0);
    EXPECT_EQ(s.timeline.end, 3);
    ASSERT_EQ(s.warnings.size(), 1u);
    EXPECT_NE(s.warnings[0].find("1 of 3 animations"), std::string::npos) << s.warnings[0];
    EXPECT_NE(s.warnings[0].find("0 idle, 1 walk, 2 fan"), std::string::npos) << s.warnings[0];
}

TEST(GltfClips, AClipIsChosenByNameOrNumber)
{
    Clips c;
    c.add("idle", {0, 1});
    c.add("2", {0, 2});
    c.add("walk", {1, 3});
    for (const char* chosen : {"walk", "2"}) {
        const scene::Scene s = c.load(chosen);
        const std::size_t expected = std::string(chosen) == "walk" ? 2 : 1;   // a name comes before a number
        for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(s.clips[i].plays, i == expected) << chosen;
        EXPECT_EQ(s.timeline.end, expected == 2 ? 3 : 2);
        EXPECT_TRUE(s.warnings.empty());
    }
    EXPECT_TRUE(c.load("0").clips[0].plays);
    EXPECT_EQ(c.load("walk").timeline.start, 1);
    for (const char* wrong : {"run", "3", "-1", "0x", "1.0", "99999999999999999999"}) {
        try {
            c.load(wrong);
            ADD_FAILURE() << wrong;
        } catch (const UsageError& error) {
            EXPECT_NE(std::string(error.what()).find("0 idle, 1 2, 2 walk"), std::string::npos) << error.what();
        }
    }
}

TEST(GltfClips, AllPlaysAllAndTheFirstWins)
{
    Clips c;
    c.add("idle", {0, 1});
    c.add("walk", {0, 2});
    const scene::Scene s = c.load("all");
    EXPECT_TRUE(s.clips[0].plays && s.clips[1].plays);
    EXPECT_EQ(s.timeline.end, 2);
    EXPECT_EQ(s.nodes[0].transform->evaluate(2)[3].x, 1);
    EXPECT_EQ(s.warnings.size(), 1u);
}

TEST(GltfClips, WithoutAnimationsThereIsOneFrame)
{
    const Document d;
    const scene::Scene s = d.load(R"("nodes":[{}])", "", {.animation = "all"});
    EXPECT_TRUE(s.clips.empty());
    EXPECT_EQ(s.timeline.frames, 1);
    EXPECT_EQ(s.timeline.start, 0);
}

// A triangle on each of two nodes; pointers animate the place of the first and the visibility of the second.
TEST(GltfPointers, MoveAndHideNodes)
{
    Document d;
    const int p = d.positions({0, 0, 0, 1, 0, 0, 0, 1, 0}), t = d.times({0, 1, 2});
    const int places = d.floats({0, 0, 0, 4, 0, 0, 8, 0, 0}, "VEC3", 3);
    const int shown = d.accessor<std::uint8_t>({0, 1, 0}, "SCALAR", 5121, 1);
    const auto channel = [](int sampler, const char* pointer) {
        return fmt::format(R"({{"sampler":{},"target":{{"path":"pointer","extensions":{{"KHR_animation_pointer":)"
                           R"({{"pointer":"{}"}}}}}}}})",
                           sampler, pointer);
    };
    const auto load = [&](const std::string& more) {
        return d.load(
            fmt::format(R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{}}}}}]}}],)"
                        R"("nodes":[{{"mesh":0}},{{"mesh":0}},{{"mesh":0,"extensions":{{"KHR_node_visibility":)"
                        R"({{"visible":false}}}}}}],"animations":[{{"channels":[{},{}{}],"samplers":[{{"input":{},)"
                        R"("output":{}}},{{"input":{},"output":{},"interpolation":"STEP"}}]}}])",
                        p, channel(0, "/nodes/0/translation"),
                        channel(1, "/nodes/1/extensions/KHR_node_visibility/visible"), more, t, places, t, shown),
            R"("extensionsUsed":["KHR_animation_pointer","KHR_node_visibility"],)");
    };
    const auto scene = std::make_shared<const scene::Scene>(load(""));
    EXPECT_TRUE(scene->warnings.empty()) << scene->warnings.front();
    ASSERT_EQ(scene->objects.size(), 3u);
    EXPECT_EQ(scene->timeline.end, 2);
    scene::SceneState state(scene, 0);
    EXPECT_FALSE(state.object_visible(1));
    EXPECT_FALSE(state.object_visible(2));   // by the file
    state.advance(.5);
    EXPECT_NEAR(state.world(scene->objects[0].node)[3].x, 2, 1e-6);
    state.advance(1.5);
    EXPECT_TRUE(state.object_visible(1));
    EXPECT_FALSE(state.object_visible(2));
    EXPECT_EQ(state.changes().appeared.size(), 1u);
    state.advance(2);
    EXPECT_FALSE(state.object_visible(1));

    // What is not supported, or does not exist, is named.
    const scene::Scene others =
        load("," + channel(0, "/materials/0/emissiveFactor") + "," + channel(0, "/nodes/99/translation"));
    ASSERT_EQ(others.warnings.size(), 2u);
    EXPECT_NE(others.warnings[0].find("/materials/0/emissiveFactor"), std::string::npos) << others.warnings[0];
    EXPECT_NE(others.warnings[1].find("/nodes/99/translation"), std::string::npos) << others.warnings[1];
}

}   // namespace
}   // namespace gnomon
