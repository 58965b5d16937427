// SPDX-License-Identifier: Apache-2.0
#pragma once
// What is remembered: per static triangle and side a pyramid of states, one byte a part for four lights.
//
// The four states are the paper's [Nah 2009, 2.1] at a finer grain. The finest level is what look-ups read; a part
// decided at a coarser level has filled its descendants there. Beside each state lies evidence: what traced rays saw in
// the part since it was last judged.
//
// Room is one block per group of four lights, reserved at the start (the system commits pages as they are touched) and
// given out by size class; when it is full, records that were not seen lately are dropped. Threads may look up and add
// evidence at once; records are added under a lock; growing and dropping happen between frames.

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <vector>

#include "base/micro_triangles.h"
#include "shadow_culling/rim.h"

namespace gnomon::shadow_culling {

enum class ShadowState : std::uint8_t { unknown = 0, none = 1, full = 2, partial = 3 };

/// Evidence bits of one light: some ray was free, some ray was blocked by static geometry.
inline constexpr std::uint8_t k_saw_free = 1, k_saw_blocked = 2;

inline constexpr int k_lights_per_group = 4;
inline constexpr std::uint32_t k_no_slot = 0xffffffffu;
inline constexpr std::uint32_t k_max_level = 8;
/// States may be read this many bytes beyond a part's.
inline constexpr std::size_t k_read_pad = 3;

/// Record of one side of one static triangle: 2 * triangle + (front ? 0 : 1).
using RecordId = std::uint32_t;
inline constexpr RecordId k_no_record = k_no_slot;   // of points on what moves

class ShadowMemory {
 public:
    /// @param records  how many there may be: twice the static triangles
    /// @param budget   bytes of states and evidence over all groups
    ShadowMemory(std::size_t records, int lights, std::size_t budget);

    int groups() const { return static_cast<int>(states_.size()); }

    /// Where a record's pyramid begins; k_no_slot if it has none.
    std::uint32_t base(RecordId record) const { return records_[record].base.load(std::memory_order_acquire); }
    std::uint32_t level(RecordId record) const { return records_[record].level; }
    Rim rim(RecordId record) const { return Rim(records_[record].rim); }
    void note_seen(RecordId record, std::uint32_t frame)
    {
        if (records_[record].seen.load(std::memory_order_relaxed) != frame)
            records_[record].seen.store(frame, std::memory_order_relaxed);
    }

    /// Whether a record, in this frame's view, should be deeper: asked of `ask` once a frame.
    template <class Ask>
    bool coarse(RecordId record, std::uint32_t frame, const Ask& ask)
    {
        std::uint32_t checked = records_[record].checked.load(std::memory_order_relaxed);
        if (checked >> 1 != frame) {
            checked = frame << 1 | (ask() ? 1u : 0u);
            records_[record].checked.store(checked, std::memory_order_relaxed);
        }
        return (checked & 1) != 0;
    }

    const std::uint8_t* states(int group) const { return states_[static_cast<std::size_t>(group)].get(); }
    std::uint8_t* states(int group) { return states_[static_cast<std::size_t>(group)].get(); }
    std::uint8_t* evidence(int group) { return evidence_[static_cast<std::size_t>(group)].get(); }

    /// Gives a record a pyramid of unknown states inside its rim; true if this call did. Thread-safe. False and no
    /// pyramid when full.
    bool create(RecordId record, std::uint32_t level, const RimCodes& rim);
    /// Gives a record a deeper pyramid that holds what the old one knew. Between frames only. False when full.
    bool deepen(RecordId record, std::uint32_t level);
    /// Drops what was last seen before `frame`, least recently seen first, until half the room is free. Between frames.
    void drop_unseen(std::uint32_t frame);
    /// Takes a record's pyramid away; true if it had one. Between frames.
    bool drop(RecordId record);
    /// Forgets what a record says of one light, but for NONE. Between frames.
    void reopen(RecordId record, int light);
    /// Forgets one light everywhere. Between frames.
    void forget_light(int light);
    void forget_everything();

    bool full() const { return full_.load(std::memory_order_relaxed); }
    std::size_t live_records() const { return live_; }
    /// States and evidence in use, and the record table's live entries.
    std::size_t bytes() const;

 private:
    struct Record {
        std::atomic<std::uint32_t> base{k_no_slot};
        std::atomic<std::uint32_t> seen{0};
        std::atomic<std::uint32_t> checked{0};   // twice the frame in which `coarse` was asked, and the answer
        std::uint8_t level = 0;
        RimCodes rim;
    };
    struct Free {
        void operator()(std::uint8_t* p) const { std::free(p); }
    };
    using Block = std::unique_ptr<std::uint8_t, Free>;

    std::uint32_t allocate(std::uint32_t level);   // under the lock
    void release(std::uint32_t base, std::uint32_t level);

    std::unique_ptr<Record[]> records_;
    std::size_t record_count_;
    std::vector<Block> states_, evidence_;
    std::uint32_t capacity_ = 0, end_ = 0;
    std::size_t used_ = 0, live_ = 0;
    std::vector<std::uint32_t> free_[k_max_level + 1];
    std::vector<RecordId> with_pyramid_;   // and some that were dropped since
    std::atomic<bool> full_ = false;
    std::mutex mutex_;
};

}   // namespace gnomon::shadow_culling
