// SPDX-License-Identifier: Apache-2.0
// A limit on memory is kept, or one line says that it is too little; the engine stays usable.
#include <gtest/gtest.h>

#include "base/bits.h"
#include "frame/frame_engine.h"
#include "gnomon/error.h"
#include "scene/builtin/builtin.h"

namespace gnomon {
namespace {

using frame::FrameEngine;

std::vector<float> render(FrameEngine& engine, const std::shared_ptr<const scene::Scene>& scene, int frame,
                          const RenderOptions& options)
{
    engine.advance(scene, scene->timeline.time_of(frame), options);
    engine.render(engine.make_view(0, {64, 48}));
    return engine.buffers().color.data;
}

TEST(MemoryLimit, IsKeptOrRefusedAtEverySize)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("kinetic"));
    RenderOptions options{.threads = 2, .layers = true};
    FrameEngine free({.threads = 2});
    std::vector<std::vector<float>> expected;
    for (const int frame : {1, 2, 3}) expected.push_back(render(free, scene, frame, options));

    // One engine is given more and more memory.
    FrameEngine engine({.threads = 2});
    int refused = 0, rendered = 0;
    for (options.memory = 1; rendered < 2 && options.memory <= 1 << 14; options.memory *= 2) {
        try {
            for (const int frame : {1, 2, 3}) {
                ASSERT_TRUE(
                    same_bits(render(engine, scene, frame, options), expected[static_cast<std::size_t>(frame - 1)]))
                    << options.memory << " MB, frame " << frame;
                EXPECT_LE(engine.held_bytes(), static_cast<std::size_t>(options.memory) << 20);
            }
            ++rendered;
        } catch (const MissingError& error) {
            ++refused;
            const std::string message = error.what();
            EXPECT_EQ(
                message.find("needs more than the limit of " + std::to_string(options.memory) + " MB of memory: the "),
                0u)
                << message;
            EXPECT_EQ(message.find('\n'), std::string::npos);
        }
    }
    EXPECT_GE(refused, 2);
    EXPECT_EQ(rendered, 2);
}

TEST(MemoryLimit, LeavesTheEngineToASmallerScene)
{
    const auto large = std::make_shared<const scene::Scene>(scene::make_builtin("kinetic"));
    const auto small = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    RenderOptions options{.threads = 1};
    options.indirect = Indirect::off;
    options.memory = 2;
    FrameEngine engine({.threads = 1}), fresh({.threads = 1});
    EXPECT_THROW(render(engine, large, 1, options), MissingError);
    EXPECT_TRUE(same_bits(render(engine, small, 1, options), render(fresh, small, 1, options)));
}

TEST(MemoryLimit, RefusesLayersBeforeTheyAreMade)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    RenderOptions options{.threads = 1};
    options.indirect = Indirect::off;
    options.memory = 64;
    FrameEngine engine({.threads = 1});
    engine.advance(scene, 0, options);
    EXPECT_THROW(engine.render(engine.make_view(0, {16000, 16000})), MissingError);   // 3 GB
    EXPECT_NO_THROW(render(engine, scene, 2, options));
}

}   // namespace
}   // namespace gnomon
