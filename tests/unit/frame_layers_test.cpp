// SPDX-License-Identifier: Apache-2.0
// Layers as views of shared memory, what is seen at a pixel, and the report of what a frame changed.
#include <gtest/gtest.h>

#include <limits>
#include <optional>

#include "gnomon/gnomon.h"
#include "support.h"

namespace gnomon {
namespace {

constexpr Size k_size{48, 36};

RenderOptions with_layers()
{
    RenderOptions options;
    options.size = k_size;
    options.layers = options.ids = options.motion = true;
    options.indirect = Indirect::off;
    return options;
}

TEST(FrameLayers, OutliveTheirFrameAndTheRenderer)
{
    const Scene scene = load("builtin:cornell");
    std::optional<Renderer> renderer(with_layers());
    std::optional<Frame> first(renderer->render(scene, 1));
    const std::vector<float> color = first->layers[0].copy(), depth = first->layer("depth")->copy();
    const Frame second = renderer->render(scene, 5);
    EXPECT_NE(second.layers[0].data, first->layers[0].data);
    EXPECT_NE(second.layers[0].copy(), color);
    EXPECT_EQ(first->layers[0].copy(), color);

    const Layer kept = *first->layer("depth");
    first.reset();
    renderer->render(scene, 6);
    EXPECT_EQ(kept.copy(), depth);
    renderer.reset();
    EXPECT_EQ(kept.copy(), depth);
    EXPECT_EQ(second.layer("depth")->copy(), Renderer(with_layers()).render(scene, 5).layer("depth")->copy());
}

TEST(FrameLayers, MemoryOfDroppedFramesIsUsedAgain)
{
    const Scene scene = load("builtin:cornell");
    Renderer renderer(with_layers());
    const void* const data = renderer.render(scene, 1).layers[0].data;
    EXPECT_EQ(renderer.render(scene, 2).layers[0].data, data);
    // A host that keeps the last frame takes turns between two.
    Frame frame = renderer.render(scene, 3);
    frame = renderer.render(scene, 4);
    const void* const other = frame.layers[0].data;
    EXPECT_NE(other, data);
    frame = renderer.render(scene, 5);
    EXPECT_EQ(frame.layers[0].data, data);
    frame = renderer.render(scene, 6);
    EXPECT_EQ(frame.layers[0].data, other);
}

TEST(FrameLayers, AccessIsChecked)
{
    Renderer renderer(with_layers());
    const Frame frame = renderer.render(load("builtin:cornell"), 2);
    const Layer& color = frame.layers[0];
    const Layer& ids = *frame.layer("id");
    EXPECT_EQ(frame.layer("nothing"), nullptr);
    EXPECT_EQ(color.size, k_size);
    EXPECT_EQ(color.values().size(), 48u * 36 * 3);
    EXPECT_EQ(ids.channels, (std::vector<std::string>{"object", "material"}));
    EXPECT_EQ(color.value(47, 35, 2), color.values().back());
    EXPECT_EQ(ids.id(47, 35, 1), ids.ids().back());
    EXPECT_THROW(ids.value(0, 0), UsageError);
    EXPECT_THROW(ids.values(), UsageError);
    EXPECT_THROW(ids.copy(), UsageError);
    EXPECT_THROW(color.id(0, 0), UsageError);
    EXPECT_THROW(color.ids(), UsageError);
    EXPECT_THROW(color.value(48, 0), UsageError);
    EXPECT_THROW(color.value(0, 36), UsageError);
    EXPECT_THROW(color.value(-1, 0), UsageError);
    EXPECT_THROW(color.value(0, -1), UsageError);
    EXPECT_THROW(color.value(0, 0, 3), UsageError);
    EXPECT_THROW(color.value(0, 0, -1), UsageError);
    Layer strided = color;
    strided.row_stride *= 2;
    EXPECT_THROW(strided.values(), UsageError);
    EXPECT_EQ(strided.value(3, 2, 1), color.value(3, 4, 1));
    EXPECT_THROW(Frame().to_srgb8(), UsageError);
}

TEST(FrameLayers, ExrHasIdsAndMotionOnRequestOnly)
{
    const test::ScratchFolder folder;
    const Scene scene = load("builtin:cornell");
    RenderOptions options = with_layers();
    const Frame frame = Renderer(options).render(scene, 3);
    frame.write(folder / "more.exr");
    options.ids = options.motion = false;
    Renderer(options).render(scene, 3).write(folder / "plain.exr");
    for (const char* layer : {"", "depth", "shadow"}) {
        CompareOptions compared;
        compared.layer = layer;
        EXPECT_EQ(compare(folder / "more.exr", folder / "plain.exr", compared).max_abs, 0) << layer;
    }
    CompareOptions compared;
    compared.ssim = compared.flip = false;
    for (const char* layer : {"id", "id.object", "id.material", "motion", "motion.X"}) {
        compared.layer = layer;
        EXPECT_EQ(compare(folder / "more.exr", folder / "more.exr", compared).max_abs, 0) << layer;
        EXPECT_THROW(compare(folder / "plain.exr", folder / "more.exr", compared), UsageError) << layer;
    }
}

TEST(Pick, IsTheLayerOfIdsAtEveryPixel)
{
    for (const Accelerator accelerator : {Accelerator::embree, Accelerator::kdtree}) {
        RenderOptions options = with_layers();
        options.accelerator = accelerator;
        Renderer renderer(options);
        const Scene scene = load("builtin:cornell");
        const Frame frame = renderer.render(scene, 4);
        const Layer &ids = *frame.layer("id"), &depth = *frame.layer("depth");
        const Layer& normal = *frame.layer("normal");
        for (int y = 0; y < k_size.height; ++y)
            for (int x = 0; x < k_size.width; ++x) {
                const Pick pick = renderer.pick(x, y);
                ASSERT_EQ(pick.hit, ids.id(x, y) != 0);
                if (!pick.hit) continue;
                ASSERT_EQ(pick.instance, scene.instance_of(ids.id(x, y, 0))) << x << " " << y;
                ASSERT_EQ(pick.material, scene.material_of(ids.id(x, y, 1))) << x << " " << y;
                ASSERT_EQ(pick.depth, depth.value(x, y)) << x << " " << y;
                ASSERT_EQ(pick.normal, (Vec3{normal.value(x, y, 0), normal.value(x, y, 1), normal.value(x, y, 2)}));
            }
    }
}

TEST(Pick, NeedsAFrameAndAPlaceInIt)
{
    Renderer renderer(with_layers());
    const Scene scene = load("builtin:cornell");
    EXPECT_THROW(renderer.pick(1, 1), UsageError);
    EXPECT_THROW(renderer.report(), UsageError);
    renderer.render(scene, 1);
    EXPECT_NO_THROW(renderer.pick(0, 0));
    EXPECT_NO_THROW(renderer.pick(47, 35));
    EXPECT_THROW(renderer.pick(-1, 1), UsageError);
    EXPECT_THROW(renderer.pick(1, 36), UsageError);
    EXPECT_THROW(renderer.pick(48, std::numeric_limits<int>::min()), UsageError);
    const Pick plain = renderer.pick(24, 18);
    RenderOptions overlay = with_layers();
    overlay.overlay = Overlay::shadow_states;
    Renderer titled(overlay);
    EXPECT_EQ(titled.render(scene, 1).view_size, (Size{48, 36}));
    EXPECT_EQ(titled.pick(24, 18).position, plain.position) << "the view's pixels, not the image's";
    EXPECT_THROW(titled.pick(48, 0), UsageError);
    EXPECT_THROW(renderer.render(scene, 2, [](const ProgressStep&) { return false; }), InterruptedError);
    EXPECT_THROW(renderer.pick(1, 1), UsageError);
    EXPECT_THROW(renderer.report(), UsageError);
}

#ifdef GNOMON_VULKAN
TEST(Pick, BuildsRaysForRasterisedFrames)
{
    RenderOptions options;
    options.size = k_size;
    options.indirect = Indirect::off;
    options.renderer = RenderMethod::raster;
    Renderer drawn(options), traced(with_layers());
    const Scene scene = load("builtin:cornell");
    for (const int frame : {2, 6}) {
        drawn.render(scene, frame);
        const Frame other = traced.render(scene, frame);
        for (int y = 0; y < k_size.height; y += 3)
            for (int x = 0; x < k_size.width; x += 3)
                EXPECT_EQ(drawn.pick(x, y).instance, scene.instance_of(other.layer("id")->id(x, y)));
    }
}
#endif

TEST(FrameReport, ListsWhatChanged)
{
    const Scene scene = load("builtin:cornell");
    RenderOptions options = with_layers();
    options.report_changes = true;
    Renderer renderer(options);
    const PixelRectangle whole{0, 0, k_size.width, k_size.height};

    std::optional<Frame> before(renderer.render(scene, 1));
    FrameReport report = renderer.report();
    EXPECT_TRUE(report.everything);
    EXPECT_TRUE(report.instances.empty());
    EXPECT_EQ(report.rectangles, std::vector<PixelRectangle>{whole});

    for (const int number : {2, 3, 7}) {
        const Frame frame = renderer.render(scene, number);
        report = renderer.report();
        EXPECT_FALSE(report.everything);
        EXPECT_EQ(report.instances.size(), scene.info().objects_dynamic);
        // The pixels that differ are those within the rectangles' tight bounds.
        for (int y = 0; y < k_size.height; ++y)
            for (int x = 0; x < k_size.width; ++x) {
                bool differs = false;
                for (int c = 0; c < 3; ++c)
                    differs = differs || frame.layers[0].value(x, y, c) != before->layers[0].value(x, y, c);
                int inside = 0;
                for (const PixelRectangle& r : report.rectangles)
                    inside += x >= r.x && y >= r.y && x < r.x + r.width && y < r.y + r.height;
                EXPECT_LE(inside, 1);
                if (differs) {
                    EXPECT_EQ(inside, 1) << x << " " << y;
                }
            }
        // What moved is seen in pixels of a listed object.
        for (const InstanceId& id : report.instances) EXPECT_NE(scene.mobility(id), Mobility::fixed);
        *before = frame;
    }

    // The same frame again changes nothing, and a frame that failed makes the next one new.
    renderer.render(scene, 7);
    report = renderer.report();
    EXPECT_FALSE(report.everything);
    EXPECT_TRUE(report.instances.empty() && report.lights.empty() && report.rectangles.empty());
    EXPECT_THROW(renderer.render(scene, 8, [](const ProgressStep&) { return false; }), InterruptedError);
    renderer.render(scene, 8);
    report = renderer.report();
    EXPECT_TRUE(report.everything);
    EXPECT_EQ(report.rectangles, std::vector<PixelRectangle>{whole});
}

TEST(FrameReport, HasRectanglesOnRequestOnly)
{
    const Scene scene = load("builtin:cornell");
    Renderer renderer(with_layers());
    renderer.render(scene, 1);
    renderer.render(scene, 2);
    EXPECT_FALSE(renderer.report().instances.empty());
    EXPECT_TRUE(renderer.report().rectangles.empty());
}

TEST(FrameReport, ListsMovedLights)
{
    const Scene scene = load("builtin:kinetic");
    RenderOptions options = with_layers();
    options.size = {16, 12};
    Renderer renderer(options);
    renderer.render(scene, 1);
    renderer.render(scene, 2);
    for (const LightId& light : renderer.report().lights) EXPECT_NO_THROW(scene.light(light));
}

// What is picked at a pixel lies where the frame's matrices put it.
TEST(FrameMatrices, ProjectWhatIsPickedToItsPixel)
{
    const Scene scene = load("builtin:cornell");
    RenderOptions options;
    options.size = {64, 40};
    Renderer renderer(options);
    const Frame frame = renderer.render(scene, 3);
    const auto product = [](const Transform& matrix, const Vec3& p, std::size_t row) {
        return matrix.m[row] * p.x + matrix.m[4 + row] * p.y + matrix.m[8 + row] * p.z + matrix.m[12 + row];
    };
    int hits = 0;
    for (int y = 1; y < 40; y += 6)
        for (int x = 1; x < 64; x += 6) {
            const Pick pick = renderer.pick(x, y);
            if (!pick.hit) continue;
            ++hits;
            const double w = product(frame.world_to_image, pick.position, 3);
            EXPECT_NEAR(64 * product(frame.world_to_image, pick.position, 0) / w, x + 0.5, 1e-2);
            EXPECT_NEAR(40 * product(frame.world_to_image, pick.position, 1) / w, y + 0.5, 1e-2);
            EXPECT_NEAR(-product(frame.world_to_camera, pick.position, 2), pick.depth, 1e-4);
        }
    EXPECT_GT(hits, 20);
}

}   // namespace
}   // namespace gnomon
