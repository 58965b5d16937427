// SPDX-License-Identifier: Apache-2.0
// What shared places of lobes remember of an environment image: found once for all tiles, and nothing that has changed
// stays.
#include "trace/place_memory.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "gnomon/gnomon.h"
#include "host_scene.h"

namespace gnomon {
namespace {

using trace::PlaceKey;
using trace::PlaceMemory;

TEST(PlaceMemory, GivesEachPlaceToOneThreadAndItsAnswerToAll)
{
    constexpr std::uint64_t k_places = 3000;
    PlaceMemory memory;
    std::atomic<int> own = 0, wrong = 0;
    const auto ask = [&](std::uint64_t first) {
        for (std::uint64_t i = 0; i < k_places; ++i) {
            const std::uint64_t number = (first + i) % k_places;
            bool is_own = false;
            PlaceMemory::Place& place = memory.find({number, number + 1}, is_own);
            if (is_own) {
                ++own;
                const std::uint64_t seen[2] = {number, ~number};
                PlaceMemory::publish(place, seen, {glm::vec3(static_cast<float>(number))});
            }
            if (!PlaceMemory::wait(place) || place.seen()[0] != number || place.seen()[1] != ~number ||
                place.irradiance().x != static_cast<float>(number))
                ++wrong;
        }
    };
    std::vector<std::thread> threads;
    for (std::uint64_t t = 0; t < 4; ++t) threads.emplace_back(ask, t * k_places / 4);
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(own, static_cast<int>(k_places));
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(memory.size(), k_places);
}

// Another key of the same triangle is another place.
TEST(PlaceMemory, AbandonedPlacesAreToldAndForgotten)
{
    PlaceMemory memory;
    bool is_own = false;
    PlaceMemory::Place& place = memory.find({1, 2}, is_own);
    ASSERT_TRUE(is_own);
    memory.find({1, 3}, is_own);
    EXPECT_TRUE(is_own);
    EXPECT_EQ(&memory.find({1, 2}, is_own), &place);
    EXPECT_FALSE(is_own);
    bool published = true;
    std::thread waits([&] { published = PlaceMemory::wait(place); });
    memory.abandon(place);
    waits.join();
    EXPECT_FALSE(published);
    memory.begin_frame();
    EXPECT_EQ(memory.size(), 0u);
}

constexpr float k_bright = 6;

// Boxes of rough metal on a floor, under an image whose bright half is at `turn` of its columns.
Scene boxes(std::size_t turn, NodeId* moved = nullptr)
{
    SceneBuilder builder;
    const MaterialId metal = builder.material({.base_color = {.9f, .8f, .7f}, .metallic = 1, .roughness = .5f});
    const test::Shape square = test::square(4), cube = test::cube(.5f);
    builder.instance(builder.mesh(square.mesh()), builder.material({.base_color = {.6f, .5f, .4f}, .roughness = 1}),
                     Transform::translation(0, 0, -4));
    const MeshId mesh = builder.mesh(cube.mesh());
    for (const double x : {-1.4, 0.0, 1.4}) builder.instance(mesh, metal, Transform::translation(x, .3 * x, -3));
    const NodeId node = builder.node(Transform::translation(.5, 1.3, -3.2));
    builder.attach(node, mesh, metal);
    if (moved) *moved = node;
    std::vector<float> pixels(32 * 16 * 3);
    for (std::size_t y = 0; y < 16; ++y)
        for (std::size_t x = 0; x < 32; ++x)
            for (std::size_t c = 0; c < 3; ++c) pixels[3 * (32 * y + (x + turn) % 32) + c] = x < 16 ? k_bright : .2f;
    builder.environment({.width = 32, .height = 16, .pixels = pixels});
    builder.camera(test::camera_along_z());
    return builder.finish();
}

std::vector<float> colours(const Frame& frame)
{
    const auto values = frame.layers.front().values();
    return {values.begin(), values.end()};
}

RenderOptions small()
{
    RenderOptions options;
    options.size = {96, 96};   // nine tiles
    options.indirect = Indirect::off;
    options.keep_image = false;   // frames of one view are lit again and again
    return options;
}

// Frames of a renderer that is kept equal those of a new one, on one thread or three: while the camera moves, while a
// box moves, and under another image.
TEST(PlaceMemory, FramesAreThoseOfANewRenderer)
{
    NodeId moved;
    const Scene scene = boxes(0, &moved);
    RenderOptions options = small(), one = small();
    one.threads = 1, options.threads = 3;
    Renderer kept(options);
    const auto check = [&](const Scene& now, const FrameInput& input, const char* what) {
        const std::vector<float> image = colours(kept.render(now, input));
        EXPECT_EQ(colours(Renderer(one).render(now, input)), image) << what;
        return image;
    };
    FrameInput input;
    const std::vector<float> first = check(scene, input, "first");
    kept.render(scene, input);   // points by themselves remember from the second frame on
    EXPECT_EQ(kept.render(scene, input).counters.shadow.rays, 0u) << "the same view asks again";
    input.camera = test::camera_along_z();
    input.camera->transform = Transform::translation(.05, 0, 0);
    check(scene, input, "another view");
    input.camera.reset();
    const std::vector<float> turned = check(boxes(12, &moved), input, "another image");
    EXPECT_NE(turned, first);
    const Scene again = boxes(0, &moved);
    for (const double height : {1.2, 1.0, .8}) {
        input.transforms = {{moved, Transform::translation(.5, height, -3.2)}};
        EXPECT_NE(check(again, input, "a box moves"), first);
    }
}

// After a frame that was cancelled somewhere, the next one is whole.
TEST(PlaceMemory, OutlivesACancelledFrame)
{
    const Scene scene = boxes(0);
    const std::vector<float> truth = colours(Renderer(small()).render(scene, 1));
    for (const int last : {1, 3, 6}) {
        Renderer renderer(small());
        int calls = 0;
        try {
            renderer.render(scene, 1, [&](const ProgressStep&) { return ++calls < last; });
        } catch (const InterruptedError&) {
        }
        EXPECT_EQ(colours(renderer.render(scene, 1)), truth) << last;
    }
}

// What tiles have in common is asked once: fewer rays than tiles by themselves need.
TEST(PlaceMemory, AnImageOfManyTilesAsksLittleMoreThanItsParts)
{
    const Scene scene = boxes(0);
    RenderOptions options = small();
    const std::uint64_t whole = Renderer(options).render(scene, 1).counters.shadow.rays;
    options.max_depth = 0;   // no lobe has rays
    const std::uint64_t without = Renderer(options).render(scene, 1).counters.shadow.rays;
    EXPECT_GT(whole, without);
    EXPECT_LT(whole - without, 430'000u);
    std::printf("%llu rays, %llu of them without lobes\n", static_cast<unsigned long long>(whole),
                static_cast<unsigned long long>(without));
}

}   // namespace
}   // namespace gnomon
