// SPDX-License-Identifier: Apache-2.0
#pragma once
// The JSON document of bench culling: every frame, and a summary. Its keys are stable; tests/cli/json_test.cpp checks
// them.

#include <nlohmann/json_fwd.hpp>

#include "bench/culling/window.h"

namespace gnomon::bench {

/// Returns {"frames": [...], "summary": {...}} with the methods that were run and the counts if they were taken.
nlohmann::ordered_json culling_json(const CullingWindow& window);

}   // namespace gnomon::bench
