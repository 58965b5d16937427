// SPDX-License-Identifier: Apache-2.0
#pragma once
// bench shadow-textures as a section of a report: Figures 7 and 8 of the paper redrawn, with what it prints beside
// [Oh and Shin 2004, 4]; whole frame and shadow pass apart.

#include "bench/report/page.h"
#include "bench/shadow_textures/bench.h"

namespace gnomon::bench {

void add_shadow_textures_section(ReportPage& page, const std::string& command,
                                 const ShadowTexturesBenchOptions& options, const ShadowTexturesBenchResult& result,
                                 const nlohmann::ordered_json& document);

/// The document of bench shadow-textures.
nlohmann::ordered_json shadow_textures_json(const ShadowTexturesBenchOptions& options,
                                            const ShadowTexturesBenchResult& result);

}   // namespace gnomon::bench
