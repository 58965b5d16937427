// SPDX-License-Identifier: Apache-2.0
// The comparison of frames that many tests rest on finds one different value, and one different id.
#include "same_frames.h"

#include <gtest/gtest-spi.h>

#include "gnomon/renderer.h"

namespace gnomon::test {
namespace {

// The number of failures that a comparison reports.
int failures(const Frame& got, const Frame& expected)
{
    testing::TestPartResultArray results;
    {
        const testing::ScopedFakeTestPartResultReporter reporter(
            testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &results);
        expect_same(got, expected);
    }
    return results.size();
}

TEST(SameFrames, DifferencesAreFound)
{
    const Scene scene = load("builtin:cornell");
    RenderOptions options;
    options.size = {12, 8}, options.layers = true, options.indirect = Indirect::off, options.samples = 1;
    Renderer one(options), other(options), moved(options);
    const Frame a = one.render(scene, 1), b = other.render(scene, 1), c = moved.render(scene, 20);
    EXPECT_EQ(failures(a, b), 0);
    EXPECT_GT(failures(a, c), 1);
    Frame fewer = a;
    fewer.layers.pop_back();
    EXPECT_GT(failures(fewer, a), 0);
}

}   // namespace
}   // namespace gnomon::test
