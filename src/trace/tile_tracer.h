// SPDX-License-Identifier: Apache-2.0
#pragma once
// The work of one tile of the traced frame, with the memory it needs. One a thread, reused from tile to tile.

#include "base/stopwatch.h"
#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"
#include "reference/reference.h"
#include "shading/shading.h"
#include "shadow_culling/certified/certified_culling.h"
#include "shadow_culling/nah2009/paper_tracer.h"
#include "trace/state_map.h"
#include "trace/traced_frame.h"

namespace gnomon::trace {

struct TileRect {
    int x = 0, y = 0, width = 0, height = 0;
};

class TileTracer {
 public:
    /// @param primary_hits  by pixel of the image: filled for the published culling, else not touched
    TileTracer(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
               const TracedOptions& options, const Remembered& remembered, shadow_culling::PrimaryHit* primary_hits,
               TraceLog* log);

    void trace(const TileRect& tile, shading::FrameBuffers& out);
    const FrameCounters& counters() const { return counters_; }
    /// Milliseconds of this thread.
    const FrameTimes& times() const { return times_; }
    reference::ReferenceCounters reference_counters() const
    {
        return paths_ ? paths_->counters() : reference::ReferenceCounters{};
    }
    /// What its rays saw, for the culling's end of frame; null without culling.
    std::unique_ptr<shadow_culling::CertifiedCulling::Batch> take_batch() { return std::move(batch_); }
    std::unique_ptr<irradiance_cache::IrradianceCache::Batch> take_indirect_batch()
    {
        return std::move(indirect_batch_);
    }
    std::unique_ptr<light_quadtree::MapLight::Batch> take_map_batch() { return std::move(map_batch_); }
    shadow_culling::PaperCulling::Notes take_notes() { return paper_tracer_.take_notes(); }

 private:
    // What a ray in a queue belongs to.
    struct Path {
        std::uint32_t pixel;   // of the tile
        glm::vec3 share;       // of the pixel's colour
        shading::RayCone cone;
    };
    struct PathQueue {
        ray::RayQueue rays;
        std::vector<Path> paths;
        void clear() { rays.clear(), paths.clear(); }
        void push(const Path& path, const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar)
        {
            rays.push(origin, tnear, direction, tfar);
            paths.push_back(path);
        }
    };
    struct Point {
        shading::SurfacePoint surface;
        shading::Continuation next;
        std::uint32_t pixel;
        glm::vec3 share;
    };

    void queue_primary(const TileRect& tile, int sample);
    void trace_queue(const PathQueue& queue);
    void shade_hits(const PathQueue& queue, bool primary, int sample);
    void sort_hits(std::size_t count);
    void note_primary_hits(const TileRect& tile);
    void light_points(bool primary, const TileRect& tile, bool show_states, Stopwatch& watch);
    void queue_shadow_rays(std::size_t light);
    void find_lit_by_rays(std::size_t light);
    void find_lit_by_memory(std::size_t light);
    void find_lit_by_paper(std::size_t light);
    void mark_states(std::size_t light, const TileRect& tile);
    StateMark mark_of(std::uint32_t point, std::size_t light, bool& untrusted) const;
    void check_lit(std::size_t light, bool primary, const TileRect& tile);
    void bounce_light(bool primary, const TileRect& tile);
    void add_reference(const TileRect& tile, bool primary);
    int samples_of(const glm::vec3& share) const;
    void queue_continuations();
    void store(const TileRect& tile, shading::FrameBuffers& out) const;
    std::size_t pixel_of_image(std::uint32_t pixel_of_tile, const TileRect& tile) const;

    const scene::SceneState& state_;
    const scene::Scene& scene_;
    const ray::RayScene& rays_;
    const scene::View& view_;
    const TracedOptions& options_;
    shadow_culling::CertifiedCulling* culling_;
    std::unique_ptr<shadow_culling::CertifiedCulling::Batch> batch_;
    irradiance_cache::IrradianceCache* visible_;
    std::unique_ptr<irradiance_cache::IrradianceCache::Batch> indirect_batch_;
    light_quadtree::MapLight* map_;
    std::unique_ptr<light_quadtree::MapLight::Batch> map_batch_;
    shadow_culling::PaperCulling* paper_;
    shadow_culling::PaperTracer paper_tracer_;
    shadow_culling::PrimaryHit* primary_hits_;
    StateMap* states_;
    TraceLog* log_;
    FrameCounters counters_;
    FrameTimes times_;

    PathQueue primary_, reflected_, refracted_, next_reflected_, next_refracted_;
    ray::Hits hits_;
    std::vector<std::uint64_t> order_;
    std::vector<Point> points_;
    ray::RayQueue shadow_rays_;
    std::vector<std::uint32_t> shadow_point_;
    std::vector<shadow_culling::ShadowPoint> shadow_points_;   // by point; apart, since every light reads all of them
    std::vector<glm::vec3> shading_normals_;
    std::vector<std::uint32_t> lit_;   // points that the present light reaches
    std::vector<std::uint8_t> occluded_;
    std::vector<shadow_culling::PrimitiveId> origins_;   // by shadow ray, for the published culling
    std::vector<std::uint8_t> found_lit_;                // by point, for the check

    std::vector<irradiance_cache::IndirectPoint> indirect_points_;
    std::vector<light_quadtree::MapReceiver> map_receivers_;
    std::vector<std::uint32_t> indirect_point_;   // of points_
    std::vector<glm::vec3> irradiance_;

    std::unique_ptr<reference::ReferencePaths> paths_;   // with a reference
    std::vector<reference::ReferencePaths::Request> requests_;
    std::vector<reference::IrradianceEstimate> estimates_;
    std::vector<std::uint32_t> request_point_;
    std::vector<std::uint32_t> points_of_pixel_;   // asked for so far, over all samples

    std::vector<glm::vec3> color_, direct_, indirect_, albedo_, normal_;    // by pixel of the tile
    std::vector<glm::vec3> variance_, first_irradiance_, first_variance_;   // with a reference
    std::vector<float> depth_, shadow_;
};

}   // namespace gnomon::trace
