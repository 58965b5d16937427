// SPDX-License-Identifier: Apache-2.0
#pragma once
// Writes the results of bench shadow-textures as a section of a report: Figures 7 and 8 of the paper, measured here and
// with its printed values [Oh and Shin 2004, 4], for the whole frame and for the shadow pass.

#include "bench/report/page.h"
#include "bench/shadow_textures/bench.h"

namespace gnomon::bench {

void add_shadow_textures_section(ReportPage& page, const std::string& command,
                                 const ShadowTexturesBenchOptions& options, const ShadowTexturesBenchResult& result,
                                 const nlohmann::ordered_json& document);

/// The JSON document of bench shadow-textures.
nlohmann::ordered_json shadow_textures_json(const ShadowTexturesBenchOptions& options,
                                            const ShadowTexturesBenchResult& result);

}   // namespace gnomon::bench
