// SPDX-License-Identifier: Apache-2.0
#pragma once
// Certified shadow culling: an exact variant of [Nah 2009].
//
// The paper remembers, per whole triangle, the results of the shadow rays of the pixels that showed it. Here every
// static triangle is divided into parts as small as the image needs, and a part's shadow is remembered only once it is
// proven for all of its points (certificates.h). NONE: only dynamic objects are traced. FULL: nothing is traced.
// PARTIAL: the ray is traced. So the image equals, to the bit, the image with every ray traced, whatever is remembered.
//
// In each frame, `begin_frame` follows the changes of the scene. `classify` and `shadow`, called from many threads,
// answer batches of shadow queries; they trace rays where the state is unknown and record the results as evidence.
// `end_frame` judges the parts with new evidence: occluded and free rays in one part make it PARTIAL at no cost;
// otherwise the one certificate that the evidence allows is tried, from the coarsest open part down.
//
// Dynamic objects are tested against a mask of their outlines seen from the light, drawn where enough points need it
// (dynamic_mask.h). The mask also answers for points on dynamic objects. Where it is inconclusive, rays are traced.
//
// Cost per frame: a look-up per query, the mask, the rays of PARTIAL parts and along the outlines of dynamic objects,
// and certificates for what came into view. A static surface that was seen before costs only the look-up.

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/tasks.h"
#include "gnomon/types.h"
#include "shadow_culling/certified/certificates.h"
#include "shadow_culling/certified/forget.h"
#include "shadow_culling/certified/look_up.h"
#include "shadow_culling/certified/shadow_memory.h"
#include "shadow_culling/certified/shadow_point.h"
#include "shadow_culling/dynamic_mask/dynamic_mask.h"
#include "visibility/dynamic_bounds.h"

namespace gnomon::shadow_culling {

struct CertifiedOptions {
    double pixels_per_part = 8;        // parts are refined until they cover about so many pixels
    std::size_t memory = 256u << 20;   // bytes for states and evidence; the least recently seen are dropped first
    double rim_margins = 2;            // width of a receiver's rim (rim.h), in margins of the certificates
    CertificateOptions certificates;
    MaskOptions mask;
};

struct CullingCounters {
    std::uint64_t skipped = 0;             // answered without a ray
    std::uint64_t dynamic_only = 0;        // NONE, traced against dynamic objects that the ray could hit
    std::uint64_t traced = 0;              // traced against everything
    std::uint64_t partial = 0;             // of these, on parts known to be partial
    std::uint64_t certificates = 0;        // tried
    std::uint64_t certified = 0;           // certificates that succeeded
    std::uint64_t forgotten_records = 0;   // of promoted objects
    std::uint64_t forgotten_visited = 0;   // pairs of a light and a triangle that these could have shadowed
    void add(const CullingCounters& other);
};

class CertifiedCulling {
 public:
    CertifiedCulling(const scene::SceneState& state, const ray::RayScene& rays, const CertifiedOptions& options);
    ~CertifiedCulling();

    /// Call after the state advanced and the ray scene was updated.
    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, const CullingView& view);

    /// The points of one tile, and scratch memory. One per thread; reused.
    class Batch;
    std::unique_ptr<Batch> make_batch() const;

    /// Sets the points of a batch and finds their parts.
    void classify(Batch& batch, std::span<const ShadowPoint> points);
    /// Tests the visibility of one light from all points of the batch.
    /// @param occluded  by point, with room for 8 more: 1 where the light is behind the surface, or a surface that
    /// blocks
    ///                  light lies between
    /// @param rays      optional, by point: set to 1 where a ray was traced against everything, to 2 where against
    ///                  dynamic objects only
    void shadow(Batch& batch, int light, std::uint8_t* occluded, std::uint8_t* rays = nullptr);
    ShadowState state_of(const Batch& batch, std::uint32_t point, int light) const;

