// SPDX-License-Identifier: Apache-2.0
#include "scene/memory_budget.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/one_line.h"
#include "gnomon/error.h"
#include "scene/reduced_image.h"

namespace gnomon::scene {

namespace {

Texture halved(const Texture& texture)
{
    if (texture.levels().size() > 1) return {texture.name(), texture.levels()[1], texture.srgb(), texture.sampler()};
    return {texture.name(), reduced_rgba(texture.levels()[0], texture.srgb(), 1), texture.srgb(), texture.sampler()};
}

}   // namespace

// All levels are counted, also where the texture has one alone, and beside them what it takes for a moment to make a
// halved texture of an image.
std::uint64_t MemoryBudget::Entry::bytes() const
{
    constexpr std::uint64_t k_texel = 4;   // bytes
    auto w = static_cast<std::uint64_t>(width), h = static_cast<std::uint64_t>(height);
    std::uint64_t sum = id == none && halvings > 0 ? k_texel * w * h : 0;
    while (true) {
        sum += k_texel * w * h;
        if (w == 1 && h == 1) return sum;
        w = std::max<std::uint64_t>(1, w / 2), h = std::max<std::uint64_t>(1, h / 2);
    }
}

void MemoryBudget::refuse(const Asker& asker) const
{
    throw InputError(asker.file, asker.place,
                     fmt::format("{} would take more memory than the {} MB that a file may ask for (--memory)",
                                 asker.what, bytes_ >> 20));
}

void MemoryBudget::take(std::uint64_t bytes, SharedList<Texture>& textures, const Asker& asker)
{
    if (bytes > bytes_ - taken_) refuse(asker);
    make_room(bytes, textures, asker);
    taken_ += bytes;
}

MemoryBudget::Expected MemoryBudget::expect(int width, int height)
{
    const Expected result = entries_.size();
    entries_.push_back({width, height});
    in_textures_ += entries_.back().bytes();
    largest_.push({entries_.back().bytes(), result});
    return result;
}

void MemoryBudget::made(Expected texture, TextureId id)
{
    Entry& entry = entries_[texture];
    in_textures_ -= entry.bytes();
    entry.id = id;
    in_textures_ += entry.bytes();
    if (entry.halvings > 0) largest_.push({entry.bytes(), texture});
}

void MemoryBudget::left_out(Expected texture)
{
    if (entries_[texture].counts) in_textures_ -= entries_[texture].bytes();
    entries_[texture].counts = false;
}

void MemoryBudget::make_room(std::uint64_t bytes, SharedList<Texture>& textures, const Asker& asker)
{
    if (bytes > bytes_ - taken_) refuse(asker);
    const std::uint64_t left = bytes_ - taken_ - bytes;
    while (!largest_.empty()) {
        const Size size = largest_.top();
        Entry& entry = entries_[size.entry];
        const bool outdated = !entry.counts || size.bytes != entry.bytes();
        // Keep a quarter of the largest texture, which it takes for a moment to halve it.
        if (!outdated && in_textures_ + size.bytes / 4 <= left) return;
        largest_.pop();
        if (outdated || (entry.width == 1 && entry.height == 1)) continue;
        entry.width = std::max(1, entry.width / 2), entry.height = std::max(1, entry.height / 2);
        ++entry.halvings;
        if (entry.id != none) textures.replace(entry.id, halved(textures[entry.id]));
        in_textures_ = in_textures_ - size.bytes + entry.bytes();
        largest_.push({entry.bytes(), size.entry});
    }
    if (in_textures_ > left) refuse(asker);
}

Texture MemoryBudget::make(Expected texture, std::string name, const Image8& image, bool srgb, const Sampler& sampler,
                           bool without_alpha) const
{
    const int halvings = entries_[texture].halvings;
    if (halvings == 0 && !(without_alpha && image.channels % 2 == 0)) return {std::move(name), image, srgb, sampler};
    return {std::move(name), reduced_rgba(image, srgb, halvings, without_alpha), srgb, sampler};
}

std::string MemoryBudget::warning(const SharedList<Texture>& textures) const
{
    const auto was_halved = [](const Entry& entry) { return entry.halvings > 0 && entry.id != none; };
    const auto count = std::ranges::count_if(entries_, was_halved);
    if (count == 0) return {};
    const Texture& first = textures[std::ranges::find_if(entries_, was_halved)->id];
    return fmt::format("{} {} halved, once or more, to stay within {} MB (--memory): '{}' has {} x {} texels{}", count,
                       count == 1 ? "texture was" : "textures were", bytes_ >> 20, shown_name(first.name()),
                       first.width(), first.height(), count == 1 ? "" : ", and so on");
}

}   // namespace gnomon::scene
