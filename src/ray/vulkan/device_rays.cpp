// SPDX-License-Identifier: Apache-2.0
#include "ray/vulkan/device_rays.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <deque>

#include "base/check.h"
#include "gnomon/error.h"
#include "gpu_scene/scene_blocks.h"
#include "ray/traceable.h"

namespace gnomon::ray {

namespace {

using gpu_scene::GpuScene;
using gpu_scene::shared::GpuObject;
using shared::GpuRayGeometry;
using shared::RayPush;
using vk::Use;

constexpr std::uint32_t k_generation[] =
#include "ray/vulkan/occluded.rgen.inc"
    ;
constexpr std::uint32_t k_miss[] =
#include "ray/vulkan/occluded.rmiss.inc"
    ;
constexpr std::uint32_t k_any_hit[] =
#include "ray/vulkan/occluded.rahit.inc"
    ;

constexpr VkDeviceSize k_scratch_bytes = 128 << 20;   // shared by builds; larger if one build needs more
constexpr std::uint32_t k_arrays = 8;                 // of a ray queue
constexpr std::uint32_t k_most_objects = 1 << 24;     // limit of an instance's custom index
constexpr std::uint32_t k_least_room = 1024;          // rays

VkTransformMatrixKHR rows_of(const glm::mat4& m)
{
    VkTransformMatrixKHR rows{};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column) rows.matrix[row][column] = m[column][row];
    return rows;
}

bool finite(const glm::mat4& m)
{
    for (int column = 0; column < 4; ++column)
        if (!is_finite(glm::vec3(m[column]))) return false;
    return true;
}

// Whether rays can hit a triangle with this corner. Embree ignores all others, and devices require finite coordinates.
bool can_be_met(const glm::vec3& p)
{
    constexpr float farthest = 1e18f;
    return is_finite(p) && std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < farthest;
}

bool can_be_met(const std::vector<glm::vec3>& positions)
{
    return std::all_of(positions.begin(), positions.end(), [](const glm::vec3& p) { return can_be_met(p); });
}

template <class T>
vk::Buffer make_buffer(const std::shared_ptr<vk::Device>& device, const char* name, const std::vector<T>& values)
{
    return {device, name, std::max<std::size_t>(values.size(), 1) * sizeof(T)};
}

// An object's world matrix; the identity for skins, which are in world space.
glm::mat4 placed(const scene::SceneState& state, scene::ObjectId o)
{
    const scene::Object& object = state.scene().objects[o];
    return object.skin != scene::none ? glm::mat4(1) : glm::mat4(state.world(object.node));
}

}   // namespace

DeviceRays::DeviceRays(const std::shared_ptr<vk::Device>& device, const GpuScene& scene, const scene::SceneState& state)
    : device_(device), scene_(state.shared_scene())
{
    GNOMON_CHECK(supported(*device));
    const std::size_t objects = scene_->objects.size();
    if (objects > std::min<std::uint64_t>(k_most_objects, device->ray_limits().most_instances))
        throw MissingError(fmt::format("Vulkan: {} objects are more than the device traces rays against", objects));
    find_runs();

    // Make the tables that the any-hit shader needs, and the BLASes and the TLAS.
    std::vector<GpuRayGeometry> geometries;
    for (const auto& runs : runs_) {
        first_geometry_.push_back(static_cast<std::uint32_t>(geometries.size()));
        for (const Run& run : runs) geometries.push_back({run.first_triangle, run.material});
    }
    std::vector<std::uint32_t> firsts;
    for (const scene::Object& object : scene_->objects) firsts.push_back(first_geometry_[object.mesh]);
    make_bottoms(scene, state);
    make_top(state);

    geometries_ = make_buffer(device, "ray geometries", geometries);
    first_geometries_ = make_buffer(device, "ray geometries of objects", firsts);
    vk::Commands commands(device);
    const vk::Upload uploads[] = {
        vk::upload_of(geometries_, std::span<const GpuRayGeometry>(geometries)),
        vk::upload_of(first_geometries_, std::span<const std::uint32_t>(firsts)),
        vk::upload_of(matrices_, std::span<const VkTransformMatrixKHR>(matrices_host_)),
        vk::upload_of(instances_, std::span<const VkAccelerationStructureInstanceKHR>(instances_host_))};
    commands.upload("send ray tables", uploads);

    // Build everything. BLASes that are built once need their scratch memory only here.
    const vk::Buffer scratch = make_scratch(rigid_);
    scratch_ = make_scratch(deforming_);
    if (rigid_storage_) build_bottoms(commands, scene, rigid_, *rigid_storage_, scratch);
    std::vector<std::uint32_t> deformed;
    for (const std::uint32_t number : deforming_)
        if (!broken(state, bottoms_[number].object)) deformed.push_back(number);
    if (!deformed.empty()) build_bottoms(commands, scene, deformed, *deforming_storage_, scratch_);
    build_top(commands, scratch_);
    commands.submit();
    work_.instances = instances_host_.size();

    pipeline_ = vk::Pipeline(
        device, vk::RayDesc{.name = "occluded rays",
                            .generation = {"occluded.rgen", k_generation},
                            .miss = {"occluded.rmiss", k_miss},
                            .any_hit = {"occluded.rahit", k_any_hit},
                            .blocks = vk::all_blocks(vk::shared_push<RayPush>(), gpu_scene::scene_data_blocks(),
                                                     std::vector{vk::shared_block<GpuRayGeometry>("geometries")})});
}

