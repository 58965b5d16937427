// SPDX-License-Identifier: Apache-2.0
#pragma once
// The directions that light comes from, in a fixed hierarchy of cells: those of an environment image, or those of the
// disc of a sun.
//
// The sphere is an icosahedron. Its faces are divided into nine, and these into four, level by level; level 2 has 720
// cells. A cell that brings more than its share of the light is divided further, so that a sun in an image gets as many
// cells as its light deserves. The cells at a place are the same for every image as far as they are divided, so that
// what was proven of them holds for another image, too. A disc is a square of cells in the plane that touches the
// sphere at its middle.
//
// A leaf has one direction, the same for every point, at which its visibility is found: the place is jittered within
// the cell, because an edge of a shadow that is parallel to rows of a regular grid would hide a whole row at once. Its
// light is the integral of the radiance over the cell. The irradiance that it brings is linear in the normal, so a mean
// direction has it exactly for surfaces that see all of the cell.
//
// Leaves are numbered in the order of the tree; those of a node are neighbours.
// Cost: one pass over half a million to two million samples of the image. Memory: 200 bytes a cell.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/math.h"
#include "scene/environment.h"

namespace gnomon::environment_light {

struct CellOptions {
    double largest_share = 1.0 / 512;   // of the light, by luminance, that one cell may bring
    int least_level = 2;                // of the cells; level k from 1 on has 45 * 4^k
    int most_levels = 12;
    std::size_t most_cells = 4096;
    int disc_level = 4;   // a disc has 4^k cells
    bool groups = true;   // DirectionCells::groups() and families()
};

/// Neighbouring leaves that lie so close together that most points see all of them, or none: a sun.
struct LeafGroup {
    std::uint32_t first = 0, leaves = 0;
    /// Leaves that are looked at first: where all of these that lie above a surface are visible, or none, the others
    /// are taken to be as they. Its rim, and some within.
    std::vector<std::uint32_t> scouts;
};

/// The cells that one cell of the level above the least was divided into.
struct CellFamily {
    std::uint32_t first = 0, leaves = 0;
    /// The leaf next to the middle.
    std::uint32_t scout = 0;
    /// That leaf; or of a family that was divided further, one of every four leaves, and those that are in no such
    /// four. Where the scouts of a family and the middle ones of all its neighbours are visible from a point, or none,
    /// the followers of the family are taken to be as they.
    std::vector<std::uint32_t> scouts;
    std::array<std::uint32_t, 3> neighbours{};   // families across the edges
};

/// Leaves in a row, and the one of them that stands in for all where a coarse answer will do.
struct StoodFor {
    std::uint32_t first = 0, leaves = 0, stand_in = 0;
};

/// A cell of the tree: the directions between its corners.
struct DirectionNode {
    std::array<glm::dvec3, 4> corner{};   // unit, around the cell, seen from the sphere's middle in either sense
    int corners = 3;
    std::uint32_t children = 0;   // the first of them; 0: a leaf
    std::uint32_t count = 0;      // of children
    std::uint32_t first_leaf = 0, leaves = 1;
    std::uint64_t place = 0;   // identifies the cell, whatever the light is
    glm::vec3 axis{0};         // of a cone around it: unit,
    float cosine = 1;          // and of its half-angle
};

/// A cell of which a point sees a share; the bit of the leaf does not count then.
struct PartialCell {
    std::uint32_t leaf = 0;
    float share = 0;   // 0 to 1
};

class DirectionCells {
 public:
    DirectionCells(const scene::Environment& environment, const CellOptions& options = {});
    /// A disc of even radiance.
    /// @param to_light  unit
    /// @param diameter  angular, in radians, above 0 and below pi / 2
    /// @param irradiance  on a surface that faces its middle
    DirectionCells(const glm::vec3& to_light, double diameter, const glm::vec3& irradiance,
                   const CellOptions& options = {});

    std::span<const DirectionNode> nodes() const { return nodes_; }
    /// Nodes that are no other's child: the first ones.
    std::size_t roots() const { return roots_; }

