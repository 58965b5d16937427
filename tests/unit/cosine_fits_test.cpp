// SPDX-License-Identifier: Apache-2.0
// The table of fits of transformed cosines is what fitting them finds.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "base/bits.h"
#include "shading/cosine_fit.h"

namespace gnomon::shading {
namespace {

// Writes the table as the source file that holds it: to the bit, as hexadecimal floating-point numbers.
void write_table(const CosineFits& fits, const std::filesystem::path& file)
{
    std::FILE* const out = std::fopen(file.c_str(), "w");
    ASSERT_TRUE(out);
    std::fprintf(out,
                 "// SPDX-License-Identifier: Apache-2.0\n"
                 "// Made by fitted_cosines(): the test CosineFits writes this file where they differ.\n"
                 "#include \"shading/cosine_fit.h\"\n\n"
                 "namespace gnomon::shading {\n\n"
                 "// clang-format off\n"
                 "const CosineFits k_cosine_fits = {{\n");
    for (const CosineFit& f : fits) std::fprintf(out, "    {%a, %a, %a, %a, %a},\n", f.a, f.b, f.c, f.tilt, f.scale);
    std::fprintf(out, "}};\n// clang-format on\n\n}   // namespace gnomon::shading\n");
    std::fclose(out);
}

TEST(CosineFits, TheTableIsWhatIsFitted)
{
    const CosineFits fits = fitted_cosines();
    if (same_bits(fits, k_cosine_fits)) return;
    const std::filesystem::path file = std::filesystem::temp_directory_path() / "cosine_fits.cpp";
    write_table(fits, file);
    ADD_FAILURE() << "src/shading/cosine_fits.cpp is to be " << file;
}

}   // namespace
}   // namespace gnomon::shading
