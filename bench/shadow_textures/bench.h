// SPDX-License-Identifier: Apache-2.0
#pragma once
// What shadow textures cost by each method [Oh and Shin 2004, 4]: for every receiver all casters between it and the
// light; one depth buffer for all receivers; that buffer and the textures kept from frame to frame; and, as images
// are made, the same with one buffer of items in place of all textures.
//
// All methods of a setting follow the same motion, frame by frame in turn; times are medians over the frames after the
// first two: in the first everything is drawn, in the second those who move are found out. On a hardware device they
// are its timestamps. A software driver's work is done by this process, and copies and compute passes have no honest
// timestamps there: so they are process CPU time. Figure and clock are said together. After the last frame every
// method's textures (and the light view's buffers) are compared, to the bit, with those of a full redraw.
//
// Of crowds the update alone is measured, all of them side by side; their image is drawn once, at the end.

#include <optional>
#include <string>
#include <vector>

#include "base/image.h"
#include "gnomon/types.h"

namespace gnomon::bench {

enum class TextureMethod : std::uint8_t { per_caster, depth, coherent, items };
/// As on the command line.
const char* name_of(TextureMethod method);
/// All but per_caster, which is slow.
std::vector<TextureMethod> usual_methods();

struct ShadowTexturesBenchOptions {
    std::vector<int> objects{300};
    std::vector<double> dynamic{10};      // percent; ignored with dynamic objects
    std::optional<int> dynamic_objects;   // in a crowd of small objects: scene::SpheresOptions::crowd
    int vertices = 2037;
    Size size{512, 512};    // of the whole frame's image
    int view_size = 1024;   // texels a side of the light's view
    int frames = 7;
    std::vector<TextureMethod> methods = usual_methods();
};

struct ShadowTexturesRow {
    int objects = 0;
    double dynamic_percent = 0;
    int dynamic_objects = 0;
    TextureMethod method = TextureMethod::depth;
    double buffers_ms = 0;      // of shadow_ms: the light view's depths and items, and where casters are
    double textures_ms = 0;     // of shadow_ms: the receivers' textures, which the items could stand for
    double shadow_ms = 0;       // the shadow pass
    double shadow_cpu_ms = 0;   // planning and recording it, on one thread, without what the device does
    double frame_ms = 0;        // shadow pass and image; of a crowd: with the one image at the end
    // Means a frame.
    double draws = 0, copies = 0, textures_updated = 0;
    double touched = 0;   // objects and index entries looked at
    bool identical_to_full = false;
};

struct ShadowTexturesBenchResult {
    std::string device, clock;
    std::vector<ShadowTexturesRow> rows;
    /// Of shadow_ms over objects, by method, at the first share of dynamic objects; where there are several numbers of
    /// objects.
    std::vector<std::pair<TextureMethod, double>> exponents;
    Image8 image;   // of the last frame and method
};

/// @throws MissingError      no Vulkan
/// @throws InterruptedError  progress returned false
ShadowTexturesBenchResult bench_shadow_textures(const ShadowTexturesBenchOptions& options,
                                                const Progress& progress = {});

/// Slope of log y over log x by least squares; x and y above 0, at least two different x.
double growth_exponent(const std::vector<std::pair<double, double>>& points);

}   // namespace gnomon::bench