// Finds the runs of triangles of each mesh that block light and that rays can hit. Parts are sorted by surface class.
void DeviceRays::find_runs()
{
    for (const scene::Mesh& mesh : scene_->meshes) {
        std::vector<Run>& runs = runs_.emplace_back();
        for (const scene::MeshPart& part : mesh.parts) {
            const scene::SurfaceClass surface = scene_->materials[part.material].surface_class();
            if (surface == scene::SurfaceClass::transparent) continue;
            const bool opaque = surface == scene::SurfaceClass::opaque;
            for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
                const glm::uvec3& corners = mesh.triangles[t];
                if (!can_be_met(mesh.positions[corners.x]) || !can_be_met(mesh.positions[corners.y]) ||
                    !can_be_met(mesh.positions[corners.z]))
                    continue;
                // Join opaque parts, whatever their materials.
                if (!runs.empty() && runs.back().first_triangle + runs.back().triangles == t &&
                    runs.back().opaque == opaque && (opaque || runs.back().material == part.material))
                    ++runs.back().triangles;
                else
                    runs.push_back({t, 1, part.material, opaque});
            }
        }
    }
}

// Lists the BLASes and allocates them in two buffers: one for rigid meshes, one for deforming objects.
void DeviceRays::make_bottoms(const GpuScene& scene, const scene::SceneState& state)
{
    bottom_of_mesh_.assign(scene_->meshes.size(), scene::none);
    bottom_of_object_.assign(scene_->objects.size(), scene::none);
    const auto add = [&](std::uint32_t& number, scene::ObjectId o, std::uint32_t matrix, bool deforming) {
        number = static_cast<std::uint32_t>(bottoms_.size());
        bottoms_.push_back({o, matrix, deforming});
        (deforming ? deforming_ : rigid_).push_back(number);
    };
    for (scene::ObjectId o = 0; o < scene_->objects.size(); ++o) {
        const scene::Object& object = scene_->objects[o];
        if (runs_[object.mesh].empty()) continue;
        if (!object.deforming && bottom_of_mesh_[object.mesh] == scene::none)
            add(bottom_of_mesh_[object.mesh], o, scene::none, false);
        // A static object with a singular transform gets a BLAS of transformed vertices, which needs no inverse.
        const glm::mat4 matrix = placed(state, o);
        const bool flat = !state.is_dynamic(o) && !has_volume(matrix) && finite(matrix);
        if (flat) matrices_host_.push_back(rows_of(matrix));
        if (flat || object.deforming)
            add(bottom_of_object_[o], o, flat ? static_cast<std::uint32_t>(matrices_host_.size() - 1) : scene::none,
                object.deforming);
    }

    matrices_ = make_buffer(device_, "matrices of what is flat", matrices_host_);
    for (auto* const list : {&rigid_, &deforming_}) {
        if (list->empty()) continue;
        const bool deforming = list == &deforming_;
        VkDeviceSize bytes = 0;
        std::vector<VkDeviceSize> sizes;
        for (const std::uint32_t number : *list) {
            const vk::StructureBytes needs = structure_bytes(*device_, describe(scene, bottoms_[number]));
            bottoms_[number].scratch = needs.scratch;
            sizes.push_back(needs.storage);
            bytes += needs.storage;
        }
        const auto storage = std::make_shared<const vk::Buffer>(
            device_, deforming ? "bottom levels of what deforms" : "bottom levels", bytes);
        (deforming ? deforming_storage_ : rigid_storage_) = storage;
        VkDeviceSize at = 0;
        for (std::size_t i = 0; i < list->size(); ++i) {
            Bottom& bottom = bottoms_[(*list)[i]];
            bottom.structure = vk::AccelerationStructure(
                device_, fmt::format("bottom level of object {}", bottom.object), false, storage, at, sizes[i]);
            at += sizes[i];
        }
    }
}

