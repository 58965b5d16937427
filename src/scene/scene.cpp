// SPDX-License-Identifier: Apache-2.0
#include "scene/scene.h"

#include <algorithm>
#include <numeric>

#include "base/check.h"
#include "base/interruption.h"
#include "base/one_line.h"

namespace gnomon::scene {

namespace {

// Whether each surface class (opaque, masked, transparent) is one range of a mesh's triangles, in this order.
bool parts_are_sorted(const Mesh& mesh, const std::vector<Material>& materials)
{
    return std::is_sorted(mesh.parts.begin(), mesh.parts.end(), [&](const MeshPart& a, const MeshPart& b) {
        return materials[a.material].surface_class() < materials[b.material].surface_class();
    });
}

// Sorts a mesh's parts, and its triangles with them, by surface class.
void sort_parts(Mesh& mesh, const std::vector<Material>& materials)
{
    const auto class_of = [&](const MeshPart& part) { return materials[part.material].surface_class(); };
    std::vector<MeshPart> sorted = mesh.parts;
    std::stable_sort(sorted.begin(), sorted.end(),
                     [&](const MeshPart& a, const MeshPart& b) { return class_of(a) < class_of(b); });
    std::vector<glm::uvec3> triangles;
    triangles.reserve(mesh.triangles.size());
    for (MeshPart& part : sorted) {
        const auto begin = mesh.triangles.begin() + part.first_triangle;
        part.first_triangle = static_cast<std::uint32_t>(triangles.size());
        triangles.insert(triangles.end(), begin, begin + part.triangle_count);
    }
    mesh.triangles = std::move(triangles);
    mesh.parts = std::move(sorted);
}

}   // namespace

double Timeline::time_of(int frame) const
{
    if (frames <= 1) return start;
    if (own_frames) return start + (frame - 1) * (end - start) / (frames - 1);
    return start + (frame - 1) / fps;
}

Timeline Timeline::at_rate(double new_fps) const
{
    Timeline result = *this;
    result.fps = new_fps;
    if (!own_frames) result.frames = frames_in(end - start, new_fps);
    return result;
}

int Timeline::frames_in(double seconds, double rate)
{
    constexpr double k_tolerance = 1e-3;   // frames
    const double last = std::floor(seconds * rate + k_tolerance);
    return static_cast<int>(std::clamp(last, 0.0, k_most_frames - 1.0)) + 1;
}

NodeId Scene::add_node(std::string node_name, NodeId parent, const glm::dmat4& local)
{
    GNOMON_CHECK(parent == none || parent < nodes.size());
    Node node;
    node.name = std::move(node_name);
    node.parent = parent;
    node.local = local;
    nodes.push_back(std::move(node));
    return static_cast<NodeId>(nodes.size() - 1);
}

void Scene::finish()
{
    for (std::string& warning : warnings) warning = one_line(warning);

    // Check the guarantees of importers.
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        interruption_point();
        const Mesh& mesh = meshes[m];
        check_mesh(mesh);
        for (const MeshPart& part : mesh.parts) GNOMON_CHECK_LT(part.material, materials.size());
        if (!parts_are_sorted(mesh, materials)) sort_parts(meshes.edit(m), materials);
    }
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const Node& node = nodes[n];
        GNOMON_CHECK(node.parent == none || node.parent < n);
        GNOMON_CHECK(node.mesh == none || node.mesh < meshes.size());
        GNOMON_CHECK(node.skin == none || node.skin < skins.size());
    }
    for (const Skin& skin : skins) {
        GNOMON_CHECK_EQ(skin.joints.size(), skin.inverse_bind.size());
        for (const NodeId joint : skin.joints) GNOMON_CHECK_LT(joint, nodes.size());
    }
    for (const Light& light : lights) GNOMON_CHECK_LT(light.node, nodes.size());
    for (const Camera& camera : cameras) GNOMON_CHECK_LT(camera.node, nodes.size());

    // Index children, parents first.
    child_begin.assign(nodes.size() + 1, 0);
    for (const Node& node : nodes)
        if (node.parent != none) ++child_begin[node.parent + 1];
    std::partial_sum(child_begin.begin(), child_begin.end(), child_begin.begin());
    child_list.resize(child_begin.back());
    std::vector<std::uint32_t> fill(child_begin.begin(), child_begin.end());
    for (std::size_t n = 0; n < nodes.size(); ++n)
        if (nodes[n].parent != none) child_list[fill[nodes[n].parent]++] = static_cast<NodeId>(n);

    // Find each node's nearest animated ancestor (itself included): its anchor.
    std::vector<NodeId> anchor(nodes.size(), none);
    track_nodes.clear();
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const Node& node = nodes[n];
        if (node.transform || node.visibility || node.weights) track_nodes.push_back(static_cast<std::uint32_t>(n));
        if (node.may_move())
            anchor[n] = static_cast<NodeId>(n);
        else if (node.parent != none)
            anchor[n] = anchor[node.parent];
    }

    // Create an object for each mesh instance, and group objects that move as one rigid body.
    objects.clear();
    groups.clear();
    std::vector<GroupId> group_of(nodes.size(), none);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const Node& node = nodes[n];
        if (node.mesh == none || meshes[node.mesh].triangles.empty()) continue;
        const Mesh& mesh = meshes[node.mesh];
        Object object;
        object.node = static_cast<NodeId>(n);
        object.mesh = node.mesh;
        object.by_default = node.by_default;
        object.skin = mesh.skin ? node.skin : none;
        object.deforming =
            object.skin != none || mesh.vertex_keys || (!mesh.morph_targets.empty() && node.weights) || node.deforms;
        object.dynamic = object.deforming || anchor[n] != none;
        // Mark a constant morph as deforming, because it must be evaluated once at the start.
        if (!mesh.morph_targets.empty()) object.deforming = true;
        if (object.dynamic && !object.deforming) {
            if (group_of[anchor[n]] == none) {
                group_of[anchor[n]] = static_cast<GroupId>(groups.size());
                groups.push_back({anchor[n], {}});
            }
            object.group = group_of[anchor[n]];
            groups[object.group].objects.push_back(static_cast<ObjectId>(objects.size()));
        }
        objects.push_back(object);
    }
}

