// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts the options that `render` and `view` have in common to RenderOptions.

#include <optional>

#include "gnomon/renderer.h"
#include "options/option_values.h"

namespace gnomon::options {

/// @throws UsageError  options exclude each other
RenderOptions read_render_options(const OptionValues& values);

/// --ground, for LoadOptions::ground.
/// @throws UsageError  neither on nor off
std::optional<bool> read_ground(const OptionValues& values);

}   // namespace gnomon::options
