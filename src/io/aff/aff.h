// SPDX-License-Identifier: Apache-2.0
#pragma once
// The importer of AFF, BART's scene format [Lext, Assarsson and Moller 2000, "BART: A Benchmark for Animated Ray
// Tracing"; BART AFF], with options and a report. load_aff in io/load.h calls it with the defaults.
//
// Included files lie beside the main file; textures (binary PPM) lie in the sibling folder TextureFiles. No other file
// is opened. Files that are included repeatedly (robots, wheels) are read once.

#include <filesystem>

#include "gnomon/types.h"
#include "io/aff/builder.h"

namespace gnomon::io {

struct AffOptions {
    AffShapeOptions shapes;
    AffSceneLimits scene;
    std::uint64_t max_file_bytes = 64ull << 20;
    std::uint64_t max_parsed_bytes = 512ull << 20;   // repeated includes are counted each time
    std::uint64_t max_texture_bytes = 1ull << 30;
    std::size_t max_include_depth = 32;
    std::size_t max_includes = 1u << 16;
    std::int64_t max_frames = 1'000'000;
    std::int64_t max_resolution = 16384;                   // pixels on a side
    std::int64_t max_pixels = 1 << 25;                     // of a resolution: 7680 x 4320 has fewer
    std::uint64_t memory = scene::MemoryBudget::k_usual;   // bytes of textures
};

/// Statistics of an import.
struct AffReport {
    std::size_t files = 0;             // distinct files
    std::size_t deepest_nesting = 0;   // of `xs` and `x`
    std::map<std::string, AffTracks> tracks;
};

scene::Scene load_aff(const std::filesystem::path& file, const Progress& progress, const AffOptions& options,
                      AffReport* report = nullptr);

}   // namespace gnomon::io
