// SPDX-License-Identifier: Apache-2.0
// What the viewer's window asks for and gets.
// LONG: one way to ask a session and to wait for it, which all these tests share.
#ifdef GNOMON_VIEWER
#include "viewer/session.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "support.h"
#include "two_clips.h"
#include "viewer/settings.h"

namespace gnomon::viewer {
namespace {

constexpr std::uint64_t k_few_rays = 500;   // bounced light takes many frames
constexpr auto k_patience = std::chrono::seconds(60);

bool comes(const std::function<bool()>& what)
{
    const auto start = std::chrono::steady_clock::now();
    while (!what()) {
        if (std::chrono::steady_clock::now() - start > k_patience) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}

void load(ViewSession& session, double fps = 0, const std::string& what = "builtin:cornell")
{
    SceneRecipe recipe;
    recipe.what = what;
    recipe.fps = fps;
    session.load(recipe);
    ASSERT_TRUE(comes([&] { return !session.load_state().loading; }));
    ASSERT_EQ(session.load_state().error, "");
}

// The last image of a request, once it gets no better.
std::shared_ptr<const ViewImage> finished(ViewSession& session, const ViewRequest& request)
{
    const auto before = session.image(0);
    session.ask(request);
    EXPECT_TRUE(comes([&] { return !session.busy() && !session.refining(); })) << "rendered again and again";
    EXPECT_EQ(session.load_state().error, "");
    return session.image(before ? before->number : 0);
}

ViewRequest at(double time)
{
    ViewRequest request;
    request.size = {48, 36};
    request.time = time;
    return request;
}

// A user override that raises a node a little above where it is when the clip begins.
UserOverride raised(const Scene& scene, const std::string& name)
{
    const NodeId node = scene.find_node(name);
    EXPECT_TRUE(node) << "no node " << name;
    return {node, scene.transform(node), glm::vec3(0, 0.3f, 0)};
}

bool same(const std::shared_ptr<const ViewImage>& a, const std::shared_ptr<const ViewImage>& b)
{
    return a && b && a->image.data == b->image.data;
}

TEST(ViewSession, UserOverrideOfAMissingNodeFailsItsFrameOnly)
{
    ViewSession session(1);
    load(session);
    const auto plain = finished(session, at(0));
    ViewRequest request = at(0);
    request.scene = session.scene();
    request.overrides = {raised(gnomon::load("builtin:cornell"), "ball")};   // the ids of another scene
    const std::uint64_t bad = session.ask(request);
    ASSERT_TRUE(comes([&] { return !session.busy(); }));
    EXPECT_EQ(session.load_state().failed, bad);
    EXPECT_NE(session.load_state().frame_error, "");
    request.overrides = {raised(*session.scene(), "ball")};
    EXPECT_FALSE(same(finished(session, request), plain));
    EXPECT_EQ(session.load_state().frame_error, "");
    EXPECT_TRUE(same(finished(session, at(0)), plain)) << "an override is released when it ends";
}

// The picked object is held where the image shows it, and stays there while the clip goes on.
TEST(ViewSession, UserOverrideHoldsThePickedObject)
{
    ViewSession session(1);
    load(session);
    ViewRequest request = at(0.4);
    request.scene = session.scene();
    std::optional<Picked> ball;
    for (int step = 1; step < 32 && !ball; ++step)
        for (int row = 1; row < 24 && !ball; ++row) {
            request.pick = glm::vec2(static_cast<float>(step) / 32, static_cast<float>(row) / 24);
            const auto image = finished(session, request);
            ASSERT_TRUE(image && image->picked);
            if (image->picked->name == "ball") ball = image->picked;
        }
    ASSERT_TRUE(ball) << "the ball is in the image";
    EXPECT_EQ(ball->mobility, "moves");
    request.pick.reset();
    const auto before = finished(session, request);
    ASSERT_TRUE(before && before->picked) << "later images still say what was picked";
    EXPECT_EQ(before->picked->instance, ball->instance);
    EXPECT_EQ(before->picked->transform, ball->transform);
    ASSERT_FALSE(before->outline.empty()) << "what is picked is outlined";
    glm::ivec2 low(100), high(0);
    for (const OutlineEdge& edge : before->outline) low = glm::min(low, edge.from), high = glm::max(high, edge.to);
    EXPECT_GE(high.x - low.x, 3);
    EXPECT_LT(high.x - low.x, 24) << "around the ball alone";
    EXPECT_EQ(before->frame.layer("id"), nullptr);

    // Only the ball moves in this clip.
    request.overrides = {{ball->node, ball->transform, glm::vec3(0)}};
    request.time = 1.1;
    const auto held = finished(session, request);
    EXPECT_TRUE(same(held, before));
    request.overrides.clear();
    const auto moved = finished(session, request);
    EXPECT_FALSE(same(moved, before));
    EXPECT_NE(moved->picked->transform, ball->transform) << "it follows the image";
}

// The values of the layer "id" in one channel, and edges by what they separate.
TEST(Outline, IsTheBorderOfAnObject)
{
    //  . 7 7 .
    //  . 7 5 7
    const std::vector<std::uint32_t> values{0, 7, 7, 0, 0, 7, 5, 7};
    Layer ids;
    ids.channels = {"object"}, ids.format = PixelFormat::u32, ids.size = {4, 2};
    ids.data = values.data(), ids.pixel_stride = sizeof(values[0]), ids.row_stride = 4 * sizeof(values[0]);
    const std::vector<OutlineEdge> expected{{{1, 0}, {3, 0}}, {{2, 1}, {4, 1}}, {{1, 2}, {2, 2}}, {{3, 2}, {4, 2}},
                                            {{1, 0}, {1, 2}}, {{2, 1}, {2, 2}}, {{3, 0}, {3, 2}}, {{4, 1}, {4, 2}}};
    EXPECT_EQ(outline_of(ids, 7), expected);
    EXPECT_EQ(outline_of(ids, 5).size(), 4u);
    EXPECT_TRUE(outline_of(ids, 3).empty());
    EXPECT_TRUE(outline_of(ids, 0).empty());
}

// Another clip is another scene, and its frames are those of the file with this clip.
TEST(ViewSession, AClipIsChosenByName)
{
    const test::ScratchFolder folder;
    const std::string file = folder / "two.gltf";
    test::write_two_clips(file);
    ViewSession session(1);
    SceneRecipe recipe;
    recipe.what = file;
    std::vector<std::shared_ptr<const ViewImage>> images;
    for (const char* clip : {"", "jump", "0", "jump"}) {
        const std::uint64_t loads = session.load_state().loads;
        recipe.animation = clip;
        session.load(recipe);
        ASSERT_TRUE(comes([&] { return !session.load_state().loading; }));
        ASSERT_EQ(session.load_state().error, "");
        EXPECT_EQ(session.load_state().loads, loads + 1);
        const bool jumps = std::string_view(clip) == "jump";
        EXPECT_EQ(session.scene()->frame_count(), jumps ? 49 : 25) << clip;
        EXPECT_EQ(session.scene()->info().animations.at(1).plays, jumps) << clip;
        images.push_back(finished(session, at(1)));
    }
    EXPECT_FALSE(same(images[0], images[1]));
    EXPECT_TRUE(same(images[0], images[2]));
    EXPECT_TRUE(same(images[1], images[3]));
    // A name that the file lacks is an error that names those it has.
    recipe.animation = "run";
    session.load(recipe);
    ASSERT_TRUE(comes([&] { return !session.load_state().loading; }));
    EXPECT_NE(session.load_state().error.find("walk"), std::string::npos) << session.load_state().error;
}

// Hidden by its parent's scale of 0 when it was taken.
TEST(ViewSession, UserOverrideOfASingularTransformHoldsTheObject)
{
    const test::ScratchFolder folder;
    std::ofstream(folder / "grows.gltf")
        << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 2]}],
        "nodes": [{"children": [1]}, {"mesh": 0, "name": "triangle"}, {"camera": 0, "translation": [0, 0, 4]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "scale"}}],
                        "samplers": [{"input": 1, "output": 2}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
            {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
                        {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
        "buffers": [{"byteLength": 68, "uri": "data:application/octet-stream;base64,)"
           "AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AACAPwAAgD8="
           R"("}]})";
    ViewSession session(1), late(1);
    for (ViewSession* s : {&session, &late}) load(*s, 0, folder / "grows.gltf");
    const auto with_hand = [&](ViewSession& s, double time) {
        ViewRequest request = at(time);
        request.scene = s.scene();
        request.overrides = {raised(*s.scene(), "triangle")};
        return finished(s, request);
    };
    ASSERT_TRUE(with_hand(session, 0));
    const auto grown = with_hand(session, 1);
    EXPECT_TRUE(same(grown, with_hand(late, 1)));
    EXPECT_FALSE(same(grown, finished(late, at(0))));
}

