// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which places of a light a triangle with holes hides from a point: those that the whole triangle hides
// (blocked_places.h) where the line to the place meets more alpha than the material's cutoff.
//
// A map says of each square between four texels whether alpha, filtered, is surely below the cutoff in all of it,
// surely not, or neither; only in the last case is the texture filtered. So most places cost one look-up, and each
// place has the answer of the whole texture.
//
// Results are the same for any instruction set.
// Cost: some 3 ns a place (AVX-512), and a byte of map for each texel.

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "area_light/light_places.h"
#include "scene/scene.h"

namespace gnomon::area_light {

/// Where a texture's alpha lets light through.
class HoleMap {
 public:
    enum Kind : std::uint8_t { solid, hole, mixed };

    /// @param alpha, cutoff  a place is a hole if alpha times the texture's is below the cutoff
    HoleMap(std::shared_ptr<const scene::Texture> texture, float alpha, float cutoff);

    bool is_of(const scene::Texture& texture, float alpha, float cutoff) const
    {
        return &texture == texture_.get() && alpha == alpha_ && cutoff == cutoff_;
    }
    /// Entry (x + 1, y + 1) is of the square between the texels (x, y) and (x + 1, y + 1), where coordinates are
    /// filtered, and of the texel (x, y), where they are not. Both run from -1, over one period of the wrapping.
    const std::uint8_t* kinds() const { return kinds_.data(); }
    int columns() const { return columns_; }
    int rows() const { return rows_; }
    const scene::Texture& texture() const { return *texture_; }
    /// What the map is made from, for one place.
    bool is_hole(glm::vec2 uv) const { return alpha_ * texture_->alpha(uv) < cutoff_; }
    std::size_t bytes() const { return kinds_.capacity() * sizeof(kinds_[0]); }

 private:
    std::shared_ptr<const scene::Texture> texture_;   // shared, so that no other can have its address
    float alpha_, cutoff_;
    int columns_ = 0, rows_ = 0;
    std::vector<std::uint8_t> kinds_;
};

/// Adds to `blocked` the places of a mask that a triangle hides where its texture has no holes.
/// @param corner    of the triangle
/// @param texcoord  the texture's coordinates at the corners, transformed
/// @param mask      what the triangle would hide without holes
/// @return          whether any place was added
bool add_blocked_past_holes(const glm::vec3& point, const glm::vec3 (&corner)[3], const glm::vec2 (&texcoord)[3],
                            const HoleMap& map, const LightPlaces& places, const PlaceMask& mask, PlaceMask& blocked);
/// The same for any holes, slower: of alpha that has other sources as well.
/// @param is_hole  whether there is one at (1-u-v) corner 0 + u corner 1 + v corner 2
bool add_blocked_past_holes(const glm::vec3& point, const glm::vec3 (&corner)[3],
                            const std::function<bool(float, float)>& is_hole, const LightPlaces& places,
                            const PlaceMask& mask, PlaceMask& blocked);

}   // namespace gnomon::area_light
