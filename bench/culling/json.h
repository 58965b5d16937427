// SPDX-License-Identifier: Apache-2.0
#pragma once
// The document of bench culling: every frame, and a summary. Its keys are a contract; tests/cli/json_test.cpp holds it.

#include <nlohmann/json_fwd.hpp>

#include "bench/culling/window.h"

namespace gnomon::bench {

/// {"frames": [...], "summary": {...}}: of the methods that were run, with what was counted.
nlohmann::ordered_json culling_json(const CullingWindow& window);

}   // namespace gnomon::bench
