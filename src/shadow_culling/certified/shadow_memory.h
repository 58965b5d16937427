// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stores the remembered states: a pyramid per side of each static triangle, one byte per part and group of four lights.
//
// The four states are those of [Nah 2009, 2.1], for smaller parts. Only differences are stored. A record begins as one
// byte for the whole triangle; once that is PARTIAL, the record is opened. A pyramid of few levels is then stored
// whole. Of a deeper one, the upper levels are stored, and below them one piece of k_piece_levels for each part that is
// PARTIAL. A part that is decided, or was never seen, has no piece; its byte in the upper levels holds for all of it.
//
//   closed        [state]
//   open, flat    [states of levels 0 ... level]
//   open, pieces  [table: 4 bytes per piece][states of levels 0 ... level - k_piece_levels], and pieces elsewhere
//
// Invariant: a part that is PARTIAL at a level above the finest is open below.
//
// Evidence is the results of rays in the finest parts since a record was last judged. It is stored only for records
// with new results, and freed when they are judged.
//
// Memory is one block per group of four lights, reserved at the start (the system commits pages as they are touched)
// and allocated by size class. When it is full, the least recently seen records are dropped. Threads may look up states
// and add records and evidence concurrently. Only the one task that judges a record opens it. Records are deepened and
// dropped between frames.

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <vector>

#include "base/micro_triangles.h"
#include "shadow_culling/certified/rim.h"

namespace gnomon::shadow_culling {

enum class ShadowState : std::uint8_t { unknown = 0, none = 1, full = 2, partial = 3 };

/// Evidence bits of one light: some ray was free, some ray was occluded by static geometry.
inline constexpr std::uint8_t k_saw_free = 1, k_saw_occluded = 2;

inline constexpr int k_lights_per_group = 4;
inline constexpr std::uint32_t k_no_slot = 0xffffffffu;
inline constexpr std::uint32_t k_max_level = 8;
/// Levels of a piece, below its part.
inline constexpr std::uint32_t k_piece_levels = 4;
/// Look-ups may read so many bytes beyond a part's state.
inline constexpr std::size_t k_read_pad = 3;

/// An entry of a table of pieces: the address of the finest states, and this bit if there is a piece. Without a piece
/// it is the address of the part's one byte in the upper levels.
inline constexpr std::uint32_t k_has_piece = 0x80000000u;

/// Record of one side of one static triangle: 2 * triangle + (front ? 0 : 1).
using RecordId = std::uint32_t;
inline constexpr RecordId k_no_record = k_no_slot;   // of points on dynamic objects

class ShadowMemory {
 public:
    /// @param records  largest number: twice the static triangles
    /// @param budget   bytes of states and evidence over all groups
    ShadowMemory(std::size_t records, int lights, std::size_t budget);
    ~ShadowMemory();
    ShadowMemory(const ShadowMemory&) = delete;
    ShadowMemory& operator=(const ShadowMemory&) = delete;

    int groups() const { return static_cast<int>(states_.size()); }

    /// Whether a record is remembered.
    bool has(RecordId record) const { return records_[record].begin.load(std::memory_order_acquire) != k_no_slot; }
    /// The finest level of its parts.
    std::uint32_t level(RecordId record) const { return records_[record].level; }
    Rim rim(RecordId record) const { return Rim(records_[record].rim); }

    /// Where look-ups begin.
    struct Place {
        std::uint32_t begin;   // address of the finest states; with pieces: of their table, in the block of the first
                               // group; k_no_slot: not remembered
        std::uint32_t level;   // of the states or table entries there
        bool pieces;
    };
    Place place(RecordId id) const
    {
        const Record& record = records_[id];
        const std::uint32_t begin = record.begin.load(std::memory_order_acquire);
        if (begin == k_no_slot) return {k_no_slot, 0, false};   // `create` may still be writing the rest
        const std::uint32_t level = record.level;
        if (!record.open) return {begin, 0, false};
        return level <= k_piece_levels ? Place{begin, level, false} : Place{begin, level - k_piece_levels, true};
    }

    void note_seen(RecordId record, std::uint32_t frame)
    {
        if (records_[record].seen.load(std::memory_order_relaxed) != frame)
            records_[record].seen.store(frame, std::memory_order_relaxed);
    }

    /// Whether a record should be deeper in this frame's view. Calls `ask` once per frame and keeps its result.
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

