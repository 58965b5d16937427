// SPDX-License-Identifier: Apache-2.0
// A scene that a host hands over, frame by frame, gives the same bytes and leaves out as many shadow rays as the same
// scene with the same declarations loaded from a file.
#include <gtest/gtest.h>

#include "host_copy.h"
#include "io/load.h"
#include "same_frames.h"
#include "scene/builtin/builtin.h"
#include "scene/defaults/emissive_lights.h"
#include "support.h"

namespace gnomon {
namespace {

// Renders frames of a scene by its tracks, and as a host would, and compares them.
void compare_frames(const std::shared_ptr<const scene::Scene>& read, const RenderOptions& options, int first, int last,
                    int step = 1)
{
    // Give the file's scene what load() gives it.
    auto completed = std::make_shared<scene::Scene>(*read);
    scene::add_emitter_lights(*completed);
    scene::add_default_light(*completed);
    scene::add_default_camera(*completed);
    const Scene from_file = api::public_scene(completed);
    test::HostCopy copy(read);
    const Scene from_host = copy.builder().finish({.default_light = true});

    Renderer of_file(options), of_host(options);
    for (int frame = first; frame <= last; frame += step) {
        const Frame expected = of_file.render(from_file, frame);
        FrameInput input = copy.input_at(from_file.time_of(frame));
        input.camera = of_file.camera();
        const Frame got = of_host.render(from_host, input);
        ASSERT_NO_FATAL_FAILURE(test::expect_same(got, expected)) << frame;
        EXPECT_EQ(got.counters.shadow.rays, expected.counters.shadow.rays) << frame;
        EXPECT_EQ(got.counters.shadow.rays_skipped, expected.counters.shadow.rays_skipped) << frame;
        EXPECT_EQ(got.counters.shadow.rays_dynamic_only, expected.counters.shadow.rays_dynamic_only) << frame;
        EXPECT_EQ(got.counters.indirect.rays, expected.counters.indirect.rays) << frame;
        EXPECT_EQ(got.counters.update.began_anew, frame == first) << frame;
    }
}

std::shared_ptr<const scene::Scene> read_file(const std::filesystem::path& file)
{
    return std::make_shared<const scene::Scene>(io::load_scene(file.string(), {}));
}

RenderOptions small(int width, int height)
{
    RenderOptions options;
    options.size = {width, height};
    options.layers = true;
    return options;
}

TEST(Host, SameBytesAndShadowRaysAsTheBuiltInBox)
{
    compare_frames(std::make_shared<const scene::Scene>(scene::make_builtin("cornell")), small(80, 80), 1, 12);
}

TEST(Host, SameBytesAsTheBuiltInBoxWithTheLightQuadTree)
{
    RenderOptions options = small(64, 64);
    options.indirect = Indirect::quadtree;
    compare_frames(std::make_shared<const scene::Scene>(scene::make_builtin("cornell")), options, 1, 6);
}

TEST(Host, SameBytesAndShadowRaysAsBoxAnimated)
{
    GNOMON_NEED_SCENE(file, "gltf/BoxAnimated.glb");
    compare_frames(read_file(file), small(96, 64), 1, 40, 3);
}

TEST(Host, SameBytesAndShadowRaysAsABendingTube)
{
    GNOMON_NEED_SCENE(file, "real/RiggedSimple/RiggedSimple.gltf");
    compare_frames(read_file(file), small(64, 96), 1, 12, 2);
}

TEST(Host, SameBytesAndShadowRaysAsAMorphingMesh)
{
    GNOMON_NEED_SCENE(file, "real/morphLoader/morphLoader.glb");
    compare_frames(read_file(file), small(64, 64), 1, 40, 4);
}

TEST(Host, SameBytesAndShadowRaysAsKitchen)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    compare_frames(read_file(file), small(48, 48), 118, 130, 2);
}

TEST(HostFull, SameBytesAndShadowRaysAsAllOfKitchen)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    compare_frames(read_file(file), small(48, 48), 1, 800);
}

}   // namespace
}   // namespace gnomon
