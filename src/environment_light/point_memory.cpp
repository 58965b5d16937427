// SPDX-License-Identifier: Apache-2.0
#include "environment_light/point_memory.h"

#include <bit>

namespace gnomon::environment_light {

namespace {

std::size_t hash_of(std::uint64_t a, std::uint64_t b)
{
    std::uint64_t h = (a ^ (b >> 32) ^ (b << 29)) * 0x9e3779b97f4a7c15ull + b * 0xc2b2ae3d27d4eb4full;
    h ^= h >> 32;
    return static_cast<std::size_t>(h * 0x165667b19e3779f9ull >> 20);
}

}   // namespace

PointMemory::Key PointMemory::key_of(const visibility::ShadowPoint& point)
{
    // Objects and triangles have fewer than 2^31 numbers; the side has the bit between them.
    return {(std::uint64_t{point.object} << 33) ^ (std::uint64_t{point.front} << 32) ^ point.triangle,
            (std::uint64_t{std::bit_cast<std::uint32_t>(point.u)} << 32) | std::bit_cast<std::uint32_t>(point.v)};
}

const PointMemory::Entry* PointMemory::Table::find(const Key& key) const
{
    if (entries.empty()) return nullptr;
    const std::size_t mask = entries.size() - 1;
    for (std::size_t at = hash_of(key.triangle, key.place) & mask;; at = (at + 1) & mask) {
        if (!entries[at].masks) return nullptr;
        if (entries[at].key == key) return &entries[at];
    }
}

// @param added  with any `first` and `first_part`
void PointMemory::Table::add(const Entry& added, const std::uint64_t* words, const KnownParts* first_part)
{
    const Key key = added.key;
    if (2 * (count + 1) > entries.size()) {
        std::vector<Entry> old =
            std::exchange(entries, std::vector<Entry>(std::max<std::size_t>(64, 2 * entries.size())));
        count = 0;
        const std::size_t mask = entries.size() - 1;
        for (const Entry& entry : old) {
            if (!entry.masks) continue;
            std::size_t at = hash_of(entry.key.triangle, entry.key.place) & mask;
            while (entries[at].masks) at = (at + 1) & mask;
            entries[at] = entry;
            ++count;
        }
    }
    const std::size_t mask = entries.size() - 1;
    std::size_t at = hash_of(key.triangle, key.place) & mask;
    while (entries[at].masks && entries[at].key != key) at = (at + 1) & mask;
    if (!entries[at].masks) ++count;   // else more is known now
    entries[at] = added;
    entries[at].first = static_cast<std::uint32_t>(seen.size());
    seen.insert(seen.end(), words, words + added.words);
    entries[at].first_part = static_cast<std::uint32_t>(parts.size());
    parts.insert(parts.end(), first_part, first_part + added.parts);
}

void PointMemory::begin_frame()
{
    std::swap(now_, before_);
    now_.entries.assign(now_.entries.size(), {});
    now_.seen.clear();
    now_.parts.clear();
    now_.count = 0;
    // Give memory back that a view no longer needs.
    if (before_.count * 8 < now_.entries.size()) now_ = {};
}

PointMemory::Known PointMemory::find(const visibility::ShadowPoint& point)
{
    const Key key = key_of(point);
    const Entry* entry = now_.find(key);
    if (!entry) {
        const Entry* old = before_.find(key);
        if (!old) return {};
        now_.add(*old, before_.seen.data() + old->first, before_.parts.data() + old->first_part);
        entry = now_.find(key);
    }
    const std::uint64_t* bits = now_.seen.data() + entry->first;
    return {entry->masks,
            entry->cells,
            bits,
            bits + entry->words / 2,
            {now_.parts.data() + entry->first_part, entry->parts}};
}

void PointMemory::add(const visibility::ShadowPoint& point, const PartMasks& masks, std::uint32_t cells,
                      const std::vector<std::uint64_t>& bits, std::span<const KnownParts> parts)
{
    now_.add({key_of(point), &masks, 0, static_cast<std::uint32_t>(bits.size()), cells, 0,
              static_cast<std::uint32_t>(parts.size())},
             bits.data(), parts.data());
}

}   // namespace gnomon::environment_light
