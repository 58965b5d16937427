// SPDX-License-Identifier: Apache-2.0
#include "scene/memory_budget.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/one_line.h"
#include "gnomon/error.h"

namespace gnomon::scene {

namespace {

// The texture without its finest level.
Texture halved(const Texture& texture)
{
    if (texture.levels().size() > 1) return {texture.name(), texture.levels()[1], texture.srgb(), texture.sampler()};
    Sampler with_levels = texture.sampler();
    with_levels.mipmaps = true;
    const Texture all(texture.name(), texture.levels()[0], texture.srgb(), with_levels);
    return {texture.name(), all.levels()[1], texture.srgb(), texture.sampler()};
}

}   // namespace

void MemoryBudget::take(std::uint64_t bytes, const std::string& file, const std::string& place, const std::string& what)
{
    if (bytes > bytes_ - taken_)
        throw InputError(file, place,
                         fmt::format("{} would take more memory than the {} MB that a file may ask for (--memory)",
                                     what, bytes_ >> 20));
    taken_ += bytes;
}

void MemoryBudget::fit(SharedList<Texture>& textures)
{
    for (std::size_t t = halved_.size(); t < textures.size(); ++t) {
        halved_.push_back(0);
        in_textures_ += textures[t].bytes();
        largest_.push({textures[t].bytes(), t});
    }
    while (in_textures_ > bytes_ - taken_ && !largest_.empty()) {
        const Size size = largest_.top();
        largest_.pop();
        const Texture& texture = textures[size.texture];
        if (texture.width() == 1 && texture.height() == 1) continue;
        Texture smaller = halved(texture);
        ++halved_[size.texture];
        in_textures_ -= size.bytes - smaller.bytes();
        largest_.push({smaller.bytes(), size.texture});
        textures.replace(size.texture, std::move(smaller));
    }
}

std::string MemoryBudget::warning(const SharedList<Texture>& textures) const
{
    const auto count = std::ranges::count_if(halved_, [](int times) { return times > 0; });
    if (count == 0) return {};
    const auto first =
        static_cast<std::size_t>(std::ranges::find_if(halved_, [](int times) { return times > 0; }) - halved_.begin());
    return fmt::format("{} {} halved, once or more, to stay within {} MB (--memory): '{}' has {} x {} texels{}", count,
                       count == 1 ? "texture was" : "textures were", bytes_ >> 20, shown_name(textures[first].name()),
                       textures[first].width(), textures[first].height(), count == 1 ? "" : ", and so on");
}

}   // namespace gnomon::scene
