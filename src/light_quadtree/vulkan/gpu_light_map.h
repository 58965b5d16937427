// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light map and its quad-tree on the device [Ki and Oh 2007, 3.1 and 3.2]: the map is rasterised, and compute
// shaders build the pyramid, evaluate validity by thresholds, and compact the cut. The device version of LightMap and
// find_clusters, with the same layout of views and nodes.
//
// The rasteriser writes only ids (draw and triangle). A compute pass then computes each texel where its ray hits that
// triangle, with the formulas of the ray-traced map. So both maps have the same texels, except where ray tracing and
// rasterisation disagree about an edge. Surfaces that do not occlude light are not drawn; alpha-tested ones are drawn
// where they are opaque.
//
// The map is kept from frame to frame: in each view, one rectangle around the old and new footprints of dynamic objects
// is redrawn, and only the nodes above it are recomputed. A map that was updated over any number of frames equals a new
// one, bit for bit.
//
// Cost per frame: the draws that touch these rectangles, their texels and a third more nodes; then the cut, at most
// 5,440 nodes per view. Memory: 52 bytes per node on the device.

#include "gpu_scene/gpu_scene.h"
#include "light_quadtree/clusters.h"
#include "light_quadtree/map_views.h"
#include "light_quadtree/vulkan/map_shared.h"
#include "light_views/casters.h"

namespace gnomon::light_quadtree {

class GpuLightMap {
 public:
    /// @throws MissingError  too little device memory, or a storage buffer is too small for the nodes
    /// @param with_levels  also keep the levels of the cut as an image (level_image()), for the gather as printed
    GpuLightMap(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                const LightMapOptions& options, const CutLevels& levels, bool with_levels = false);

    /// Records the updates after one advance() of the state; everything the first time. Culls the scene's draws for
    /// lights, so cull for the camera afterwards.
    void record(vk::Commands& commands, const gpu_scene::GpuScene& scene, const scene::SceneState& state);
    /// The same with texels from elsewhere: nodes in the layout of LightMap, of which the finest levels are used.
    void record_tree_over(vk::Commands& commands, const scene::SceneState& state, std::span<const LightNode> nodes);

    /// Forgets everything: the next record() draws all views anew, as the paper does where something moves.
    void forget() { fresh_ = true; }

    /// For measurements: extends the list to exactly this length by repeating it from its beginning, until the next
    /// cut. Submits. There must be a cluster, and room for as many.
    void record_repeated(vk::Commands& commands, std::uint32_t clusters) const;

    std::span<const MapView> views() const { return views_; }
    /// Number of views whose light is on.
    std::uint32_t views_on() const;
    std::size_t node_count() const { return views_.empty() ? 0 : views_.back().end(); }
    /// Increases with every change of the map.
    std::uint32_t version() const { return version_; }
    /// Work of the last record: texels redrawn, and nodes above them.
    struct Work {
        std::uint64_t texels = 0, nodes = 0;
    };
    const Work& work() const { return work_; }
    /// By view: the rectangle that the last record changed.
    std::span<const light_views::Rect> dirty() const { return dirty_; }
    std::size_t bytes() const;

    // Buffers on the device.
    const vk::Buffer& view_buffer() const { return view_buffer_; }   // GpuMapView
    const vk::Buffer& nodes() const { return nodes_; }               // GpuNode
    const vk::Buffer& shares() const { return shares_; }             // 32 bits per node: Share
    const vk::Buffer& clusters() const { return clusters_; }         // GpuCluster
    /// The clusters as texels for the gather: see GNOMON_CLUSTERS_A_ROW. Mesa's software driver reads an image several
    /// times faster than a buffer.
    const vk::Image& cluster_image() const { return cluster_image_; }
    /// The nodes of the levels from start to limit, with their shares: see map_levels.comp.
    const vk::Image& level_image() const { return level_image_; }
    std::uint32_t start() const { return start_; }
    std::uint32_t limit() const { return limit_; }
    const vk::Buffer& counts() const { return counts_; }
    std::uint32_t count_at() const { return groups_; }   // index in `counts` of the number of clusters

 private:
    void make_pipelines();
    void make_buffers();
    void follow_layout(const scene::SceneState& state);
    bool find_dirty(const scene::SceneState& state);
    void send_views(vk::Commands& commands, const scene::SceneState& state);
    void draw(vk::Commands& commands, const gpu_scene::GpuScene& scene, std::uint32_t view) const;
    void make_texels(vk::Commands& commands, const gpu_scene::GpuScene& scene, std::uint32_t view) const;
    void make_tree(vk::Commands& commands);
    void cut(vk::Commands& commands) const;
    void copy_clusters(vk::Commands& commands) const;
    void copy_levels(vk::Commands& commands) const;
    std::uint32_t level_nodes() const;

    std::shared_ptr<vk::Device> device_;
    LightMapOptions options_;
    std::uint32_t start_, limit_, groups_ = 0;
    bool with_levels_;
    light_views::Casters casters_;
    light_views::SceneBounds bounds_;
    std::vector<MapView> views_;
    std::vector<light_views::Rect> dirty_;                  // by view
    std::vector<std::vector<light_views::Rect>> dynamic_;   // footprints, by view and SceneState::dynamic_index()
    bool fresh_ = true;
    std::uint32_t version_ = 0;
    Work work_;

    vk::Pipeline ids_pipeline_, masked_pipeline_, texels_pipeline_, level_pipeline_, cut_pipeline_, copy_pipeline_;
    vk::Image ids_, depth_, cluster_image_, level_image_;
    vk::Buffer view_buffer_, nodes_, shares_, counts_, clusters_;
};

}   // namespace gnomon::light_quadtree
