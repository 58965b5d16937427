// SPDX-License-Identifier: Apache-2.0
#pragma once
// A device that cuts the light tree for surface points and sums the light of the nodes that they see
// (vulkan/gpu_points.h). It may trace visibility rays, too.
//
// It works on many points at a time (device_evaluator.h) and keeps the visible nodes of each. Its arithmetic equals
// that of point_kernels.h up to rounding, and is repeatable.

#include <span>
#include <vector>

#include "irradiance_cache/light_tree/point_kernels.h"
#include "ray/ray_scene.h"

namespace gnomon::irradiance_cache {

/// The arguments of cut_tree() for a point.
struct CutRequest {
    glm::vec3 origin{0};
    float error = 0;
    glm::vec3 normal{0};
    float estimate = 0;
};

/// Cuts of some points. Point p has the nodes first[p] ... first[p + 1] - 1, each with what a unit of its flux brings.
struct PointCuts {
    std::vector<std::uint32_t> first;
    std::vector<NodeId> node;
    std::vector<float> weight;
};

/// A list of visible nodes that a device keeps.
struct KeptNodes {
    std::uint32_t name = 0, count = 0;
};

/// A point whose present light is to be summed.
struct SumRequest {
    glm::vec3 origin{0};
    KeptNodes seen;
};

/// Present flux times weight times direction, summed over visible nodes, by point and colour. Nodes whose path to the
/// point crosses the bounds of a dynamic object are not summed but listed, if they have any flux.
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

class PointDevice {
 public:
    virtual ~PointDevice() = default;

    /// After the tree followed the frame. Kept lists stay; the caller forgets those of nodes that were made again.
    virtual void begin_frame(const LightTree& tree, const MovingSpheres& dynamic_bounds) = 0;

    /// Like cut_tree().
    virtual void cut(std::span<const CutRequest> points, const CutOptions& options, PointCuts& cuts) = 0;

    /// Keeps lists that lie one after another, each padded with 0 to k_seen_step.
    /// @param lists  in: their lengths without padding; out: their names
    virtual void keep(std::span<const SeenNode> seen, std::span<KeptNodes> lists) = 0;
    virtual void forget(const KeptNodes& list) = 0;

    virtual void sum(std::span<const SumRequest> points, PointSums& sums) = 0;

    /// Whether it traces rays, too.
    virtual bool traces() const { return false; }
    /// Like RayScene::occluded(), for all rays of a queue; for one thread at a time. Only if it traces.
    virtual void occluded(const ray::RayQueue& rays, std::uint8_t* occluded, ray::Against against);

    /// Bytes of its memory, kept lists aside.
    virtual std::size_t bytes() const = 0;
};

}   // namespace gnomon::irradiance_cache