Statistics Scene::statistics() const
{
    Statistics result;
    for (const Object& object : objects) {
        if (object.removed || object.by_default) continue;
        const std::uint64_t triangles = meshes[object.mesh].triangles.size();
        result.triangles += triangles;
        ++result.objects;
        if (object.dynamic) result.triangles_dynamic += triangles, ++result.objects_dynamic;
    }
    return result;
}

Box3 Scene::bounds(double time) const
{
    std::vector<glm::dmat4> world(nodes.size());
    std::vector<char> visible(nodes.size());
    Box3 box;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const Node& node = nodes[n];
        const glm::dmat4 local = node.transform ? node.transform->evaluate(time) : node.local;
        world[n] = node.parent == none ? local : world[node.parent] * local;
        visible[n] =
            (node.parent == none || visible[node.parent]) && (!node.visibility || node.visibility->evaluate(time));
        if (node.mesh == none || !visible[n] || node.by_default) continue;
        interruption_point();
        const Mesh& mesh = meshes[node.mesh];
        for (const glm::uvec3& triangle : mesh.triangles)
            for (int i = 0; i < 3; ++i)
                box.add(glm::vec3(transform_point(world[n], glm::dvec3(mesh.positions[triangle[i]]))));
    }
    return box;
}

std::vector<glm::dmat4> Scene::world_matrices(double time) const
{
    std::vector<glm::dmat4> world(nodes.size());
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const Node& node = nodes[n];
        const glm::dmat4 local = node.transform ? node.transform->evaluate(time) : node.local;
        world[n] = node.parent == none ? local : world[node.parent] * local;
    }
    return world;
}

glm::dmat4 Scene::world_matrix(NodeId node, double time) const
{
    glm::dmat4 result(1);
    for (NodeId n = node; n != none; n = nodes[n].parent)
        result = (nodes[n].transform ? nodes[n].transform->evaluate(time) : nodes[n].local) * result;
    return result;
}

}   // namespace gnomon::scene
