// SPDX-License-Identifier: Apache-2.0
#pragma once
// Soft shadow textures, kept over time: each receiver's shadow texture convolved with the image of a rectangular light
// [Soler and Sillion 1998, 3], and made again only where the receiver's shadow may have changed [Oh and Shin
// 2004, 3.2].
//
// The light's centre sees which parts of a receiver lie behind which occluder. If light, occluder and receiver are
// parallel, what the receiver sees of the light is that image convolved with the light's own, scaled by
// (receiver - occluder) / occluder, with distances along the view. Here the scale follows from mean distances over the
// shadowed texels: of a whole receiver, as in the source, or of each occluder on it.
//
// DEVIATION(Soler and Sillion 1998, 3): the convolution is a box, the image of the rectangle's bounds along the view's
// axes, summed from a table of sums and not by a Fourier transform. It is exact in a view along the light's normal
// whose axes are the light's sides.
// DEVIATION(Soler and Sillion 1998, 4): a receiver is not divided until an error bound holds, because shadow textures
// belong to whole objects. `bench lights` measures what that costs.
//
// Texels without a part of the receiver have no weight, so that neither its border nor an occluder beyond it shows.
// Where a receiver hides itself, only distances tell, as for hard textures (lookup.h), and the shadow is hard.

#include <map>
#include <optional>
#include <span>

#include "light_views/software.h"

namespace gnomon::shadow_textures {

/// A rectangle around the centre of a light view.
struct SoftLight {
    glm::vec3 half_s{0}, half_t{0};   // from the centre to the middles of two sides, metres
    friend bool operator==(const SoftLight&, const SoftLight&) = default;
};

/// Whose mean distance scales the light's image.
enum class SoftScale : std::uint8_t {
    receiver,   // all occluders of a receiver have one
    occluder,   // each occluding object has its own on each receiver; their shadows are added
};

struct SoftTexture {
    light_views::Rect rect;
    std::vector<float> visible;   // part of the light, 0 to 1, by texel in rows
    std::vector<float> depth;     // of the receiver alone; 0 where it has no part
    std::size_t at(int x, int y) const
    {
        return static_cast<std::size_t>(y - rect.y0) * static_cast<std::size_t>(rect.width()) +
               static_cast<std::size_t>(x - rect.x0);
    }
    friend bool operator==(const SoftTexture&, const SoftTexture&) = default;
};

/// @param everything  the view's rendering buffer
/// @param rect        the receiver's footprint, not empty
SoftTexture soft_texture(const light_views::ViewProjection& view, const light_views::SoftwareBuffer& everything,
                         const scene::SceneState& state, scene::ObjectId receiver, const light_views::Rect& rect,
                         const SoftLight& light, SoftScale scale);

/// All soft textures of one view. Needs LightViewsOptions::receivers. Cost of an update: the texels of the receivers
/// that the plan lists, times their occluders.
class CoherentSoftTextures {
 public:
    explicit CoherentSoftTextures(SoftScale scale) : scale_(scale) {}
    /// Call after the plan was carried out on `everything`. With a light of another size, all textures are made again.
    void update(const light_views::LightView& view, const light_views::SoftwareBuffer& everything,
                const light_views::Casters& casters, const scene::SceneState& state, const SoftLight& light);
    const std::map<scene::ObjectId, SoftTexture>& textures() const { return textures_; }
    std::size_t updated() const { return updated_; }   // by the last update

 private:
    SoftScale scale_;
    std::optional<SoftLight> light_;
    std::map<scene::ObjectId, SoftTexture> textures_;
    std::size_t updated_ = 0;
};

/// What a point of a receiver sees of the light, 0 to 1, between four texels. A point outside the view sees all.
/// @param normal       unit, geometric, on the visible side; a light behind it gives 0
/// @param self_margin  how much nearer the receiver must be to shadow itself, in texel widths at the point
float soft_visibility(const light_views::ViewProjection& view, const SoftTexture& texture, const glm::vec3& point,
                      const glm::vec3& normal, float self_margin = 1);

}   // namespace gnomon::shadow_textures
