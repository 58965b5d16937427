// SPDX-License-Identifier: Apache-2.0
// The bounds of a frame leave out the ground that the library adds, which is wider than the scene.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "gnomon/gnomon.h"
#include "support.h"

namespace gnomon {
namespace {

TEST(ShownBounds, LeaveOutTheGroundThatTheLibraryAdds)
{
    const test::ScratchFolder folder;
    // A tetrahedron without a light: it gets a studio, and stands on a ground.
    std::ofstream(folder / "a.obj") << "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    const Scene scene = load(folder / "a.obj");
    ASSERT_TRUE(scene.find_node("default ground"));
    RenderOptions options{.size = {16, 12}, .threads = 1};
    options.samples = 1;
    options.indirect = Indirect::off;
    Renderer renderer(options);
    renderer.render(scene, 1);
    const Box bounds = renderer.bounds();
    EXPECT_EQ(bounds.low, (Vec3{0, 0, 0}));
    EXPECT_EQ(bounds.high, (Vec3{2, 2, 3}));
    // An object that is moved takes its bounds with it.
    const NodeId node = scene.moving_node(scene.instances().front());
    FrameInput input;
    Transform raised = scene.transform(node);
    raised.m[13] += 5;
    input.transforms.push_back({node, raised, {}});
    renderer.render(scene, input);
    EXPECT_NEAR(renderer.bounds().low.y, 5, 1e-5);
    EXPECT_NEAR(renderer.bounds().high.y, 7, 1e-5);
    // Far from the origin, too.
    std::ofstream(folder / "b.obj")
        << "v 500000 0 0\nv 500002 0 0\nv 500000 2 0\nv 500000 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    renderer.render(load(folder / "b.obj"), 1);
    EXPECT_NEAR(renderer.bounds().low.x, 500000, 0.1);
    EXPECT_NEAR(renderer.bounds().high.x, 500002, 0.1);
}

}   // namespace
}   // namespace gnomon
