// SPDX-License-Identifier: Apache-2.0
// The work of an update follows what a host moves, not what is there, and memory stays as it is.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <deque>
#include <fstream>

#include "gnomon/renderer.h"
#include "gnomon/scene_builder.h"
#include "sanitized.h"

namespace gnomon {
namespace {

MeshId add_box(SceneBuilder& builder, float size)
{
    std::vector<Vec3> corners;
    for (int c = 0; c < 8; ++c) corners.push_back({c & 1 ? size : 0, c & 2 ? size : 0, c & 4 ? size : 0});
    const std::vector<std::uint32_t> indices{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                             2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    Mesh mesh;
    mesh.positions = corners;
    mesh.indices = indices;
    return builder.mesh(mesh);
}

// A floor, a light and a camera for boxes on a square grid of unit cells.
void add_surroundings(SceneBuilder& builder, int across)
{
    builder.instance(add_box(builder, static_cast<float>(across)), {}, Transform::translation(0, -across, 0));
    builder.light({}, Transform::translation(0.5 * across, 0.5 * across + 2, 0.5 * across));
    Camera camera;
    camera.transform = Transform::translation(0.5 * across, 0.3 * across + 1, 1.5 * across);
    builder.camera(camera);
}

RenderOptions tiny(Indirect indirect)
{
    RenderOptions options;
    options.size = {8, 8};
    options.threads = 1;
    options.indirect = indirect;
    return options;
}

// Moves ten boxes in each frame and checks the counters.
void expect_work_of_ten(int count, Mobility mobility_of_others)
{
    constexpr int k_moved = 10, k_frames = 6;
    const int across = static_cast<int>(std::ceil(std::sqrt(count)));
    SceneBuilder builder;
    add_surroundings(builder, across);
    const MeshId mesh = add_box(builder, 0.5f);
    std::vector<NodeId> boxes;
    for (int i = 0; i < count; ++i)
        boxes.push_back(
            builder.instance(mesh, {}, Transform::translation(i % across, 0, i / across),
                             {.mobility = i % (count / k_moved) == 0 ? Mobility::may_move : mobility_of_others}));
    const Scene scene = builder.finish();
    Renderer renderer(tiny(Indirect::off));
    for (int frame = 0; frame < k_frames; ++frame) {
        FrameInput input;
        // Where all may move, other boxes do in each frame.
        const int shift = mobility_of_others == Mobility::may_move ? frame : 0;
        for (int k = 0; k < k_moved; ++k) {
            const int i = k * (count / k_moved) + shift;
            input.transforms.push_back({boxes[static_cast<std::size_t>(i)],
                                        Transform::translation(i % across, 0.1 * (frame + 1), i / across)});
        }
        const Frame image = renderer.render(scene, input);
        EXPECT_EQ(image.counters.update.began_anew, frame == 0);
        if (frame == 0) continue;
        EXPECT_EQ(image.counters.update.nodes, k_moved) << count << " boxes, frame " << frame;
        EXPECT_EQ(image.counters.update.instances, k_moved) << count << " boxes, frame " << frame;
        EXPECT_EQ(renderer.report().instances.size(), k_moved);
    }
}

TEST(UpdateCost, CountersFollowWhatMovesAmongFixedObjects)
{
    for (const int count : {100, 10000}) expect_work_of_ten(count, Mobility::fixed);
}

TEST(UpdateCost, CountersFollowWhatMovesAmongObjectsThatMayMove)
{
    for (const int count : {100, 10000}) expect_work_of_ten(count, Mobility::may_move);
}

// Adds and removes a box that may move, and checks the counters.
TEST(UpdateCost, CountersFollowWhatIsAddedAndRemoved)
{
    for (const int count : {100, 10000}) {
        const int across = static_cast<int>(std::ceil(std::sqrt(count)));
        SceneBuilder builder;
        add_surroundings(builder, across);
        const MeshId mesh = add_box(builder, 0.5f);
        for (int i = 0; i < count; ++i)
            builder.instance(mesh, {}, Transform::translation(i % across, 0, i / across),
                             {.mobility = i % 2 ? Mobility::may_move : Mobility::fixed});
        Renderer renderer(tiny(Indirect::visible));
        renderer.render(builder.finish(), FrameInput{});
        const InstanceId box = builder.instance(mesh, {}, Transform::translation(1, 2, 1),
                                                {.mobility = Mobility::may_move, .name = "guest"});
        const Frame with = renderer.render(builder.finish(), FrameInput{});
        EXPECT_FALSE(with.counters.update.began_anew);
        EXPECT_EQ(with.counters.update.nodes, 1u) << count;
        EXPECT_EQ(with.counters.update.instances, 1u) << count;
        ASSERT_EQ(renderer.report().instances.size(), 1u);
        EXPECT_EQ(renderer.report().instances.front(), box);
        builder.remove(NodeId(box));
        const Frame without = renderer.render(builder.finish(), FrameInput{});
        EXPECT_FALSE(without.counters.update.began_anew);
        EXPECT_EQ(without.counters.update.nodes, 1u) << count;
        EXPECT_EQ(without.counters.update.instances, 0u) << count;
        EXPECT_TRUE(renderer.report().instances.empty());
    }
}

double resident_megabytes()
{
    std::ifstream file("/proc/self/statm");
    double total = 0, resident = 0;
    file >> total >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

TEST(UpdateCost, MemoryStaysWhileObjectsComeAndGo)
{
    if (test::k_sanitized) GTEST_SKIP() << "a sanitizer keeps what was freed";
    constexpr int k_boxes = 64, k_across = 8, k_frames = 240, k_warm = 120;
    SceneBuilder builder;
    add_surroundings(builder, k_across);
    std::deque<std::pair<NodeId, MeshId>> boxes;
    const auto add = [&](int i) {
        const MeshId mesh = add_box(builder, 0.5f);
        const int cell = i % k_boxes;
        boxes.emplace_back(builder.instance(mesh, {}, Transform::translation(cell % k_across, 0, cell / k_across),
                                            {.mobility = i % 2 ? Mobility::may_move : Mobility::fixed}),
                           mesh);
    };
    for (int i = 0; i < k_boxes; ++i) add(i);
    Renderer renderer(tiny(Indirect::visible));
    double early = 0;
    for (int frame = 0; frame < k_frames; ++frame) {
        builder.remove(boxes.front().first);
        builder.remove(boxes.front().second);
        boxes.pop_front();
        add(k_boxes + frame);
        FrameInput input;
        input.transforms.push_back({boxes.back().first, Transform::translation(0.01 * frame, 0.5, 0)});
        renderer.render(builder.finish(), input);
        if (frame == k_warm) early = resident_megabytes();
    }
    EXPECT_LT(resident_megabytes(), early + 4);   // 119 frames that leaked 40 kB each would exceed it
}

}   // namespace
}   // namespace gnomon