    /// The evidence by group and finest part, zero at first; set its bits atomically. Thread-safe. Null when full.
    std::uint8_t* evidence(RecordId record);
    using Evidence = std::unique_ptr<std::uint8_t[]>;
    /// What was noted since it was last taken; null: nothing. Thread-safe.
    Evidence take_evidence(RecordId record);

    /// Remembers a record, unknown and closed, inside its rim; true if this call did. Thread-safe. False and nothing
    /// remembered when full.
    bool create(RecordId record, std::uint32_t level, const RimCodes& rim);
    /// The address of a part's state in the block of each group; of the enclosing part if it has none of its own.
    std::uint32_t address(RecordId record, const MicroTriangle& part, std::uint32_t at_level) const;
    /// Whether the quarters of a part have states of their own.
    bool is_open(RecordId record, const MicroTriangle& part, std::uint32_t at_level) const;
    /// Gives the quarters of a part states of their own: those decided above, else unknown. By one thread per record.
    /// False when full.
    bool open(RecordId record, const MicroTriangle& part, std::uint32_t at_level);
    /// Increases a record's level and keeps its states. Between frames. False when full.
    bool deepen(RecordId record, std::uint32_t level);
    /// Drops records last seen before `frame`, least recently seen first, until half the memory is free. Between
    /// frames.
    void drop_unseen(std::uint32_t frame);
    /// Drops a record; true if there was one. Between frames.
    bool drop(RecordId record);
    /// Forgets a record's states for one light, except NONE. Between frames.
    void reopen(RecordId record, int light);
    /// Forgets all states of one light. Between frames.
    void forget_light(int light);

    bool full() const { return full_.load(std::memory_order_relaxed); }
    std::size_t live_records() const { return live_; }
    /// Bytes of states and evidence in use, and of the live entries of the record table.
    std::size_t bytes() const;
    /// The largest size of the evidence so far.
    std::size_t most_evidence_bytes() const { return most_evidence_; }

 private:
    struct Record {
        std::atomic<std::uint32_t> begin{k_no_slot};   // where look-ups begin
        std::atomic<std::uint32_t> seen{0};
        std::atomic<std::uint32_t> checked{0};   // twice the frame of the last `coarse`, plus its result
        std::uint8_t level : 7 = 0;
        std::uint8_t open : 1 = 0;
        RimCodes rim;
    };
    // Determines the layout of a record's states.
    struct Shape {
        std::uint32_t base, level;
        bool open;
        bool in_pieces() const { return open && level > k_piece_levels; }
        // Where look-ups begin.
        std::uint32_t begin() const { return open && !in_pieces() ? base + pyramid_offset(level) : base; }
    };
    struct Free {
        void operator()(std::uint8_t* p) const { std::free(p); }
    };
    using Block = std::unique_ptr<std::uint8_t, Free>;
    Shape shape_of(RecordId record) const;
    std::uint32_t address_in(const Shape& shape, const MicroTriangle& part, std::uint32_t at_level) const;
    std::uint32_t allocate(std::uint32_t size_class);
    std::uint32_t allocate_under_lock(std::uint32_t size_class);
    void release(std::uint32_t base, std::uint32_t size_class);
    void release(const Shape& shape);
    std::uint32_t entry(const Shape& shape, std::uint32_t piece) const;
    void set_entry(const Shape& shape, std::uint32_t piece, std::uint32_t entry);
    bool add_piece(const Shape& shape, std::uint32_t piece);
    void hand_down(const Shape& from, const Shape& to);
    void hand_piece_down(const Shape& from, const Shape& to, std::uint32_t piece);
    template <class Change>
    void for_each_range(const Shape& shape, const Change& change) const;
    void forget_in(const Shape& shape, int light, bool but_none);
    std::size_t evidence_size(std::uint32_t level) const { return states_.size() << (2 * level); }

    std::unique_ptr<Record[]> records_;
    std::size_t record_count_;
    std::vector<Block> states_;
    std::uint32_t capacity_ = 0, end_ = 0;
    std::size_t used_ = 0, live_ = 0;
    std::vector<std::uint32_t> free_[k_max_level + 1];
    std::vector<RecordId> with_states_;                        // also some that were dropped since
    std::unique_ptr<std::atomic<std::uint8_t*>[]> evidence_;   // by record; null: none
    std::size_t evidence_room_ = 0;
    std::atomic<std::size_t> evidence_bytes_ = 0;
    std::size_t most_evidence_ = 0;
    std::atomic<bool> full_ = false;
    std::mutex mutex_;   // of the allocator
};

}   // namespace gnomon::shadow_culling
