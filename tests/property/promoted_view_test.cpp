// SPDX-License-Identifier: Apache-2.0
// A viewer's session in which somebody lifts what stood still: the image is that of a session that knew it no other
// way.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "api/scene_access.h"
#include "gnomon/scene.h"
#include "sanitized.h"
#include "scene/scene.h"
#include "viewer/session.h"
#include "vk_helpers.h"

namespace gnomon::viewer {
namespace {

template <class Done>
void wait_for(const Done& done)
{
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60 * test::k_patience);
    while (!done()) {
        ASSERT_LT(std::chrono::steady_clock::now(), end);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

// The last image of these requests, each shown whole before the next.
Image8 last_of(std::vector<ViewRequest> requests)
{
    ViewSession session(2);
    SceneRecipe recipe;
    recipe.what = "builtin:cornell";
    session.load(recipe);
    wait_for([&] { return session.scene() || !session.load_state().error.empty(); });
    for (ViewRequest& request : requests) {
        request.scene = session.scene();
        session.ask(request);
        wait_for([&] { return !session.busy() && !session.refining(); });
    }
    EXPECT_EQ(session.load_state().error, "");
    EXPECT_EQ(session.load_state().frame_error, "");
    const auto image = session.image(0);
    return image ? image->image : Image8();
}

void expect_warm_is_cold(const RenderOptions& options)
{
    const std::shared_ptr<const scene::Scene> scene = api::scene_of(load("builtin:cornell"));
    scene::NodeId block = scene::none;
    for (scene::NodeId n = 0; n < scene->nodes.size(); ++n)
        if (scene->nodes[n].name == "short block") block = n;
    ASSERT_NE(block, scene::none);
    ViewRequest before;
    before.size = {96, 96};
    before.options = options;
    before.options.exposure = 0;
    ViewRequest promoted = before, higher = before;
    promoted.hands = {{block, true, {0, 0.3f, 0.2f}}};
    higher.hands = {{block, true, {-0.1f, 0.6f, 0.3f}}};
    const Image8 cold = last_of({higher});
    EXPECT_TRUE(cold.data == last_of({before, promoted, higher}).data) << static_cast<int>(options.indirect);
    EXPECT_FALSE(cold.data == last_of({before}).data);
}

TEST(PromotedView, SameImageWarmAndCold)
{
    RenderOptions options;
    for (const Indirect indirect : {Indirect::visible, Indirect::quadtree}) {
        options.indirect = indirect;
        expect_warm_is_cold(options);
    }
}

#ifdef GNOMON_VULKAN
class PromotedViewVulkan : public test::VulkanTest {};

TEST_F(PromotedViewVulkan, SameImageWarmAndCold)
{
    RenderOptions options;
    options.renderer = RenderMethod::raster;
    options.indirect = Indirect::visible;
    options.indirect_on = IndirectOn::vulkan;
    expect_warm_is_cold(options);
}
#else
TEST(PromotedViewVulkan, SkippedWithoutVulkan)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif

}   // namespace
}   // namespace gnomon::viewer
