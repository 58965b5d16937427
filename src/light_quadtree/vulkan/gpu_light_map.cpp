// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/vulkan/gpu_light_map.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "gnomon/error.h"
#include "gpu_scene/scene_blocks.h"
#include "light_views/texel_ray.h"

namespace gnomon::light_quadtree {

namespace {

using light_views::Rect;
using shared::GpuCluster;
using shared::GpuMapView;
using shared::GpuNode;
using vk::Use;

constexpr std::uint32_t k_ids_vert[] =
#include "light_quadtree/vulkan/map_ids.vert.inc"
    ;
constexpr std::uint32_t k_ids_frag[] =
#include "light_quadtree/vulkan/map_ids.frag.inc"
    ;
constexpr std::uint32_t k_masked_vert[] =
#include "light_quadtree/vulkan/map_ids_masked.vert.inc"
    ;
constexpr std::uint32_t k_masked_frag[] =
#include "light_quadtree/vulkan/map_ids_masked.frag.inc"
    ;
constexpr std::uint32_t k_texels_comp[] =
#include "light_quadtree/vulkan/map_texels.comp.inc"
    ;
constexpr std::uint32_t k_level_comp[] =
#include "light_quadtree/vulkan/map_level.comp.inc"
    ;
constexpr std::uint32_t k_cut_comp[] =
#include "light_quadtree/vulkan/map_cut.comp.inc"
    ;

constexpr std::uint32_t k_levels_comp[] =
#include "light_quadtree/vulkan/map_levels.comp.inc"
    ;

constexpr VkFormat k_id_format = VK_FORMAT_R32G32_UINT;
constexpr VkFormat k_depth_format = VK_FORMAT_D32_SFLOAT;

static_assert(sizeof(GpuNode) == sizeof(LightNode) && offsetof(GpuNode, flux) == offsetof(LightNode, flux) &&
              offsetof(GpuNode, members) == offsetof(LightNode, members));

// Planes around the volume that a rectangle of a view sees, with normals pointing inwards.
void rectangle_planes(const light_views::ViewProjection& view, const Rect& rect, glm::vec4 (&planes)[6])
{
    const glm::mat4 rows = glm::transpose(view.clip_from_world);
    const auto clip = [&](int texel) { return 2 * static_cast<float>(texel) / static_cast<float>(view.size) - 1; };
    planes[0] = rows[0] - clip(rect.x0) * rows[3];
    planes[1] = clip(rect.x1) * rows[3] - rows[0];
    planes[2] = rows[1] - clip(rect.y0) * rows[3];
    planes[3] = clip(rect.y1) * rows[3] - rows[1];
    planes[4] = rows[3] - rows[2];
    planes[5] = rows[2];
}

std::vector<vk::BlockExpectation> view_blocks()
{
    return {vk::shared_block<GpuMapView>("views"), vk::shared_block<GpuNode>("nodes")};
}

}   // namespace

GpuLightMap::GpuLightMap(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                         const LightMapOptions& options, const CutLevels& levels, bool with_levels)
    : device_(device),
      options_(options),
      start_(static_cast<std::uint32_t>(grid_of_paper_level(levels.start))),
      limit_(static_cast<std::uint32_t>(grid_of_paper_level(levels.limit))),
      with_levels_(with_levels),
      casters_(state),
      bounds_(state.present_bounds()),
      views_(lay_out_views(state.scene(), bounds_, options))
{
    GNOMON_CHECK(levels.limit <= levels.start && (1 << start_) <= options.least_side);
    GNOMON_CHECK(!options.separate_trees);
    make_pipelines();
    make_buffers();
}

// Makes what depends on the layout of the views.
void GpuLightMap::make_buffers()
{
    dirty_.assign(views_.size(), {});
    dynamic_.assign(views_.size(), {});
    const auto views = static_cast<std::uint32_t>(views_.size());
    const auto side = static_cast<std::uint32_t>(views_.empty() ? 1 : views_.front().side());
    ids_ = vk::Image(device_, {.name = "light map ids",
                               .width = side,
                               .height = side,
                               .format = k_id_format,
                               .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT});
    depth_ = vk::Image(device_, {.name = "light map depth",
                                 .width = side,
                                 .height = side,
                                 .format = k_depth_format,
                                 .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT});
    groups_ = views * (limit_ - start_ + 1);
    // With a margin of validity, a node and its children may both be clusters.
    std::size_t most = static_cast<std::size_t>(std::min(side * side, 1u << (2 * limit_))) * views;
    if (options_.validity.margin > 0) most += (most + 2) / 3;
    const auto make = [&](const char* name, std::size_t bytes) {
        if (bytes > device_->limits().maxStorageBufferRange)
            throw MissingError(fmt::format("Vulkan: the {} take {} MiB, and the device addresses {} MiB", name,
                                           bytes >> 20, device_->limits().maxStorageBufferRange >> 20));
        return vk::Buffer(device_, name, bytes);
    };
    view_buffer_ = make("light map views", std::max<std::size_t>(views, 1) * sizeof(GpuMapView));
    nodes_ = make("light map nodes", std::max<std::size_t>(node_count(), 1) * sizeof(GpuNode));
    shares_ = make("light cluster maps", std::max<std::size_t>(node_count(), 1) * sizeof(std::uint32_t));
    counts_ = make("cluster counts", (groups_ + 1) * sizeof(std::uint32_t));
    const std::size_t rows = std::max<std::size_t>(1, (most + GNOMON_CLUSTERS_A_ROW - 1) / GNOMON_CLUSTERS_A_ROW);
    clusters_ = make("clusters", rows * GNOMON_CLUSTERS_A_ROW * sizeof(GpuCluster));
    cluster_image_ = vk::Image(device_, {.name = "cluster texels",
                                         .width = 3 * GNOMON_CLUSTERS_A_ROW,
                                         .height = static_cast<std::uint32_t>(rows),
                                         .format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                         .usage = VK_IMAGE_USAGE_STORAGE_BIT});
    if (with_levels_)
        level_image_ = vk::Image(device_, {.name = "light cluster maps",
                                           .width = 3 * GNOMON_NODES_A_ROW,
                                           .height = (level_nodes() + GNOMON_NODES_A_ROW - 1) / GNOMON_NODES_A_ROW,
                                           .format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                           .usage = VK_IMAGE_USAGE_STORAGE_BIT});
}

// The nodes of the levels of the cut, in all views.
std::uint32_t GpuLightMap::level_nodes() const
{
    const std::uint32_t a_view = ((1u << (2 * (limit_ + 1))) - (1u << (2 * start_))) / 3;
    return a_view * std::max(1u, static_cast<std::uint32_t>(views_.size()));
}

void GpuLightMap::make_pipelines()
{
    using vk::ComputeDesc;
    using vk::GraphicsDesc;
    const auto drawn = [&](const char* name, vk::ShaderCode vertex, vk::ShaderCode fragment, const auto& blocks) {
        return vk::Pipeline(device_,
                            GraphicsDesc{.name = name,
                                         .vertex = vertex,
                                         .fragment = fragment,
                                         .colors = {k_id_format},
                                         .depth = k_depth_format,
                                         .blocks = vk::all_blocks(vk::shared_push<shared::MapDrawPush>(), blocks)});
    };
    ids_pipeline_ =
        drawn("light map ids", {"map_ids.vert", k_ids_vert}, {"map_ids.frag", k_ids_frag}, gpu_scene::draw_blocks());
    masked_pipeline_ = drawn("light map ids with holes", {"map_ids_masked.vert", k_masked_vert},
                             {"map_ids_masked.frag", k_masked_frag}, gpu_scene::scene_data_blocks());
    texels_pipeline_ = vk::Pipeline(
        device_, ComputeDesc{.name = "light map texels",
                             .code = {"map_texels.comp", k_texels_comp},
                             .blocks = vk::all_blocks(
                                 vk::shared_push<shared::TexelPush>(), gpu_scene::scene_data_blocks(), view_blocks(),
                                 std::vector{vk::shared_block<gpu_scene::shared::GpuLight>("lights")})});
    level_pipeline_ = vk::Pipeline(
        device_, ComputeDesc{.name = "light map level",
                             .code = {"map_level.comp", k_level_comp},
                             .blocks = vk::all_blocks(vk::shared_push<shared::NodePush>(), view_blocks())});
    cut_pipeline_ = vk::Pipeline(
        device_, ComputeDesc{.name = "light clusters",
                             .code = {"map_cut.comp", k_cut_comp},
                             .blocks = vk::all_blocks(vk::shared_push<shared::CutPush>(), view_blocks(),
                                                      std::vector{vk::shared_block<GpuCluster>("clusters")})});
    if (with_levels_)
        copy_pipeline_ = vk::Pipeline(
            device_, ComputeDesc{.name = "light cluster maps to an image",
                                 .code = {"map_levels.comp", k_levels_comp},
                                 .blocks = vk::all_blocks(vk::shared_push<shared::LevelsPush>(), view_blocks())});
}

std::uint32_t GpuLightMap::views_on() const
{
    return static_cast<std::uint32_t>(
        std::count_if(views_.begin(), views_.end(), [](const MapView& view) { return view.on; }));
}

// Makes the map anew in other bounds, or if the lights have other views now.
void GpuLightMap::follow_layout(const scene::SceneState& state)
{
    const bool other_bounds = !(state.present_bounds() == bounds_);
    if (!other_bounds && state.changes().lights_moved.empty()) return;
    bounds_ = state.present_bounds();
    std::vector<MapView> views = lay_out_views(state.scene(), bounds_, options_);
    if (!same_layout(views, views_)) {
        views_ = std::move(views);
        make_buffers();
        fresh_ = true;
    }
    fresh_ = fresh_ || other_bounds;
}

// Finds the rectangle around all changes in each view. Returns false if there are none.
bool GpuLightMap::find_dirty(const scene::SceneState& state)
{
    const scene::FrameChanges& changes = state.changes();
    std::fill(dirty_.begin(), dirty_.end(), Rect{});
    if (!fresh_ && !changes.anything()) return false;
    casters_.update(state);

    // Draw everything anew where a material changed, or a static object was promoted: its footprint before is not
    // known.
    const bool all = fresh_ || !changes.materials_changed.empty() ||
                     std::any_of(changes.promoted.begin(), changes.promoted.end(),
                                 [&](scene::ObjectId o) { return casters_.casts(o); });
    bool anything = false;
    for (std::size_t v = 0; v < views_.size(); ++v) {
        MapView& view = views_[v];
        const bool aimed = fresh_ || changes.light_changed(view.light);
        if (aimed) aim_view(view, state, bounds_);
        if (aimed || all) {
            dirty_[v] = {0, 0, view.side(), view.side()};
            dynamic_[v].assign(state.dynamic_objects().size(), {});
            for (std::size_t d = 0; d < dynamic_[v].size() && view.on; ++d)
                dynamic_[v][d] = casters_.footprint(view.projection, state, state.dynamic_objects()[d]);
        } else if (view.on) {
            dynamic_[v].resize(state.dynamic_objects().size());
            for (const scene::ObjectId o : changes.changed) {
                Rect& rect = dynamic_[v][state.dynamic_index(o)];
                dirty_[v] = around(dirty_[v], rect);
                rect = casters_.footprint(view.projection, state, o);
                dirty_[v] = around(dirty_[v], rect);
            }
        }
        anything = anything || !dirty_[v].empty();
    }
    fresh_ = false;
    return anything;
}

void GpuLightMap::send_views(vk::Commands& commands, const scene::SceneState& state)
{
    std::vector<GpuMapView> views;
    for (std::size_t v = 0; v < views_.size(); ++v) {
        const MapView& view = views_[v];
        const light_views::ViewProjection& p = view.projection;
        GpuMapView& g = views.emplace_back();
        g.clip_from_world = p.clip_from_world;
        light_views::ViewProjection near;
        g.leaves_out = view.on && leaves_out(view, state, bounds_, near) ? 1 : 0;
        g.near_clip = near.clip_from_world;
        g.origin = p.origin, g.forward = p.forward, g.across = p.across, g.down = p.down;
        g.light = view.light;
        g.first = static_cast<std::uint32_t>(view.first);
        g.levels = static_cast<std::uint32_t>(view.levels);
        g.depth_range = view.depth_range;
        const double texel = 2.0 / view.side();
        g.cell = static_cast<float>(texel * texel * static_cast<double>(glm::length(p.across)) *
                                    static_cast<double>(glm::length(p.down)));
        g.perspective = p.perspective ? 1 : 0;
        g.on = view.on ? 1 : 0;
        const Rect& rect = dirty_[v];
        if (!rect.empty()) {
            const int edges[] = {rect.x0, rect.y0, rect.x1, rect.y1};
            std::copy(std::begin(edges), std::end(edges), std::begin(g.dirty));
        }
    }
    const vk::Upload upload = vk::upload_of(view_buffer_, std::span<const GpuMapView>(views));
    commands.upload("send light map views", {&upload, 1});
}

void GpuLightMap::draw(vk::Commands& commands, const gpu_scene::GpuScene& scene, std::uint32_t v) const
{
    const MapView& view = views_[v];
    const Rect& rect = dirty_[v];
    glm::vec4 planes[6];
    rectangle_planes(view.projection, rect, planes);
    scene.cull(commands, planes);
    const vk::Rect area{rect.x0, rect.y0, static_cast<std::uint32_t>(rect.x1 - rect.x0),
                        static_cast<std::uint32_t>(rect.y1 - rect.y0)};
    commands.pass("light map ids")
        .reads(scene.objects, Use::storage_read)
        .reads(scene.draws, Use::storage_read)
        .reads(scene.materials, Use::storage_read)
        .reads(scene.textures, Use::storage_read)
        .reads(scene.texels, Use::sampled)
        .reads(scene.texcoords, Use::storage_read)
        .reads(scene.colors, Use::storage_read)
        .reads(scene.positions, Use::vertices)
        .reads(scene.indices, Use::vertices)
        .reads(scene.commands_buffer, Use::indirect)
        .color({.image = &ids_, .clear = VkClearColorValue{}})
        .depth({.image = &depth_, .clear = 0.0f})
        .area(area)
        .render([&](vk::Recorder& r) {
            for (const bool masked : {false, true}) {
                const auto wanted = masked ? scene::SurfaceClass::masked : scene::SurfaceClass::opaque;
                bool bound = false;
                for (const gpu_scene::DrawGroup& group : scene.groups()) {
                    if (group.surface != wanted) continue;
                    if (!bound) {
                        r.bind(masked ? masked_pipeline_ : ids_pipeline_);
                        r.viewport({0, 0, ids_.width(), ids_.height()});
                        r.scissor(area);
                        r.cull(VK_CULL_MODE_NONE);
                        r.set("objects", scene.objects);
                        r.set("draws", scene.draws);
                        if (masked) {
                            r.set("materials", scene.materials);
                            r.set("textures", scene.textures);
                            r.set_texels("texels", scene.texels, gpu_scene::GpuScene::k_texel_format);
                            r.set("texcoords", scene.texcoords);
                            r.set("colors", scene.colors);
                        }
                        r.push(shared::MapDrawPush{view.projection.clip_from_world});
                        r.vertex_buffer(0, scene.positions);
                        r.index_buffer(scene.indices);
                        bound = true;
                    }
                    r.draw_indexed_indirect(scene.commands_buffer, group.first * sizeof(VkDrawIndexedIndirectCommand),
                                            group.count);
                }
            }
        });
}

void GpuLightMap::make_texels(vk::Commands& commands, const gpu_scene::GpuScene& scene, std::uint32_t v) const
{
    const std::pair<const char*, const vk::Buffer*> inputs[] = {
        {"objects", &scene.objects},     {"draws", &scene.draws},         {"materials", &scene.materials},
        {"textures", &scene.textures},   {"texcoords", &scene.texcoords}, {"colors", &scene.colors},
        {"positions", &scene.positions}, {"indices", &scene.indices},     {"lights", &scene.lights},
        {"views", &view_buffer_}};
    vk::Pass pass = commands.pass("light map texels");
    for (const auto& [name, buffer] : inputs) pass.reads(*buffer, Use::storage_read);
    pass.reads(scene.texels, Use::sampled).reads(ids_, Use::sampled).writes(nodes_).compute([&](vk::Recorder& r) {
        r.bind(texels_pipeline_);
        for (const auto& [name, buffer] : inputs) r.set(name, *buffer);
        r.set_texels("texels", scene.texels, gpu_scene::GpuScene::k_texel_format);
        r.set("ids", ids_);
        r.set("nodes", nodes_);
        r.push(shared::TexelPush{v, options_.least_cosine});
        const Rect& rect = dirty_[v];
        r.dispatch_over(static_cast<std::uint32_t>(rect.x1 - rect.x0), static_cast<std::uint32_t>(rect.y1 - rect.y0));
    });
}

// Recomputes the nodes above changed texels, level by level, in all views at once.
void GpuLightMap::make_tree(vk::Commands& commands)
{
    for (int level = views_.front().levels - 1; level >= 0; --level) {
        std::uint32_t width = 0, height = 0;
        const int up = views_.front().levels - level;
        for (const Rect& rect : dirty_) {
            if (rect.empty()) continue;
            const auto across = static_cast<std::uint32_t>(((rect.x1 - 1) >> up) - (rect.x0 >> up) + 1),
                       down = static_cast<std::uint32_t>(((rect.y1 - 1) >> up) - (rect.y0 >> up) + 1);
            width = std::max(width, across), height = std::max(height, down);
            work_.nodes += std::uint64_t{across} * down;
        }
        commands.pass("light map level")
            .reads(view_buffer_, Use::storage_read)
            .writes(nodes_)
            .writes(shares_)
            .compute([&](vk::Recorder& r) {
                r.bind(level_pipeline_);
                r.set("views", view_buffer_);
                r.set("nodes", nodes_);
                r.set("shares", shares_);
                r.push(shared::NodePush{static_cast<std::uint32_t>(level), options_.validity.depth_threshold,
                                        options_.validity.normal_threshold, options_.validity.margin});
                r.dispatch_over(width, height, static_cast<std::uint32_t>(views_.size()));
            });
    }
}

void GpuLightMap::cut(vk::Commands& commands) const
{
    for (const bool write : {false, true})
        commands.pass(write ? "write clusters" : "count clusters")
            .reads(view_buffer_, Use::storage_read)
            .reads(nodes_, Use::storage_read)
            .reads(shares_, Use::storage_read)
            .writes(counts_)
            .writes(clusters_)
            .compute([&](vk::Recorder& r) {
                r.bind(cut_pipeline_);
                r.set("views", view_buffer_);
                r.set("nodes", nodes_);
                r.set("shares", shares_);
                r.set("counts", counts_);
                r.set("clusters", clusters_);
                r.push(shared::CutPush{static_cast<std::uint32_t>(views_.size()), start_, limit_, write ? 1u : 0u});
                r.dispatch(groups_);
            });
    copy_clusters(commands);
    if (with_levels_) copy_levels(commands);
}

void GpuLightMap::copy_levels(vk::Commands& commands) const
{
    constexpr std::uint32_t k_row = 1 << 14;   // groups in x of a dispatch
    const std::uint32_t groups = (level_nodes() + 63) / 64;
    commands.pass("light cluster maps to an image")
        .reads(view_buffer_, Use::storage_read)
        .reads(nodes_, Use::storage_read)
        .reads(shares_, Use::storage_read)
        .writes(level_image_)
        .compute([&](vk::Recorder& r) {
            r.bind(copy_pipeline_);
            r.set("views", view_buffer_);
            r.set("nodes", nodes_);
            r.set("shares", shares_);
            r.set("levels", level_image_);
            r.push(shared::LevelsPush{static_cast<std::uint32_t>(views_.size()), start_, limit_});
            r.dispatch(std::min(groups, k_row), (groups + k_row - 1) / k_row);
        });
}

void GpuLightMap::copy_clusters(vk::Commands& commands) const
{
    commands.pass("clusters to texels")
        .reads(clusters_, Use::copy_source)
        .writes(cluster_image_, Use::copy_target)
        .copy([&](vk::Recorder& r) {
            VkBufferImageCopy all{};
            all.imageSubresource = {cluster_image_.aspect(), 0, 0, 1};
            all.imageExtent = {cluster_image_.width(), cluster_image_.height(), 1};
            r.copy(clusters_, cluster_image_, {&all, 1});
        });
}

void GpuLightMap::record(vk::Commands& commands, const gpu_scene::GpuScene& scene, const scene::SceneState& state)
{
    work_ = {};
    follow_layout(state);
    if (fresh_)
        commands.pass("forget light maps")
            .writes(nodes_, Use::copy_target)
            .writes(shares_, Use::copy_target)
            .writes(counts_, Use::copy_target)
            .copy([&](vk::Recorder& r) {
                r.fill(nodes_, 0);
                r.fill(shares_, k_whole_share);
                r.fill(counts_, 0);
            });
    if (!find_dirty(state)) return;
    ++version_;
    send_views(commands, state);
    for (std::uint32_t v = 0; v < views_.size(); ++v) {
        if (dirty_[v].empty()) continue;
        if (views_[v].on) draw(commands, scene, v);
        make_texels(commands, scene, v);
        work_.texels += static_cast<std::uint64_t>(dirty_[v].x1 - dirty_[v].x0) *
                        static_cast<std::uint64_t>(dirty_[v].y1 - dirty_[v].y0);
    }
    make_tree(commands);
    cut(commands);
}

void GpuLightMap::record_tree_over(vk::Commands& commands, const scene::SceneState& state,
                                   std::span<const LightNode> nodes)
{
    GNOMON_CHECK_EQ(nodes.size(), node_count());
    fresh_ = true;
    work_ = {};
    if (!find_dirty(state)) return;
    ++version_;
    send_views(commands, state);
    const vk::Upload upload = vk::upload_of(nodes_, nodes);
    commands.upload("send light map texels", {&upload, 1});
    make_tree(commands);
    cut(commands);
}

void GpuLightMap::record_repeated(vk::Commands& commands, std::uint32_t wanted) const
{
    const vk::Buffer counts = commands.read_back(counts_), clusters = commands.read_back(clusters_);
    commands.submit();
    const std::uint32_t count = counts.as<std::uint32_t>()[groups_];
    GNOMON_CHECK(count > 0 && wanted <= clusters.as<GpuCluster>().size());
    std::vector<GpuCluster> list;
    for (std::uint32_t c = 0; c < wanted; ++c) list.push_back(clusters.as<GpuCluster>()[c % count]);
    const vk::Upload uploads[] = {
        vk::upload_of(clusters_, std::span<const GpuCluster>(list)),
        vk::upload_of(counts_, std::span<const std::uint32_t>(&wanted, 1), groups_ * sizeof(std::uint32_t))};
    commands.upload("repeat clusters", uploads);
    copy_clusters(commands);
    commands.submit();
}

std::size_t GpuLightMap::bytes() const
{
    std::size_t bytes = static_cast<std::size_t>(ids_.width()) * ids_.height() * 12;
    for (const vk::Buffer* buffer : {&view_buffer_, &nodes_, &shares_, &counts_, &clusters_}) bytes += buffer->bytes();
    return bytes;
}

}   // namespace gnomon::light_quadtree