// A request that was made for the scene before comes after the next one was loaded.
TEST(ViewSession, IgnoresRequestsMadeForAnotherScene)
{
    ViewSession session(1);
    load(session);
    ViewRequest request = at(0);
    request.scene = session.scene();
    request.overrides = {raised(*session.scene(), "ball")};
    request.pick = {0.5f, 0.5f};
    const auto before = finished(session, request);
    ASSERT_TRUE(before && before->picked);
    EXPECT_EQ(before->scene, request.scene);
    request.orbit = before->camera;
    request.orbit->transform.m[12] += 0.2;
    load(session, 12);
    const auto after = finished(session, request);
    ASSERT_TRUE(after);
    EXPECT_EQ(after->scene, session.scene());
    EXPECT_FALSE(after->picked);
    EXPECT_TRUE(same(after, finished(session, at(0))));
}

TEST(ViewSession, IndirectLightFollowsMotionUnderTheOverlay)
{
    ViewSession session(1), fresh(1);
    load(session), load(fresh);
    finished(session, at(0));
    ViewRequest overlay = at(0.8);
    overlay.options.overlay = Overlay::shadow_states;
    finished(session, overlay);
    EXPECT_TRUE(same(finished(session, at(0.8)), finished(fresh, at(0.8))));
}

TEST(ViewSession, OverlayDoesNotWaitForIndirectLight)
{
    ViewSession session(1, k_few_rays);
    load(session);
    session.ask(at(0));
    ASSERT_TRUE(comes([&] { return session.image(0) != nullptr; }));
    ViewRequest overlay = at(0);
    overlay.options.overlay = Overlay::shadow_states;
    const auto shown = finished(session, overlay);
    ASSERT_TRUE(shown);
    EXPECT_TRUE(shown->frame.complete);
    EXPECT_TRUE(finished(session, at(0))->frame.complete);
}

