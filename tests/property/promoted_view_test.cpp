// SPDX-License-Identifier: Apache-2.0
// A viewer's session in which somebody lifts what stood still: the image is that of a session that knew it no other
// way.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "gnomon/scene.h"
#include "sanitized.h"
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

// What somebody asks for: where the block is, from where it stands.
struct Asked {
    ViewRequest request;
    std::optional<glm::vec3> offset{};
};

// The last image of these requests, each shown whole before the next.
Image8 last_of(std::vector<Asked> all)
{
    ViewSession session(2);
    SceneRecipe recipe;
    recipe.what = "builtin:cornell";
    session.load(recipe);
    wait_for([&] { return session.scene() || !session.load_state().error.empty(); });
    for (auto& [request, offset] : all) {
        request.scene = session.scene();
        if (offset) {
            const NodeId block = session.scene()->find_node("short block");
            request.overrides = {{block, session.scene()->transform(block), *offset}};
        }
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
    Asked before;
    before.request.size = {96, 96};
    before.request.options = options;
    before.request.options.exposure = 0;
    Asked promoted = before, higher = before;
    promoted.offset = {0, 0.3f, 0.2f};
    higher.offset = {-0.1f, 0.6f, 0.3f};
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
