// SPDX-License-Identifier: Apache-2.0
#pragma once
// One shadow texture per receiver on the device [Oh and Shin 2004, 2 and 3.2], and the earlier method for comparison.
//
// `depth`, and the paper's coherent method: one draw per receiver against the depth of everything. `per_caster`: first
// draws the casters between each receiver and the light, O(N^2) in total. All give the same bits, and so do the items
// of the light views wherever no two objects are equally near. Therefore the renderer reads items by default.
// DEVIATION(Oh and Shin 2004, 2): a texture covers only its receiver's footprint, with one bit per texel, and is
// written from the fragment shader, because a render target per receiver would need as many passes as receivers.
// DEVIATION(Oh and Shin 2004, 3.2): only receivers in sight of the camera get their textures. One that is out of sight
// when its texture changes has none until it is seen again.
// DEVIATION(Oh and Shin 2004, 1): per caster, casters whose extents do not meet the receiver's are left out, unless
// PreviousMethod::all_between asks for all of them.

#include <functional>

#include "light_views/vulkan/gpu_light_views.h"
#include "shadow_textures/vulkan/texture_arena.h"
#include "shadow_textures/vulkan/textures_shared.h"

namespace gnomon::shadow_textures {

struct TextureCounts {                        // of the last record
    std::uint64_t updated = 0;                // textures redrawn
    std::uint64_t draws = 0;                  // of receivers, and of casters between them and the light (per_caster)
    std::uint64_t draws_of_all_between = 0;   // per_caster: draws if extents were not tested
    std::uint64_t waiting = 0;   // textures that changed and are not made, because their receivers are out of sight
};

/// Which casters the previous method draws for a receiver.
enum class PreviousMethod : std::uint8_t {
    by_extents,    // those that reach nearer to the light and whose light-view extent meets the receiver's
    all_between,   // all that reach nearer to the light, as the paper describes it
};

/// Whether the camera may see an object.
using InSight = std::function<bool(scene::ObjectId)>;

class GpuTextures {
 public:
    GpuTextures(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views);

    /// Redraws the textures that the plans list, by depth. Call after GpuLightViews::record, with plans that list
    /// receivers; textures are kept from frame to frame. Cost: the textures listed, and a test of sight for each that
    /// waits.
    /// @param in_sight  textures of other objects wait until they are in sight; empty: all are made
    void record(vk::Commands& commands, const light_views::LightViews& views, const light_views::GpuLightViews& buffers,
                const light_views::CasterGeometry& casters, const scene::SceneState& state,
                const InSight& in_sight = {});
    /// Redraws all textures per caster, without any light view.
    void record_per_caster(vk::Commands& commands, const light_views::LightViews& views,
                           const light_views::CasterGeometry& casters, const scene::SceneState& state,
                           PreviousMethod which = PreviousMethod::by_extents, const InSight& in_sight = {});

    const TextureCounts& counts() const { return counts_; }
    const vk::Buffer& textures() const { return words_; }
    const vk::Buffer& places() const { return places_; }
    /// The location of a receiver's texture, for tests and read-back.
    const shared::TexturePlace& place(std::size_t view, scene::ObjectId object) const
    {
        return host_places_[view * objects_ + object];
    }

 private:
    struct Receiver {
        std::uint32_t view = 0;
        scene::ObjectId object = scene::none;
        light_views::Rect rect;   // in texels of the view
    };
    void place_texture(const light_views::LightView& view, const Receiver& receiver);
    void drop_texture(std::size_t view, scene::ObjectId object);
    void make_room(vk::Commands& commands, bool keep);
    void upload_places(vk::Commands& commands);
    void clear_textures(vk::Commands& commands, const std::vector<Receiver>& receivers);
    void draw_receivers(vk::Commands& commands, const light_views::LightViews& views, const vk::Image& depth, int page,
                        std::span<const Receiver> receivers, const light_views::CasterGeometry& casters);
    void draw_casters_between(vk::Commands& commands, const light_views::LightViews& views, int page,
                              std::span<const Receiver> receivers, const light_views::CasterGeometry& casters,
                              PreviousMethod which);

    std::shared_ptr<vk::Device> device_;
    std::size_t objects_;
    TextureArena arena_;
    std::vector<shared::TexturePlace> host_places_;   // by view and object
    std::vector<std::uint32_t> place_words_;          // sizes of the textures in words
    std::vector<std::uint32_t> changed_places_;
    vk::Buffer words_, places_;
    std::vector<vk::Buffer> outgrown_;
    std::vector<std::vector<scene::ObjectId>> waiting_;   // by view, ascending: changed, and not made yet
    // Per caster, by view: the casters in the view, and their distances and extents by object.
    struct Extents {
        std::vector<scene::ObjectId> casters;
        std::vector<light_views::DistanceRange> range;
        std::vector<light_views::Rect> rect;
    };
    std::vector<Extents> extents_;
    vk::Image scratch_;                            // per caster: depth of the casters between receiver and light
    vk::Pipeline receiver_[2][2], caster_[2][2];   // perspective or not, opaque or alpha-tested
    bool places_filled_ = false;
    TextureCounts counts_;
};

}   // namespace gnomon::shadow_textures