TEST(ViewSession, OverlaysReportTheirViewRectangle)
{
    ViewSession session(1);
    load(session);
    const auto plain = finished(session, at(0));
    ASSERT_TRUE(plain);
    EXPECT_EQ(glm::ivec2(plain->frame.view_left, plain->frame.view_top), glm::ivec2(0));
    ViewRequest overlay = at(0);
    overlay.options.overlay = Overlay::shadow_states;
    const auto shown = finished(session, overlay);
    ASSERT_TRUE(shown);
    const auto tone = [&](int x, int y) { return *shown->image.pixel(x, y); };
    const Size size = shown->frame.view_size;
    EXPECT_EQ(size, overlay.size);
    const glm::ivec2 first(shown->frame.view_left, shown->frame.view_top),
        end = first + glm::ivec2(size.width, size.height);
    ASSERT_TRUE(first.x > 0 && first.y > 0 && end.x < shown->image.width && end.y < shown->image.height);
    const auto paper = tone(0, 0);
    const int x = (first.x + end.x) / 2, y = (first.y + end.y) / 2;
    EXPECT_EQ(tone(first.x - 1, y), paper);
    EXPECT_NE(tone(first.x, y), paper);
    EXPECT_NE(tone(end.x - 1, y), paper);
    EXPECT_EQ(tone(end.x, y), paper);
    EXPECT_NE(tone(x, first.y), paper);
    EXPECT_NE(tone(x, end.y - 1), paper);
}

