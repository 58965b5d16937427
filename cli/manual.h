// SPDX-License-Identifier: Apache-2.0
#pragma once
// The manual page, the guide's page of options and the shells' completions, made from the tables of subcommands and
// options.

#include <string>

namespace gnomon::cli {

/// gnomon(1), as man takes it. What is not built is not in it.
std::string manual_page();

/// docs/guide/options.md, which a test holds against it.
std::string options_page();

/// Scripts that complete subcommands, options and their choices; everything else as files.
std::string bash_completion();
std::string zsh_completion();
std::string fish_completion();

}   // namespace gnomon::cli
