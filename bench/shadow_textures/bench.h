// SPDX-License-Identifier: Apache-2.0
#pragma once
// Measures the cost of shadow textures by method [Oh and Shin 2004, 4], with the renderer's names and code
// (shadow_textures/shadow_method.h): per_caster draws, for every receiver, the casters between it and the light whose
// extents meet its own; depth draws one depth buffer for all receivers; coherent keeps that buffer and the textures
// from frame to frame; items does the same with one item buffer in place of all textures.
//
// All methods of a setting follow the same motion, frame by frame in turn. Times are medians over the frames after the
// first two: the first draws everything, and the second detects the dynamic objects. On a hardware device they are its
// timestamps. On a software device they are process CPU times, because the work runs in this process and timestamps of
// copies and compute passes are unreliable there. Results state the clock. After the last frame the textures of every
// method (and the light view's buffers) are compared to the bit with those of a full redraw.
//
// For crowds only the update is measured, all crowds frame by frame in turn; their image is drawn once at the end.

#include <optional>
#include <string>
#include <vector>

#include "base/image.h"
#include "gnomon/renderer.h"

namespace gnomon::bench {

/// All methods except per_caster, which is slow.
std::vector<ShadowTextures> usual_methods();

struct ShadowTexturesBenchOptions {
    std::vector<int> objects{300};
    std::vector<double> dynamic{10};      // percent of dynamic objects; ignored if dynamic_objects is set
    std::optional<int> dynamic_objects;   // their number, in a crowd of small objects: scene::SpheresOptions::crowd
    int vertices = 2037;
    Size size{512, 512};    // of the image
    int view_size = 1024;   // texels along a side of the light view
    int frames = 7;
    std::vector<ShadowTextures> methods = usual_methods();
    /// The texture's colour decides alone, and per_caster draws all casters nearer than the receiver.
    bool as_printed = false;
    /// Measure a further coherent method, which makes textures again by footprints alone (LightViewsOptions).
    bool by_footprints = false;
    bool images = false;   // keep images of every setting, by both look-ups
};

/// The last frame of a setting.
struct ShadowTexturesImages {
    int objects = 0, dynamic_objects = 0;
    Image8 compared, as_printed;   // distances are compared; the texture's colour decides
};

struct ShadowTexturesRow {
    int objects = 0;
    double dynamic_percent = 0;
    int dynamic_objects = 0;
    ShadowTextures method = ShadowTextures::depth;
    bool by_footprints = false;
    double buffers_ms = 0;      // part of shadow_ms: the light view's buffers and the casters' transforms
    double textures_ms = 0;     // part of shadow_ms: the receivers' textures
    double shadow_ms = 0;       // the shadow pass
    double shadow_cpu_ms = 0;   // planning and recording it on one thread, without the device's work
    double frame_ms = 0;        // shadow pass and image; for a crowd with the one image drawn at the end
    // Means per frame.
    double draws = 0, copies = 0, textures_updated = 0;
    double draws_of_all_between = 0;   // per_caster: of the shadow pass, if extents were not tested
    double touched = 0;                // objects and index entries visited
    bool identical_to_full = false;
    /// Percent of the last frame's pixels in which the texture's colour alone decides otherwise than distances, with
    /// hard edges.
    double printed_wrong_percent = 0;
};

struct ShadowTexturesBenchResult {
    std::string device, clock;
    std::vector<ShadowTexturesRow> rows;
    /// Growth of shadow_ms with the number of objects, by method, at the first percentage of dynamic objects. Empty
    /// unless there are several numbers of objects.
    std::vector<std::pair<ShadowTextures, double>> exponents;
    std::vector<ShadowTexturesImages> images;   // by setting, if asked for
};

/// @throws MissingError      no Vulkan
/// @throws InterruptedError  progress returned false
ShadowTexturesBenchResult bench_shadow_textures(const ShadowTexturesBenchOptions& options,
                                                const Progress& progress = {});

/// That of the method, as in the renderer, or "by-footprints".
std::string name_of(const ShadowTexturesRow& row);

/// The slope of log y over log x by least squares; needs x and y above 0 and at least two different x.
double growth_exponent(const std::vector<std::pair<double, double>>& points);

}   // namespace gnomon::bench