    std::size_t leaves() const { return directions_.size(); }
    /// Words of a mask with one bit a leaf.
    std::size_t words() const { return (leaves() + 63) / 64; }
    /// Of visibility; unit.
    const glm::vec3& direction(std::size_t leaf) const { return directions_[leaf]; }
    /// The mean direction by luminance; not quite of unit length.
    const glm::vec3& mean(std::size_t leaf) const { return means_[leaf]; }
    /// The integral of radiance.
    const glm::vec3& flux(std::size_t leaf) const { return fluxes_[leaf]; }
    /// The solid angle.
    float angle(std::size_t leaf) const { return angles_[leaf]; }
    /// The node of a leaf.
    std::uint32_t node_of(std::size_t leaf) const { return nodes_of_[leaf]; }
    const glm::vec3& total_flux() const { return total_; }
    std::span<const LeafGroup> groups() const { return groups_; }
    /// Leaves of groups that are not scouts, as a mask.
    const std::vector<std::uint64_t>& followers() const { return followers_; }
    /// Of an image; a disc has none.
    std::span<const CellFamily> families() const { return families_; }
    /// Leaves of families that are not scouts, as a mask; leaves of groups are none.
    const std::vector<std::uint64_t>& family_followers() const { return family_followers_; }
    /// Leaves that stand in for others where a coarse answer will do, as a mask: one of each family, and of each of its
    /// quarters where these were divided further. Without families, empty.
    const std::vector<std::uint64_t>& stand_ins() const { return stand_ins_; }
    /// The leaf that stands in for a leaf. @pre families() is not empty
    std::size_t stand_in_of(std::size_t leaf) const { return stand_in_of_[leaf]; }
    /// All leaves, by the leaf that stands in for them. Without families, empty.
    std::span<const StoodFor> stood_for() const { return stood_for_; }
    /// All leaves in fewer rows, where a rough answer will do: of families next to each other that bring at most a 32nd
    /// of the light together and are at most a 60th of all directions, with the brightest leaf to stand in for them. A
    /// family that brings more than a 12th is as in stood_for(). Without families, empty.
    std::span<const StoodFor> few_stood_for() const { return few_stood_for_; }
    /// The index of the family of a leaf. @pre families() is not empty
    std::size_t family_of(std::size_t leaf) const { return family_of_[leaf]; }
    /// Adds the leaves in and next to the family of a leaf to a mask; without families, all.
    void add_around(std::size_t leaf, std::span<std::uint64_t> mask) const;
    /// The number of a leaf, or of the cell of the least level that it is in, counted through that level; leaves of one
    /// cell count on from it. It hardly depends on the image: that of other places does not matter.
    std::uint32_t stable_number(std::size_t leaf) const { return stable_numbers_[leaf]; }
    /// For each leaf, that of another set which is the same cell, or none (-1).
    std::vector<std::int32_t> same_leaves(const DirectionCells& other) const;
    /// Another set whose leaves are the same directions, whatever light they bring.
    bool same_directions(const DirectionCells& other) const;
    std::size_t bytes() const;

 private:
    struct Builder;
    void number_leaves(std::uint32_t node);
    void add_cones();
    void add_group(std::uint32_t first, std::uint32_t leaves);
    void add_families(std::uint32_t begin, std::uint32_t end);
    void add_followers(const DirectionNode& node, std::uint32_t scout);
    std::uint32_t middle_of(const DirectionNode& node) const;
    void add_scouts(const DirectionNode& node, CellFamily& family);
    void add_stand_ins(const DirectionNode& family, std::uint32_t scout, bool divided_once);
    void add_few_stand_ins();

    std::vector<DirectionNode> nodes_;
    std::size_t roots_ = 0;
    std::vector<glm::vec3> directions_, means_, fluxes_;
    std::vector<float> angles_;
    std::vector<std::uint32_t> nodes_of_, stable_numbers_;
    std::vector<LeafGroup> groups_;
    std::vector<std::uint64_t> followers_;
    std::vector<CellFamily> families_;
    std::vector<std::uint64_t> family_followers_;
    std::vector<std::uint16_t> family_of_;   // by leaf
    std::vector<std::uint64_t> stand_ins_;
    std::vector<std::uint16_t> stand_in_of_;   // by leaf
    std::vector<StoodFor> stood_for_, few_stood_for_;
    glm::vec3 total_{0};
};

}   // namespace gnomon::environment_light
