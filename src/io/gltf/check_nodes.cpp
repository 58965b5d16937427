// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/gltf/check.h"

namespace gnomon::io::gltf {

namespace {

constexpr double k_unit_tolerance = 0.00769;   // slightly more than the error of a quaternion in four bytes
constexpr double k_shear_tolerance = 1e-3;     // cosine between the axes of a matrix

// Whether a column-major matrix is a product of translation, rotation and scale: affine, without shear, not singular.
bool is_trs(const std::array<double, 16>& m)
{
    constexpr double affine_tolerance = 1e-5;
    for (int c = 0; c < 4; ++c)
        if (std::abs(m[static_cast<std::size_t>(c) * 4 + 3] - (c == 3 ? 1.0 : 0.0)) > affine_tolerance) return false;
    const glm::dvec3 x(m[0], m[1], m[2]), y(m[4], m[5], m[6]), z(m[8], m[9], m[10]);
    const double lx = glm::length(x), ly = glm::length(y), lz = glm::length(z);
    if (!(lx > 0 && ly > 0 && lz > 0)) return false;
    return std::abs(glm::dot(x, y)) <= k_shear_tolerance * lx * ly &&
           std::abs(glm::dot(y, z)) <= k_shear_tolerance * ly * lz &&
           std::abs(glm::dot(z, x)) <= k_shear_tolerance * lz * lx;
}

template <std::size_t n>
void check_size(const std::optional<std::array<double, n>>& values, const std::string& pointer, const Context& context)
{
    if (!values) return;
    for (const double v : *values)
        if (!std::isfinite(static_cast<float>(v))) context.fail(pointer, fmt::format("{} is too large", v));
}

void check_node(const Model& model, Index index, Context& context)
{
    const Node& node = model.nodes[index];
    const std::string here = at("/nodes", index);
    check_size(node.matrix, at(here, "matrix"), context);
    check_size(node.translation, at(here, "translation"), context);
    check_size(node.scale, at(here, "scale"), context);
    if (node.matrix && (node.translation || node.rotation || node.scale))
        context.fail(at(here, "matrix"), "a node has either a matrix or translation, rotation and scale");
    if (node.matrix && !is_trs(*node.matrix))
        context.repair(Fault::shear, at(here, "matrix"),
                       [] { return "is not made of translation, rotation and scale"; });
    if (node.rotation) {
        const auto& q = *node.rotation;
        const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (std::abs(length - 1) > k_unit_tolerance)
            context.repair(Fault::rotation_length, at(here, "rotation"),
                           [&] { return fmt::format("is not of unit length: {}", length); });
    }
    if (node.mesh == k_absent) return;

    const Mesh& mesh = model.meshes[node.mesh];
    const std::size_t targets = mesh.targets();
    if (node.weights && node.weights->size() != targets)
        context.repair(Fault::weight_count, at(here, "weights"), [&] {
            return fmt::format("{} weights, but the mesh has {} morph targets", node.weights->size(), targets);
        });
    if (node.weights)
        for (const float w : *node.weights)
            if (!std::isfinite(w)) context.fail(at(here, "weights"), "a weight is too large");
}

// Finds the meshes that a skin can deform.
std::vector<char> find_skinned(const Model& model)
{
    std::vector<char> skinned(model.meshes.size());
    for (std::size_t i = 0; i < model.meshes.size(); ++i)
        skinned[i] = std::any_of(model.meshes[i].primitives.begin(), model.meshes[i].primitives.end(),
                                 [](const Primitive& p) { return p.has("JOINTS_0"); });
    return skinned;
}

// The order of a depth-first walk: the first and last number below each node, and the root of its tree.
struct Forest {
    std::vector<Index> root;
    std::vector<std::uint32_t> first, last;
};

Forest walk(const Model& model, const std::vector<Index>& parent, Context& context)
{
    const std::size_t n = model.nodes.size();
    Forest forest{std::vector<Index>(n, k_absent), std::vector<std::uint32_t>(n), std::vector<std::uint32_t>(n)};
    std::uint32_t number = 0;
    std::vector<std::pair<Index, std::size_t>> stack;   // node and its next child
    for (Index start = 0; start < n; ++start) {
        if (parent[start] != k_absent) continue;
        stack.assign(1, {start, 0});
        forest.root[start] = start;
        forest.first[start] = number++;
        while (!stack.empty()) {
            auto& [node, next] = stack.back();
            if (next == model.nodes[node].children.size()) {
                forest.last[node] = number;
                stack.pop_back();
                continue;
            }
            const Index child = model.nodes[node].children[next++];
            forest.root[child] = start;
            forest.first[child] = number++;
            stack.emplace_back(child, 0);
        }
    }

    // Nodes that were not reached are in a cycle or below one. Walk up far enough to be in the cycle.
    for (Index i = 0; i < n; ++i) {
        if (forest.root[i] != k_absent) continue;
        Index inside = i;
        for (std::size_t steps = 0; steps < n; ++steps) inside = parent[inside];
        Index least = inside;
        for (Index j = parent[inside]; j != inside; j = parent[j]) least = std::min(least, j);
        context.fail(at("/nodes", least), "is its own ancestor");
    }
    return forest;
}

void check_skins(const Model& model, const Forest& forest, Context& context)
{
    for (Index i = 0; i < model.skins.size(); ++i) {
        const Skin& skin = model.skins[i];
        const std::string here = at("/skins", i);
        if (std::any_of(skin.joints.begin(), skin.joints.end(),
                        [&](Index joint) { return forest.root[joint] != forest.root[skin.joints.front()]; }))
            context.repair(Fault::joint_roots, at(here, "joints"), [] { return "the joints have no common root"; });
        if (skin.skeleton == k_absent) continue;
        for (const Index joint : skin.joints)
            if (forest.first[joint] < forest.first[skin.skeleton] || forest.first[joint] >= forest.last[skin.skeleton])
                context.repair(Fault::skeleton, at(here, "skeleton"),
                               [&] { return fmt::format("joint {} is not below the skeleton's root", joint); });
    }
}

void check_scenes(const Model& model, const std::vector<Index>& parent, const Forest& forest, Context& context)
{
    if (model.scenes.size() > context.limits.scenes)
        context.fail("/scenes",
                     fmt::format("has {} scenes, the limit is {}", model.scenes.size(), context.limits.scenes));

    // All joints of a skin share a root. So a scene with a skinned node needs this root besides the node's own.
    std::vector<std::vector<std::pair<Index, Index>>> needed(model.nodes.size());   // by root: other root, skinned node
    for (Index i = 0; i < model.nodes.size(); ++i) {
        const Node& node = model.nodes[i];
        if (node.skin == k_absent || node.mesh == k_absent) continue;
        needed[forest.root[i]].emplace_back(forest.root[model.skins[node.skin].joints.front()], i);
    }
    for (auto& list : needed) {
        std::sort(list.begin(), list.end());
        list.erase(
            std::unique(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.first == b.first; }),
            list.end());
    }
    std::vector<std::size_t> in_scene(model.nodes.size());   // scene number from 1 that a root was last seen in
    for (std::size_t s = 0; s < model.scenes.size(); ++s) {
        const std::string here = at(at("/scenes", s), "nodes");
        bool all_roots = true;
        for (std::size_t k = 0; k < model.scenes[s].nodes.size(); ++k) {
            const Index node = model.scenes[s].nodes[k];
            if (parent[node] != k_absent) {
                all_roots = false;
                context.repair(Fault::scene_root, at(here, k),
                               [&] { return fmt::format("node {} is not a root", node); });
            }
            in_scene[node] = s + 1;
        }
        if (!all_roots) continue;   // build_scene() checks the joints of such a scene
        for (const Index root : model.scenes[s].nodes)
            for (const auto& [other, node] : needed[root])
                if (in_scene[other] != s + 1)
                    context.fail(at("/nodes", node),
                                 fmt::format("is in scene {}, but the joints of its skin are not", s));
    }
}

}   // namespace

std::vector<Index> check_nodes(const Model& model, Context& context)
{
    std::vector<Index> parent(model.nodes.size(), k_absent);
    for (Index i = 0; i < model.nodes.size(); ++i) {
        for (std::size_t k = 0; k < model.nodes[i].children.size(); ++k) {
            const Index child = model.nodes[i].children[k];
            if (parent[child] != k_absent)
                context.fail(at(at(at("/nodes", i), "children"), k),
                             fmt::format("node {} already is a child of node {}", child, parent[child]));
            parent[child] = i;
        }
    }
    const Forest forest = walk(model, parent, context);
    const std::vector<char> skinned = find_skinned(model);
    for (Index i = 0; i < model.nodes.size(); ++i) {
        check_node(model, i, context);
        const Node& node = model.nodes[i];
        if (node.skin != k_absent && node.mesh != k_absent && !skinned[node.mesh])
            context.repair(Fault::unused_skin, at("/nodes", i),
                           [] { return "has a skin, but its mesh has no JOINTS"; });
    }
    check_skins(model, forest, context);
    check_scenes(model, parent, forest, context);
    return parent;
}

}   // namespace gnomon::io::gltf