TEST(ViewSession, NewRequestInterruptsRefinement)
{
    ViewSession session(1, k_few_rays);
    load(session);
    ViewRequest first = at(0);
    first.scene = session.scene();
    first.pick = {0.5f, 0.5f};
    first.size = {160, 120};   // hundreds of images
    session.ask(first);
    ASSERT_TRUE(comes([&] { return session.refining(); }));
    EXPECT_FALSE(session.busy());
    ViewRequest second = at(0.8);
    second.whole = true;
    const std::uint64_t wanted = session.ask(second);
    const std::uint64_t shown = session.image(0)->number;   // no image of the first request follows this one
    std::shared_ptr<const ViewImage> next;
    ASSERT_TRUE(comes([&] {
        next = session.image(shown - 1);
        return next->request == wanted;
    }));
    EXPECT_LE(next->number, shown + 1) << "the refined one under way is interrupted";
    EXPECT_TRUE(next->picked) << "the answer came with an image that nobody may have taken";
}

// Where bounced light is not prepared yet, an image without it comes first. Once it is, no image lacks it.
TEST(ViewSession, TheFirstImagesDoNotWaitForBouncedLight)
{
    ViewSession session(1);
    load(session);
    ViewRequest request = at(0);
    request.early = true;
    const std::uint64_t number = session.ask(request);
    std::shared_ptr<const ViewImage> first;
    ASSERT_TRUE(comes([&] { return (first = session.image(0)) != nullptr; }));
    EXPECT_TRUE(first->early);
    EXPECT_FALSE(first->frame.complete);
    EXPECT_EQ(first->frame.counters.indirect.rays, 0u);
    ASSERT_TRUE(comes([&] { return !session.busy() && !session.refining(); }));
    const auto last = session.image(0);
    EXPECT_EQ(last->request, number);
    EXPECT_FALSE(last->early);
    EXPECT_TRUE(last->frame.complete);
    EXPECT_GT(last->frame.counters.indirect.rays, 0u);
    EXPECT_EQ(session.load_state().preparing, "");
    ViewSession fresh(1);
    load(fresh);
    EXPECT_TRUE(same(last, finished(fresh, at(0)))) << "what came early leaves nothing behind";

    // It is prepared now, until another number of bounces is asked for.
    const std::uint64_t shown = last->number;
    request.time = 0.8;
    session.ask(request);
    std::shared_ptr<const ViewImage> next;
    ASSERT_TRUE(comes([&] { return (next = session.image(shown)) != nullptr; }));
    EXPECT_FALSE(next->early);
    ASSERT_TRUE(comes([&] { return !session.busy() && !session.refining(); }));
    request.options.bounces = 1;
    const std::uint64_t before = session.image(0)->number;
    session.ask(request);
    ASSERT_TRUE(comes([&] { return (next = session.image(before)) != nullptr; }));
    EXPECT_EQ(next->number, before + 1);
    EXPECT_TRUE(next->early);
}

// A newer request need not wait until bounced light is prepared.
TEST(ViewSession, NewRequestInterruptsThePreparationOfBouncedLight)
{
    ViewSession session(1);
    load(session, 0, "builtin:kinetic");
    ViewRequest request = at(0);
    request.early = true;
    session.ask(request);
    ASSERT_TRUE(comes([&] { return !session.load_state().preparing.empty(); }));
    EXPECT_FALSE(session.busy()) << "there is an image";
    const std::uint64_t shown = session.image(0)->number;
    request.time = 0.1;
    const std::uint64_t wanted = session.ask(request);
    std::shared_ptr<const ViewImage> next;
    ASSERT_TRUE(comes([&] { return (next = session.image(shown)) != nullptr; }));
    EXPECT_EQ(next->request, wanted);
    EXPECT_TRUE(next->early);
}

// The first image of a request in motion has little bounced light, and the one that it ends with has all. The session
// says when there is something new.
TEST(ViewSession, ImagesInMotionCastFewRays)
{
    std::atomic<int> news = 0;
    ViewSession session(1, ViewSession::k_rays_a_frame, [&] { ++news; }), fresh(1);
    load(session), load(fresh);
    EXPECT_GT(news, 0) << "the scene";
    news = 0;
    ViewRequest moving = at(0.8);
    moving.rays = 100;
    session.ask(moving);
    ASSERT_TRUE(comes([&] { return news > 0; }));
    const auto first = session.image(0);
    ASSERT_TRUE(first);
    ASSERT_TRUE(comes([&] { return !session.busy() && !session.refining(); }));
    const auto last = session.image(0), whole = finished(fresh, at(0.8));
    EXPECT_LT(first->number, last->number);
    EXPECT_LT(first->frame.counters.indirect.rays, whole->frame.counters.indirect.rays / 4);
    EXPECT_TRUE(same(last, whole));
}

