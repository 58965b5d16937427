// SPDX-License-Identifier: Apache-2.0
#pragma once
// Mobility: which objects count as dynamic in the present frame, with hysteresis.
//
// An object becomes dynamic in the frame in which it changes, and static again after `quiet_frames` frames of rest.
// Hysteresis keeps an object that moves now and then from being redrawn into static buffers each time it pauses. An
// override fixes an object either way. It changes cost, never pixels.
//
// SceneState::is_dynamic() is another question: whether an object may ever change, or was promoted.
//
// Cost per frame: the objects that changed, and those whose rest ended.

#include <vector>

#include "scene/state.h"

namespace gnomon::scene {

enum class MobilityOverride : std::uint8_t { automatic, always_static, always_dynamic };

class Mobility {
 public:
    /// @param quiet_frames  frames of rest after which an object counts as static; at least 1
    explicit Mobility(std::size_t object_count, int quiet_frames = 8);

    /// Must be called once per frame, with the changes of that frame.
    void update(const FrameChanges& changes);
    void set_override(ObjectId object, MobilityOverride value);

    bool is_dynamic(ObjectId object) const;
    /// Objects whose mobility changed in the last update, ascending.
    const std::vector<ObjectId>& became_dynamic() const { return became_dynamic_; }
    const std::vector<ObjectId>& became_static() const { return became_static_; }
    /// All objects that are dynamic now, in no particular order.
    const std::vector<ObjectId>& dynamic_objects() const { return dynamic_; }
    /// Objects visited in the last update.
    std::uint64_t touched() const { return touched_; }

 private:
    void note_change(ObjectId object);
    void make_dynamic(ObjectId object);
    void make_static(ObjectId object);

    std::vector<MobilityOverride> override_;
    std::vector<std::uint32_t> last_active_;    // frame number
    std::vector<std::uint32_t> dynamic_slot_;   // index in dynamic_, or none
    std::vector<ObjectId> dynamic_;
    std::vector<std::vector<ObjectId>> rested_at_;   // ring of quiet_frames + 1 frames: whose rest may end in each
    std::vector<ObjectId> became_dynamic_, became_static_;
    std::uint32_t frame_ = 0;
    std::uint64_t touched_ = 0;
};

}   // namespace gnomon::scene
