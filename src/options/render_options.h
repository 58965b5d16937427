// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts the options that `render` and `view` have in common to RenderOptions.

#include "gnomon/renderer.h"
#include "options/option_values.h"

namespace gnomon::options {

/// @throws UsageError  options exclude each other
RenderOptions read_render_options(const OptionValues& values);

}   // namespace gnomon::options
