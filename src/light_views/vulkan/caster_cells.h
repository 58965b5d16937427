// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which triangles may lie over each place of a light's view: for hard shadows with the edges of triangles instead of
// texels (shadow_textures/vulkan/hard_edges.glsl). All that can block a ray to the light is in one cell's list.
//
// A cell is a square of texels. Each view has two sets of lists, as it has two buffers: of what stands still, made when
// that changes, and of what moves, made in every frame in which the view's plan does something. Lists hold every
// triangle whose image meets the cell, and near its rim a few that do not; a cell has one of opaque triangles and one
// of alpha-tested ones, which cost more to ask. Each 32 entries are a block, which says which of them lie around a part
// of their cell, and how near the light any of them comes: most entries of a long list are passed over 32 at a time. A
// block may hold entries of several cells. Lists that one buffer of the device cannot hold are a MissingError. Cost of
// a set: its triangles, and the cells that they cover; on the CPU. Memory: 10 bytes a triangle and cell, and
// CasterTriangles.

#include "light_views/light_views.h"
#include "light_views/vulkan/caster_triangles.h"

namespace gnomon::light_views {

class CasterCells {
 public:
    CasterCells(const std::shared_ptr<vk::Device>& device, const LightViews& views);

    /// Follows one update() of the views and one of the geometry.
    void update(vk::Commands& commands, const LightViews& views, const CasterGeometry& casters,
                const scene::SceneState& state);

    /// CellBases, CellTriangles, and of both sets First, Blocks and Entries (StaticFirst ... MovingEntries).
    vk::Pass& declare(vk::Pass& pass) const;
    void bind(vk::Recorder& recorder) const;

    /// Lists of one view: of cell c, opaque, entries[first[2 c]] up to first[2 c + 1]; the alpha-tested ones follow, up
    /// to first[2 c + 2].
    struct Lists {
        std::vector<std::uint32_t> first;
        std::vector<shared::CellEntry> entries;
        std::vector<shared::CellBlock> blocks;   // of each GNOMON_BLOCK_ENTRIES entries
    };
    const Lists& statics(std::size_t view) const { return sets_[0].views[view]; }
    std::uint32_t side(std::size_t view) const { return side_[view]; }   // in cells
    const Lists& moving(std::size_t view) const { return sets_[1].views[view]; }

 private:
    struct Set {
        std::vector<Lists> views;
        std::vector<char> stale;   // by view: to be made
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
    std::vector<std::uint32_t> side_, base_;   // by view: cells a side; its first list in the buffers
    std::uint32_t lists_ = 0;                  // in all, one more a view
    Set sets_[2];                              // static, moving
    std::vector<std::vector<char>> among_;     // by view, object: moves there
    std::vector<std::vector<Found>> found_;    // by view; scratch
    vk::Buffer bases_;
    bool sent_bases_ = false;
};

}   // namespace gnomon::light_views
