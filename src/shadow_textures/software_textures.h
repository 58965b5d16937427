// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shadow textures on the CPU, by each of the three methods: the slow twins of those drawn by Vulkan.
//
// A shadow texture belongs to one receiver in one light view. It covers the receiver's footprint, a bit a texel: set
// where the receiver is the object nearest the light [Oh and Shin 2004, 2]. Its texels are the view's own, since equal
// depths need the same projection of the same vertices.

#include <map>

#include "light_views/software.h"

namespace gnomon::shadow_textures {

struct ReceiverTexture {
    light_views::Rect rect;
    std::vector<std::uint32_t> bits;   // rows of whole words

    static std::size_t row_words(const light_views::Rect& rect)
    {
        return (static_cast<std::size_t>(rect.width()) + 31) / 32;
    }
    bool lit(int x, int y) const;
    void set(int x, int y, bool lit);
    friend bool operator==(const ReceiverTexture&, const ReceiverTexture&) = default;
};

/// One draw of the receiver against the depth of everything [2].
/// @param rect  the receiver's footprint, not empty
ReceiverTexture texture_by_depth(const light_views::ViewProjection& view, const light_views::SoftwareBuffer& everything,
                                 const scene::SceneState& state, scene::ObjectId receiver,
                                 const light_views::Rect& rect);

/// The method before: every caster that reaches nearer to the light than the receiver does, drawn black. O(N) a
/// receiver.
ReceiverTexture texture_by_casters(const light_views::ViewProjection& view, const light_views::Casters& casters,
                                   const scene::SceneState& state, scene::ObjectId receiver,
                                   const light_views::Rect& rect);

/// The same texture read from the items, without any draw: exact wherever no other object of a higher number is equally
/// near.
ReceiverTexture texture_by_items(const light_views::SoftwareBuffer& everything, scene::ObjectId receiver,
                                 const light_views::Rect& rect);

/// All textures of one view, made anew only where the plan says so [3.2]. Needs LightViewsOptions::receivers.
class CoherentTextures {
 public:
    /// Call after the plan was carried out on `everything`.
    void update(const light_views::LightView& view, const light_views::SoftwareBuffer& everything,
                const light_views::Casters& casters, const scene::SceneState& state);
    const std::map<scene::ObjectId, ReceiverTexture>& textures() const { return textures_; }
    std::size_t updated() const { return updated_; }   // in the last update

 private:
    std::map<scene::ObjectId, ReceiverTexture> textures_;
    std::size_t updated_ = 0;
};

}   // namespace gnomon::shadow_textures
