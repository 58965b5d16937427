// SPDX-License-Identifier: Apache-2.0
#pragma once
// Writes the results of bench lights as a section of a report: what is proven of each light, what it costs beside
// shadow rays, images, and the rasterised frame beside the traced one.

#include "bench/lights/bench.h"
#include "bench/lights/raster.h"
#include "bench/report/page.h"

namespace gnomon::bench {

/// The first frame measured, and the states of its shadows.
struct LightsImages {
    Image8 traced, states;
    RasterLightsResult raster;
};
/// Renders the scene with squares in place of its lights, all together.
/// @throws InterruptedError
LightsImages lights_images(const std::shared_ptr<const scene::Scene>& scene, const LightsBenchOptions& options,
                           const Progress& progress);

void add_lights_section(ReportPage& page, const std::string& command, const LightsBenchOptions& options,
                        const LightsBenchResult& result, const LightsImages& images,
                        const nlohmann::ordered_json& document);

/// The JSON document of bench lights.
/// @param images  of a report; nullptr: none was asked for
nlohmann::ordered_json lights_json(const LightsBenchResult& result, const LightsImages* images);

}   // namespace gnomon::bench
