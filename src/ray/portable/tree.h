// SPDX-License-Identifier: Apache-2.0
#pragma once
// Bounding volume hierarchies with eight children per node, for the portable ray tracer (kernels.h).
//
// The build is a binned surface area heuristic [Wald 2007, 'On fast Construction of SAH-based Bounding Volume
// Hierarchies'] in scalar code. Threads share the binning of large nodes, and build subtrees of a fixed size each, so
// that a tree is a function of its triangles alone: the same on every processor and for any number of threads.
//
// Boxes are larger than what they hold by k_box_margin of their largest coordinate. Together with the same fraction of
// a ray's origin, this is more than the rounding of the tests of boxes and triangles, so that what rays hit does not
// depend on the tree.

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "ray/embree/solid.h"

namespace gnomon {
class Tasks;
}

namespace gnomon::ray {

// A triangle's edges are off by a few units in the last place of coordinates relative to the ray's origin.
inline constexpr float k_box_margin = 0x1p-20f;

/// A node: the boxes of up to eight children. A child is the index of a node, or a leaf.
struct alignas(64) TreeNode {
    static constexpr std::size_t k_width = 8;
    float low[3][k_width], high[3][k_width];
    std::uint32_t child[k_width];
    std::uint32_t count = 0;   // children; 1 to k_width

    static constexpr std::uint32_t k_leaf = 1u << 31;
    static constexpr unsigned k_count_shift = 27;   // of a leaf: first item, and the number of items less one
    static constexpr std::uint32_t k_most_items = 16;
    static constexpr std::uint32_t k_past_items = 1u << k_count_shift;
    static std::uint32_t leaf(std::uint32_t first, std::uint32_t items)
    {
        return k_leaf | (items - 1) << k_count_shift | first;
    }
    static bool is_leaf(std::uint32_t child) { return (child & k_leaf) != 0; }
    static std::uint32_t first_of(std::uint32_t leaf) { return leaf & (k_past_items - 1); }
    static std::uint32_t items_of(std::uint32_t leaf) { return ((leaf & ~k_leaf) >> k_count_shift) + 1; }
};

/// Four triangles of a leaf, as a structure of arrays.
struct alignas(64) TriangleBlock {
    float corner[3][3][4];   // by corner and axis
    std::uint32_t geometry[4], triangle[4];
    std::uint8_t mask[4];             // rays that meet it (embree.h); 0 where there is no triangle
    std::uint8_t judged_closest[4];   // whether hits of closest-hit rays must be judged by the holes of the material
    /// What hits of other rays must be judged by: the material; their distance in double precision, because the
    /// triangle is narrow.
    std::uint8_t judged_any[4];
    static constexpr std::uint8_t k_by_material = 1, k_by_distance = 2;
    /// Bits of the triangles that are one-sided, which closest-hit rays of `front_only` pass through: those that come
    /// from the side on which corners run counter-clockwise in the space of the tree, and those from behind.
    std::uint8_t unmet[2];
};

/// Something to build a tree over.
struct TreeItem {
    Box3 box;
    std::uint32_t id = 0;
};

/// The tree of a set of triangles: of the static scene, or of a solid.
class TriangleTree {
 public:
    /// Builds over the geometries that are attached. Keeps a reference to the records and their vertices.
    /// @param tasks  share the work; null: the caller's thread alone
    /// @throws InterruptedError  the current work was interrupted
    void build(const std::deque<GeometryRecord>& records, Tasks* tasks = nullptr);
    /// Follows vertices that moved: the tree keeps its structure, and its boxes are computed again.
    void refit();

    bool empty() const { return nodes_.empty(); }
    const TreeNode* nodes() const { return nodes_.data(); }
    const TriangleBlock* blocks() const { return blocks_.get(); }
    const GeometryRecord& record(std::uint32_t geometry) const { return (*records_)[geometry]; }
    /// Of its triangles, with the margin.
    const Box3& box() const { return box_; }
    std::size_t bytes() const;

 private:
    void fill(TriangleBlock& block, unsigned lane, std::uint32_t geometry, std::uint32_t triangle) const;

    const std::deque<GeometryRecord>* records_ = nullptr;
    std::vector<TreeNode> nodes_;
    std::unique_ptr<TriangleBlock[]> blocks_;
    std::size_t block_count_ = 0;
    Box3 box_;
};

/// A tree of triangles in a scene.
struct TreeInstance {
    const TriangleTree* tree = nullptr;
    unsigned id = RTC_INVALID_GEOMETRY_ID;   // Embree's id of the instance; invalid: world-space triangles
    scene::ObjectId object = scene::none;    // none: the object of the geometry's record
    bool identity = true;                    // the tree is in world space
    std::array<float, 12> to_object{};       // by column: three of the linear part, one of the translation
    Box3 box;                                // in world space
};

/// A scene: instances of trees, and a tree over them.
class SceneTree {
 public:
    void clear();
    /// World-space triangles. The tree must outlive this scene.
    void add(const TriangleTree& tree);
    /// @param to_world  regular (has_volume())
    void add(const TriangleTree& tree, unsigned id, scene::ObjectId object, const glm::mat4& to_world);
    /// All instances of another scene.
    void add(const SceneTree& other);
    /// Call after the last add().
    void build();

    const std::vector<TreeInstance>& instances() const { return instances_; }
    const TreeNode* nodes() const { return nodes_.data(); }
    const Box3& box() const { return box_; }
    std::size_t bytes() const;

 private:
    std::vector<TreeInstance> instances_;
    std::vector<TreeNode> nodes_;
    Box3 box_;
};

}   // namespace gnomon::ray
