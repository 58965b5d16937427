// SPDX-License-Identifier: Apache-2.0
#pragma once
// Generates the manual page, the guide's page of options and the shell completions from the tables of subcommands and
// options.

#include <string>

namespace gnomon::cli {

/// gnomon(1) in roff. Subcommands and options that are not built are omitted.
std::string manual_page();

/// docs/guide/options.md. A test compares that file with this text.
std::string options_page();

/// blender/gnomon_render/options.json: the options of render. A test compares that file with this text.
std::string options_json();

/// Scripts that complete subcommands, options and their choices, and file names elsewhere.
std::string bash_completion();
std::string zsh_completion();
std::string fish_completion();

}   // namespace gnomon::cli
