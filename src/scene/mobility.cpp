// SPDX-License-Identifier: Apache-2.0
#include "scene/mobility.h"

#include <algorithm>

#include "base/check.h"

namespace gnomon::scene {

Mobility::Mobility(std::size_t object_count, int quiet_frames)
    : override_(object_count, MobilityOverride::automatic),
      last_active_(object_count, 0),
      dynamic_slot_(object_count, none),
      rested_at_(static_cast<std::size_t>(quiet_frames) + 1)
{
    GNOMON_CHECK_LE(1, quiet_frames);
}

void Mobility::update(const FrameChanges& changes)
{
    ++frame_;
    touched_ = 0;
    became_dynamic_.clear();
    became_static_.clear();
    for (const ObjectId object : changes.changed) note_change(object);

    // Make those static whose rest ends now, unless they changed meanwhile.
    std::vector<ObjectId>& due = rested_at_[frame_ % rested_at_.size()];
    const auto quiet_frames = static_cast<std::uint32_t>(rested_at_.size() - 1);
    for (const ObjectId object : due) {
        ++touched_;
        const bool rested = last_active_[object] + quiet_frames <= frame_;
        if (rested && dynamic_slot_[object] != none && override_[object] == MobilityOverride::automatic)
            make_static(object);
    }
    due.clear();
    std::sort(became_dynamic_.begin(), became_dynamic_.end());
    std::sort(became_static_.begin(), became_static_.end());
}

void Mobility::note_change(ObjectId object)
{
    ++touched_;
    last_active_[object] = frame_;
    if (override_[object] != MobilityOverride::automatic) return;
    const std::size_t quiet_frames = rested_at_.size() - 1;
    rested_at_[(frame_ + quiet_frames) % rested_at_.size()].push_back(object);
    if (dynamic_slot_[object] == none) make_dynamic(object);
}

void Mobility::set_override(ObjectId object, MobilityOverride value)
{
    override_[object] = value;
    if (value == MobilityOverride::always_dynamic && dynamic_slot_[object] == none) make_dynamic(object);
    if (value == MobilityOverride::always_static && dynamic_slot_[object] != none) make_static(object);
    // Back to automatic: it becomes static after its rest, as any other object.
    if (value == MobilityOverride::automatic && dynamic_slot_[object] != none) {
        last_active_[object] = frame_;
        rested_at_[(frame_ + rested_at_.size() - 1) % rested_at_.size()].push_back(object);
    }
}

bool Mobility::is_dynamic(ObjectId object) const
{
    return dynamic_slot_[object] != none;
}

void Mobility::make_dynamic(ObjectId object)
{
    dynamic_slot_[object] = static_cast<std::uint32_t>(dynamic_.size());
    dynamic_.push_back(object);
    became_dynamic_.push_back(object);
}

void Mobility::make_static(ObjectId object)
{
    const std::uint32_t slot = dynamic_slot_[object];
    dynamic_slot_[dynamic_.back()] = slot;
    std::swap(dynamic_[slot], dynamic_.back());
    dynamic_.pop_back();
    dynamic_slot_[object] = none;
    became_static_.push_back(object);
}

}   // namespace gnomon::scene
