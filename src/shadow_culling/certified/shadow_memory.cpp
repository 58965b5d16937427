// SPDX-License-Identifier: Apache-2.0
// Allocates and drops records and evidence. The layout of a record's states is in shadow_parts.cpp.
#include "shadow_culling/certified/shadow_memory.h"

#include <algorithm>
#include <cstring>
#include <new>

#include "base/check.h"

namespace gnomon::shadow_culling {

namespace {

// Size of a pyramid of so many levels: whole, or the upper levels with the table of pieces.
constexpr std::uint32_t size_of_class(std::uint32_t level)
{
    if (level <= k_piece_levels) return pyramid_size(level);
    const std::uint32_t above = level - k_piece_levels;
    return static_cast<std::uint32_t>(sizeof(std::uint32_t) << (2 * above)) + pyramid_size(above);
}

}   // namespace

ShadowMemory::ShadowMemory(std::size_t records, int lights, std::size_t budget)
    : records_(std::make_unique<Record[]>(records)),
      record_count_(records),
      evidence_(std::make_unique<std::atomic<std::uint8_t*>[]>(records)),
      evidence_room_(budget / 2)
{
    const int groups = (lights + k_lights_per_group - 1) / k_lights_per_group;
    const std::size_t each = groups > 0 ? budget / (2 * static_cast<std::size_t>(groups)) : 0;
    capacity_ = static_cast<std::uint32_t>(std::min<std::size_t>(each, k_has_piece - 1));
    for (int g = 0; g < groups; ++g) {
        auto* block = static_cast<std::uint8_t*>(std::calloc(capacity_ + k_read_pad, 1));
        if (!block) throw std::bad_alloc();
        states_.emplace_back(block);
    }
}

ShadowMemory::~ShadowMemory()
{
    for (const RecordId id : with_states_) take_evidence(id);
}

std::uint32_t ShadowMemory::allocate(std::uint32_t size_class)
{
    const std::lock_guard lock(mutex_);
    return allocate_under_lock(size_class);
}

std::uint32_t ShadowMemory::allocate_under_lock(std::uint32_t size_class)
{
    const std::uint32_t size = size_of_class(size_class);
    if (free_[size_class].empty()) {
        if (size <= capacity_ - end_) {
            end_ += size;
            used_ += size;
            return end_ - size;
        }
        // Split a larger free block. (A deeper pyramid in pieces takes less than a whole one.)
        std::uint32_t larger = size_class + 1;
        while (larger <= k_max_level && (free_[larger].empty() || size_of_class(larger) < size)) ++larger;
        if (larger > k_max_level) {
            full_.store(true, std::memory_order_relaxed);
            return k_no_slot;
        }
        const std::uint32_t whole = free_[larger].back();
        free_[larger].pop_back();
        for (std::uint32_t at = 0; at + size <= size_of_class(larger); at += size)
            free_[size_class].push_back(whole + at);
    }
    const std::uint32_t base = free_[size_class].back();
    free_[size_class].pop_back();
    used_ += size;
    return base;
}

void ShadowMemory::release(std::uint32_t base, std::uint32_t size_class)
{
    const std::uint32_t size = size_of_class(size_class);
    for (const Block& block : states_) std::memset(block.get() + base, 0, size);
    const std::lock_guard lock(mutex_);
    free_[size_class].push_back(base);
    used_ -= size;
}

bool ShadowMemory::create(RecordId id, std::uint32_t level, const RimCodes& rim)
{
    GNOMON_CHECK_LT(id, record_count_);
    const std::lock_guard lock(mutex_);
    Record& record = records_[id];
    if (record.begin.load(std::memory_order_relaxed) != k_no_slot) return false;
    const std::uint32_t base = allocate_under_lock(0);
    if (base == k_no_slot) return false;
    record.level = static_cast<std::uint8_t>(std::min(level, k_max_level)) & 0x7f;
    record.open = false;
    record.rim = rim;
    record.begin.store(base, std::memory_order_release);
    with_states_.push_back(id);
    ++live_;
    return true;
}

std::uint8_t* ShadowMemory::evidence(RecordId id)
{
    if (std::uint8_t* const there = evidence_[id].load(std::memory_order_acquire)) return there;
    const std::lock_guard lock(mutex_);
    if (std::uint8_t* const there = evidence_[id].load(std::memory_order_relaxed)) return there;
    const std::size_t size = evidence_size(level(id));
    if (evidence_bytes_ + size > evidence_room_) return nullptr;
    evidence_bytes_ += size;
    most_evidence_ = std::max(most_evidence_, evidence_bytes_.load());
    std::uint8_t* const made = new std::uint8_t[size]();
    evidence_[id].store(made, std::memory_order_release);
    return made;
}

ShadowMemory::Evidence ShadowMemory::take_evidence(RecordId id)
{
    Evidence taken(evidence_[id].exchange(nullptr, std::memory_order_acquire));
    if (taken) evidence_bytes_ -= evidence_size(level(id));
    return taken;
}

bool ShadowMemory::drop(RecordId id)
{
    if (!has(id)) return false;
    take_evidence(id);
    release(shape_of(id));
    records_[id].begin.store(k_no_slot);
    records_[id].open = false;
    --live_;
    return true;
}

void ShadowMemory::drop_unseen(std::uint32_t frame)
{
    std::erase_if(with_states_, [&](RecordId id) { return !has(id); });
    std::sort(with_states_.begin(), with_states_.end(), [&](RecordId a, RecordId b) {
        const auto seen_a = records_[a].seen.load(), seen_b = records_[b].seen.load();
        return seen_a != seen_b ? seen_a > seen_b : a < b;
    });
    while (!with_states_.empty() && used_ > capacity_ / 2) {
        if (records_[with_states_.back()].seen.load() >= frame) break;
        drop(with_states_.back());
        with_states_.pop_back();
    }
    full_.store(false);
}

void ShadowMemory::forget_light(int light)
{
    for (const RecordId id : with_states_)
        if (has(id)) forget_in(shape_of(id), light, false);
    const std::size_t group = static_cast<std::size_t>(light / k_lights_per_group);
    const auto keep = static_cast<std::uint8_t>(~(3 << (2 * (light % k_lights_per_group))));
    for (const RecordId id : with_states_)
        if (std::uint8_t* const evidence = evidence_[id].load()) {
            const std::size_t parts = std::size_t{1} << (2 * level(id));
            for (std::size_t i = group * parts; i < (group + 1) * parts; ++i) evidence[i] &= keep;
        }
}

void ShadowMemory::reopen(RecordId id, int light)
{
    if (has(id)) forget_in(shape_of(id), light, true);
}

std::size_t ShadowMemory::bytes() const
{
    return used_ * states_.size() + evidence_bytes_.load() +
           live_ * (sizeof(Record) + sizeof(std::uint8_t*) + sizeof(RecordId));
}

}   // namespace gnomon::shadow_culling
