// SPDX-License-Identifier: Apache-2.0
#pragma once
// The methods that bench indirect measures, behind one interface, and the table of their names.
//
// A method lights a picture's primary hits. It may remember what it likes from frame to frame.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "app/indirect_points.h"
#include "base/tasks.h"

namespace gnomon::app {

/// What a method did for one frame. What does not apply is 0.
struct IndirectWork {
    std::uint64_t clusters = 0;   // lights in use
    std::uint64_t rays = 0;
    std::uint64_t dirty_pixels = 0, dirty_nodes = 0;   // of light maps and of trees over them: changed
    std::uint64_t bytes = 0;                           // held
};

class IndirectMethod {
 public:
    virtual ~IndirectMethod() = default;

    /// After the state advanced and the ray scene followed: light maps and trees are repaired here.
    virtual void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks) = 0;
    /// Irradiance of every pixel of a picture; what its points without a surface get is not read.
    virtual void light(const SeenPicture& picture, Tasks& tasks, glm::vec3* irradiance) = 0;
    /// The same of other points that the picture shows, between its pixels' centres. After light().
    virtual void sample(std::span<const SeenPoint> points, glm::vec3* irradiance) = 0;
    virtual IndirectWork end_frame() = 0;
};

struct IndirectMethodInfo {
    std::string name;    // as given: "visible", "rsm:256"
    std::string title;   // for people
    /// Cost: everything that the method prepares, as if nothing were remembered.
    std::unique_ptr<IndirectMethod> (*make)(const IndirectMethodInfo& info, const scene::SceneState& state,
                                            const ray::RayScene& rays, Tasks& tasks);
    int number = 0;   // after the colon
    std::unique_ptr<IndirectMethod> make_for(const scene::SceneState& state, const ray::RayScene& rays,
                                             Tasks& tasks) const
    {
        return make(*this, state, rays, tasks);
    }
};

/// @throws UsageError  no such method
IndirectMethodInfo find_indirect_method(const std::string& name);

}   // namespace gnomon::app
