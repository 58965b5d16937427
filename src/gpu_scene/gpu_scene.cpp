// SPDX-License-Identifier: Apache-2.0
#include "gpu_scene/gpu_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>

#include "gnomon/error.h"
#include "gpu_scene/convert.h"
#include "gpu_scene/scene_blocks.h"

namespace gnomon::gpu_scene {

namespace {

using shared::GpuDraw;
using shared::GpuLayers;
using shared::GpuLight;
using shared::GpuMaterial;
using shared::GpuObject;
using shared::GpuTexture;

constexpr std::uint32_t k_cull_code[] =
#include "gpu_scene/cull.comp.inc"
    ;

// The offsets of a mesh's arrays in the shared ones.
struct MeshPlace {
    std::uint32_t positions = 0, normals = GNOMON_NONE, texcoords[2] = {GNOMON_NONE, GNOMON_NONE};
    std::uint32_t tangents = GNOMON_NONE, colors = GNOMON_NONE, first_index = 0;
};

// Appends values and returns the index of the first, or none if there are none.
template <class T>
std::uint32_t append(std::vector<T>& to, const std::vector<T>& values)
{
    if (values.empty()) return GNOMON_NONE;
    const auto first = static_cast<std::uint32_t>(to.size());
    to.insert(to.end(), values.begin(), values.end());
    return first;
}

// The inverse transpose up to a positive factor; it exists for singular matrices too.
glm::mat3 normal_matrix(const glm::dmat4& m)
{
    const glm::dmat3 l(m);
    const glm::dmat3 cofactor(glm::cross(l[1], l[2]), glm::cross(l[2], l[0]), glm::cross(l[0], l[1]));
    return glm::mat3(glm::determinant(l) < 0 ? -cofactor : cofactor);
}

Box3 bounds_of(std::span<const glm::vec3> positions, const scene::Mesh& mesh, const scene::MeshPart& part)
{
    Box3 box;
    for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
        for (int c = 0; c < 3; ++c) box.add(positions[mesh.triangles[t][c]]);
    return box;
}

}   // namespace

GpuScene::GpuScene(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state)
    : device_(device), scene_(state.shared_scene())
{
    static_assert(sizeof(shared::GpuDrawCommand) == sizeof(VkDrawIndexedIndirectCommand));
    cull_ = vk::Pipeline(device, vk::ComputeDesc{.name = "cull",
                                                 .code = {"gpu_scene/cull.comp", k_cull_code},
                                                 .blocks = vk::all_blocks(
                                                     vk::shared_push<shared::CullPush>(), draw_blocks(),
                                                     std::vector{vk::shared_block<shared::GpuDrawCommand>("commands"),
                                                                 vk::shared_block<shared::CullCounts>("counts")})});
    std::vector<vk::Upload> uploads;
    lay_out(state, uploads);
}

// Concatenates all meshes' arrays, and creates objects and draws.
void GpuScene::lay_out(const scene::SceneState& state, std::vector<vk::Upload>& uploads)
{
    const scene::Scene& scene = *scene_;
    std::vector<glm::vec3> all_positions, all_normals;
    std::vector<glm::vec2> all_texcoords;
    std::vector<glm::vec4> all_tangents, all_colors;
    std::vector<glm::uvec3> all_triangles;
    std::vector<MeshPlace> places;
    for (const scene::Mesh& mesh : scene.meshes) {
        MeshPlace& place = places.emplace_back();
        place.positions = append(all_positions, mesh.positions);
        place.normals = append(all_normals, mesh.normals);
        place.tangents = append(all_tangents, mesh.tangents);
        for (int set = 0; set < 2; ++set) place.texcoords[set] = append(all_texcoords, mesh.texcoords[set]);
        place.colors = append(all_colors, mesh.colors);
        place.first_index = static_cast<std::uint32_t>(3 * all_triangles.size());
        all_triangles.insert(all_triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
    }

    draws_of_.resize(scene.objects.size());
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
        const scene::Object& object = scene.objects[o];
        const scene::Mesh& mesh = scene.meshes[object.mesh];
        MeshPlace place_of = places[object.mesh];
        if (object.deforming) {
            // Give a deforming object its own vertices.
            const scene::DeformedMesh& shape = state.deformed(static_cast<scene::ObjectId>(o));
            place_of.positions = append(all_positions, shape.positions);
            place_of.normals = append(all_normals, shape.normals);
            place_of.tangents = append(all_tangents, shape.tangents);
        }
        GpuObject& g = objects_host_.emplace_back();
        g.positions = place_of.positions;
        g.normals = place_of.normals;
        std::copy(std::begin(place_of.texcoords), std::end(place_of.texcoords), g.texcoords);
        g.colors = place_of.colors;
        g.tangents = place_of.tangents;
        g.first_index = place_of.first_index;
        place(state, static_cast<scene::ObjectId>(o));
        for (const scene::MeshPart& part : mesh.parts) {
            GpuDraw& draw = draws_host_.emplace_back();
            draw.object = static_cast<std::uint32_t>(o);
            draw.material = part.material;
            draw.first_triangle = part.first_triangle;
            draw.count = part.triangle_count;
        }
    }
    sort_draws();
    for (std::size_t o = 0; o < scene.objects.size(); ++o) set_bounds(state, static_cast<scene::ObjectId>(o));

    std::vector<GpuMaterial> all_materials;
    for (const scene::Material& material : scene.materials) all_materials.push_back(convert(material));
    std::vector<GpuLayers> all_layers;
    for (const scene::Material& material : scene.materials) all_layers.push_back(convert_layers(material));
    TexelPool pool = convert(scene.textures);
    for (std::size_t l = 0; l < scene.lights.size(); ++l)
        lights_host_.push_back(convert(scene.lights[l], state.light(static_cast<scene::LightId>(l))));

    const auto make = [&]<class T>(vk::Buffer& buffer, const char* name, const std::vector<T>& values) {
        buffer = vk::Buffer(device_, name, std::max<std::size_t>(values.size(), 1) * sizeof(T));
        counts_.bytes += buffer.bytes();
        if (buffer.bytes() > device_->limits().maxStorageBufferRange && &buffer != &texels)
            throw MissingError(fmt::format("Vulkan: the scene's {} need {} MiB, but the device can address only {} MiB",
                                           name, buffer.bytes() >> 20, device_->limits().maxStorageBufferRange >> 20));
        if (!values.empty()) uploads.push_back(vk::upload_of(buffer, std::span<const T>(values)));
    };
    make(positions, "positions", all_positions);
    make(normals, "normals", all_normals);
    make(tangents, "tangents", all_tangents);
    make(texcoords, "texture coordinates", all_texcoords);
    make(colors, "vertex colours", all_colors);
    make(indices, "indices", all_triangles);
    make(objects, "objects", objects_host_);
    make(draws, "draws", draws_host_);
    make(materials, "materials", all_materials);
    make(layers, "material layers", all_layers);
    make(textures, "textures", pool.textures);
    make(texels, "texels", pool.halves);
    if (pool.halves.empty())
        texels = vk::Buffer(device_, "texels", 8);   // one unused texel, because a buffer cannot be empty
    make(lights, "lights", lights_host_);
    make(commands_buffer, "draw commands", commands_host_);
    counts_buffer = vk::Buffer(device_, "draw counts", 2 * sizeof(std::uint32_t));

    // Upload one by one, so that the staging memory is only as large as the largest upload.
    vk::Commands commands(device_);
    for (const vk::Upload& upload : uploads) {
        commands.upload("send " + upload.to->name(), {&upload, 1});
        commands.submit();
    }
}

// Copies an object's matrices and visibility from the state.
void GpuScene::place(const scene::SceneState& state, scene::ObjectId o)
{
    GpuObject& g = objects_host_[o];
    const scene::Object& object = scene_->objects[o];
    const glm::dmat4 world = object.skin != scene::none ? glm::dmat4(1) : state.world(object.node);
    g.to_world = glm::mat4(world);
    const glm::mat3 n = normal_matrix(world);
    g.normal_x = n[0], g.normal_y = n[1], g.normal_z = n[2];
    const double determinant = glm::determinant(glm::dmat3(world));
    g.mirrored = determinant < 0 ? 1 : 0;
    g.shown = state.object_there(o) && std::isfinite(determinant) ? 1 : 0;
}

// Sorts draws by pipeline state, then by object and part; makes the groups and the indirect commands.
void GpuScene::sort_draws()
{
    const auto key = [&](const GpuDraw& draw) {
        const scene::Material& material = scene_->materials[draw.material];
        const VkCullModeFlags cull = !material.one_sided()                 ? VK_CULL_MODE_NONE
                                     : objects_host_[draw.object].mirrored ? VK_CULL_MODE_FRONT_BIT
                                                                           : VK_CULL_MODE_BACK_BIT;
        return std::pair(material.surface_class(), cull);
    };
    std::stable_sort(draws_host_.begin(), draws_host_.end(), [&](const GpuDraw& a, const GpuDraw& b) {
        return std::tuple(key(a), a.object, a.first_triangle) < std::tuple(key(b), b.object, b.first_triangle);
    });
    groups_.clear();
    commands_host_.clear();
    for (auto& list : draws_of_) list.clear();
    for (std::size_t d = 0; d < draws_host_.size(); ++d) {
        const GpuDraw& draw = draws_host_[d];
        const auto [surface, cull] = key(draw);
        const auto number = static_cast<std::uint32_t>(d);
        if (groups_.empty() || groups_.back().surface != surface || groups_.back().cull != cull)
            groups_.push_back({surface, cull, number, 0});
        ++groups_.back().count;
        draws_of_[draw.object].push_back(number);
        const GpuObject& object = objects_host_[draw.object];
        commands_host_.push_back({3 * draw.count, 1, object.first_index + 3 * draw.first_triangle,
                                  static_cast<std::int32_t>(object.positions), number});
    }
}

// Computes the bounds of an object's parts in object space.
void GpuScene::set_bounds(const scene::SceneState& state, scene::ObjectId o)
{
    const scene::Object& object = scene_->objects[o];
    const scene::Mesh& mesh = scene_->meshes[object.mesh];
    const auto& vertices = object.deforming ? state.deformed(o).positions : mesh.positions;
    for (const std::uint32_t d : draws_of_[o]) {
        GpuDraw& draw = draws_host_[d];
        const Box3 box = bounds_of(vertices, mesh, {draw.material, draw.first_triangle, draw.count});
        draw.centre = box.centre();
        draw.extent = 0.5f * box.size();
    }
}

void GpuScene::update(vk::Commands& commands, const scene::SceneState& state)
{
    const scene::FrameChanges& changes = state.changes();
    std::vector<vk::Upload> uploads;
    counts_.touched = counts_.bytes_uploaded = 0;

    // Update the matrices of objects that moved, appeared or vanished.
    bool turned = false;
    std::vector<scene::ObjectId> touched = changes.moved;
    for (const auto* list : {&changes.appeared, &changes.vanished})
        touched.insert(touched.end(), list->begin(), list->end());
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    for (const scene::ObjectId o : touched) {
        const std::uint32_t mirrored = objects_host_[o].mirrored;
        place(state, o);
        turned = turned || mirrored != objects_host_[o].mirrored;
        uploads.push_back(
            vk::upload_of(objects, std::span<const GpuObject>(&objects_host_[o], 1), o * sizeof(GpuObject)));
        ++counts_.touched;
    }

    // Upload the vertices of objects that deformed.
    for (const scene::ObjectId o : changes.deformed) {
        const scene::DeformedMesh& shape = state.deformed(o);
        const GpuObject& g = objects_host_[o];
        uploads.push_back(
            vk::upload_of(positions, std::span<const glm::vec3>(shape.positions), g.positions * sizeof(glm::vec3)));
        if (g.normals != GNOMON_NONE)
            uploads.push_back(
                vk::upload_of(normals, std::span<const glm::vec3>(shape.normals), g.normals * sizeof(glm::vec3)));
        if (g.tangents != GNOMON_NONE)
            uploads.push_back(
                vk::upload_of(tangents, std::span<const glm::vec4>(shape.tangents), g.tangents * sizeof(glm::vec4)));
        set_bounds(state, o);
        if (!turned)
            for (const std::uint32_t d : draws_of_[o])
                uploads.push_back(
                    vk::upload_of(draws, std::span<const GpuDraw>(&draws_host_[d], 1), d * sizeof(GpuDraw)));
        ++counts_.touched;
    }

    // If an object's matrix became mirrored, or no longer is, its cull mode changes: sort again. This is rare.
    if (turned) {
        sort_draws();
        uploads.push_back(vk::upload_of(draws, std::span<const GpuDraw>(draws_host_)));
        uploads.push_back(
            vk::upload_of(commands_buffer, std::span<const VkDrawIndexedIndirectCommand>(commands_host_)));
        counts_.touched += draws_host_.size();
    }

    // Update the lights that moved or were relit, and the materials.
    std::vector<scene::LightId> lights_changed;
    std::set_union(changes.lights_moved.begin(), changes.lights_moved.end(), changes.lights_relit.begin(),
                   changes.lights_relit.end(), std::back_inserter(lights_changed));
    for (const scene::LightId l : lights_changed) {
        lights_host_[l] = convert(scene_->lights[l], state.light(l));
        uploads.push_back(vk::upload_of(lights, std::span<const GpuLight>(&lights_host_[l], 1), l * sizeof(GpuLight)));
        ++counts_.touched;
    }
    std::vector<GpuMaterial> changed_materials;
    for (const scene::MaterialId m : changes.materials_changed)
        changed_materials.push_back(convert(scene_->materials[m]));
    std::vector<GpuLayers> changed_layers;
    for (const scene::MaterialId m : changes.materials_changed)
        changed_layers.push_back(convert_layers(scene_->materials[m]));
    for (std::size_t i = 0; i < changed_materials.size(); ++i) {
        uploads.push_back(vk::upload_of(layers, std::span<const GpuLayers>(&changed_layers[i], 1),
                                        changes.materials_changed[i] * sizeof(GpuLayers)));
        uploads.push_back(vk::upload_of(materials, std::span<const GpuMaterial>(&changed_materials[i], 1),
                                        changes.materials_changed[i] * sizeof(GpuMaterial)));
        ++counts_.touched;
    }
    for (const vk::Upload& upload : uploads) counts_.bytes_uploaded += upload.bytes.size();
    commands.upload("follow the scene", uploads);
}

bool GpuScene::has_transparent() const
{
    return std::any_of(groups_.begin(), groups_.end(),
                       [](const DrawGroup& g) { return g.surface == scene::SurfaceClass::transparent; });
}

void GpuScene::cull(vk::Commands& commands, const glm::vec4 (&planes)[6]) const
{
    commands.pass("forget counts").writes(counts_buffer, vk::Use::copy_target).copy([&](vk::Recorder& r) {
        r.fill(counts_buffer, 0);
    });
    shared::CullPush push{};
    std::copy(std::begin(planes), std::end(planes), push.planes);
    push.draws = draw_count();
    if (push.draws == 0) return;
    commands.pass("cull")
        .reads(objects, vk::Use::storage_read)
        .reads(draws, vk::Use::storage_read)
        .writes(commands_buffer)
        .writes(counts_buffer)
        .compute([&](vk::Recorder& r) {
            r.bind(cull_);
            r.set("objects", objects);
            r.set("draws", draws);
            r.set("commands", commands_buffer);
            r.set("counts", counts_buffer);
            r.push(push);
            r.dispatch_over(push.draws);
        });
}

}   // namespace gnomon::gpu_scene