void DeviceRays::make_top(const scene::SceneState& state)
{
    instances_host_.resize(std::max<std::size_t>(scene_->objects.size(), 1));
    instances_host_.front() = {};
    for (scene::ObjectId o = 0; o < scene_->objects.size(); ++o) place(state, o);
    instances_ =
        vk::Buffer(device_, "ray instances", instances_host_.size() * sizeof(VkAccelerationStructureInstanceKHR));
    const vk::StructureBytes needs = structure_bytes(*device_, describe_top());
    top_ = vk::AccelerationStructure(device_, "top level", true, needs.storage);
    top_scratch_ = needs.scratch;
}

vk::StructureDesc DeviceRays::describe(const GpuScene& scene, const Bottom& bottom) const
{
    const scene::Mesh& mesh = scene_->meshes[scene_->objects[bottom.object].mesh];
    const GpuObject& object = scene.object(bottom.object);
    vk::StructureDesc desc{.often = bottom.deforming};
    for (const Run& run : runs_[scene_->objects[bottom.object].mesh])
        desc.triangles.push_back({.positions = &scene.positions,
                                  .first_position = object.positions,
                                  .position_count = static_cast<std::uint32_t>(mesh.positions.size()),
                                  .indices = &scene.indices,
                                  .first_index = object.first_index + 3 * run.first_triangle,
                                  .triangles = run.triangles,
                                  .matrices = bottom.matrix != scene::none ? &matrices_ : nullptr,
                                  .matrix = bottom.matrix,
                                  .opaque = run.opaque});
    return desc;
}

vk::StructureDesc DeviceRays::describe_top() const
{
    return {.instances = &instances_, .instance_count = static_cast<std::uint32_t>(instances_host_.size())};
}

// Sets an object's instance from the state. No ray hits it if the object is hidden or its transform is singular.
void DeviceRays::place(const scene::SceneState& state, scene::ObjectId o)
{
    VkAccelerationStructureInstanceKHR& instance = instances_host_[o];
    instance = {};
    instance.instanceCustomIndex = o & (k_most_objects - 1);
    glm::mat4 matrix = placed(state, o);
    std::uint32_t bottom = bottom_of_object_[o];
    if (bottom != scene::none && bottoms_[bottom].matrix != scene::none) {
        if (!state.is_dynamic(o))
            matrix = glm::mat4(1);   // the vertices contain it
        else
            bottom = scene::none;   // it was promoted
    }
    if (bottom == scene::none) bottom = bottom_of_mesh_[scene_->objects[o].mesh];
    const bool met = bottom != scene::none && state.object_visible(o) && has_volume(matrix) && !broken(state, o);
    instance.transform = rows_of(met ? matrix : glm::mat4(1));
    if (!met) return;
    instance.mask = state.is_dynamic(o) ? GNOMON_RAYS_DYNAMIC : GNOMON_RAYS_STATIC;
    instance.accelerationStructureReference = bottoms_[bottom].structure.address();
}

