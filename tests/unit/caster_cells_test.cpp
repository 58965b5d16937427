// SPDX-License-Identifier: Apache-2.0
// Lists of triangles per cell, compared with clipping every triangle against every cell while objects move.
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include <map>

#include "light_script.h"
#include "light_views/vulkan/caster_cells.h"

namespace gnomon::light_views {
namespace {

class CasterCellsTest : public test::VulkanTest {};

// The corners of one triangle in clip space.
struct Caster {
    glm::dvec4 clip[3];
    double nearest = 0;   // along the view direction
    bool masked = false;
};

// Triangles that cast shadows, by their number in the entries.
std::map<std::uint32_t, Caster> all_casters(const scene::SceneState& state, const ViewProjection& view)
{
    std::map<std::uint32_t, Caster> casters;
    const scene::Scene& scene = state.scene();
    std::uint32_t number = 0;
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) {
        const scene::Object& object = scene.objects[o];
        const scene::Mesh& mesh = scene.meshes[object.mesh];
        for (const scene::MeshPart& part : mesh.parts) {
            const scene::SurfaceClass surface = scene.materials[part.material].surface_class();
            if (surface == scene::SurfaceClass::transparent) continue;
            for (std::uint32_t t = 0; t < part.triangle_count; ++t, ++number) {
                if (!state.object_visible(o)) continue;
                const auto& positions = object.deforming ? state.deformed(o).positions : mesh.positions;
                Caster caster;
                caster.masked = surface == scene::SurfaceClass::masked;
                caster.nearest = k_infinity;
                for (int i = 0; i < 3; ++i) {
                    const auto corner = static_cast<std::size_t>(mesh.triangles[part.first_triangle + t][i]);
                    const glm::dvec4 world = glm::dmat4(state.object_matrix(o)) * glm::dvec4(positions[corner], 1);
                    caster.clip[i] = glm::dmat4(view.clip_from_world) * world;
                    const glm::dvec3 from_eye = glm::dvec3(world) - glm::dvec3(view.origin);
                    caster.nearest = std::min(caster.nearest, glm::dot(from_eye, glm::dvec3(view.forward)));
                }
                casters[number] = caster;
            }
        }
    }
    return casters;
}

// Whether a triangle's projection overlaps a square of clip space: clips it against five planes.
bool meets(const Caster& caster, const glm::dvec2& low, const glm::dvec2& high, double least_w)
{
    const glm::dvec4 planes[] = {
        {1, 0, 0, -low.x}, {-1, 0, 0, high.x}, {0, 1, 0, -low.y}, {0, -1, 0, high.y}, {0, 0, 0, 1}};
    std::vector<glm::dvec4> polygon(caster.clip, caster.clip + 3);
    for (const glm::dvec4& plane : planes) {
        std::vector<glm::dvec4> inside;
        const auto height = [&](const glm::dvec4& p) {
            return glm::dot(plane, p) - (plane.x == 0 && plane.y == 0 ? least_w : 0);
        };
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const glm::dvec4 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
            const double ha = height(a), hb = height(b);
            if (ha >= 0) inside.push_back(a);
            if ((ha >= 0) != (hb >= 0)) inside.push_back(a + ha / (ha - hb) * (b - a));
        }
        polygon = std::move(inside);
        if (polygon.empty()) return false;
    }
    return true;
}

struct Counts {
    std::uint64_t entries = 0, masked = 0, moving = 0, blocks = 0;
};

