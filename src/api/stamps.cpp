// SPDX-License-Identifier: Apache-2.0
#include "api/stamps.h"

#include <algorithm>
#include <atomic>
#include <limits>

namespace gnomon::api {

std::uint32_t new_stamps(std::size_t count)
{
    static std::atomic<std::uint32_t> next{1};
    std::uint32_t first = next.load(std::memory_order_relaxed), after = 0;
    do {
        // Begin again at 1 rather than run through 0.
        if (count >= std::numeric_limits<std::uint32_t>::max() - first) first = 1;
        after = first + static_cast<std::uint32_t>(count);
    } while (!next.compare_exchange_weak(first, after, std::memory_order_relaxed));
    return first;
}

StampList::StampList(std::size_t count) : stamps_(count)
{
    std::uint32_t stamp = new_stamps(count);
    for (std::uint32_t& own : stamps_) own = stamp++;
}

std::uint32_t StampList::renew(std::size_t index)
{
    if (index == stamps_.size()) stamps_.push_back(0);
    return stamps_[index] = new_stamps(1);
}

std::uint32_t StampList::search(std::uint32_t index, std::uint32_t stamp) const
{
    if (stamp == 0) return scene::none;
    if (index < stamps_.size() && stamps_[index] == stamp) return index;
    const auto at = std::find(stamps_.begin(), stamps_.end(), stamp);
    return at == stamps_.end() ? scene::none : static_cast<std::uint32_t>(at - stamps_.begin());
}

SceneStamps::SceneStamps(const scene::Scene& scene)
    : nodes(scene.nodes.size()),
      meshes(scene.meshes.size()),
      materials(scene.materials.size()),
      textures(scene.textures.size()),
      skins(scene.skins.size()),
      lights(scene.lights.size()),
      cameras(scene.cameras.size())
{
}

}   // namespace gnomon::api