// Whether a deforming object has vertices that are not finite. It is not built while it has, and no ray hits it.
bool DeviceRays::broken(const scene::SceneState& state, scene::ObjectId o) const
{
    return scene_->objects[o].deforming && !can_be_met(state.deformed(o).positions);
}

vk::Buffer DeviceRays::make_scratch(std::span<const std::uint32_t> for_bottoms) const
{
    VkDeviceSize sum = 0, largest = top_scratch_;
    for (const std::uint32_t number : for_bottoms) {
        sum += bottoms_[number].scratch;
        largest = std::max(largest, bottoms_[number].scratch);
    }
    // The buffer may begin at any address: leave room to align it.
    return {device_, "scratch memory of builds",
            std::max(largest, std::min(sum, k_scratch_bytes)) + device_->ray_limits().scratch_alignment};
}

void DeviceRays::build_bottoms(vk::Commands& commands, const GpuScene& scene, std::span<const std::uint32_t> which,
                               const vk::Buffer& storage, const vk::Buffer& scratch)
{
    const VkDeviceAddress first = vk::round_up(scratch.address(), device_->ray_limits().scratch_alignment);
    const VkDeviceAddress end = scratch.address() + scratch.bytes();
    for (std::size_t at = 0; at < which.size();) {
        // Build as many at once as the scratch memory holds.
        std::deque<vk::StructureDesc> descs;
        std::vector<vk::StructureBuild> builds;
        VkDeviceAddress next = first;
        for (; at < which.size() && next + bottoms_[which[at]].scratch <= end; ++at) {
            const Bottom& bottom = bottoms_[which[at]];
            descs.push_back(describe(scene, bottom));
            builds.push_back({&descs.back(), &bottom.structure, next});
            next += bottom.scratch;
        }
        GNOMON_CHECK(!builds.empty());
        commands.pass("build bottom levels")
            .reads(scene.positions, Use::build_input)
            .reads(scene.indices, Use::build_input)
            .reads(matrices_, Use::build_input)
            .writes(storage, Use::build_target)
            .writes(scratch, Use::build_target)
            .build([&](vk::Recorder& r) { r.build(builds, scratch); });
    }
    work_.bottom_levels += which.size();
}

void DeviceRays::build_top(vk::Commands& commands, const vk::Buffer& scratch)
{
    const vk::StructureDesc desc = describe_top();
    const vk::StructureBuild build{&desc, &top_,
                                   vk::round_up(scratch.address(), device_->ray_limits().scratch_alignment)};
    vk::Pass pass = commands.pass("build top level");
    for (const vk::Buffer* storage : {rigid_storage_.get(), deforming_storage_.get()})
        if (storage) pass.reads(*storage, Use::build_source);
    pass.reads(instances_, Use::build_input)
        .writes(top_.storage(), Use::build_target)
        .writes(scratch, Use::build_target)
        .build([&](vk::Recorder& r) {
            r.build({&build, 1}, scratch);
        });
    ++work_.top_levels;
}

void DeviceRays::update(vk::Commands& commands, const GpuScene& scene, const scene::SceneState& state)
{
    const scene::FrameChanges& changes = state.changes();
    work_ = {};

    // Place what changed. (After a deformation, vertices may not be finite, or may be finite again.)
    std::vector<vk::Upload> uploads;
    for (const scene::ObjectId o : changes.changed) {
        place(state, o);
        uploads.push_back(vk::upload_of(instances_,
                                        std::span<const VkAccelerationStructureInstanceKHR>(&instances_host_[o], 1),
                                        o * sizeof(VkAccelerationStructureInstanceKHR)));
    }
    work_.instances = changes.changed.size();
    commands.upload("send ray instances", uploads);

    // Build the BLASes of objects that deformed, and the TLAS if anything changed.
    std::vector<std::uint32_t> deformed;
    for (const scene::ObjectId o : changes.deformed)
        if (bottom_of_object_[o] != scene::none && !broken(state, o)) deformed.push_back(bottom_of_object_[o]);
    if (!deformed.empty()) build_bottoms(commands, scene, deformed, *deforming_storage_, scratch_);
    if (!changes.changed.empty()) build_top(commands, scratch_);
}

