// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light map and its quad-tree on the device [Ki and Oh 2007, 3.1 and 3.2]: drawn, not cast; the pyramid, validity
// by thresholds and the compacted cut in compute shaders. The twin of LightMap and find_clusters; views and nodes are
// laid out alike.
//
// What is drawn is ids alone (draw and triangle); a compute pass then makes each texel where its ray meets that
// triangle, by the cast map's formulas, so both maps hold the same texels and differ where a ray and the rasteriser
// disagree about an edge. Surfaces that let light pass are not drawn; alpha-tested ones where they are opaque.
//
// Kept from frame to frame: in each view one rectangle around what moved, before and now, is drawn anew, and the nodes
// above it are made anew, no others. A map that followed any number of frames equals a new one, to the bit.
//
// Cost a frame: the draws that touch these rectangles, their texels and a third more nodes; then the cut, 5,440 nodes a
// view at most. 52 bytes a node on the device.

#include "gpu_scene/gpu_scene.h"
#include "light_quadtree/clusters.h"
#include "light_quadtree/map_views.h"
#include "light_quadtree/vulkan/map_shared.h"
#include "light_views/casters.h"

namespace gnomon::light_quadtree {

class GpuLightMap {
 public:
    /// @throws MissingError  too little device memory, or a storage buffer cannot hold the nodes
    GpuLightMap(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                const LightMapOptions& options, const CutLevels& levels);

    /// Records what follows one advance() of the state; all of it the first time. Culls the scene's draws for lights:
    /// cull for the eye afterwards.
    void record(vk::Commands& commands, const gpu_scene::GpuScene& scene, const scene::SceneState& state);
    /// The same with texels from elsewhere: nodes laid out as LightMap has them, of which the finest levels are read.
    void record_tree_over(vk::Commands& commands, const scene::SceneState& state, std::span<const LightNode> nodes);

    /// Makes the list exactly so long for what follows, by repeating it from its beginning, until the next cut: for
    /// measurements. Submits. There must be a cluster, and room for so many.
    void record_repeated(vk::Commands& commands, std::uint32_t clusters) const;

    std::span<const MapView> views() const { return views_; }
    /// Views with something to see.
    std::uint32_t views_on() const;
    std::size_t node_count() const { return views_.empty() ? 0 : views_.back().end(); }
    /// Something changed. Counts up.
    std::uint32_t version() const { return version_; }
    /// Of the last record: texels drawn anew, and nodes above them.
    struct Work {
        std::uint64_t texels = 0, nodes = 0;
    };
    const Work& work() const { return work_; }
    /// Of the last record, by view: where texels changed.
    std::span<const light_views::Rect> dirty() const { return dirty_; }
    std::size_t bytes() const;

    // On the device.
    const vk::Buffer& view_buffer() const { return view_buffer_; }   // GpuMapView
    const vk::Buffer& nodes() const { return nodes_; }               // GpuNode
    const vk::Buffer& valid() const { return valid_; }               // 32 bits a node
    const vk::Buffer& clusters() const { return clusters_; }         // GpuCluster
    /// The same as texels, for the gather: see GNOMON_CLUSTERS_A_ROW. Mesa's software driver reads an image several
    /// times as fast as a buffer.
    const vk::Image& cluster_image() const { return cluster_image_; }
    const vk::Buffer& counts() const { return counts_; }
    std::uint32_t count_at() const { return groups_; }   // where `counts` has the number of clusters

 private:
    void make_pipelines();
    bool find_dirty(const scene::SceneState& state);
    void send_views(vk::Commands& commands, const scene::SceneState& state);
    void draw(vk::Commands& commands, const gpu_scene::GpuScene& scene, std::uint32_t view) const;
    void make_texels(vk::Commands& commands, const gpu_scene::GpuScene& scene, std::uint32_t view) const;
    void make_tree(vk::Commands& commands);
    void cut(vk::Commands& commands) const;
    void copy_clusters(vk::Commands& commands) const;

    std::shared_ptr<vk::Device> device_;
    LightMapOptions options_;
    std::uint32_t start_, limit_, groups_ = 0;
    light_views::Casters casters_;
    light_views::SceneBounds bounds_;
    std::vector<MapView> views_;
    std::vector<light_views::Rect> dirty_;                  // by view
    std::vector<std::vector<light_views::Rect>> dynamic_;   // by view and place in dynamics_: where each is
    std::vector<scene::ObjectId> dynamics_;                 // that cast
    std::vector<std::uint32_t> dynamic_place_;              // by object; none: it stands still
    bool fresh_ = true;
    std::uint32_t version_ = 0;
    Work work_;

    vk::Pipeline ids_pipeline_, masked_pipeline_, texels_pipeline_, level_pipeline_, cut_pipeline_;
    vk::Image ids_, depth_, cluster_image_;
    vk::Buffer view_buffer_, nodes_, valid_, counts_, clusters_;
};

}   // namespace gnomon::light_quadtree
