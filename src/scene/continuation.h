// SPDX-License-Identifier: Apache-2.0
#pragma once
// A scene with other parts, numbered so that what is remembered about the parts that stay remains true.
//
// A host that adds or removes an instance finishes its builder again and has another scene, in which all objects are
// numbered anew. A continuation is the same scene, but objects and rigid groups that were there before keep their
// numbers. Objects that are gone stay in the list, marked as removed, until one that is added takes the number of one
// with the same mesh. What is new comes at the end.
//
// Only dynamic objects can be added or removed. Static geometry, lights, tracks and skins must stay as they are,
// because nearly everything that is remembered depends on them. An environment image may be replaced by another one,
// with the lights that approximate it.
//
// Cost: O(nodes + objects + meshes + materials), comparisons for the most part.

#include <memory>
#include <optional>
#include <vector>

#include "scene/scene.h"

namespace gnomon::scene {

struct Continuation {
    std::shared_ptr<const Scene> scene;
    std::vector<NodeId> replaced;   // new, or different from before, or below such a node; ascending
    std::vector<ObjectId> added;    // ascending, as the next list
    std::vector<ObjectId> removed;
    bool other_environment = false;   // another image than before
    std::vector<MaterialId> edited;   // values differ, in use before and after; same_to_rays() to before
};

/// Numbers a scene's parts as another scene has them.
/// @param before  the scene so far: one that was finished, or that of a continuation
/// @param wanted  a finished scene
/// @return  none if more differs than dynamic objects, cameras, values of lights and materials, and the image of an
/// environment; or if so much was removed that it is better to begin anew
std::optional<Continuation> continuation(const Scene& before, const Scene& wanted);

}   // namespace gnomon::scene
