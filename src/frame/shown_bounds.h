// SPDX-License-Identifier: Apache-2.0
#pragma once
// The bounds of what a frame shows, without what the library added by itself, such as a ground: it is wider than the
// scene, which would be small in a view that shows all of both.
//
// Cost: a scene's meshes once, then its objects. Deformed objects count as they are when nothing deforms them.

#include <vector>

#include "scene/state.h"

namespace gnomon::frame {

class ShownBounds {
 public:
    /// Whether the scene has an object that its file does not have.
    static bool adds_to(const scene::Scene& scene);
    /// In the state's space.
    Box3 of(const scene::SceneState& state);
    void forget() { meshes_.clear(); }

 private:
    std::vector<Box3> meshes_;   // in their own space
};

}   // namespace gnomon::frame