// A coarse image, which another one will replace, has few reflections in a row; an image in motion of all pixels has
// all.
TEST(ViewSession, OnlyCoarseImagesLackReflections)
{
    ViewSession session(1), fresh(1);
    load(session, 0, "builtin:kinetic"), load(fresh, 0, "builtin:kinetic");
    ViewRequest whole = at(0.05);
    whole.options.indirect = Indirect::off;
    ViewRequest moving = whole;
    moving.rays = 100;
    ViewRequest coarse = moving;
    coarse.coarse = true;
    const auto expected = finished(fresh, whole);
    EXPECT_FALSE(same(finished(session, coarse), expected)) << "the scene has no long chains of reflections";
    EXPECT_TRUE(same(finished(session, moving), expected));
    EXPECT_FALSE(same(finished(session, coarse), expected));
    EXPECT_TRUE(same(finished(session, whole), expected));
}

// Enlarged images have the frame's size times the factor, on average its colours, and leave no trace in later images.
TEST(ViewSession, ImagesAreEnlargedForTheScreen)
{
    ViewSession session(1), fresh(1);
    load(session), load(fresh);
    ViewRequest small = at(0.8);
    small.enlarge = 3;
    const auto large = finished(session, small), plain = finished(session, at(0.8));
    EXPECT_EQ(large->frame.size, plain->frame.size);
    EXPECT_TRUE(large->frame.layers.empty());
    EXPECT_EQ(large->image.width, 3 * plain->image.width);
    EXPECT_EQ(large->image.height, 3 * plain->image.height);
    EXPECT_TRUE(same(plain, finished(fresh, at(0.8))));
    const auto mean = [](const Image8& image) {
        double sum = 0;
        for (const std::uint8_t value : image.data) sum += value;
        return sum / static_cast<double>(image.data.size());
    };
    EXPECT_NEAR(mean(large->image), mean(plain->image), 2);
}

// A frame of seconds ends within a fraction of one when a newer request comes, and what it remembered stays true.
TEST(ViewSession, NewRequestInterruptsTheFrameInProgress)
{
    using Clock = std::chrono::steady_clock;
    const auto seconds_since = [](Clock::time_point start) {
        return std::chrono::duration<double>(Clock::now() - start).count();
    };
    const auto slow = [](double time) {
        ViewRequest request = at(time);
        request.size = {320, 240};
        request.options.samples = 64;
        return request;
    };
    // A refining frame, and a first image that only sharpens what is shown.
    double whole = 0;   // seconds of such a frame
    for (const bool refines : {true, false}) {
        ViewSession session(1, refines ? k_few_rays : ViewSession::k_rays_a_frame), fresh(1);
        load(session), load(fresh);
        ViewRequest first = slow(0.8);
        first.interruptible = !refines;
        if (!refines) finished(session, at(0));
        const Clock::time_point start = Clock::now();
        session.ask(first);
        if (refines) {
            ASSERT_TRUE(comes([&] { return session.refining(); }));
            whole = seconds_since(start);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(50));   // the frame is in progress
        EXPECT_EQ(session.interruptible(), !refines);
        const std::uint64_t shown = session.image(0)->number;
        const Clock::time_point asked = Clock::now();
        const std::uint64_t wanted = session.ask(at(0.2));
        ASSERT_TRUE(comes([&] {
            const auto image = session.image(0);
            EXPECT_TRUE(image->number == shown || image->request == wanted) << "of the first request";
            return image->request == wanted;
        }));
        const double reaction = seconds_since(asked);
        EXPECT_LT(reaction, 0.5 * whole);
        ASSERT_TRUE(comes([&] { return !session.busy() && !session.refining(); }));
        EXPECT_TRUE(same(session.image(0), finished(fresh, at(0.2))));
        EXPECT_EQ(session.load_state().frame_error, "");
    }
}

