// SPDX-License-Identifier: Apache-2.0
#pragma once
// Static or dynamic, over time: the reading of FrameChanges that caches use.
//
// An object becomes dynamic in the frame in which it moves, deforms, appears or vanishes, and static again after
// `quiet_frames` frames of rest (hysteresis: a thing that moves now and then should not be redrawn into static buffers
// each time it pauses). An author may fix an object either way. Cost a frame: what changed, and what fell asleep.
// Hysteresis may change cost, never pixels.

#include <vector>

#include "scene/state.h"

namespace gnomon::scene {

enum class MobilityOverride : std::uint8_t { automatic, always_static, always_dynamic };

class Mobility {
 public:
    /// @param quiet_frames  how long an object must rest to count as static, in frames; at least 1
    explicit Mobility(std::size_t object_count, int quiet_frames = 8);

    /// Must be called once a frame, with that frame's changes.
    void update(const FrameChanges& changes);
    void set_override(ObjectId object, MobilityOverride value);

    bool is_dynamic(ObjectId object) const;
    /// Objects that changed sides in the last update, ascending.
    const std::vector<ObjectId>& became_dynamic() const { return became_dynamic_; }
    const std::vector<ObjectId>& became_static() const { return became_static_; }
    /// All objects that are dynamic now, in no particular order.
    const std::vector<ObjectId>& dynamic_objects() const { return dynamic_; }
    /// Objects looked at in the last update.
    std::uint64_t touched() const { return touched_; }

 private:
    void wake(ObjectId object);
    void make_dynamic(ObjectId object);
    void make_static(ObjectId object);

    std::vector<MobilityOverride> override_;
    std::vector<std::uint32_t> last_active_;    // frame number
    std::vector<std::uint32_t> dynamic_slot_;   // place in dynamic_, or none
    std::vector<ObjectId> dynamic_;
    std::vector<std::vector<ObjectId>> asleep_at_;   // ring of quiet_frames + 1: who may fall asleep in which frame
    std::vector<ObjectId> became_dynamic_, became_static_;
    std::uint32_t frame_ = 0;
    std::uint64_t touched_ = 0;
};

}   // namespace gnomon::scene
