// SPDX-License-Identifier: Apache-2.0
#include "patches/detail_cells.h"

#include <algorithm>
#include <array>
#include <limits>
#include <queue>

#include "base/interruption.h"

namespace gnomon::patches {

namespace {

constexpr float k_margin = 0.05f;        // around the surfaces, of their largest extent
constexpr float k_least_width = 1e-6f;   // of a cube, of the root's

// Walls often stand at round coordinates: cubes are offset by these fractions of the margin.
constexpr std::array<float, 3> k_offset{0.3819660f, 0.2360680f, 0.1458980f};

// The surfaces of a leaf.
struct Content {
    std::uint32_t node = 0;
    std::vector<std::uint32_t> samples;
    double priority = 0;
    int directions = 0;   // that any surface faces
};

void measure(Content& content, std::span<const DetailSample> samples, float width)
{
    std::array<double, 6> area{};
    double weighted = 0, sum = 0;
    for (const std::uint32_t s : content.samples) {
        const auto a = static_cast<double>(samples[s].area);
        area[static_cast<std::size_t>(samples[s].facing)] += a;
        weighted += static_cast<double>(samples[s].weight) * a, sum += a;
    }
    const double square = static_cast<double>(width) * static_cast<double>(width);
    double filled = 0;
    content.directions = 0;
    for (const double a : area) filled += std::min(a / square, 1.0), content.directions += a > 0;
    content.priority = square * filled * filled * (weighted / sum);
}

}   // namespace

int facing_of(const glm::vec3& normal)
{
    const glm::vec3 a = glm::abs(normal);
    const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    return 2 * axis + (normal[axis] < 0 ? 1 : 0);
}

int DetailCells::child_of(const Node& node, const glm::vec3& position)
{
    const glm::vec3 middle = node.low + 0.5f * node.width;
    return (position.x >= middle.x ? 1 : 0) | (position.y >= middle.y ? 2 : 0) | (position.z >= middle.z ? 4 : 0);
}

DetailCells::DetailCells(std::span<const DetailSample> samples, std::size_t cells)
{
    Box3 box;
    for (const DetailSample& sample : samples) box.add(sample.position);
    const glm::vec3 size = box.size();
    const float extent = std::max({size.x, size.y, size.z, std::numeric_limits<float>::min()});
    Node root;
    root.width = (1 + 2 * k_margin) * extent;
    for (int axis = 0; axis < 3; ++axis)
        root.low[axis] = box.low[axis] - 2 * k_margin * extent * k_offset[static_cast<std::size_t>(axis)];
    nodes_.push_back(root);

    std::vector<Content> contents(1);
    contents[0].samples.resize(samples.size());
    for (std::uint32_t s = 0; s < samples.size(); ++s) contents[0].samples[s] = s;
    measure(contents[0], samples, root.width);
    using Entry = std::pair<double, std::uint32_t>;   // priority, content; ties: the first made
    const auto later = [](const Entry& a, const Entry& b) {
        return a.first < b.first || (a.first == b.first && a.second > b.second);
    };
    std::priority_queue<Entry, std::vector<Entry>, decltype(later)> queue(later);
    queue.emplace(contents[0].priority, 0);
    auto made = static_cast<std::size_t>(contents[0].directions);
    while (!queue.empty() && made < cells) {
        const std::uint32_t c = queue.top().second;
        queue.pop();
        const Node parent = nodes_[contents[c].node];
        if (parent.width < k_least_width * root.width) continue;
        if (c % 64 == 0) interruption_point();
        // Divide it.
        const auto first = static_cast<std::uint32_t>(nodes_.size());
        nodes_[contents[c].node].children = first;
        std::array<Content, 8> below;
        for (int k = 0; k < 8; ++k) {
            Node child;
            child.width = 0.5f * parent.width;
            child.low = parent.low + child.width * glm::vec3(k & 1, (k >> 1) & 1, k >> 2);
            nodes_.push_back(child);
            below[static_cast<std::size_t>(k)].node = first + static_cast<std::uint32_t>(k);
        }
        for (const std::uint32_t s : contents[c].samples)
            below[static_cast<std::size_t>(child_of(parent, samples[s].position))].samples.push_back(s);
        made -= static_cast<std::size_t>(contents[c].directions);
        contents[c].samples = {};
        for (Content& content : below) {
            if (content.samples.empty()) continue;
            measure(content, samples, 0.5f * parent.width);
            made += static_cast<std::size_t>(content.directions);
            queue.emplace(content.priority, static_cast<std::uint32_t>(contents.size()));
            contents.push_back(std::move(content));
        }
    }
}

DetailCells::Cube DetailCells::cube_at(const glm::vec3& position) const
{
    std::uint32_t node = 0;
    while (nodes_[node].children != 0)
        node = nodes_[node].children + static_cast<std::uint32_t>(child_of(nodes_[node], position));
    return {node, nodes_[node].width};
}

}   // namespace gnomon::patches
