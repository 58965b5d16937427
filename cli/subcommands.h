// SPDX-License-Identifier: Apache-2.0
#pragma once
// One function per subcommand. Each returns an exit code or throws one of gnomon's errors.

#include "cli/command_line.h"
#include "cli/output.h"
#include "gnomon/scene.h"

namespace gnomon::cli {

int run_render(const CommandLine& line, Output& output);
int run_join(const CommandLine& line, Output& output);
int run_view(const CommandLine& line, Output& output);
int run_info(const CommandLine& line, Output& output);
int run_compare(const CommandLine& line, Output& output);
int run_devices(const CommandLine& line, Output& output);
int run_serve(const CommandLine& line, Output& output);
int run_bench_trace(const CommandLine& line, Output& output);
int run_bench_culling(const CommandLine& line, Output& output);
int run_bench_all(const CommandLine& line, Output& output);
int run_bench_shadow_textures(const CommandLine& line, Output& output);
int run_bench_indirect(const CommandLine& line, Output& output);
int run_bench_lights(const CommandLine& line, Output& output);

/// Loads the scene named by the first positional argument and applies --fps, --light, --lights and --environment where
/// the subcommand has them.
Scene load_scene(const CommandLine& line, const Progress& progress);

}   // namespace gnomon::cli
