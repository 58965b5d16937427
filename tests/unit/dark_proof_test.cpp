// SPDX-License-Identifier: Apache-2.0
// Each check of the proof that a part gets no light is needed: with it, a small scene made for it is not called dark;
// without it, it is, although some segment is free.

#include "area_light/dark_proof.h"

#include <gtest/gtest.h>

#include "area_light/area_shadows.h"
#include "ray/ray_scene.h"

namespace gnomon::area_light {
namespace {

using visibility::StaticTriangles;

// The part is the triangle (0 0 0), (1 0 0), (0 1 0), seen from above; the light a square of side 1 at z = 2.
class Stage {
 public:
    explicit Stage(scene::Mesh occluder)
    {
        scene::Mesh receiver;
        receiver.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        receiver.triangles = {{0, 1, 2}};
        auto made = std::make_shared<scene::Scene>();
        made->materials.emplace_back().double_sided = true;
        for (scene::Mesh* mesh : {&receiver, &occluder}) {
            mesh->parts = {{0, 0, static_cast<std::uint32_t>(mesh->triangles.size())}};
            made->nodes[made->add_node("", scene::none)].mesh = static_cast<scene::MeshId>(made->meshes.size());
            made->meshes.push_back(std::move(*mesh));
        }
        made->finish();
        state_.emplace(made, 0);
        rays_.emplace(*state_);
        triangles_.emplace(*state_, *rays_);
        light_.corner = {glm::vec3(0, 0, 2), glm::vec3(0, 1, 2), glm::vec3(1, 1, 2), glm::vec3(1, 0, 2)};
        light_.corners = 4;
        light_.normal = {0, 0, -1};
    }
    bool is_dark(DarkCheck left_out = DarkCheck::none) const
    {
        AreaOptions options;
        options.most_levels = 0;
        options.dark.left_out = left_out;
        std::vector<visibility::TriangleId> list;
        return AreaShadows(*triangles_, light_, options).judged_anew(0, true, 0.3f, 0.3f, list).state ==
               PartState::dark;
    }
    /// Whether rays find a free segment.
    bool some_segment_is_free() const
    {
        constexpr int n = 24;
        for (int i = 0; i <= n; ++i)
            for (int j = 0; i + j <= n; ++j)
                for (int k = 0; k <= n; ++k)
                    for (int l = 0; l <= n; ++l) {
                        const glm::vec3 from(static_cast<float>(i) / n, static_cast<float>(j) / n, 2e-6f);
                        const glm::vec3 to(static_cast<float>(k) / n, static_cast<float>(l) / n, 2);
                        if (!rays_->occluded_single(from, 0, to - from, ray::k_shadow_ray_end)) return true;
                    }
        return false;
    }

 private:
    std::optional<scene::SceneState> state_;
    std::optional<ray::RayScene> rays_;
    std::optional<StaticTriangles> triangles_;
    LightPolygon light_;
};

// A sheet of n x n squares over [low, high]^2, at the height that `height` gives.
template <class Height>
scene::Mesh sheet(float low, float high, const Height& height, std::uint32_t n = 6)
{
    scene::Mesh mesh;
    for (std::uint32_t j = 0; j <= n; ++j)
        for (std::uint32_t i = 0; i <= n; ++i) {
            const float x = low + (high - low) * static_cast<float>(i) / static_cast<float>(n),
                        y = low + (high - low) * static_cast<float>(j) / static_cast<float>(n);
            mesh.positions.emplace_back(x, y, height(x, y));
        }
    for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t a = j * (n + 1) + i;
            mesh.triangles.emplace_back(a, a + 1, a + n + 2);
            mesh.triangles.emplace_back(a, a + n + 2, a + n + 1);
        }
    return mesh;
}
const auto k_flat = [](float, float) { return 1.0f; };

void expect_needed(const Stage& stage, DarkCheck check)
{
    ASSERT_TRUE(stage.some_segment_is_free()) << "otherwise the part is dark";
    EXPECT_FALSE(stage.is_dark());
    EXPECT_TRUE(stage.is_dark(check)) << "the scene does not show that the check is needed";
}

TEST(DarkProof, HoldsBehindAClosedSheet)
{
    const Stage flat(sheet(-2, 3, k_flat));
    EXPECT_TRUE(flat.is_dark());
    EXPECT_FALSE(flat.some_segment_is_free());
    const Stage folded(sheet(
        -2, 3, [](float x, float) { return 1 + 0.4f * std::sin(9 * x); }, 40));
    EXPECT_FALSE(folded.some_segment_is_free());
    EXPECT_FALSE(folded.is_dark()) << "the patch has more triangles than a proof may visit";
    const Stage bumpy(sheet(
        -1, 2, [](float x, float y) { return 1 + 0.3f * std::sin(7 * x) * std::cos(5 * y); }, 7));
    EXPECT_TRUE(bumpy.is_dark());
    EXPECT_FALSE(bumpy.some_segment_is_free());
}

TEST(DarkProof, NeedsEveryEdgeInTheShaftToLeadOn)
{
    scene::Mesh holed = sheet(-2, 3, k_flat, 20);
    // Cut one square out, beside the middle.
    holed.triangles.erase(holed.triangles.begin() + 2 * (20 * 9 + 11), holed.triangles.begin() + 2 * (20 * 9 + 11) + 2);
    expect_needed(Stage(std::move(holed)), DarkCheck::no_open_edge);
}

TEST(DarkProof, NeedsThePatchToBeClearOfThePart)
{
    expect_needed(Stage(sheet(-3, 4, [](float x, float) { return 0.6f - x; })), DarkCheck::clear_of_part);
}

TEST(DarkProof, NeedsThePatchToBeClearOfTheLight)
{
    expect_needed(Stage(sheet(-3, 4, [](float x, float) { return 1.4f + x; })), DarkCheck::clear_of_light);
}

scene::Mesh box(const glm::vec3& low, const glm::vec3& high)
{
    scene::Mesh mesh;
    for (int c = 0; c < 8; ++c)
        mesh.positions.emplace_back(c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z);
    for (const auto& quad : {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
                             std::array{2, 6, 7, 3}, std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}}) {
        mesh.triangles.emplace_back(quad[0], quad[1], quad[2]);
        mesh.triangles.emplace_back(quad[0], quad[2], quad[3]);
    }
    return mesh;
}

TEST(DarkProof, NeedsTheNetNumberOfCrossings)
{
    // A closed box in the middle has no open edge; a segment through it enters and leaves.
    const Stage stage(box({0.35f, 0.35f, 0.9f}, {0.45f, 0.45f, 1.1f}));
    expect_needed(stage, DarkCheck::crosses);
    expect_needed(stage, DarkCheck::signs);
}

}   // namespace
}   // namespace gnomon::area_light
