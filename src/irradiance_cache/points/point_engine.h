// SPDX-License-Identifier: Apache-2.0
#pragma once
// Who cuts the emitters' tree for surface points and sums what they see, if not the processor's threads: a device
// (vulkan/gpu_points.h). Visibility, too, if it can.
//
// Many points at a time: VisibleLight collects all that an image needs before it asks. What a point sees is kept on
// the engine's side. Its arithmetic is that of point_kernels.h up to rounding, and repeatable.

#include <span>
#include <vector>

#include "irradiance_cache/light_tree/point_kernels.h"
#include "ray/ray_scene.h"

namespace gnomon::irradiance_cache {

/// A point that wants its cut: cut_tree()'s arguments.
struct CutRequest {
    glm::vec3 origin{0};
    float error = 0;
    glm::vec3 normal{0};
    float estimate = 0;
};

/// Cuts of some points: of point p, nodes first[p] ... first[p + 1] - 1, and what a unit of flux of each brings.
struct PointCuts {
    std::vector<std::uint32_t> first;
    std::vector<NodeId> node;
    std::vector<float> weight;
};

/// Seen nodes that an engine keeps.
struct KeptNodes {
    std::uint32_t name = 0, count = 0;
};

/// A point that wants the present light of its seen nodes.
struct SumRequest {
    glm::vec3 origin{0};
    KeptNodes seen;
};

/// Present flux times weight times direction over seen nodes, by point and colour; but for nodes whose way to the point
/// passes something that moves: those are listed, if they have any flux.
struct PointSums {
    struct Light {
        glm::vec3 of[3];   // by colour
    };
    struct Crossed {
        std::uint32_t point;   // among the requests
        std::uint32_t place;   // in its list
        SeenNode seen;
    };
    std::vector<Light> light;
    std::vector<Crossed> crossed;   // by point and place, rising
};

class PointEngine {
 public:
    virtual ~PointEngine() = default;

    /// After the tree followed the frame. What is kept stays; it is the caller's to forget it where nodes were made
    /// anew.
    virtual void begin_frame(const EmitterTree& tree, const MovingSpheres& dynamic_objects) = 0;

    /// As cut_tree().
    virtual void cut(std::span<const CutRequest> points, const CutOptions& options, PointCuts& cuts) = 0;

    /// Keeps lists that lie one after another, each padded with 0 to k_seen_step.
    /// @param lists  in: their lengths without what pads them; out: their names
    virtual void keep(std::span<const SeenNode> seen, std::span<KeptNodes> lists) = 0;
    virtual void forget(const KeptNodes& list) = 0;

    virtual void sum(std::span<const SumRequest> points, PointSums& sums) = 0;

    /// It answers rays, too.
    virtual bool traces() const { return false; }
    /// As RayScene::occluded(), for all of a queue. Only if it traces.
    virtual void occluded(const ray::RayQueue& rays, std::uint8_t* occluded, ray::Against against);

    /// Of its own memory, seen nodes apart.
    virtual std::size_t bytes() const = 0;
};

}   // namespace gnomon::irradiance_cache