    /// Judges the parts for which this frame's rays brought evidence. The order of batches does not matter.
    void end_frame(std::span<const std::unique_ptr<Batch>> batches, Tasks& tasks)
    {
        note_news(batches);
        judge(tasks);
    }
    /// The two halves of end_frame(), for callers that show the image in between. note_news() gathers the evidence.
    /// judge() judges it while `go_on` returns true (it is called from any thread); without `go_on`, as far as the rays
    /// that the frame saved pay for certificates. The rest waits for a later call. Images do not depend on how much was
    /// judged. @return whether nothing is left
    /// @throws InterruptedError  the current work was interrupted; the rest waits for a later call
    /// @throws InterruptedError  the current work was interrupted: the evidence is kept
    void note_news(std::span<const std::unique_ptr<Batch>> batches);
    bool judge(Tasks& tasks, const std::function<bool()>& go_on = {});
    /// Sums since begin_frame; valid after end_frame.
    const CullingCounters& counters() const { return counters_; }
    /// Bytes of states, evidence and records.
    std::size_t bytes() const;
    /// The largest size of the evidence so far; it is freed when it is judged.
    std::size_t most_evidence_bytes() const;
    /// Bytes of the mask of dynamic objects, which is made anew in every frame.
    std::size_t mask_bytes() const;
    std::size_t visible_triangles() const { return memory_->live_records(); }

 private:
    void sort_news();
    struct FrameLight;
    void trace_all(Batch& batch, const FrameLight& light, std::uint8_t* occluded) const;
    void sort_open(Batch& batch, const FrameLight& light, std::uint8_t* occluded) const;
    void test_dynamic(Batch& batch, const FrameLight& light, std::uint8_t* occluded);
    void trace_static(Batch& batch, const FrameLight& light, std::uint8_t* occluded);
    void note_seen(Batch& batch, int light);
    bool may_meet_dynamic(const Batch& batch, const FrameLight& light, std::uint32_t point) const;
    void forget_promoted();
    std::vector<RememberedLight> remembered_lights() const;
    RimCodes rim_of_record(RecordId record) const;
    std::uint64_t affordable() const;
    std::uint32_t wanted_level(TriangleId triangle) const;

    const scene::SceneState* state_;
    const ray::RayScene* rays_;
    CertifiedOptions options_;
    CullingView view_;
    std::unique_ptr<StaticTriangles> triangles_;
    std::unique_ptr<ShadowMemory> memory_;
    std::unique_ptr<visibility::DynamicBounds> dynamic_;
    std::unique_ptr<DynamicMask> mask_;
    std::vector<char> light_on_;   // the light rests, so its states are valid
    bool any_light_on_ = true;
    std::vector<std::uint8_t> group_mask_;   // per group of four: bits of the lights that are on
    CullingCounters counters_;
    std::vector<RecordId> news_;   // records to judge, in order
    bool judged_once_ = false;
    std::uint32_t frame_ = 0;
};

class CertifiedCulling::Batch {
 public:
    CullingCounters counters;

 private:
    friend class CertifiedCulling;
    static constexpr std::size_t k_strip = 32;   // consecutive points that share a box

    void find_bounds(std::size_t first);

    std::span<const ShadowPoint> points;
    Box3 bounds;
    std::vector<Box3> strip_bounds;     // of every k_strip points
    LookUp at;                          // by point; no slot: not remembered (dynamic receiver, rim, or memory full)
    std::vector<RecordId> record;       // by point
    std::vector<std::uint8_t> states;   // by group, then point
    std::vector<RecordId> touched;      // records with new evidence, or PARTIAL ones where finer parts may help
    std::size_t stride = 0;             // between groups in `states`: points, padded
    // Scratch of shadow().
    ray::RayQueue static_rays, dynamic_rays;
    std::vector<std::uint32_t> static_point, dynamic_point;
    std::vector<std::uint8_t>
        then_dynamic;   // by static ray: 1 where dynamic objects are tested if nothing static is hit
    std::vector<std::uint8_t> hit;
    std::vector<Box3> dynamic_objects;
    DynamicMask::Asked asked;
    std::vector<std::uint8_t> strip_open;   // by strip: 1 where a dynamic object may occlude
    std::vector<std::uint8_t> open;         // by query: 1 where static geometry may occlude
};

}   // namespace gnomon::shadow_culling
