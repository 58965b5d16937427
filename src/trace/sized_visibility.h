// SPDX-License-Identifier: Apache-2.0
#pragma once
// Interface of the techniques that find how much of a light with size the points of the traced frame see, and the
// technique that remembers nothing: SampledVisibility, a shadow ray to every sample place.
//
// The answer for a point is one of: the whole light is visible (lit), none of it is (dark), or how much of each of the
// light's sample places (scene/sized_light.h, or finer ones of the technique's own). The caller multiplies the light's
// unshadowed contribution by the ratio of the visible places' weights to all places' weights, each for the diffuse and
// for the glossy lobe; or by the diffuse share that the technique has computed.
//
// Cost of SampledVisibility: a ray per point and place that face each other.

#include <memory>
#include <span>
#include <vector>

#include "scene/sized_light.h"
#include "trace/point_batch.h"
#include "trace/state_map.h"

namespace gnomon::trace {

/// What the asked points of a batch see of one light.
struct SizedVisible {
    enum class Answer : std::uint8_t {
        dark,      // no place of the light is visible
        lit,       // every place that faces the point, and that the point faces, is visible
        partial,   // some are, as a whole or in part
    };
    static constexpr std::uint8_t k_whole = 16;   // a place that is visible as a whole

    std::vector<Answer> answer;   // by asked point
    /// The places that `seen` is about, by asked point: the light's own, or the technique's. Valid until its
    /// end_frame().
    std::vector<const std::vector<scene::SizedPlace>*> places;
    /// Only for `partial`: where the point's numbers begin in `seen`; one for each place, up to k_whole.
    std::vector<std::size_t> first;
    std::vector<std::uint8_t> seen;
    /// Only for `partial`: the visible share of the irradiance, if the light has one radiance; negative: not computed.
    std::vector<float> share;
    /// What is remembered, by asked point: nothing (unknown), or as StateMark says; away: the light is behind.
    std::vector<StateMark> state;

    std::span<const std::uint8_t> seen_by(std::size_t asked) const
    {
        return {seen.data() + first[asked], places[asked]->size()};
    }
    /// Sizes the lists; every answer is dark.
    void reset(std::size_t asked)
    {
        answer.assign(asked, Answer::dark);
        places.assign(asked, nullptr);
        first.assign(asked, 0);
        share.assign(asked, -1);
        state.assign(asked, StateMark::unknown);
        seen.clear();
    }
    /// Makes a point's answer partial, with nothing visible.
    /// @return  its numbers; valid until the next call
    std::uint8_t* add_partial(std::size_t asked, const std::vector<scene::SizedPlace>& of)
    {
        answer[asked] = Answer::partial;
        places[asked] = &of;
        first[asked] = seen.size();
        seen.resize(seen.size() + of.size());
        return seen.data() + first[asked];
    }
};

class SizedVisibility {
 public:
    virtual ~SizedVisibility() = default;

    /// After the state advanced, and the ray scene and the lights followed. Outside the frame's parallel part, as
    /// end_frame(). All arguments outlive the frame.
    virtual void begin_frame(const FrameContext& frame, const scene::SizedLights& lights) = 0;

    /// The scratch memory of one thread, for one frame.
    class Worker {
     public:
        virtual ~Worker() = default;
        /// Prepares for all lights of a batch; called once, before its find_visible().
        virtual void prepare(const PointBatch&) {}
        /// Finds what points of the prepared batch see of a light. Rays start at PointBatch::shadow_points[].origin.
        /// @param light   index in SizedLights::lights()
        /// @param points  of the batch, ascending; each has some of the light above its horizons
        /// @param result  overwritten; by index in `points`
        virtual void find_visible(const PointBatch& batch, std::uint32_t light, std::span<const std::uint32_t> points,
                                  SizedVisible& result) = 0;
    };
    virtual std::unique_ptr<Worker> make_worker() = 0;

    /// @param workers  those that took part
    virtual FrameCounters::Shadow end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks) = 0;
};

/// Traces a shadow ray to every sample place that faces the point: the reference of the techniques that remember.
class SampledVisibility final : public SizedVisibility {
 public:
    void begin_frame(const FrameContext& frame, const scene::SizedLights& lights) override;
    std::unique_ptr<Worker> make_worker() override;
    FrameCounters::Shadow end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks) override;

 private:
    class Work;
    const scene::SizedLights* lights_ = nullptr;
    const ray::RayScene* rays_ = nullptr;
};

}   // namespace gnomon::trace
