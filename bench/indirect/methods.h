// SPDX-License-Identifier: Apache-2.0
#pragma once
// The methods that bench indirect measures, behind one interface, and the table of their names.
//
// A method lights an image's primary hits. It may remember what it likes from frame to frame.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/tasks.h"
#include "bench/indirect/points.h"

namespace gnomon::bench {

/// What a method did for one frame. What does not apply is 0.
struct IndirectWork {
    std::uint64_t clusters = 0;   // lights in use
    std::uint64_t rays = 0;
    std::uint64_t dirty_pixels = 0, dirty_nodes = 0;   // of light maps and of trees over them: changed
    std::uint64_t bytes = 0;                           // held
};

/// Milliseconds that a method took, where it knows better than a clock around its calls: of what a device does.
struct IndirectTimes {
    struct Took {
        double wall = 0, cpu = 0;
    };
    Took made, begun, lit;   // by its construction; by the last begin_frame() and light()
};

class IndirectMethod {
 public:
    virtual ~IndirectMethod() = default;

    /// Pixels between two of the sparse receivers that light() finds in the image; 0: it needs none.
    virtual int grid_step(Size) const { return 0; }

    /// After the state advanced and the ray scene followed: light maps and trees are repaired here.
    virtual void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks) = 0;
    /// Irradiance of every pixel of an image; what its points without a surface get is not read.
    virtual void light(const SeenImage& image, Tasks& tasks, glm::vec3* irradiance) = 0;
    /// The same of other points that the image shows, between its pixels' centres. After light().
    virtual void sample(std::span<const SeenPoint> points, glm::vec3* irradiance) = 0;
    virtual IndirectWork end_frame() = 0;
    /// Null: what its calls take is what it takes.
    virtual const IndirectTimes* own_times() const { return nullptr; }
};

/// What is not in a method's name.
struct IndirectSettings {
    double depth_threshold = 0.05;    // of quadtree; a fraction of the light view's depth range
    double normal_threshold = 0.9;    // of quadtree; least cosine
    bool full = false;                // rsm, quadtree: every pixel gathers
    bool vulkan = false;              // rsm, quadtree: on a Vulkan device
    std::size_t memory = 16u << 20;   // visible: of remembered points, in bytes
    double radius = 0.3;              // of rsm's disk, in sides of the light map; rsm:SAMPLES:RADIUS says another
};

struct IndirectMethodInfo {
    std::string name;    // as given: "visible", "rsm:256", "rsm:256:0.6"
    std::string title;   // for people
    IndirectSettings settings;
    /// Cost: everything that the method prepares, as if nothing were remembered.
    std::unique_ptr<IndirectMethod> (*make)(const IndirectMethodInfo& info, const scene::SceneState& state,
                                            const ray::RayScene& rays, Tasks& tasks);
    int number = 0;        // after the colon
    bool vulkan = false;   // on a Vulkan device
    bool visible = true;   // knows what stands in light's way; else it is also judged by brute_irradiance()
    bool walks = true;     // is also judged while the view alone moves
    std::unique_ptr<IndirectMethod> make_for(const scene::SceneState& state, const ray::RayScene& rays,
                                             Tasks& tasks) const
    {
        return make(*this, state, rays, tasks);
    }
};

/// @throws UsageError  no such method
IndirectMethodInfo find_indirect_method(const std::string& name, const IndirectSettings& settings);

/// The light of all texels of the scene's light maps at points, by the kernel of rsm and quadtree, whatever stands
/// between: what both approximate. Cost: a light map; then texels times points.
std::vector<glm::vec3> brute_irradiance(const scene::SceneState& state, const ray::RayScene& rays,
                                        std::span<const SeenPoint> points, Tasks& tasks);

}   // namespace gnomon::bench
