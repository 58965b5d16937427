// SPDX-License-Identifier: Apache-2.0
// Large OBJ files are read in a bounded multiple of their size.
#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "run_program.h"

namespace gnomon::test {
namespace {

// A grid of quads, as exporters write it: with texture coordinates and normals, or positions alone.
void write_grid(const std::filesystem::path& file, int quads, bool complete)
{
    std::ofstream out(file);
    const int side = quads + 1;
    std::string rows;
    const auto flush = [&] {
        out << rows;
        rows.clear();
    };
    for (int z = 0; z < side; ++z, flush())
        for (int x = 0; x < side; ++x)
            rows +=
                fmt::format("v {:.6f} {:.6f} {:.6f}\n", 10.0 * x / quads, 0.3 * std::sin(0.02 * x), 10.0 * z / quads);
    for (int z = 0; complete && z < side; ++z, flush())
        for (int x = 0; x < side; ++x)
            rows += fmt::format("vt {:.6f} {:.6f}\nvn 0.0000 1.0000 {:.4f}\n", 1.0 * x / quads, 1.0 * z / quads,
                                0.01 * std::sin(0.02 * z));
    for (int z = 0; z < quads; ++z, flush())
        for (int x = 0; x < quads; ++x) {
            const int a = z * side + x + 1, b = a + side;
            rows += complete ? fmt::format("f {0}/{0}/{0} {1}/{1}/{1} {2}/{2}/{2} {3}/{3}/{3}\n", a, b, b + 1, a + 1)
                             : fmt::format("f {} {} {} {}\n", a, b, b + 1, a + 1);
        }
}

TEST(LargeObjFull, IsReadInABoundedMultipleOfItsSize)
{
    if (k_sanitized) GTEST_SKIP() << "a sanitizer needs memory of its own";
    const ScratchFolder folder;
    for (const bool complete : {true, false}) {
        const std::filesystem::path file = folder / "grid.obj";
        write_grid(file, 1200, complete);
        const auto bytes = static_cast<double>(std::filesystem::file_size(file));
        const Outcome outcome = run({"info", file, "--json"});
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        const double peak = outcome.json()["peak_memory_bytes"].get<double>();
        std::printf("%.0f MB: %.2f bytes of memory for a byte of the file\n", bytes / 1e6, peak / bytes);
        EXPECT_LT(peak, (complete ? 2 : 6) * bytes + 30e6);
    }
}

}   // namespace
}   // namespace gnomon::test
