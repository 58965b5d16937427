// SPDX-License-Identifier: Apache-2.0
#include "environment_light/part_directions.h"

#include "base/check.h"
#include "environment_light/spherical_triangles.h"

namespace gnomon::environment_light {

PartDirections::PartDirections(const DirectionCells& cells)
{
    directions_.reserve(k_parts * cells.leaves());
    for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
        const DirectionNode& node = cells.nodes()[cells.node_of(leaf)];
        GNOMON_CHECK(node.corners == 3);
        const Corners whole = {node.corner[0], node.corner[1], node.corner[2]};
        // Jitter by the cell alone, so that a cell has the same parts in every image.
        auto index = static_cast<double>(node.place % 4093);
        for (const Corners& quarter : quarters(whole))
            for (const Corners& sixteenth : quarters(quarter))
                for (const Corners& part : quarters(sixteenth)) directions_.emplace_back(jittered_in(part, index++));
    }
}

std::uint64_t PartDirections::above(std::size_t leaf, const glm::vec3& normal, float least) const
{
    std::uint64_t mask = 0;
    for (std::uint32_t part = 0; part < k_parts; ++part)
        mask |= std::uint64_t{glm::dot(direction(leaf, part), normal) > least} << part;
    return mask;
}

}   // namespace gnomon::environment_light
