// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/shadow_memory.h"

#include <algorithm>
#include <cstring>
#include <new>

#include "base/check.h"

namespace gnomon::shadow_culling {

ShadowMemory::ShadowMemory(std::size_t records, int lights, std::size_t budget)
    : records_(std::make_unique<Record[]>(records)), record_count_(records)
{
    const int groups = (lights + k_lights_per_group - 1) / k_lights_per_group;
    const std::size_t each = groups > 0 ? budget / (2 * static_cast<std::size_t>(groups)) : 0;
    capacity_ = static_cast<std::uint32_t>(std::min<std::size_t>(each, k_no_slot - 1));
    for (int g = 0; g < groups; ++g) {
        for (std::vector<Block>* blocks : {&states_, &evidence_}) {
            auto* block = static_cast<std::uint8_t*>(std::calloc(capacity_ + k_read_pad, 1));
            if (!block) throw std::bad_alloc();
            blocks->emplace_back(block);
        }
    }
}

std::uint32_t ShadowMemory::allocate(std::uint32_t level)
{
    const std::uint32_t size = pyramid_size(level);
    std::uint32_t base = k_no_slot;
    if (!free_[level].empty()) {
        base = free_[level].back();
        free_[level].pop_back();
    } else if (size <= capacity_ - end_) {
        base = end_;
        end_ += size;
    } else {
        full_.store(true, std::memory_order_relaxed);
        return k_no_slot;
    }
    used_ += size;
    return base;
}

void ShadowMemory::release(std::uint32_t base, std::uint32_t level)
{
    const std::uint32_t size = pyramid_size(level);
    for (std::size_t g = 0; g < states_.size(); ++g) {
        std::memset(states_[g].get() + base, 0, size);
        std::memset(evidence_[g].get() + base, 0, size);
    }
    free_[level].push_back(base);
    used_ -= size;
}

bool ShadowMemory::create(RecordId id, std::uint32_t level, const RimCodes& rim)
{
    GNOMON_CHECK_LT(id, record_count_);
    const std::lock_guard lock(mutex_);
    Record& record = records_[id];
    if (record.base.load(std::memory_order_relaxed) != k_no_slot) return false;
    const std::uint32_t base = allocate(std::min(level, k_max_level));
    if (base == k_no_slot) return false;
    record.level = static_cast<std::uint8_t>(std::min(level, k_max_level));
    record.rim = rim;
    record.base.store(base, std::memory_order_release);
    with_pyramid_.push_back(id);
    ++live_;
    return true;
}

bool ShadowMemory::deepen(RecordId id, std::uint32_t level)
{
    Record& record = records_[id];
    const std::uint32_t old_base = record.base.load(std::memory_order_relaxed), old_level = record.level;
    level = std::min(level, k_max_level);
    if (old_base == k_no_slot || level <= old_level) return false;
    const std::uint32_t base = allocate(level);
    if (base == k_no_slot) return false;

    for (std::size_t g = 0; g < states_.size(); ++g) {
        std::uint8_t* const states = states_[g].get();
        std::memcpy(states + base, states + old_base, pyramid_size(old_level));
        // Hand what is decided down to the new levels; partial parts are open again below.
        for (std::uint32_t k = old_level + 1; k <= level; ++k) {
            const std::uint32_t parts = 1u << (2 * k);
            for (std::uint32_t i = 0; i < parts; ++i) {
                const MicroTriangle parent = parent_of(micro_at(i, k));
                std::uint8_t state = states[base + pyramid_offset(k - 1) + micro_index(parent, k - 1)];
                const std::uint8_t partial = state & static_cast<std::uint8_t>(state >> 1) & 0x55;
                state &= static_cast<std::uint8_t>(~(partial * 3));
                states[base + pyramid_offset(k) + i] = state;
            }
        }
    }
    release(old_base, old_level);
    record.level = static_cast<std::uint8_t>(level);
    record.base.store(base, std::memory_order_relaxed);
    return true;
}

bool ShadowMemory::drop(RecordId id)
{
    Record& record = records_[id];
    const std::uint32_t base = record.base.load();
    if (base == k_no_slot) return false;
    release(base, record.level);
    record.base.store(k_no_slot);
    --live_;
    return true;
}

void ShadowMemory::reopen(RecordId id, int light)
{
    const Record& record = records_[id];
    const std::uint32_t base = record.base.load();
    if (base == k_no_slot) return;
    std::uint8_t* const states = states_[static_cast<std::size_t>(light / k_lights_per_group)].get() + base;
    const int shift = 2 * (light % k_lights_per_group);
    for (std::uint32_t i = 0; i < pyramid_size(record.level); ++i)
        if (static_cast<ShadowState>((states[i] >> shift) & 3) != ShadowState::none)
            states[i] &= static_cast<std::uint8_t>(~(3u << shift));
}

void ShadowMemory::drop_unseen(std::uint32_t frame)
{
    std::erase_if(with_pyramid_, [&](RecordId id) { return records_[id].base.load() == k_no_slot; });
    std::sort(with_pyramid_.begin(), with_pyramid_.end(), [&](RecordId a, RecordId b) {
        const auto seen_a = records_[a].seen.load(), seen_b = records_[b].seen.load();
        return seen_a != seen_b ? seen_a > seen_b : a < b;
    });
    while (!with_pyramid_.empty() && used_ > capacity_ / 2) {
        if (records_[with_pyramid_.back()].seen.load() >= frame) break;
        drop(with_pyramid_.back());
        with_pyramid_.pop_back();
    }
    full_.store(false);
}

void ShadowMemory::forget_light(int light)
{
    const auto group = static_cast<std::size_t>(light / k_lights_per_group);
    const auto keep = static_cast<std::uint8_t>(~(3 << (2 * (light % k_lights_per_group))));
    std::uint8_t *const states = states_[group].get(), *const evidence = evidence_[group].get();
    for (std::uint32_t i = 0; i < end_; ++i) states[i] &= keep;
    for (std::uint32_t i = 0; i < end_; ++i) evidence[i] &= keep;
}

void ShadowMemory::forget_everything()
{
    for (std::size_t g = 0; g < states_.size(); ++g) {
        std::memset(states_[g].get(), 0, end_);
        std::memset(evidence_[g].get(), 0, end_);
    }
}

std::size_t ShadowMemory::bytes() const
{
    return 2 * used_ * states_.size() + live_ * (sizeof(Record) + sizeof(RecordId));
}

}   // namespace gnomon::shadow_culling
