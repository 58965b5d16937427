// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shadow textures on the CPU, by each of the three methods: reference implementations of the Vulkan versions.
//
// A shadow texture belongs to one receiver in one light view. It covers the receiver's footprint with one bit per
// texel, set where the receiver is the object nearest to the light [Oh and Shin 2004, 2]. Its texels are those of the
// view, because equal depths require the same projection of the same vertices.

#include <map>

#include "light_views/software.h"

namespace gnomon::shadow_textures {

struct ReceiverTexture {
    light_views::Rect rect;
    std::vector<std::uint32_t> bits;   // rows, each padded to a whole word

    static std::size_t row_words(const light_views::Rect& rect)
    {
        return (static_cast<std::size_t>(rect.width()) + 31) / 32;
    }
    bool lit(int x, int y) const;
    void set(int x, int y, bool lit);
    friend bool operator==(const ReceiverTexture&, const ReceiverTexture&) = default;
};

/// Draws the receiver once against the depth of everything [2].
/// @param rect  the receiver's footprint, not empty
ReceiverTexture texture_by_depth(const light_views::ViewProjection& view, const light_views::SoftwareBuffer& everything,
                                 const scene::SceneState& state, scene::ObjectId receiver,
                                 const light_views::Rect& rect);

/// The earlier method: draws every caster that reaches nearer to the light than the receiver as an occluder. O(N) per
/// receiver.
ReceiverTexture texture_by_casters(const light_views::ViewProjection& view, const light_views::Casters& casters,
                                   const scene::SceneState& state, scene::ObjectId receiver,
                                   const light_views::Rect& rect);

/// Reads the same texture from the items, without drawing. Exact wherever no other object with a higher number is
/// equally near.
ReceiverTexture texture_by_items(const light_views::SoftwareBuffer& everything, scene::ObjectId receiver,
                                 const light_views::Rect& rect);

/// All textures of one view, redrawn only where the plan lists them [3.2]. Needs LightViewsOptions::receivers.
class CoherentTextures {
 public:
    /// Call after the plan was carried out on `everything`.
    void update(const light_views::LightView& view, const light_views::SoftwareBuffer& everything,
                const light_views::Casters& casters, const scene::SceneState& state);
    const std::map<scene::ObjectId, ReceiverTexture>& textures() const { return textures_; }
    std::size_t updated() const { return updated_; }   // by the last update

 private:
    std::map<scene::ObjectId, ReceiverTexture> textures_;
    std::size_t updated_ = 0;
};

}   // namespace gnomon::shadow_textures
