// SPDX-License-Identifier: Apache-2.0
#pragma once
// --preset: the defaults of several options at once.

#include "options/option_values.h"

namespace gnomon::options {

/// Replaces the defaults of the subcommand's options by those of the preset that its values name, if they name one.
/// Values that were given win.
void apply_preset(OptionValues& values);

}   // namespace gnomon::options
