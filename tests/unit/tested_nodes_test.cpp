// SPDX-License-Identifier: Apache-2.0
// Which nodes of a cut are tested, and that they stand for all.
#include "irradiance_cache/light_tree/tested_nodes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "irradiance_cache/light_tree/point_kernels.h"
#include "scene/builtin/builtin.h"

namespace gnomon {
namespace {

using namespace irradiance_cache;
using irradiance_cache::NodeId;

class TestedNodesOfCornell : public testing::Test {
 protected:
    // The finest cut for a place on the floor.
    void SetUp() override
    {
        CutOptions finest;
        finest.error = 0.0005f;
        cut_tree(tree_, finest, point_.origin, point_.normal, cut_, weights_, scratch_);
        ASSERT_GT(cut_.size(), 500u);
    }
    glm::dvec3 light(std::span<const NodeId> nodes, std::span<const float> weights) const
    {
        glm::dvec3 sum(0);
        for (std::size_t k = 0; k < nodes.size(); ++k)
            if (above(nodes[k])) sum += static_cast<double>(weights[k]) * glm::dvec3(tree_.static_flux().at(nodes[k]));
        return sum;
    }
    bool above(NodeId node) const
    {
        const VirtualLightQuad& quad = tree_.quad(node / 4);
        const glm::vec3 at(quad.x[node % 4], quad.y[node % 4], quad.z[node % 4]);
        return glm::dot(at - point_.origin, point_.normal) > 0;
    }

    std::shared_ptr<const scene::Scene> scene_ = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    scene::SceneState state_{scene_, scene_->timeline.time_of(3)};
    ray::RayScene rays_{state_};
    Tasks tasks_{1};
    LightTree tree_{state_, rays_, LightTreeOptions{}, tasks_};
    const FacingPoint point_{{0.1f, -0.9f, 0.2f}, {0, 1, 0}, {0, 1, 0}};
    std::vector<NodeId> cut_;
    CutScratch scratch_;
    std::vector<float> weights_;
    TestedNodes tested_;
};

TEST_F(TestedNodesOfCornell, BringTheLightOfAll)
{
    const glm::dvec3 all = light(cut_, weights_);
    for (const std::size_t count : {64u, 128u, 256u}) {
        tested_.choose(tree_, point_, cut_, weights_, count);
        EXPECT_LT(tested_.nodes().size(), count + 2);
        EXPECT_GT(tested_.nodes().size(), count / 2);
        const glm::dvec3 some = light(tested_.nodes(), tested_.weights());
        for (int colour = 0; colour < 3; ++colour)
            EXPECT_NEAR(some[colour] / all[colour], 1, 3.0 / static_cast<double>(count)) << count;
    }
}

TEST_F(TestedNodesOfCornell, OfAShortCutAreAll)
{
    tested_.choose(tree_, point_, cut_, weights_, cut_.size());
    EXPECT_EQ(tested_.nodes().data(), cut_.data());
    EXPECT_EQ(tested_.nodes().size(), cut_.size());
    EXPECT_EQ(tested_.weights().data(), weights_.data());
}

// The light of a dynamic object may reach a node that is dark otherwise. Of the darkest nodes, which have half of the
// form factor, an eighth of all tested ones must be, besides what their light brings.
TEST_F(TestedNodesOfCornell, AreDarkOnesToo)
{
    constexpr std::size_t k_count = 256;
    const auto form_factor = [&](std::size_t k) {
        return above(cut_[k]) ? weights_[k] * tree_.quad(cut_[k] / 4).area[cut_[k] % 4] : 0;
    };
    const auto exitance = [&](std::size_t k) {
        const VirtualLightQuad& quad = tree_.quad(cut_[k] / 4);
        return quad.flux[cut_[k] % 4] / quad.area[cut_[k] % 4];
    };
    std::vector<std::size_t> by_exitance(cut_.size());
    std::iota(by_exitance.begin(), by_exitance.end(), std::size_t{0});
    std::ranges::sort(by_exitance, {}, exitance);
    float all = 0, sum = 0;
    for (std::size_t k = 0; k < cut_.size(); ++k) all += form_factor(k);
    std::set<NodeId> dark;
    double light = 0, light_of_all = 0;
    for (const std::size_t k : by_exitance) {
        const double brings = static_cast<double>(exitance(k) * form_factor(k));
        light_of_all += brings;
        sum += form_factor(k);
        if (sum > all / 2) continue;
        dark.insert(cut_[k]);
        light += brings;
    }
    tested_.choose(tree_, point_, cut_, weights_, k_count);
    const auto tested = std::ranges::count_if(tested_.nodes(), [&](const NodeId node) { return dark.contains(node); });
    const double expected = k_count * (0.25 * 0.5 + 0.75 * light / light_of_all);
    EXPECT_NEAR(static_cast<double>(tested), expected, 0.03 * k_count);
}

}   // namespace
}   // namespace gnomon
