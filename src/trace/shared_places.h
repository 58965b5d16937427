// SPDX-License-Identifier: Apache-2.0
#pragma once
// Places at which the visibility of an environment is found for many points at once.
//
// A ray of a rough lobe shows the mean of what lies in its part of the lobe (shading/lobe_rays.h), and many such rays
// meet the same piece of surface. Points that they meet therefore share places: each triangle is divided into equal
// parts, so many that a part is at most as wide as the ray's cone, and the middle of the part stands in for its
// points. A narrow cone has places of its own. Of triangles that are smaller than the cone, one stands in for those
// around it that face the same way (place_groups.h).
//
// The place of a point is a function of the point, its cone and the mesh alone.

#include <cstdint>
#include <span>
#include <vector>

#include "trace/place_groups.h"
#include "trace/place_memory.h"
#include "trace/point_batch.h"

namespace gnomon::trace {

class SharedPlaces {
 public:
    /// @param groups  null: no triangle stands in for others
    explicit SharedPlaces(const ray::RayScene& rays, PlaceGroups* groups = nullptr) : rays_(rays), groups_(groups) {}

    /// Finds the places of points of a batch: first those of points that keep their own, in the order of the list, then
    /// shared ones.
    /// @param asked  indices of points
    void find(const PointBatch& batch, std::span<const std::uint32_t> asked);

    /// Shared ones may lie on other triangles than their points.
    std::span<const visibility::ShadowPoint> places() const { return places_; }
    /// By place that is shared, from own() on: what identifies it.
    std::span<const PlaceKey> shared_keys() const { return shared_keys_; }
    /// Places that belong to one point.
    std::size_t own() const { return own_; }
    /// By place that belongs to one point: the index of the point in the batch.
    std::span<const std::uint32_t> own_points() const { return own_points_; }
    /// By asked point: the index of its place.
    std::uint32_t place_of(std::size_t asked) const { return place_of_[asked]; }

 private:
    struct Entry {
        PlaceKey key;
        std::uint32_t place = 0xffffffff;
    };
    struct Divided {
        std::uint32_t triangle = 0;   // that the part is of
        glm::vec3 corners[3]{};       // its own
        std::uint32_t level = 0, column = 0, row = 0;
        bool upper = false;   // the half of the square that is away from the first corner
    };
    bool divide(const TilePoint& point, const visibility::ShadowPoint& at, Divided& part);
    void stand_in(const visibility::ShadowPoint& at, float width, float edge, Divided& part);
    std::uint32_t place(const visibility::ShadowPoint& at, const Divided& part);

    const ray::RayScene& rays_;
    PlaceGroups* groups_;
    const scene::Mesh* mesh_ = nullptr;   // the last one
    const TriangleRuns* runs_ = nullptr;
    std::vector<visibility::ShadowPoint> places_;
    std::vector<PlaceKey> shared_keys_;
    std::vector<std::uint32_t> own_points_, place_of_;
    std::vector<Divided> parts_;   // by asked point that shares its place
    std::vector<Entry> table_;     // a power of two
    std::size_t own_ = 0;
};

}   // namespace gnomon::trace
