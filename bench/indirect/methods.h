// SPDX-License-Identifier: Apache-2.0
#pragma once
// The methods for indirect light that bench indirect measures, with one interface, and the table of their names.
//
// A method computes irradiance at the primary hits of an image. It may keep any data from frame to frame.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/tasks.h"
#include "bench/indirect/points.h"

namespace gnomon::bench {

/// The work of a method in one frame. Counters that do not apply are 0.
struct IndirectWork {
    std::uint64_t clusters = 0;   // virtual point lights used
    std::uint64_t rays = 0;
    std::uint64_t dirty_pixels = 0, dirty_nodes = 0;   // texels of light maps and nodes of light trees that changed
    std::uint64_t bytes = 0;                           // memory in use
    std::uint64_t rays_left_out = 0;                   // with shadows of clusters: pairs known without a ray
};

/// Milliseconds measured by the method itself, because a clock around its calls would not measure the device's work.
struct IndirectTimes {
    struct Took {
        double wall = 0, cpu = 0;
    };
    Took made, begun, lit;   // of the construction, and of the last begin_frame() and light()
};

class IndirectMethod {
 public:
    virtual ~IndirectMethod() = default;

    /// Spacing in pixels of the sparse receivers that light() needs in the image; 0 if it needs none.
    virtual int grid_step(Size) const { return 0; }

    /// Forgets everything that it keeps from frame to frame, as if something had moved in the paper. Returns false if
    /// the method has no such state of the paper's.
    virtual bool forget() { return false; }
    /// Repairs light maps and trees. Call it after the scene state and the ray scene are updated.
    virtual void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks) = 0;
    /// Computes the irradiance of every pixel of an image. Values of pixels without a surface are not read.
    virtual void light(const SeenImage& image, Tasks& tasks, glm::vec3* irradiance) = 0;
    /// Computes the irradiance of other points visible in the image, between pixel centres. Call it after light().
    virtual void sample(std::span<const SeenPoint> points, glm::vec3* irradiance) = 0;
    virtual IndirectWork end_frame() = 0;
    /// The times measured by the method itself; null if a clock around its calls is right.
    virtual const IndirectTimes* own_times() const { return nullptr; }
};

/// The settings that are not part of a method's name.
struct IndirectSettings {
    double depth_threshold = 0.05;    // quadtree: as a fraction of the light view's depth range
    double normal_threshold = 0.9;    // quadtree: least cosine
    bool full = false;                // rsm, quadtree: every pixel is a receiver
    bool vulkan = false;              // rsm, quadtree: run on a Vulkan device
    std::size_t memory = 16u << 20;   // visible: size of the irradiance cache, in bytes
    int bounces = 1;                  // visible: diffuse bounces; beyond 64, all
    double radius = 0.3;              // rsm: radius of the disk in sides of the light map, unless the name states one
    double margin = 0;                // quadtree, separate, shadowed: margin of validity, unless the name states one
};

struct IndirectMethodInfo {
    std::string name;    // as given: "visible", "rsm:256", "rsm:256:0.6", "quadtree:6:0.5"
    std::string title;   // description for reports
    IndirectSettings settings;
    /// Constructs the method. Cost: all its preparations, without cached data.
    std::unique_ptr<IndirectMethod> (*make)(const IndirectMethodInfo& info, const scene::SceneState& state,
                                            const ray::RayScene& rays, Tasks& tasks);
    int number = 0;        // after the colon
    bool vulkan = false;   // on a Vulkan device
    bool visible = true;   // takes visibility into account; if not, it is also compared with brute_irradiance()
    bool walks = true;     // is also measured while only the view moves
    std::unique_ptr<IndirectMethod> make_for(const scene::SceneState& state, const ray::RayScene& rays,
                                             Tasks& tasks) const
    {
        return make(*this, state, rays, tasks);
    }
};

/// @throws UsageError  if there is no such method, or its number or radius is out of range
IndirectMethodInfo find_indirect_method(const std::string& name, const IndirectSettings& settings);

/// The irradiance at points from all texels of the scene's light maps, without visibility, with the kernel of rsm and
/// quadtree, which approximate it. Cost: one light map, then O(texels * points).
std::vector<glm::vec3> brute_irradiance(const scene::SceneState& state, const ray::RayScene& rays,
                                        std::span<const SeenPoint> points, Tasks& tasks);

}   // namespace gnomon::bench