// A frame that nobody has seen yet is finished: it is what the window shows next.
TEST(ViewSession, NewRequestWaitsForTheFirstImage)
{
    ViewSession session(1);
    load(session);
    ViewRequest first = at(0);
    first.size = {160, 120};
    first.interruptible = true;
    first.whole = true;   // it is to be saved, which counts for more
    const std::uint64_t saved = session.ask(first);
    ASSERT_TRUE(comes([&] { return session.busy(); }));
    EXPECT_FALSE(session.interruptible());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    session.ask(at(0.2));
    std::shared_ptr<const ViewImage> image;
    ASSERT_TRUE(comes([&] { return (image = session.image(0)) != nullptr; }));
    EXPECT_EQ(image->request, saved);
    EXPECT_FALSE(image->frame.layers.empty()) << "it can be saved";
}

// What changes more than view and time does not wait for an image in motion; that image waits for nothing else.
TEST(ViewSession, UrgentRequestInterruptsAnImageInMotion)
{
    ViewSession session(1), fresh(1);
    load(session), load(fresh);
    finished(session, at(0));
    ViewRequest slow = at(0.8);
    slow.size = {320, 240};
    slow.options.samples = 64;
    ViewRequest urgent = at(0.2);
    urgent.urgent = true;
    for (const bool both : {false, true}) {
        slow.urgent = both;
        const std::uint64_t first = session.ask(slow);
        std::this_thread::sleep_for(std::chrono::milliseconds(50));   // the frame is in progress
        const std::uint64_t wanted = session.ask(urgent);
        bool seen = false;
        ASSERT_TRUE(comes([&] {
            seen = seen || session.image(0)->request == first;
            return session.image(0)->request == wanted;
        }));
        EXPECT_EQ(seen, both) << "a second urgent one waits, so that images come however many follow one another";
        ASSERT_TRUE(comes([&] { return !session.busy() && !session.refining(); }));
        EXPECT_TRUE(same(session.image(0), finished(fresh, at(0.2))));
    }

    // A change that waits stays urgent if another request takes its place.
    slow.urgent = false;
    const std::uint64_t first = session.ask(slow);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    session.ask(urgent);
    const std::uint64_t second = session.ask(slow);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));   // the second one is in progress
    const std::uint64_t last = session.ask(urgent);
    bool seen = false;
    ASSERT_TRUE(comes([&] {
        EXPECT_NE(session.image(0)->request, first);
        seen = seen || session.image(0)->request == second;
        return session.image(0)->request == last;
    }));
    EXPECT_TRUE(seen);
}

// The sharper images of a view that has come to rest have the depths of the image in motion before.
TEST(ViewSession, ImagesAtRestHaveTheDepthsOfThoseInMotion)
{
    ViewSession session(1);
    load(session);
    EXPECT_TRUE(finished(session, at(0.8))->nearness.empty());
    ViewRequest small = at(0.8);
    small.enlarge = 3;
    ASSERT_FALSE(finished(session, small)->nearness.empty());
    for (const Size size : {Size{144, 108}, Size{200, 150}, Size{96, 72}}) {
        ViewRequest rest = at(0.8);
        rest.size = size;
        const auto image = finished(session, rest);
        RenderOptions options;
        options.size = size;
        options.layers = true;
        options.indirect = Indirect::off;
        Renderer renderer;
        renderer.set_options(options);
        FrameInput input;
        input.time = 0.8;
        input.camera = image->camera;
        const Frame frame = renderer.render(*session.scene(), input);
        const Layer* const depth = frame.layer("depth");
        ASSERT_TRUE(depth);
        ASSERT_EQ(image->nearness.size(), static_cast<std::size_t>(size.width * size.height));
        int near = 0;
        for (int y = 0; y < size.height; ++y)
            for (int x = 0; x < size.width; ++x) {
                const float d = depth->value(x, y),
                            known = image->nearness[static_cast<std::size_t>(y * size.width + x)];
                near += std::abs(known - (d > 0 ? 1 / d : 0)) < 0.03f * known + 1e-6f;
            }
        EXPECT_GT(near, 0.95 * size.width * size.height) << size.width;
    }
    EXPECT_TRUE(finished(session, at(0.2))->nearness.empty()) << "of another time";
    finished(session, small);
    ViewRequest moved = at(0.8);
    moved.scene = session.scene();
    moved.overrides.push_back(raised(*session.scene(), "ball"));
    EXPECT_TRUE(finished(session, moved)->nearness.empty()) << "with an object elsewhere";
    finished(session, small);
    ViewRequest other = at(0.8);
    other.scene = session.scene();
    other.camera = "";
    other.orbit = session.image(0)->camera;
    other.orbit->transform.m[12] += 0.1;
    EXPECT_TRUE(finished(session, other)->nearness.empty()) << "of another camera";
}

