// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/same_places.h"

#include <algorithm>

#include <glm/gtc/type_ptr.hpp>

namespace gnomon::io::gltf {

SamePlaces::SamePlaces(const Model& model) : places_(model.nodes.size())
{
    for (const Animation& animation : model.animations)
        for (const Channel& channel : animation.channels)
            if (channel.node < places_.size()) places_[channel.node].moves = true;
    for (std::size_t n = 0; n < places_.size(); ++n)
        if (model.nodes[n].skin != k_absent || model.nodes[n].weights) places_[n].moves = true;
}

void SamePlaces::add_node(Index node, Index above, const glm::dmat4& local)
{
    Place& own = places_[node];
    own.world = above == k_absent ? local : places_[above].world * local;
    own.moves = own.moves || (above != k_absent && places_[above].moves);
}

bool SamePlaces::repeats(Index node, scene::MeshId mesh)
{
    const Place& own = places_[node];
    if (own.moves || mesh == scene::none) return false;
    std::array<double, 16> matrix{};
    std::copy_n(glm::value_ptr(own.world), matrix.size(), matrix.begin());
    if (std::ranges::any_of(matrix, [](double value) { return value != value; })) return false;
    return ++count_[{mesh, matrix}] > k_most;
}

}   // namespace gnomon::io::gltf
