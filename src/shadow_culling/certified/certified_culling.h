// SPDX-License-Identifier: Apache-2.0
#pragma once
// Certified shadow culling: the idea of [Nah 2009] made exact.
//
// The paper remembers, per whole triangle, what the pixels it happened to see said. Here every static triangle is cut
// into small parts as fine as the image needs, and a part's shadow is remembered only once it is proven for all of
// its points (certificates.h): NONE, then only what moves is traced; FULL, then nothing is; else PARTIAL, and the ray
// is cast. So the image is the same to the bit as with every ray traced, whatever the memory holds.
//
// A frame goes: `begin_frame` follows what moved. `classify` and `shadow`, from many threads, answer batches of shadow
// queries, tracing what is not known and noting what those rays saw as evidence. `end_frame` judges the parts with new
// evidence: rays occluded and free in one part make it PARTIAL at no cost; else the one certificate that the evidence
// allows is tried, from the coarsest open part down.
//
// What moves is asked of an image of its outlines as the light sees them, drawn where enough points ask
// (dynamic_mask.h); it also answers points on dynamic objects. What it cannot tell is traced.
//
// Cost a frame: one look-up a query, the mask, the rays of PARTIAL parts and along the dynamic objects' outlines, and
// certificates for what came into view. What stands still and was seen before costs the look-up alone.

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
#include "shadow_culling/dynamic_mask/dynamic_bounds.h"
#include "shadow_culling/dynamic_mask/dynamic_mask.h"

namespace gnomon::shadow_culling {

struct CertifiedOptions {
    double pixels_per_part = 8;        // refine until a part covers about so many pixels
    std::size_t memory = 256u << 20;   // bytes for states and evidence; least recently seen go first
    double rim_margins = 2;            // width of a receiver's rim (rim.h), in margins of the certificates
    CertificateOptions certificates;
    MaskOptions mask;
};

struct CullingCounters {
    std::uint64_t skipped = 0;   // answered without a ray
    std::uint64_t dynamic_only =
        0;   // traced against dynamic objects alone (those that could meet one); the rest of NONE is skipped
    std::uint64_t traced = 0;              // traced against everything
    std::uint64_t partial = 0;             // of these, on parts known to be partial
    std::uint64_t certificates = 0;        // tried
    std::uint64_t certified = 0;           // that held
    std::uint64_t forgotten_records = 0;   // of static objects that started to move
    std::uint64_t forgotten_visited = 0;   // triangles that these could have shadowed, by light: judged again
    void add(const CullingCounters& other);
};

class CertifiedCulling {
 public:
    CertifiedCulling(const scene::SceneState& state, const ray::RayScene& rays, const CertifiedOptions& options);
    ~CertifiedCulling();

    /// After the state advanced and the ray scene followed.
    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, const CullingView& view);

    /// A thread's batch: the points of one tile. Reused from batch to batch.
    class Batch;
    std::unique_ptr<Batch> make_batch() const;

    /// Takes the points of a batch and finds their parts.
    void classify(Batch& batch, std::span<const ShadowPoint> points);
    /// Answers one light for all points of the batch.
    /// @param occluded  by point, with room for 8 more: 1 where the light is behind the surface, or something that
    /// blocks
    ///                 light lies between
    /// @param rays     optional, by point: 1 where a ray was traced against everything, 2 against dynamic objects
    /// alone; else left
    void shadow(Batch& batch, int light, std::uint8_t* occluded, std::uint8_t* rays = nullptr);
    ShadowState state_of(const Batch& batch, std::uint32_t point, int light) const;

    /// Judges what this frame's rays saw in the batches that took part. Order of batches does not matter.
    void end_frame(std::span<const std::unique_ptr<Batch>> batches, Tasks& tasks)
    {
        note_news(batches);
        judge(tasks);
    }
    /// The two halves of it, for who shows the image in between: what was seen is gathered, and judged as long as
    /// `go_on` says so (asked once in a while, from any thread), or without it as far as the frame can afford
    /// certificates by the rays it saved; the rest waits for the next call, in whatever frame. Images never depend on
    /// how much was judged. @return whether nothing is left
    void note_news(std::span<const std::unique_ptr<Batch>> batches);
    bool judge(Tasks& tasks, const std::function<bool()>& go_on = {});
    /// Sums since begin_frame; valid after end_frame.
    const CullingCounters& counters() const { return counters_; }
    /// States, evidence and records.
    std::size_t bytes() const;
    /// The most that evidence took at once; it is freed when it is judged.
    std::size_t most_evidence_bytes() const;
    /// The mask of dynamic objects: room that is used afresh every frame.
    std::size_t mask_bytes() const;
    std::size_t visible_triangles() const { return memory_->live_records(); }

 private:
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
    std::unique_ptr<DynamicBounds> dynamic_;
    std::unique_ptr<DynamicMask> mask_;
    std::vector<char> light_on_;   // its states count: it stands still
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
    static constexpr std::size_t k_strip = 32;   // points that follow each other and share a box

    void find_bounds(std::size_t first);

    std::span<const ShadowPoint> points;
    Box3 bounds;
    std::vector<Box3> strip_bounds;     // of every k_strip points
    LookUp at;                          // by point; no slot: not remembered (moving receiver, rim, or no room)
    std::vector<RecordId> record;       // by point
    std::vector<std::uint8_t> states;   // by group, then point
    std::vector<RecordId> touched;      // records with new evidence, or partial where finer parts may help
    std::size_t stride = 0;             // between groups in `states`: points, padded
    // Scratch of shadow().
    ray::RayQueue static_rays, dynamic_rays;
    std::vector<std::uint32_t> static_point, dynamic_point;
    std::vector<std::uint8_t> then_dynamic;   // by static ray: 1 where what moves is asked if nothing static is hit
    std::vector<std::uint8_t> hit;
    std::vector<Box3> dynamic_objects;
    DynamicMask::Asked asked;
    std::vector<std::uint8_t> strip_open;   // by strip: 1 where a dynamic object may be in the way
    std::vector<std::uint8_t> open;         // by question: 1 where what stands still may be in the way
};

}   // namespace gnomon::shadow_culling