TEST(ViewSettings, ImagesInMotionHaveNoBlur)
{
    ViewSettings settings(options::OptionValues(options::Subcommand::view));
    const auto set = [&](const char* name, const char* value) {
        EXPECT_EQ(settings.set(*options::find_option(options::Subcommand::view, name), value), "");
    };
    EXPECT_FALSE(blurs(settings.render_options()));
    EXPECT_EQ(settings.render_options().samples, 1);
    set("aperture", "2.8"), set("focus", "3"), set("shutter", "180");
    EXPECT_FALSE(blurs(settings.motion_options()));
    EXPECT_EQ(settings.motion_options().samples, 1);
    EXPECT_EQ(settings.motion_options().focus, std::nullopt) << "which is refused without a lens";
    EXPECT_EQ(settings.render_options().shutter, 180);
    EXPECT_EQ(settings.render_options().samples, k_adaptive_samples);
    set("samples", "16");
    EXPECT_EQ(settings.render_options().samples, 16);
    EXPECT_EQ(settings.motion_options().samples, 16);
    set("overlay", "clusters"), set("indirect", "quadtree");
    EXPECT_FALSE(blurs(settings.render_options())) << "overlays show one sample";
}

// A request of a frame of the clip that gets motion blur and depth of field at rest.
ViewRequest blurred_at_rest(const ViewSession& session, double time, RenderMethod renderer)
{
    ViewRequest request = at(time);
    request.scene = session.scene();
    request.options.renderer = renderer;
    request.at_rest = request.options;
    request.at_rest->samples = k_adaptive_samples;
    request.at_rest->shutter = 360;
    request.at_rest->f_number = 1.4;
    return request;
}

// The sharp image comes first, without samples for the blur, and the last one is that of a renderer that has made no
// other.
TEST(ViewSession, AnImageAtRestGetsItsBlurLast)
{
    for (const RenderMethod renderer : {RenderMethod::trace, RenderMethod::raster}) {
        ViewSession session(2), sharp_session(2);
        load(session), load(sharp_session);
        constexpr Size k_large{160, 120};   // so that the blur takes a while
        ViewRequest request = blurred_at_rest(session, 0.8, renderer), sharp = at(0.8);
        request.size = sharp.size = k_large;
        sharp.options.renderer = renderer;
        const auto plain = finished(sharp_session, sharp);
        session.ask(request);
        ASSERT_TRUE(comes([&] { return !session.busy(); }));
        ASSERT_TRUE(comes([&] { return !session.load_state().preparing.empty(); }));
        EXPECT_EQ(session.load_state().preparing.rfind("motion blur and depth of field", 0), 0u);
        EXPECT_TRUE(same(session.image(0), plain)) << "complete before it is blurred";
        ASSERT_TRUE(comes([&] { return !session.refining(); }));
        EXPECT_EQ(session.load_state().preparing, "");
        RenderOptions options = *request.at_rest;
        options.size = request.size;
        FrameInput input;
        input.time = 0.8;
        const Frame expected = Renderer(options).render(*session.scene(), input);
        EXPECT_EQ(session.image(0)->image.data, expected.to_srgb8());
        EXPECT_NE(session.image(0)->image.data, plain->image.data);
    }
}

