// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/vulkan/gpu_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/check.h"
#include "gnomon/error.h"

namespace gnomon::irradiance_cache {

namespace {

using vk::Use;

constexpr std::uint32_t k_cut_comp[] =
#include "irradiance_cache/vulkan/point_cut.comp.inc"
    ;
constexpr std::uint32_t k_sum_comp[] =
#include "irradiance_cache/vulkan/point_sum.comp.inc"
    ;
constexpr std::uint32_t k_flux_comp[] =
#include "irradiance_cache/vulkan/point_flux.comp.inc"
    ;

constexpr std::size_t k_least_crossed = 1 << 14;   // initial room; grows if needed

static_assert(sizeof(shared::GpuQuad) == sizeof(VirtualLightQuad) &&
              offsetof(shared::GpuQuad, nx) == offsetof(VirtualLightQuad, nx) &&
              offsetof(shared::GpuQuad, flux) == offsetof(VirtualLightQuad, flux));
static_assert(sizeof(shared::GpuCutRequest) == sizeof(CutRequest) &&
              offsetof(shared::GpuCutRequest, estimate) == offsetof(CutRequest, estimate));
static_assert(sizeof(shared::GpuSumRequest) == 20 && sizeof(shared::GpuPointLight) == sizeof(PointSums::Light));
static_assert(sizeof(shared::GpuCrossed) == sizeof(PointSums::Crossed));
static_assert(GNOMON_WEIGHT_BITS == k_weight_bits);

std::uint32_t steps_of(std::uint32_t count)
{
    return (count + k_seen_step - 1) / k_seen_step;
}

}   // namespace

GpuPoints::GpuPoints(const std::shared_ptr<vk::Device>& device)
    : device_(device),
      commands_(device),
      cut_(device,
           vk::ComputeDesc{
               .name = "cuts of points",
               .code = {"point_cut.comp", k_cut_comp},
               .blocks = {vk::shared_push<shared::PointCutPush>(), vk::shared_block<shared::GpuQuad>("quads"),
                          vk::shared_block<shared::GpuCutRequest>("requests"), vk::shared_block<shared::GpuCut>("cuts"),
                          vk::shared_block<shared::GpuCutNode>("nodes"), vk::shared_block<shared::GpuCutNode>("own")}}),
      sum_(device, vk::ComputeDesc{.name = "sums of points",
                                   .code = {"point_sum.comp", k_sum_comp},
                                   .blocks = {vk::shared_push<shared::PointSumPush>(),
                                              vk::shared_block<shared::GpuMovingSphere>("spheres"),
                                              vk::shared_block<shared::GpuSumRequest>("requests"),
                                              vk::shared_block<shared::GpuPointLight>("lights"),
                                              vk::shared_block<shared::GpuCrossed>("crossed")}}),
      flux_pipeline_(device, vk::ComputeDesc{.name = "flux of nodes",
                                             .code = {"point_flux.comp", k_flux_comp},
                                             .blocks = {vk::shared_push<shared::PointFluxPush>(),
                                                        vk::shared_block<shared::GpuNodeFlux>("changed")}})
{
    fitting(spheres_, "moving spheres", sizeof(shared::GpuMovingSphere));
    fitting(count_, "count", sizeof(std::uint32_t));
    fitting(crossed_, "crossed paths", k_least_crossed * sizeof(shared::GpuCrossed));
    fitting(store_, "visible nodes", std::size_t{1} << 20);
}

// Makes a buffer at least so large; its content is lost if it is replaced.
vk::Buffer& GpuPoints::fitting(vk::Buffer& buffer, const char* name, std::size_t bytes)
{
    if (buffer && buffer.bytes() >= bytes) return buffer;
    const VkDeviceSize most = device_->limits().maxStorageBufferRange;
    if (bytes > most)
        throw MissingError(
            fmt::format("Vulkan: '{}' takes {} MiB, and the device addresses {} MiB", name, bytes >> 20, most >> 20));
    buffer = vk::Buffer(device_, name, std::min<VkDeviceSize>(std::bit_ceil(std::max<std::size_t>(bytes, 64)), most));
    return buffer;
}

void GpuPoints::begin_frame(const LightTree& tree, const MovingSpheres& dynamic_bounds)
{
    tree_ = &tree;
    send_spheres(dynamic_bounds);
    if (geometry_version_ != tree.geometry_version())
        send_tree(tree);
    else
        send_flux(tree);
    geometry_version_ = tree.geometry_version();
}

void GpuPoints::send_tree(const LightTree& tree)
{
    std::vector<glm::vec3> flux;
    for (NodeId id = 0; id < tree.size(); ++id) flux.push_back(tree.flux().at(id));
    roots_count_ = static_cast<std::uint32_t>(tree.roots().size());
    std::vector<vk::Upload> uploads;
    const auto send = [&](vk::Buffer& buffer, const char* name, auto values) {
        fitting(buffer, name, values.size_bytes());
        uploads.push_back(vk::upload_of(buffer, values));
    };
    send(quads_, "light tree", tree.quads());
    send(children_, "light tree's children", tree.children());
    send(roots_, "light tree's roots", std::span<const NodeId>(tree.roots()));
    send(places_, "light tree's places", std::span<const glm::vec4>(tree.samples().places));
    send(flux_, "light tree's flux", std::span<const glm::vec3>(flux));
    commands_.upload("send light tree", uploads);
    commands_.submit();
}

void GpuPoints::send_flux(const LightTree& tree)
{
    if (tree.changed().empty()) return;
    std::vector<NodeId> nodes = tree.changed();
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    std::vector<shared::GpuNodeFlux> changed;
    for (const NodeId id : nodes) changed.push_back({id, tree.flux().at(id)});
    fitting(changed_, "changed flux", changed.size() * sizeof(shared::GpuNodeFlux));
    const vk::Upload upload = vk::upload_of(changed_, std::span<const shared::GpuNodeFlux>(changed));
    commands_.upload("send changed flux", {&upload, 1});
    commands_.pass("flux of nodes").reads(changed_, Use::storage_read).writes(flux_).compute([&](vk::Recorder& r) {
        const auto count = static_cast<std::uint32_t>(changed.size());
        r.bind(flux_pipeline_);
        r.set("changed", changed_);
        r.set("flux", flux_);
        r.push(shared::PointFluxPush{count});
        r.dispatch_over(count);
    });
    commands_.submit();
}

void GpuPoints::send_spheres(const MovingSpheres& dynamic_bounds)
{
    std::vector<shared::GpuMovingSphere> spheres;
    for (const MovingSpheres::Node& node : dynamic_bounds.nodes())
        spheres.push_back({node.sphere.centre, node.sphere.radius, node.next, node.single ? 1u : 0u});
    const std::size_t bytes = spheres.size() * sizeof(shared::GpuMovingSphere);
    if (spheres.size() == spheres_host_.size() &&
        (bytes == 0 || std::memcmp(spheres.data(), spheres_host_.data(), bytes) == 0))
        return;
    spheres_host_.swap(spheres);
    spheres_count_ = static_cast<std::uint32_t>(spheres_host_.size());
    if (bytes == 0) return;
    fitting(spheres_, "moving spheres", bytes);
    const vk::Upload upload = vk::upload_of(spheres_, std::span<const shared::GpuMovingSphere>(spheres_host_));
    commands_.upload("send moving spheres", {&upload, 1});
    commands_.submit();
}

void GpuPoints::cut(std::span<const CutRequest> points, const CutOptions& options, PointCuts& cuts)
{
    GNOMON_CHECK(tree_);
    cuts.first.assign(points.size() + 1, 0);
    cuts.node.clear();
    cuts.weight.clear();
    if (points.empty() || roots_count_ == 0) return;
    const auto count = static_cast<std::uint32_t>(points.size());
    GNOMON_CHECK_LE(count, device_->limits().maxComputeWorkGroupCount[0]);
    fitting(requests_, "requests of points", points.size_bytes());
    fitting(cuts_, "cuts of points", points.size() * sizeof(shared::GpuCut));
    fitting(nodes_, "nodes of cuts", points.size() * GNOMON_CUT_ROOM * sizeof(shared::GpuCutNode));
    fitting(own_nodes_, "room for cuts", points.size() * GNOMON_CUT_ROOM * sizeof(shared::GpuCutNode));
    const vk::Upload upload = vk::upload_of(requests_, points);
    commands_.upload("send points", {&upload, 1});
    commands_.pass("clear cuts").writes(count_, Use::copy_target).copy([&](vk::Recorder& r) { r.fill(count_, 0); });
    commands_.pass("cuts of points")
        .reads(quads_, Use::storage_read)
        .reads(children_, Use::storage_read)
        .reads(roots_, Use::storage_read)
        .reads(places_, Use::storage_read)
        .reads(requests_, Use::storage_read)
        .writes(cuts_)
        .writes(count_)
        .writes(nodes_)
        .writes(own_nodes_)
        .compute([&](vk::Recorder& r) {
            r.bind(cut_);
            r.set("quads", quads_);
            r.set("children", children_);
            r.set("roots", roots_);
            r.set("places", places_);
            r.set("requests", requests_);
            r.set("cuts", cuts_);
            r.set("count_of", count_);
            r.set("nodes", nodes_);
            r.set("own", own_nodes_);
            r.push(shared::PointCutPush{count, roots_count_, options.nearest, options.negligible});
            r.dispatch(count);
        });
    const vk::Buffer lengths = commands_.read_back(cuts_, points.size() * sizeof(shared::GpuCut));
    const vk::Buffer all = commands_.read_back(count_, sizeof(std::uint32_t));
    commands_.submit();
    vk::Buffer nodes;
    const std::size_t total = all.as<std::uint32_t>()[0];
    if (total > 0) {
        nodes = commands_.read_back(nodes_, total * sizeof(shared::GpuCutNode));
        commands_.submit();
    }

    const std::span<const shared::GpuCut> made = lengths.as<shared::GpuCut>();
    cuts.node.reserve(total);
    cuts.weight.reserve(total);
    std::vector<NodeId> node;
    CutScratch scratch;
    std::vector<float> weight;
    for (std::size_t p = 0; p < points.size(); ++p) {
        if (made[p].count > GNOMON_CUT_ROOM) {
            CutOptions own = options;
            own.error = points[p].error, own.estimate = points[p].estimate;
            cut_tree(*tree_, own, points[p].origin, points[p].normal, node, weight, scratch);
            cuts.node.insert(cuts.node.end(), node.begin(), node.end());
            cuts.weight.insert(cuts.weight.end(), weight.begin(), weight.end());
            ++long_cuts_;
        } else if (made[p].count > 0) {
            const auto own = nodes.as<shared::GpuCutNode>().subspan(made[p].first, made[p].count);
            for (const shared::GpuCutNode& seen : own) {
                cuts.node.push_back(seen.node);
                cuts.weight.push_back(seen.weight);
            }
        }
        cuts.first[p + 1] = static_cast<std::uint32_t>(cuts.node.size());
    }
}

// Takes room for a list: a free place of the same length, or else at the end. Lists of all lengths come and go.
std::uint32_t GpuPoints::take(std::uint32_t count)
{
    const std::uint32_t steps = steps_of(count);
    if (steps < free_.size() && !free_[steps].empty()) {
        const std::uint32_t place = free_[steps].back();
        free_[steps].pop_back();
        return place;
    }
    const std::uint32_t place = end_;
    end_ += steps * k_seen_step;
    return place;
}

void GpuPoints::forget(const KeptNodes& list)
{
    const std::uint32_t steps = steps_of(list.count);
    if (steps == 0) return;
    if (steps >= free_.size()) free_.resize(steps + 1);
    free_[steps].push_back(list.name);
}

void GpuPoints::keep(std::span<const SeenNode> seen, std::span<KeptNodes> lists)
{
    const std::uint32_t before = end_;
    std::vector<vk::Upload> uploads;
    std::size_t at = 0;
    for (KeptNodes& list : lists) {
        if (list.count == 0) continue;
        list.name = take(list.count);
        const auto own = std::as_bytes(seen.subspan(at, std::size_t{steps_of(list.count)} * k_seen_step));
        const VkDeviceSize offset = VkDeviceSize{list.name} * sizeof(SeenNode);
        // Merge adjacent uploads.
        if (!uploads.empty() && uploads.back().offset + uploads.back().bytes.size() == offset)
            uploads.back().bytes = {uploads.back().bytes.data(), uploads.back().bytes.size() + own.size()};
        else
            uploads.push_back({&store_, offset, own});
        at += own.size() / sizeof(SeenNode);
    }
    if (uploads.empty()) return;
    if (VkDeviceSize{end_} * sizeof(SeenNode) > store_.bytes()) {
        vk::Buffer wider;
        fitting(wider, "visible nodes", std::size_t{end_} * sizeof(SeenNode));
        const VkBufferCopy all{0, 0, std::min<VkDeviceSize>(store_.bytes(), VkDeviceSize{before} * sizeof(SeenNode))};
        if (all.size > 0) {
            commands_.pass("move visible nodes")
                .reads(store_, Use::copy_source)
                .writes(wider, Use::copy_target)
                .copy([&](vk::Recorder& r) {
                    r.copy(store_, wider, {&all, 1});
                });
            commands_.submit();
        }
        store_ = std::move(wider);
    }
    commands_.upload("send visible nodes", uploads);
    commands_.submit();
}

void GpuPoints::dispatch_sum(std::uint32_t points)
{
    const auto most = static_cast<std::uint32_t>(crossed_.bytes() / sizeof(shared::GpuCrossed));
    commands_.pass("clear crossed paths").writes(count_, Use::copy_target).copy([&](vk::Recorder& r) {
        r.fill(count_, 0);
    });
    commands_.pass("sums of points")
        .reads(places_, Use::storage_read)
        .reads(flux_, Use::storage_read)
        .reads(store_, Use::storage_read)
        .reads(spheres_, Use::storage_read)
        .reads(requests_, Use::storage_read)
        .writes(lights_)
        .writes(count_)
        .writes(crossed_)
        .compute([&](vk::Recorder& r) {
            r.bind(sum_);
            r.set("places", places_);
            r.set("flux", flux_);
            r.set("store", store_);
            r.set("spheres", spheres_);
            r.set("requests", requests_);
            r.set("lights", lights_);
            r.set("count", count_);
            r.set("crossed", crossed_);
            r.push(shared::PointSumPush{points, spheres_count_, most, 0});
            r.dispatch(points);
        });
}

void GpuPoints::sum(std::span<const SumRequest> points, PointSums& sums)
{
    GNOMON_CHECK(tree_);
    sums.light.assign(points.size(), {});
    sums.crossed.clear();
    if (points.empty() || roots_count_ == 0) return;
    const auto count = static_cast<std::uint32_t>(points.size());
    GNOMON_CHECK_LE(count, device_->limits().maxComputeWorkGroupCount[0]);
    std::vector<shared::GpuSumRequest> requests;
    for (const SumRequest& point : points) requests.push_back({point.origin, point.seen.name, point.seen.count});
    fitting(requests_, "requests of points", requests.size() * sizeof(shared::GpuSumRequest));
    fitting(lights_, "light of points", points.size() * sizeof(shared::GpuPointLight));
    const vk::Upload upload = vk::upload_of(requests_, std::span<const shared::GpuSumRequest>(requests));
    commands_.upload("send points", {&upload, 1});
    for (;;) {
        dispatch_sum(count);
        const vk::Buffer lights = commands_.read_back(lights_, points.size() * sizeof(shared::GpuPointLight));
        const vk::Buffer all = commands_.read_back(count_, sizeof(std::uint32_t));
        commands_.submit();
        const std::size_t found = all.as<std::uint32_t>()[0];
        if (found * sizeof(shared::GpuCrossed) > crossed_.bytes()) {
            fitting(crossed_, "crossed paths", found * sizeof(shared::GpuCrossed));   // and try again
            continue;
        }
        std::memcpy(sums.light.data(), lights.mapped(), points.size() * sizeof(PointSums::Light));
        if (found == 0) return;
        const vk::Buffer crossed = commands_.read_back(crossed_, found * sizeof(shared::GpuCrossed));
        commands_.submit();
        sums.crossed.resize(found);
        std::memcpy(sums.crossed.data(), crossed.mapped(), found * sizeof(PointSums::Crossed));
        break;
    }
    // Sort: the order of the device's invocations is undefined.
    std::sort(sums.crossed.begin(), sums.crossed.end(),
              [](const auto& a, const auto& b) { return std::pair(a.point, a.place) < std::pair(b.point, b.place); });
}

void GpuPoints::trace_with(std::unique_ptr<ray::DeviceRays> rays, const gpu_scene::GpuScene& scene)
{
    rays_ = std::move(rays);
    scene_ = &scene;
}

void GpuPoints::occluded(const ray::RayQueue& rays, std::uint8_t* occluded, ray::Against against)
{
    if (!rays.empty()) rays_->occluded(commands_, *scene_, rays, occluded, against);
}

std::size_t GpuPoints::bytes() const
{
    std::size_t sum = rays_ ? rays_->bytes() : 0;
    for (const vk::Buffer* buffer : {&quads_, &children_, &roots_, &places_, &flux_, &spheres_, &changed_, &requests_,
                                     &cuts_, &count_, &nodes_, &own_nodes_, &lights_, &crossed_})
        if (*buffer) sum += buffer->bytes();
    return sum;
}

}   // namespace gnomon::irradiance_cache
