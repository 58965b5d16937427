// SPDX-License-Identifier: Apache-2.0
#include "trace/place_groups.h"

#include <algorithm>

#include "base/interruption.h"
#include "base/math.h"

namespace gnomon::trace {

namespace {

constexpr int k_bits = TriangleRuns::k_levels - 1;   // of the curve, by axis
constexpr std::uint32_t k_steps = 1u << k_bits;
constexpr std::size_t k_least_run = 8;   // triangles for which one stands in
static_assert(3 * k_bits + 5 <= 32);

std::uint32_t every_third_bit(std::uint32_t x)
{
    x = (x | (x << 16)) & 0x030000ffu;
    x = (x | (x << 8)) & 0x0300f00fu;
    x = (x | (x << 4)) & 0x030c30c3u;
    return (x | (x << 2)) & 0x09249249u;
}

std::uint32_t code_of(const glm::vec3& at, const glm::vec3& low, float cube)
{
    std::uint32_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const float step = std::clamp((at[axis] - low[axis]) / cube, 0.0f, static_cast<float>(k_steps - 1));
        code |= every_third_bit(static_cast<std::uint32_t>(step)) << axis;
    }
    return code;
}

// The quarter of the side of a cube that a normal passes: 0 to 23.
std::uint32_t facing_of(const glm::vec3& normal)
{
    const glm::vec3 size = glm::abs(normal);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto is_positive = [&](int of) { return static_cast<std::uint32_t>(normal[of] > 0); };
    return static_cast<std::uint32_t>(axis) * 8 + is_positive(axis) * 4 + is_positive((axis + 1) % 3) * 2 +
           is_positive((axis + 2) % 3);
}

}   // namespace

TriangleRuns::TriangleRuns(const scene::Mesh& mesh)
{
    const Box3 box = mesh.bounds();
    const glm::vec3 size = box.empty() ? glm::vec3(0) : box.high - box.low;
    least_cube_ = std::max({size.x, size.y, size.z}) / static_cast<float>(k_steps);
    place_of_.assign(mesh.triangles.size(), scene::none);
    if (!(least_cube_ > 0)) return;

    // Sort the triangles that have an area by facing and place.
    std::vector<std::uint64_t> keys;
    keys.reserve(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const glm::uvec3& index = mesh.triangles[t];
        const glm::vec3 &a = mesh.positions[index[0]], &b = mesh.positions[index[1]], &c = mesh.positions[index[2]];
        const glm::vec3 normal = glm::cross(b - a, c - a);
        if (!(glm::dot(normal, normal) > 0)) continue;
        const std::uint32_t code = facing_of(normal) << 3 * k_bits | code_of((a + b + c) / 3.0f, box.low, least_cube_);
        keys.push_back(std::uint64_t{code} << 32 | t);
    }
    interruption_point();
    std::ranges::sort(keys);
    codes_.reserve(keys.size()), triangles_.reserve(keys.size());
    for (const std::uint64_t key : keys) {
        place_of_[static_cast<std::uint32_t>(key)] = static_cast<std::uint32_t>(codes_.size());
        codes_.push_back(static_cast<std::uint32_t>(key >> 32));
        triangles_.push_back(static_cast<std::uint32_t>(key));
    }
}

std::uint32_t TriangleRuns::middle(std::uint32_t triangle, int level) const
{
    const std::uint32_t place = place_of_[triangle];
    if (place == scene::none) return triangle;
    const int shift = 3 * level;
    const auto cube = [&](std::uint32_t code) { return code >> shift; };
    const auto first = std::ranges::lower_bound(codes_, cube(codes_[place]), {}, cube),
               last = std::ranges::upper_bound(codes_, cube(codes_[place]), {}, cube);
    const auto run = static_cast<std::size_t>(last - first);
    if (run < k_least_run) return triangle;
    return triangles_[static_cast<std::size_t>(first - codes_.begin()) + run / 2];
}

std::size_t TriangleRuns::bytes() const
{
    return (codes_.size() + triangles_.size() + place_of_.size()) * sizeof(std::uint32_t);
}

void PlaceGroups::begin_frame(const std::shared_ptr<const scene::Scene>& scene)
{
    if (scene == scene_) return;
    of_.clear();
    scene_ = scene;
}

const TriangleRuns& PlaceGroups::of(const scene::Mesh& mesh)
{
    Entry* entry = nullptr;
    {
        const std::lock_guard lock(mutex_);
        std::unique_ptr<Entry>& known = of_[&mesh];
        if (!known) known = std::make_unique<Entry>();
        entry = known.get();
    }
    std::call_once(entry->made, [&] { entry->runs = std::make_unique<TriangleRuns>(mesh); });
    return *entry->runs;
}

std::size_t PlaceGroups::bytes() const
{
    const std::lock_guard lock(mutex_);
    std::size_t bytes = 0;
    for (const auto& [mesh, entry] : of_) bytes += entry->runs ? entry->runs->bytes() : 0;
    return bytes;
}

}   // namespace gnomon::trace