// Blur ends when a newer request comes, and what is remembered has followed all times of the shutter until then.
TEST(ViewSession, NewRequestInterruptsBlur)
{
    for (const RenderMethod renderer : {RenderMethod::trace, RenderMethod::raster}) {
        ViewSession session(2), fresh(2);
        load(session), load(fresh);
        ViewRequest later = at(0.3);
        later.options.renderer = renderer;
        const auto expected = finished(fresh, later);
        for (int round = 0; round < 3; ++round) {
            ViewRequest request = blurred_at_rest(session, 0.8, renderer);
            request.size = {320, 240};
            const std::uint64_t blurs = session.ask(request);
            ASSERT_TRUE(comes([&] { return !session.load_state().preparing.empty(); }));
            std::this_thread::sleep_for(std::chrono::milliseconds(10 * round));
            const auto image = finished(session, later);
            EXPECT_TRUE(same(image, expected)) << "round " << round;
            EXPECT_GT(image->request, blurs);
            EXPECT_EQ(session.load_state().frame_error, "");
        }
    }
}

TEST(ViewSession, WholeFrameEqualsTheRefinedOne)
{
    ViewSession session(1, k_few_rays), other(1, k_few_rays);
    load(session), load(other);
    ViewRequest request = at(0.8);
    const auto refined = finished(session, request);
    ASSERT_TRUE(refined);
    EXPECT_TRUE(refined->frame.complete);
    EXPECT_GT(refined->number, 2u);
    request.whole = true;
    const auto whole = finished(other, request);
    EXPECT_TRUE(same(whole, refined));
    EXPECT_EQ(whole->number, 1u);
}

TEST(ViewSession, CacheMemoryFollowsTheCurrentRequest)
{
    ViewSession session(1);
    load(session);
    ViewRequest request = at(0);
    request.options.indirect_memory = 64;
    request.size = {160, 120};
    const auto before = finished(session, request);
    request.options.indirect_memory = 1;
    request.size = {48, 36};
    const auto after = finished(session, request);
    ASSERT_TRUE(before && after);
    EXPECT_LT(after->remembered_bytes, before->remembered_bytes);
}

#ifdef GNOMON_VULKAN
TEST(ViewSession, GathersIndirectLightOnTheDeviceIfRequested)
{
    ViewSession session(1);
    load(session);
    ViewRequest request = at(0);
    request.options.renderer = RenderMethod::raster;
    for (const IndirectOn on : {IndirectOn::vulkan, IndirectOn::cpu}) {
        request.options.indirect_on = on;
        const auto image = finished(session, request);
        ASSERT_TRUE(image);
        EXPECT_EQ(image->frame.counters.indirect.gathered_by_vulkan, on == IndirectOn::vulkan);
    }
}
#endif

TEST(ViewSession, FrameErrorIsClearedByTheNextGoodFrame)
{
    ViewSession session(1);
    load(session);
    ViewRequest request = at(0);
    request.options.renderer = RenderMethod::raster;   // which needs a driver
    const test::ScopedVariable none("VK_DRIVER_FILES", "/nowhere.json"),
        none_either("VK_ICD_FILENAMES", "/nowhere.json");
    const std::uint64_t bad = session.ask(request);
    ASSERT_TRUE(comes([&] { return !session.busy(); }));
    EXPECT_NE(session.load_state().frame_error, "");
    EXPECT_EQ(session.load_state().failed, bad);
    EXPECT_EQ(session.load_state().error, "");
    EXPECT_TRUE(finished(session, at(0)));
    EXPECT_EQ(session.load_state().frame_error, "");
    EXPECT_EQ(session.load_state().failed, 0u);
}

TEST(ViewSession, MissingCameraFailsTheFrameOfItsOwnSceneOnly)
{
    ViewSession session(1);
    load(session);
    ViewRequest request = at(0);
    request.scene = session.scene();
    request.camera = "nave";
    session.ask(request);
    ASSERT_TRUE(comes([&] { return !session.busy(); }));
    EXPECT_EQ(session.load_state().frame_error, "no camera 'nave': the scene has 1, numbered from 0");
    load(session, 12);
    EXPECT_TRUE(finished(session, request));
    EXPECT_EQ(session.load_state().frame_error, "");
}

}   // namespace
}   // namespace gnomon::viewer
#endif
