// SPDX-License-Identifier: Apache-2.0
// The progress line on a terminal: one line, however narrow the terminal is.
#include "cli/progress_line.h"

#include <gtest/gtest.h>

namespace gnomon::cli {
namespace {

TEST(ProgressText, FitsTheTerminal)
{
    EXPECT_EQ(progress_text("rendering", 0.5, "3 s left", 79), "rendering [============            ]  50 %  3 s left");
    EXPECT_EQ(progress_text("rendering", 0.5, "3 s left", 32), "rendering [==  ]  50 %  3 s left");
    EXPECT_EQ(progress_text("rendering", 0.5, "3 s left", 20), "rendering   50 %  3 ");
    for (std::size_t columns = 0; columns < 100; ++columns)
        EXPECT_LE(progress_text("warming up", 1, "12:34 min left", columns).size(), columns);
}

}   // namespace
}   // namespace gnomon::cli
