// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the options that render and view share mean for a renderer.

#include "gnomon/renderer.h"
#include "options/option_values.h"

namespace gnomon::options {

/// @throws UsageError  for options that exclude each other
RenderOptions read_render_options(const OptionValues& values);

}   // namespace gnomon::options
