// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a Frame shows: the layers that the engine rendered, or an overlay in their place.

#include <string>
#include <vector>

#include "base/image.h"
#include "frame/frame_engine.h"
#include "frame/state_overlay.h"
#include "gnomon/frame.h"
#include "gnomon/renderer.h"

namespace gnomon::api {

/// Exposes the engine's image, and lists its layers.
/// @param exposure  in stops; none: automatic, and the same for every background: what is left out behind the scene
///                  counts as if it were shown
void set_layers(frame::FrameEngine& engine, const scene::Scene& scene, const scene::View& view,
                const RenderOptions& options, std::optional<double> exposure, Frame& result);

/// Makes an overlay, which is in screen colours, the only layer.
void set_overlay(const Image8& image, Frame& result);

/// The panels of an overlay of shadow states: lights, and from the scene's number of lights on those of lights with
/// size (frame/state_overlay.h). Traced frames light with emissive surfaces, not with the lights that approximate them;
/// the published method knows lights alone.
/// @throws UsageError  there are none; no such light
std::vector<int> overlay_lights(const scene::Scene& scene, const RenderOptions& options);

/// @param frame  0: none
std::vector<std::string> overlay_titles(const scene::Scene& scene, const std::vector<int>& lights, int frame);

/// What an overlay of shadow states shows and explains.
/// @param lights  of overlay_lights()
frame::OverlayKind overlay_kind(const scene::Scene& scene, const RenderOptions& options,
                                const std::vector<int>& lights);

/// Notes where a frame is seen from, and what its results depend on.
/// @param origin  SceneStamps::origin
void describe(const scene::View& view, const glm::dvec3& origin, const RenderOptions& options, Frame& result);

/// The instruction set that results depend on: "auto", since portable arithmetic gives the same bytes under every one,
/// or "native-NAME".
std::string instruction_set_of(const RenderOptions& options);

/// @throws UsageError  the overlay cannot be shown
void check_overlay(const scene::Scene& scene, const RenderOptions& options, Size size);

/// The size that options ask for, else the camera's, else the default.
Size rendered_size(Size wanted, Size of_camera);

}   // namespace gnomon::api
