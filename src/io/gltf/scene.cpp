// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "base/interruption.h"
#include "base/one_line.h"
#include "gnomon/error.h"
#include "io/file/read_file.h"
#include "io/gltf/build.h"
#include "io/gltf/draco.h"
#include "io/gltf/meshopt.h"
#include "io/gltf/same_places.h"
#include "io/gltf/text.h"
#include "io/load.h"
#include "scene/file_surfaces.h"
#include "scene/value_tracks.h"

namespace gnomon::io {

namespace gltf {

namespace {

glm::dmat4 local_matrix(const Node& node)
{
    if (!node.matrix) return rest_parts(node).matrix();
    glm::dmat4 m;
    auto value = node.matrix->begin();   // by columns
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) m[c][r] = *value++;
    for (int c = 0; c < 4; ++c) m[c][3] = c == 3 ? 1 : 0;   // 0 0 0 1 up to rounding
    return m;
}

scene::Camera make_camera(const Camera& source, scene::NodeId node, const std::string& node_name)
{
    scene::Camera camera;
    camera.name = source.name.empty() ? node_name : source.name;
    camera.node = node;
    camera.near = source.near;
    camera.far = source.far.value_or(0);
    if (source.has_perspective)
        camera.vertical_fov = std::min(source.yfov, scene::k_widest_fov);
    else
        camera.orthographic_height = 2 * std::abs(source.ymag);
    return camera;
}

std::optional<scene::Light> make_light(const Light& source, scene::NodeId node, const std::string& node_name)
{
    scene::Light light;
    if (source.type == "directional")
        light.type = scene::LightType::directional;
    else if (source.type == "point")
        light.type = scene::LightType::point;
    else if (source.type == "spot")
        light.type = scene::LightType::spot;
    else
        return std::nullopt;
    light.name = source.name.empty() ? node_name : source.name;
    light.color = source.intensity * glm::vec3(source.color[0], source.color[1], source.color[2]);
    light.inner_angle = source.inner;
    light.outer_angle = source.outer;
    light.range = light.type == scene::LightType::directional ? 0 : source.range;
    light.node = node;
    return light;
}

// Leaves out the listed nodes that are below others: they belong to the scene already, at their place in the hierarchy.
std::vector<Index> without_descendants(const std::vector<Index>& listed, const std::vector<Index>& parent)
{
    enum class Covered : std::uint8_t { unknown, no, yes };   // whether the node or an ancestor is listed
    std::vector<Covered> covered(parent.size(), Covered::unknown);
    std::vector<char> is_listed(parent.size());
    for (const Index node : listed) is_listed[node] = 1;
    std::vector<Index> result, path;
    for (const Index node : listed) {
        // Walk up to a node that is known, and note the answer along the way.
        path.clear();
        Index above = parent[node];
        while (above != k_absent && covered[above] == Covered::unknown && !is_listed[above]) {
            path.push_back(above);
            above = parent[above];
        }
        const bool below_another = above != k_absent && (is_listed[above] || covered[above] == Covered::yes);
        for (const Index passed : path) covered[passed] = below_another ? Covered::yes : Covered::no;
        if (!below_another) result.push_back(node);
    }
    return result;
}

// Whether a node of a scene, or one below it, has a mesh.
bool shows_meshes(const Model& model, std::size_t scene)
{
    std::vector<Index> stack = model.scenes[scene].nodes;
    while (!stack.empty()) {
        const Node& node = model.nodes[stack.back()];
        stack.pop_back();
        if (node.mesh != k_absent) return true;
        stack.insert(stack.end(), node.children.begin(), node.children.end());
    }
    return false;
}

// The scene to read: the file's own choice, or unless reading is strict, the first one that has meshes.
std::size_t chosen_scene(const Model& model, Context& context)
{
    const std::size_t own = model.scene.value_or(0);
    if (context.strict() || shows_meshes(model, own)) return own;
    for (std::size_t s = 0; s < model.scenes.size(); ++s)
        if (shows_meshes(model, s)) {
            context.warn(at("/scenes", own), fmt::format("has no meshes: scene {} is read, which has some", s));
            return s;
        }
    return own;
}

std::vector<Index> roots_of(const Model& model, const std::vector<Index>& parent, Context& context)
{
    if (!model.scenes.empty()) return without_descendants(model.scenes[chosen_scene(model, context)].nodes, parent);
    std::vector<Index> roots;
    for (Index i = 0; i < model.nodes.size(); ++i)
        if (parent[i] == k_absent) roots.push_back(i);
    return roots;
}

// Gives each primitive the material that it has in a variant.
void choose_variant(Model& model, const std::string& name)
{
    if (name.empty() || model.variants.empty()) return;
    const auto found = std::find(model.variants.begin(), model.variants.end(), name);
    if (found == model.variants.end()) {
        std::string names;
        for (const std::string& variant : model.variants)
            if (names.size() < 500) names += (names.empty() ? "" : ", ") + shown_name(variant);
        throw UsageError(fmt::format("no variant '{}'; there are: {}", shown_name(name), names));
    }
    const auto variant = static_cast<Index>(found - model.variants.begin());
    for (Mesh& mesh : model.meshes)
        for (Primitive& p : mesh.primitives)
            for (const Primitive::Mapping& m : p.mappings)
                if (std::find(m.variants.begin(), m.variants.end(), variant) != m.variants.end()) {
                    p.material = m.material;
                    break;
                }
}

// Reads the transforms of a node's instances.
std::vector<glm::dmat4> instance_matrices(const Model& model, const Data& data, const Attributes& attributes,
                                          std::uint64_t& left, const std::string& here, Context& context)
{
    std::vector<scene::TransformParts> parts;
    for (const auto& [name, index] : attributes) {
        const std::string place = at(here, name);
        const Accessor& accessor = model.accessors[index];
        const bool rotation = name == "ROTATION";
        if (!rotation && name != "TRANSLATION" && name != "SCALE") continue;   // attributes of shaders
        const bool whole = accessor.component == Component::f32 && !accessor.normalized;
        const bool fraction =
            accessor.normalized && (accessor.component == Component::i8 || accessor.component == Component::i16);
        if (accessor.shape != (rotation ? Shape::vec4 : Shape::vec3) || !(whole || (rotation && fraction)))
            context.fail(place, fmt::format("cannot be {}", accessor.format()));
        if (const std::string reason = data.unreachable(accessor); !reason.empty() || !data.has_bytes(accessor))
            context.fail(place, fmt::format("accessor {} {}", index, reason.empty() ? "has no data" : reason));
        if (!parts.empty() && parts.size() != accessor.count)
            context.fail(place, fmt::format("{} elements, another attribute has {}", accessor.count, parts.size()));
        if (parts.empty() && accessor.count > left)
            context.fail(place, "far more instances than the size of the file allows");
        if (parts.empty()) left -= accessor.count, parts.resize(accessor.count);
        std::vector<double> v;
        data.read_double(accessor, v);
        for (std::size_t i = 0; i < parts.size(); ++i) {
            if (rotation) {
                const glm::dquat q(v[4 * i + 3], v[4 * i], v[4 * i + 1], v[4 * i + 2]);
                const double length = glm::length(q);
                parts[i].rotation = length > 0 && std::isfinite(length) ? q * (1 / length) : glm::dquat(1, 0, 0, 0);
            } else {
                (name == "SCALE" ? parts[i].scale : parts[i].translation) = {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
            }
        }
    }
    std::vector<glm::dmat4> matrices;
    matrices.reserve(parts.size());
    for (const scene::TransformParts& p : parts) matrices.push_back(p.matrix());
    return matrices;
}

void build_skins(const Model& model, const Data& data, const std::vector<scene::NodeId>& ids,
                 const std::vector<scene::SkinId>& skin_ids, scene::Scene& out, Context& context)
{
    for (std::size_t i = 0; i < model.skins.size(); ++i) {
        if (skin_ids[i] == scene::none) continue;
        const Skin& source = model.skins[i];
        scene::Skin skin;
        skin.name = source.name;
        for (const Index joint : source.joints) {
            if (ids[joint] == scene::none)
                context.fail(at("/skins", i), fmt::format("joint {} is not in the scene", joint));
            skin.joints.push_back(ids[joint]);
        }
        skin.inverse_bind.assign(skin.joints.size(), glm::dmat4(1));
        if (source.inverse_bind != k_absent) {
            const Accessor& accessor = model.accessors[source.inverse_bind];
            const std::string pointer = at(at("/skins", i), "inverseBindMatrices");
            if (const std::string reason = data.unreachable(accessor); !reason.empty()) context.fail(pointer, reason);
            if (data.has_bytes(accessor))
                data.for_each(accessor, [&](std::uint64_t k, std::span<const double> m) {
                    if (k >= skin.inverse_bind.size()) return;
                    for (std::size_t e = 0; e < 16; ++e)
                        skin.inverse_bind[k][static_cast<int>(e / 4)][static_cast<int>(e % 4)] =
                            e % 4 != 3 ? m[e]
                            : e == 15  ? 1
                                       : 0;   // the last row is 0 0 0 1
                });
        }
        out.skins[skin_ids[i]] = std::move(skin);
    }
}

}   // namespace

void build_scene(const Model& model, const Data& data, const std::vector<Index>& parent, Meshes& meshes,
                 const Materials& materials, const std::string& animation, scene::Scene& out, Context& context)
{
    // Visit parents before children, siblings in the file's order; without recursion, because hierarchies can be deep.
    PartIds parts;
    parts.nodes.assign(model.nodes.size(), scene::none);
    parts.lights.resize(model.lights.size());
    parts.cameras.resize(model.cameras.size());
    std::vector<scene::NodeId>& ids = parts.nodes;
    std::vector<scene::SkinId> skin_ids(model.skins.size(), scene::none);
    std::vector<Index> stack = roots_of(model, parent, context);
    std::reverse(stack.begin(), stack.end());
    SamePlaces same_places(model);
    std::set<scene::MeshId> placed;
    std::uint64_t repeated = 0;
    std::uint64_t instances_left = context.limits.instances + data.total_bytes() / context.limits.bytes_per_instance;
    while (!stack.empty()) {
        const Index index = stack.back();
        stack.pop_back();
        const Node& source = model.nodes[index];
        const Index above = parent[index];
        const scene::NodeId id =
            out.add_node(source.name, above == k_absent ? scene::none : ids[above], local_matrix(source));
        ids[index] = id;
        same_places.add_node(index, above, local_matrix(source));
        if (!source.visible)
            out.nodes[id].visibility = std::make_shared<scene::VisibilityTrack>(
                scene::VisibilityTrack{{std::numeric_limits<double>::lowest()}, {false}});
        interruption_point();
        stack.insert(stack.end(), source.children.rbegin(), source.children.rend());

        if (source.mesh != k_absent) {
            scene::MeshId mesh = meshes.get(source.mesh);
            if (!source.instances && same_places.repeats(index, mesh)) {
                context.repair(Fault::same_place, at("/nodes", index),
                               [] { return std::string("repeats a mesh in a place where 64 others have it"); });
                mesh = scene::none;
            }
            const auto count = [&](std::uint64_t times) {
                if (mesh != scene::none)
                    repeated += times * std::max(out.meshes[mesh].triangles.size(), out.meshes[mesh].positions.size());
            };
            if (source.instances && mesh != scene::none) {
                // Each instance is a node below this one.
                const std::vector<glm::dmat4> places = instance_matrices(
                    model, data, *source.instances, instances_left,
                    at(at(at(at("/nodes", index), "extensions"), "EXT_mesh_gpu_instancing"), "attributes"), context);
                count(places.size());
                if (repeated > context.limits.repeated_triangles)
                    context.fail(at("/nodes", index), fmt::format("more than {} triangles or vertices in instances",
                                                                  context.limits.repeated_triangles));
                for (const glm::dmat4& place : places) {
                    const scene::NodeId instance = out.add_node(source.name, id, place);
                    out.nodes[instance].mesh = mesh;
                    if (source.weights) out.nodes[instance].morph_weights = *source.weights;
                }
            }
            scene::Node& node = out.nodes[id];
            node.mesh = source.instances ? scene::none : mesh;
            if (!placed.insert(mesh).second && !source.instances) count(1);
            if (repeated > context.limits.repeated_triangles)
                context.fail(at("/nodes", index), fmt::format("more than {} triangles or vertices in repeated meshes",
                                                              context.limits.repeated_triangles));
            if (source.weights && node.mesh != scene::none) node.morph_weights = *source.weights;
            if (source.skin != k_absent && node.mesh != scene::none && out.meshes[mesh].skin) {
                if (skin_ids[source.skin] == scene::none) {
                    skin_ids[source.skin] = static_cast<scene::SkinId>(out.skins.size());
                    out.skins.emplace_back();
                }
                node.skin = skin_ids[source.skin];
            }
        }
        if (source.camera != k_absent && (model.cameras[source.camera].type == "perspective" ||
                                          model.cameras[source.camera].type == "orthographic")) {
            parts.cameras[source.camera].push_back(static_cast<scene::CameraId>(out.cameras.size()));
            out.cameras.push_back(make_camera(model.cameras[source.camera], id, source.name));
        }
        if (source.light != k_absent)
            if (auto light = make_light(model.lights[source.light], id, source.name)) {
                parts.lights[source.light].push_back(static_cast<scene::LightId>(out.lights.size()));
                out.lights.push_back(*light);
            }
    }
    build_skins(model, data, ids, skin_ids, out, context);
    build_animations(model, data, parts, materials, animation, out, context);
}

}   // namespace gltf

scene::Scene load_gltf(const std::filesystem::path& file, const Progress& progress, const ReadOptions& options)
{
    using namespace gltf;
    Interruption interruption(progress);
    const InterruptionScope scope(progress ? &interruption : Interruption::current());
    const auto step = [](double done) { report_progress("loading", done); };
    step(0);
    Context context(file.string(), options.strict, options.memory);
    const std::vector<std::uint8_t> bytes = read_whole_file(file, file.string(), context.limits.file_bytes);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    const Container container = open_container(text, extension == ".glb", context);

    // Release the document as soon as everything was read from it.
    Model model;
    std::vector<TextureBinding> bindings;
    {
        nlohmann::json document = parse_json(container, context);
        bindings = check_schema(document, context);
        model = read_model(document);
    }
    choose_variant(model, options.variant);
    step(0.1);
    check_extensions(model, context);
    check_layout(model, context);
    const std::vector<AccessorUse> uses = check_links(model, bindings, context);
    const std::vector<Index> parent = check_nodes(model, context);
    repair_model(model);
    Data data(model, file, container.bin, container.binary, context);
    decode_meshopt(model, data, context);
    decode_draco(model, data, context);
    step(0.2);
    check_data(model, data, uses, context);
    step(0.4);

    scene::Scene scene;
    scene.name = file.stem().string();
    scene.variants = model.variants;
    Materials materials(model, data, scene, context);
    Meshes meshes(model, data, materials, scene, context);
    build_scene(model, data, parent, meshes, materials, options.animation, scene, context);
    materials.check_unused();
    if (const std::string halved = context.memory.warning(scene.textures); !halved.empty())
        context.warn("/images", halved);
    step(0.9);
    scene.warnings = context.take_warnings();
    scene::find_solid_blends(scene);
    scene::find_outlines(scene);
    if (!options.strict) repair_surfaces(scene);
    scene::add_tangents(scene);
    scene.finish();
    step(1);
    return scene;
}

}   // namespace gnomon::io
