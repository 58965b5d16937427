// SPDX-License-Identifier: Apache-2.0
#pragma once
// Chooses the camera of a scene without one, by what small test images show.
//
// Objects are framed whole, from the right and a little above; flat objects more steeply, upright panels more from
// their front. If the image from there shows mostly the unseen backs of one-sided surfaces, or nothing, other
// directions are tried, and the one that shows most is taken. A camera goes inside only if the geometry encloses it,
// most of the scene cannot be seen from outside, and the image from inside is full of surfaces that face it.

#include <optional>

#include "scene/defaults/framing.h"
#include "scene/defaults/interior.h"
#include "scene/defaults/test_image.h"

namespace gnomon::scene {

struct DefaultViewOptions {
    float hidden = 0.5f;   // at least this fraction of the surface must not be seen from outside for a view from inside
    float enclosed = 0.85f;        // at least this fraction of the pixels must then show surfaces that face the camera
    float enough = 0.6f;           // of the pixels with surfaces, the fraction that must show the first one
    float edges = 0.004f;          // of the pixels of a view from inside: beside another object or a face at an angle
    float least_shown = 0.0007f;   // of the pixels: an image with less is blank
};

struct DefaultView {
    std::optional<Interior> room;   // the camera is inside, or before a stage
    Camera camera;                  // without a node
    glm::dmat3 axes{1};             // right, up and back
    glm::dvec3 eye{0};              // at CameraFit::k_node_aspect
};

/// What the choice of a camera finds out about a scene, so that the choice of surroundings need not ask again. It holds
/// as long as no object is added or changed.
struct Survey {
    bool judged = false;            // whether `room` is known
    std::optional<Interior> room;   // believed_interior()
    std::optional<Framed> clip;     // the box and the size of all objects, as box_of_clip() gives them
};

/// @param found  what was found out; may be null
DefaultView choose_view(const SceneState& state, const DefaultViewOptions& options = {}, Survey* found = nullptr);

/// add_default_camera() of scene.h, and what it found out.
void add_default_camera(Scene& scene, Survey& found);

/// Makes sure that the first camera of a scene that has some shows a surface at some time: if it does not, the next one
/// that does comes first, or a default camera if none does. Says so in a warning. Orthographic cameras are not judged.
/// Call after finish().
void judge_cameras(Scene& scene, const DefaultViewOptions& options = {});

/// A room that is seen from inside, or nothing: find_interior(), judged by test images. A stage is believed as it is.
std::optional<Interior> believed_interior(const SceneState& state, const DefaultViewOptions& options = {});

/// What a view shows in a square image.
TestImage test_image_of(const SceneState& state, const Camera& camera, const glm::dmat4& camera_to_world);

}   // namespace gnomon::scene