// Compares one view's lists of both sets with all triangles.
void check_view(const CasterCells& cells, const LightViews& views, const scene::SceneState& state, std::size_t v,
                Counts& counts)
{
    constexpr double k_slack = 0.04;   // of a cell: lists may contain triangles this close to it
    const ViewProjection& view = views.views()[v].projection;
    const std::map<std::uint32_t, Caster> casters = all_casters(state, view);
    const std::uint32_t side = cells.side(v);
    for (std::uint32_t c = 0; c < side * side; ++c) {
        std::map<std::uint32_t, std::uint32_t> listed;   // triangle, bounds
        for (const bool moving : {false, true}) {
            const CasterCells::Lists& lists = moving ? cells.moving(v) : cells.statics(v);
            ASSERT_EQ(lists.first.size(), 2 * side * side + 1);
            for (const bool masked : {false, true})
                for (std::uint32_t i = lists.first[2 * c + masked]; i < lists.first[2 * c + masked + 1]; ++i) {
                    const shared::CellEntry& entry = lists.entries[i];
                    EXPECT_TRUE(listed.emplace(entry.triangle, entry.bounds).second) << "twice";
                    const auto caster = casters.find(entry.triangle);
                    ASSERT_NE(caster, casters.end());
                    EXPECT_EQ(caster->second.masked, masked);
                    ++counts.entries, counts.masked += masked, counts.moving += moving;
                    // Its block must not be skipped where the triangle lies.
                    const shared::CellBlock& block = lists.blocks[i / GNOMON_BLOCK_ENTRIES];
                    EXPECT_LE(block.nearest, caster->second.nearest + 1e-4);
                    for (std::uint32_t part = 0; part < 16; ++part) {
                        const auto meets_part = [&](std::uint32_t low, std::uint32_t high, std::uint32_t at) {
                            return low <= 64 * at + 63 && high >= 64 * at;
                        };
                        const std::uint32_t b = entry.bounds;
                        const bool around =
                            meets_part(b & 255, b >> 16 & 255, part % 4) && meets_part(b >> 8 & 255, b >> 24, part / 4);
                        EXPECT_EQ(block.around[part] >> (i % GNOMON_BLOCK_ENTRIES) & 1u, around ? 1u : 0u);
                    }
                }
            counts.blocks += lists.blocks.size();
        }
        // Test the cell's square, whole and in sixteen quarters of quarters: a triangle that overlaps one must be
        // listed, with bounds around it.
        const auto at = [&](double x, double y) { return glm::dvec2(2 * x / side - 1, 2 * y / side - 1); };
        const int column = c % side, row = c / side;
        const double x = column, y = row;
        const double least = view.perspective ? 2e-3 * view.reach : 0;
        for (const auto& [number, caster] : casters) {
            if (!meets(caster, at(x - k_slack, y - k_slack), at(x + 1 + k_slack, y + 1 + k_slack), 0)) {
                EXPECT_FALSE(listed.contains(number)) << "view " << v << ", cell " << c;
                continue;
            }
            if (!meets(caster, at(x, y), at(x + 1, y + 1), least)) continue;
            ASSERT_TRUE(listed.contains(number)) << "view " << v << ", cell " << c;
            const std::uint32_t b = listed[number];
            for (std::uint32_t part = 0; part < 64; ++part) {
                const std::uint32_t px = part % 8, py = part / 8;
                if (!meets(caster, at(x + px / 8.0, y + py / 8.0), at(x + (px + 1) / 8.0, y + (py + 1) / 8.0), least))
                    continue;
                EXPECT_TRUE((b & 255) <= 32 * px + 31 && (b >> 16 & 255) >= 32 * px && (b >> 8 & 255) <= 32 * py + 31 &&
                            b >> 24 >= 32 * py)
                    << "view " << v << ", cell " << c;
            }
        }
    }
}

TEST_F(CasterCellsTest, EqualClippingOfEveryTriangle)
{
    const int frames = 12;
    const test::LightScript script = test::make_light_script(3, frames);
    scene::SceneState state(script.scene, 0);
    LightViewsOptions options;
    options.atlas.view_size = 64;   // cells of 16 texels: 4 a side
    options.quiet_frames = 2;
    LightViews views(state, options);
    CasterGeometry casters(device_, state);
    CasterCells cells(device_, views);
    vk::Commands commands(device_);
    Counts counts;
    for (int frame = 0; frame < frames; ++frame) {
        state.advance(script.time(frame));
        views.update(state);
        casters.update(commands, state);
        cells.update(commands, views, casters, state);
        commands.submit();
        SCOPED_TRACE(frame);
        for (std::size_t v = 0; v < views.views().size(); ++v)
            if (views.views()[v].shown) check_view(cells, views, state, v, counts);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(counts.masked, 100u);
    EXPECT_GT(counts.moving, 100u);
    EXPECT_LT(counts.moving, counts.entries);
    EXPECT_GT(counts.blocks, 100u);
}

}   // namespace
}   // namespace gnomon::light_views
#endif
