// SPDX-License-Identifier: Apache-2.0
#pragma once
// The bounds of a scene that light views and light maps cover.
//
// clip_bounds() depends on the scene alone: it is where tracks take things over the clip. Overrides may take objects
// anywhere. PresentBounds enlarges the bounds by what is outside now, in steps of powers of two, so that they change
// rarely. They are a function of the scene and the present state, never of earlier frames, and an override with the
// values of the tracks has no effect on them.

#include <map>
#include <unordered_map>

#include "base/bits.h"
#include "base/math.h"
#include "scene/ids.h"

namespace gnomon::scene {

class Scene;
class SceneState;

struct SceneBounds {
    Box3 whole;
    Box3 dense;   // contains most triangles of the file
    friend bool operator==(const SceneBounds& a, const SceneBounds& b)
    {
        return same_bits(a.whole, b.whole) && same_bits(a.dense, b.dense);
    }
};

/// Bounds of everything at the times of the clip's frames (at most `most_times` of them, evenly spaced), hidden or not.
/// Depends on the scene only. Deforming meshes: rest shape and vertex keys.
SceneBounds clip_bounds(const Scene& scene, int most_times = 256);

/// The clip's bounds; each side that a box exceeds moves outwards by the least power of two times the clip's extent
/// along that axis, from a sixteenth on, that encloses the box.
/// @param outside  what to enclose; may be empty
Box3 enlarged_bounds(const Box3& clip, const Box3& outside);

/// The present bounds of a state, and the objects that are outside of the clip's.
class PresentBounds {
 public:
    /// Computes the clip's bounds. Cost: those, and the dynamic objects if any override is in force.
    explicit PresentBounds(const SceneState& state);

    /// Call after each advance(). Cost: the objects that changed, and those outside; nothing without overrides.
    void follow(const SceneState& state);
    const SceneBounds& present() const { return present_; }

 private:
    void measure(const SceneState& state, ObjectId object);
    void enlarge(const SceneState& state);

    SceneBounds clip_, present_;
    bool watching_ = false;              // overrides are in force, so outside_ is up to date
    std::map<ObjectId, Box3> outside_;   // visible casting objects whose boxes exceed the clip's bounds
    struct MeshFacts {
        Box3 box;
        bool casts = false;
    };
    const MeshFacts& facts_of(const Scene& scene, MeshId mesh);
    std::unordered_map<MeshId, MeshFacts> meshes_;   // of objects that were measured
};

}   // namespace gnomon::scene
