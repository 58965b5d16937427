// SPDX-License-Identifier: Apache-2.0
// --indirect quadtree and rsm from the command line: the same bytes of all layers for any thread count, in chunks, and
// for single frames.
#include "run_program.h"

namespace gnomon::test {
namespace {

using Words = std::vector<std::string>;

// Renders frames 5 to 8 with layers, in which the ball moves. The exposure is fixed: a clip has one for all its frames,
// and a single frame its own, by which samples are chosen.
void make(const std::string& out, const Words& more)
{
    Words words{"render", "builtin:cornell", "-o", out, "--size", "72x64", "--exposure", "0"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
}

TEST(MapLightFrames, SameBytesForAnyThreadCountInChunksAndForSingleFrames)
{
    for (const Words& method : {Words{"--indirect", "quadtree", "--receivers", "64"},
                                Words{"--indirect", "quadtree", "--receivers", "full", "--indirect-level", "6"},
                                Words{"--indirect", "rsm", "--receivers", "64", "--rsm-samples", "64"}}) {
        const ScratchFolder folder;
        const auto with = [&](Words more) {
            more.insert(more.end(), method.begin(), method.end());
            return more;
        };
        make(folder / "whole-{frame:04}.exr", with({"--frames", "5-8", "--threads", "2"}));
        make(folder / "part-{frame:04}.exr", with({"--frames", "5-8", "--threads", "1", "--chunk", "2/2"}));
        make(folder / "part-{frame:04}.exr", with({"--frames", "5-8", "--threads", "3", "--chunk", "1/2"}));
        make(folder / "alone.exr", with({"--frame", "7", "--threads", "1"}));
        for (int frame = 5; frame <= 8; ++frame) {
            const std::string number = "000" + std::to_string(frame) + ".exr";
            EXPECT_EQ(bytes_of(folder / ("whole-" + number)), bytes_of(folder / ("part-" + number))) << number;
        }
        EXPECT_EQ(bytes_of(folder / "whole-0007.exr"), bytes_of(folder / "alone.exr"));
        EXPECT_NE(bytes_of(folder / "whole-0007.exr"), bytes_of(folder / "whole-0008.exr")) << "nothing moved";
    }
}

}   // namespace
}   // namespace gnomon::test
