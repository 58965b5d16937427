// SPDX-License-Identifier: Apache-2.0
#pragma once
// Irradiance cache for one-bounce indirect lighting, with shadows and without noise.
//
// A batch of surface points gets its irradiance in three steps: collect the cache points that it needs
// (points/collector.h), evaluate those that are not up to date (points/evaluator.h), and interpolate
// (points/interpolator.h). Each cache point has a cut of its own through a tree of virtual point lights
// (light_tree/light_tree.h), and remembers which nodes of it are visible past static geometry. In a frame it sums their
// current flux, and casts rays only where a dynamic object may be in the way. The places of cache points depend on the
// geometry and the level of detail alone (points/anchors.h), so a frame has the same bytes whatever frames came before,
// for any number of threads.
//
// Extends [Ki and Oh 2007], where all receivers share one cut and visibility is ignored.
//
// Cost: a new point: its cut and one ray per node. A known point: a sum, if flux or a dynamic object changed. A pixel:
// the interpolation of four points.

#include <memory>
#include <span>
#include <vector>

#include "base/tasks.h"
#include "irradiance_cache/cache_frame.h"
#include "irradiance_cache/points/evaluator.h"
#include "irradiance_cache/points/point_claims.h"
#include "irradiance_cache/points/point_device.h"
#include "irradiance_cache/points/remembered_batch.h"

namespace gnomon::irradiance_cache {

class IrradianceCache {
 public:
    IrradianceCache(const scene::SceneState& state, const ray::RayScene& rays, const CacheOptions& options,
                    Tasks& tasks);
    ~IrradianceCache();

    /// Evaluates cache points on a device; before the first frame. See for_each().
    void use_device(std::unique_ptr<PointDevice> device);

    /// Begins a frame: after the state advanced and the ray scene followed.
    void update(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks);

    /// A thread's scratch memory and counters.
    class Batch {
     public:
        ~Batch();

     private:
        friend class IrradianceCache;
        struct Scratch;
        explicit Batch(PointTable& table);
        std::unique_ptr<Scratch> scratch_;
    };
    std::unique_ptr<Batch> make_batch();

    /// Computes the irradiance that arrives at surface points by one diffuse bounce. Thread-safe, with a batch for each
    /// thread.
    /// @param form_factors  out, unless null: by point, about that of the surfaces that the light comes from, at most.
    ///                      Without patches, 0
    /// @return  always true without a device. With one, false if points were queued for it, and there is no irradiance
    /// yet; for_each() repeats such calls.
    bool shade(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance,
               float* form_factors = nullptr);
    /// The same for points that will be shaded again in the next frame. Not with a device.
    /// @param remembered  out: what they found; null if that cannot be used again
    void shade_and_remember(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance,
                            std::unique_ptr<RememberedBatch>& remembered);
    /// Computes the irradiance of the points that a batch remembers: the same, to the bit, as shade().
    /// @return  false if what it remembers does not hold any more: it was not shaded in the last frame, static geometry
    ///          or the static light changed, rays are limited, or it belongs to another cache
    bool shade_again(Batch& batch, RememberedBatch& remembered, glm::vec3* irradiance);
    /// Runs body(i, worker) for every i below `count` on the threads of `tasks`. Where it returns false because shade()
    /// did, it runs again after the device evaluated the queued points.
    /// @param batches  one for each thread of `tasks`, by worker
    void for_each(std::size_t count, std::span<const std::unique_ptr<Batch>> batches, Tasks& tasks,
                  const std::function<bool(std::size_t index, int worker)>& body);

    /// Ends a frame that was interrupted, in place of end_frame(). Points that were not evaluated are left to later
    /// frames.
    /// @return  false if update() was interrupted: the cache must be discarded
    bool abandon_frame();

    /// Sums the batches' counters, and drops points if they take too much memory. Null batches are skipped.
    void end_frame(std::span<const std::unique_ptr<Batch>> batches);

    /// For viewers: points that a frame has no rays left for are deferred to later frames. Pixels that lack new points
    /// get what is roughly known of the light there (points/rough_light.h), and those on dynamic objects what they had.
    /// 0: no limit; with one, a frame depends on those before it.
    void limit_rays(std::uint64_t per_frame) { budget_.limit(per_frame); }
    /// Whether the last frame deferred points, so that rendering it again would improve it.
    bool lacks_points() const { return budget_.any_deferred(); }

    const CacheCounters& counters() const { return counters_; }
    const LightTree& light_tree() const { return lights_; }
    /// Spacing of lattice points, in widths of a point, where neighbours can be interpolated.
    float widest_spacing() const { return options_.widest; }
    std::size_t bytes() const;
    std::size_t points() const { return table_.size(); }

 private:
    void find_dynamic_groups();
    bool takes_light(scene::ObjectId object) const;
    MovingSpheres::Object enclosed(scene::ObjectId object) const;
    void enclose_dynamic_objects();
    void follow_dynamic_objects(bool first);
    void drop_static_results();
    template <class Body>
    bool failing_together(Batch::Scratch& own, const Body& body);
    bool begin_points(Batch::Scratch& own, std::span<const IndirectPoint> points) const;
    bool shade_points(Batch::Scratch& own, std::span<const IndirectPoint> points, glm::vec3* irradiance,
                      float* form_factors, BatchRecorder* recorder = nullptr);
    bool compute_points(Batch::Scratch& own, std::span<const IndirectPoint> points,
                        std::span<const std::uint32_t> chosen, glm::vec3* irradiance, BatchRecorder* recorder);
    void shade_remembered(Batch::Scratch& own, const RememberedBatch& remembered, glm::vec3* irradiance);
    bool can_remember() const { return !evaluates_on_device_ && !budget_.limited(); }
    void evaluate_claimed(Batch::Scratch& own);
    void begin_rough_light();
    static void note_light(Batch::Scratch& own, std::span<const IndirectPoint> points, const glm::vec3* irradiance);
    void add_near_field(Batch::Scratch& own, std::span<const IndirectPoint> points, glm::vec3* irradiance);
    std::size_t defer_points(Batch::Scratch& own);

    CacheOptions options_;
    LightTree lights_;
    SkyLight sky_, sky_of_parts_;
    light_views::Casters casters_;
    TriangleNumbers triangles_;
    TriangleClusters clusters_;
    NearField near_field_;
    RayBudget budget_;
    RoughLight rough_;
    std::vector<std::vector<scene::ObjectId>> dynamic_groups_;   // dynamic objects that move together
    MovingSpheres dynamic_bounds_;
    std::vector<std::uint32_t> sphere_of_;   // by object: its node there if it moves alone, else none
    CacheFrame frame_;
    PointTable table_;
    std::unique_ptr<PointEvaluator> evaluator_;
    bool evaluates_on_device_ = false;
    // Numbers what depends on static geometry and static light alone, among all caches: batches that remember results
    // of another number have to be shaded anew.
    std::uint64_t static_results_;
    FrameFailure failure_;
    bool updating_ = false;   // or an update failed
    CacheCounters counters_;
};

}   // namespace gnomon::irradiance_cache