void DeviceRays::make_room(std::uint32_t rays)
{
    if (rays <= room_) return;
    room_ = std::bit_ceil(std::max(rays, k_least_room));
    rays_ = vk::Buffer(device_, "rays", VkDeviceSize{room_} * k_arrays * sizeof(float), vk::Access::upload);
    answers_ = vk::Buffer(device_, "answers to rays", VkDeviceSize{room_} * sizeof(std::uint32_t));
    answers_host_ = vk::Buffer(device_, "answers to rays (read back)", answers_.bytes(), vk::Access::readback);
}

void DeviceRays::occluded(vk::Commands& commands, const GpuScene& scene, const ray::RayQueue& rays, std::uint8_t* out,
                          ray::Against against)
{
    const std::pair<const char*, const vk::Buffer*> inputs[] = {{"objects", &scene.objects},
                                                                {"draws", &scene.draws},
                                                                {"materials", &scene.materials},
                                                                {"textures", &scene.textures},
                                                                {"texcoords", &scene.texcoords},
                                                                {"colors", &scene.colors},
                                                                {"indices", &scene.indices},
                                                                {"geometries", &geometries_},
                                                                {"first_geometries", &first_geometries_},
                                                                {"rays", &rays_}};
    RayPush push{};
    push.mask = against == ray::Against::static_only    ? GNOMON_RAYS_STATIC
                : against == ray::Against::dynamic_only ? GNOMON_RAYS_DYNAMIC
                                                        : GNOMON_RAYS_STATIC | GNOMON_RAYS_DYNAMIC;
    push.reach = k_largest_coordinate;
    const std::size_t most = std::min<std::uint64_t>(k_rays_at_once, device_->ray_limits().most_rays);
    for (std::size_t begin = 0; begin < rays.size(); begin += most) {
        push.count = static_cast<std::uint32_t>(std::min(most, rays.size() - begin));
        make_room(push.count);
        push.apart = room_;
        const std::vector<float>* const arrays[k_arrays] = {&rays.ox, &rays.oy, &rays.oz, &rays.tnear,
                                                            &rays.dx, &rays.dy, &rays.dz, &rays.tfar};
        for (std::size_t a = 0; a < k_arrays; ++a)
            std::memcpy(rays_.as<float>().data() + a * room_, arrays[a]->data() + begin, push.count * sizeof(float));

        vk::Pass pass = commands.pass("trace rays");
        for (const auto& [name, buffer] : inputs) pass.reads(*buffer, Use::storage_read);
        for (const vk::Buffer* storage : {&top_.storage(), rigid_storage_.get(), deforming_storage_.get()})
            if (storage) pass.reads(*storage, Use::traced);
        pass.reads(scene.texels, Use::sampled).writes(answers_).trace([&](vk::Recorder& r) {
            r.bind(pipeline_);
            r.set("scene", top_);
            for (const auto& [name, buffer] : inputs) r.set(name, *buffer);
            r.set_texels("texels", scene.texels, GpuScene::k_texel_format);
            r.set("answers", answers_);
            r.push(push);
            r.trace(push.count);
        });
        commands.read_back(answers_, answers_host_, push.count * sizeof(std::uint32_t));
        commands.submit();
        const std::span<const std::uint32_t> answers = answers_host_.as<std::uint32_t>();
        for (std::size_t i = 0; i < push.count; ++i) out[begin + i] = static_cast<std::uint8_t>(answers[i]);
    }
}

std::size_t DeviceRays::bytes() const
{
    std::size_t bytes = 0;
    for (const vk::Buffer* buffer :
         {rigid_storage_.get(), deforming_storage_.get(), &top_.storage(), &instances_, &matrices_, &scratch_,
          &first_geometries_, &geometries_, &rays_, &answers_, &answers_host_})
        if (buffer) bytes += buffer->bytes();
    return bytes;
}

}   // namespace gnomon::ray
