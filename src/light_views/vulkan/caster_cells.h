// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lists the triangles that may cover each cell of a light view, for hard shadows with the edges of triangles instead of
// texels (shadow_textures/vulkan/hard_edges.glsl). Every triangle that can block a ray from a point to the light is in
// the lists of the point's cell.
//
// A cell is a square of texels. Each view has two sets of lists, like its two buffers: of static objects, rebuilt when
// these change, and of dynamic objects, rebuilt in every frame whose plan is not idle. Lists contain every triangle
// whose projection meets the cell, and near its edges a few that do not. A cell has one list of opaque and one of
// alpha-tested triangles, which are more expensive to test. Each 32 entries form a block, which stores which of them
// meet each part of their cell and how near to the light any of them comes; so most entries of a long list are skipped
// 32 at a time. A block may contain entries of several cells. Lists that exceed one buffer of the device are a
// MissingError. Cost of a set, on the CPU: its triangles, and the cells that they cover. Memory: 10 bytes per triangle
// and cell, plus CasterTriangles.

#include "light_views/light_views.h"
#include "light_views/vulkan/caster_triangles.h"

namespace gnomon::light_views {

class CasterCells {
 public:
    CasterCells(const std::shared_ptr<vk::Device>& device, const LightViews& views);

    /// Call after each update() of the views and of the geometry.
    void update(vk::Commands& commands, const LightViews& views, const CasterGeometry& casters,
                const scene::SceneState& state);

    /// Bindings CellBases, CellTriangles, and for both sets First, Blocks and Entries (StaticFirst ... MovingEntries).
    vk::Pass& declare(vk::Pass& pass) const;
    void bind(vk::Recorder& recorder) const;

    /// The lists of one view. Opaque triangles of cell c: entries[first[2 c]] up to first[2 c + 1]; alpha-tested ones
    /// follow, up to first[2 c + 2].
    struct Lists {
        std::vector<std::uint32_t> first;
        std::vector<shared::CellEntry> entries;
        std::vector<shared::CellBlock> blocks;   // one per GNOMON_BLOCK_ENTRIES entries
    };
    const Lists& statics(std::size_t view) const { return sets_[0].views[view]; }
    std::uint32_t side(std::size_t view) const { return side_[view]; }   // in cells
    const Lists& moving(std::size_t view) const { return sets_[1].views[view]; }

 private:
    struct Set {
        std::vector<Lists> views;
        std::vector<char> stale;   // by view: must be rebuilt
        vk::Buffer first, blocks, entries;
    };
    struct Found {
        std::uint32_t list;
        shared::CellEntry entry;
        float nearest;
    };
    void make(Set& set, bool moving, const LightViews& views, const CasterGeometry& casters,
              const scene::SceneState& state);
    void add_object(const Set& set, const LightViews& views, const CasterGeometry& casters,
                    const scene::SceneState& state, scene::ObjectId object);
    void add_triangle(std::size_t view, const ViewProjection& projection, const shared::CellTriangle& triangle,
                      std::uint32_t number);
    void sort(std::size_t view, Lists& lists);
    void send(vk::Commands& commands, Set& set, const char* name);

    std::shared_ptr<vk::Device> device_;
    CasterTriangles triangles_;
    std::vector<std::uint32_t> side_, base_;          // by view: cells a side; index of its first list in the buffers
    std::uint32_t lists_ = 0;                         // in total, with one extra per view
    Set sets_[2];                                     // static, moving
    std::vector<std::vector<char>> in_dynamic_set_;   // by view and object: dynamic there
    std::vector<std::vector<Found>> found_;           // by view; scratch
    vk::Buffer bases_;
    bool sent_bases_ = false;
};

}   // namespace gnomon::light_views
