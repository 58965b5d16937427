// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>
#include <utility>

#include "io/gltf/check.h"

namespace gnomon::io::gltf {

namespace {

constexpr float k_widest_inner = 0.99f;   // of the outer angle of a spot light

bool has_joints(const Mesh& mesh)
{
    return std::any_of(mesh.primitives.begin(), mesh.primitives.end(),
                       [](const Primitive& p) { return p.has("JOINTS_0"); });
}

std::size_t targets_of(const Model& model, const Node& node)
{
    return node.mesh == k_absent ? 0 : model.meshes[node.mesh].targets();
}

// Keeps the first channel of each target, and those with something to animate.
void repair_channels(const Model& model, Animation& animation)
{
    std::set<std::pair<Index, std::string>> seen;
    std::erase_if(animation.channels, [&](const Channel& channel) {
        if (channel.node == k_absent || channel.path == Path::pointer || channel.path == Path::unknown) return false;
        if (!seen.insert({channel.node, channel.path_word}).second) return true;
        return channel.path == Path::weights && targets_of(model, model.nodes[channel.node]) == 0;
    });
}

}   // namespace

void repair_model(Model& model)
{
    for (Image& image : model.images)
        if (image.view != k_absent) image.uri.reset();   // the file is complete in itself
    for (Mesh& mesh : model.meshes)
        if (mesh.weights) mesh.weights->resize(mesh.targets());
    for (Node& node : model.nodes) {
        if (node.weights) node.weights->resize(targets_of(model, node));
        if (node.skin != k_absent && node.mesh != k_absent && !has_joints(model.meshes[node.mesh]))
            node.skin = k_absent;
    }
    for (Animation& animation : model.animations) repair_channels(model, animation);
    for (Light& light : model.lights)
        if (light.has_spot && light.outer <= light.inner) light.inner = k_widest_inner * light.outer;
    for (Camera& camera : model.cameras)
        if (camera.far && *camera.far <= camera.near) camera.far.reset();
}

}   // namespace gnomon::io::gltf
