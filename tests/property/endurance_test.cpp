// SPDX-License-Identifier: Apache-2.0
// Ten thousand frames of Kitchen with one renderer: the clip forwards, pauses, jumps, lights switched on and off.
// Memory settles, and at random frames the image equals that of a new renderer.
#include <gtest/gtest.h>

#include <unistd.h>
#include "api/scene_access.h"

#include <fstream>

#include "base/random.h"
#include "gnomon/gnomon.h"
#include "io/load.h"
#include "sanitized.h"
#include "scene_helpers.h"
#include "support.h"

namespace gnomon {
namespace {

constexpr Size k_size{48, 36};

double resident_megabytes()
{
    std::ifstream in("/proc/self/statm");
    double pages = 0, resident = 0;
    in >> pages >> resident;
    return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

// All lights but the first blink, each with its own period.
Scene blinking_kitchen(const std::filesystem::path& file)
{
    auto scene = std::make_shared<scene::Scene>(io::load_scene(file));
    const scene::Timeline& timeline = scene->timeline;
    for (std::size_t l = 1; l < scene->lights.size(); ++l) {
        std::vector<double> times;
        std::vector<bool> on;
        for (int frame = 1 + static_cast<int>(l); frame < timeline.frames; frame += 17 + 10 * static_cast<int>(l)) {
            times.push_back(timeline.time_of(frame));
            on.push_back(times.size() % 2 == 0);
        }
        const scene::NodeId node = scene->lights[l].node;
        if (node != scene::none) scene->nodes[node].visibility = test::visibility(times, on);
    }
    scene->finish();
    return api::public_scene(scene);
}

RenderOptions small()
{
    RenderOptions options;
    options.size = k_size;
    options.threads = 2;
    options.layers = true;
    return options;
}

void endure(const std::filesystem::path& file, int frames, int checkpoints)
{
    const Scene scene = blinking_kitchen(file);
    Renderer renderer(small());
    Random random(8);
    double settled = 0, late = 0;   // maximum within the third and the last quarter
    int frame = 1, checked = 0;
    for (int i = 0; i < frames; ++i) {
        // Advance; one time in ten pause, rarely jump.
        const std::uint32_t choice = random.below(100);
        if (choice == 0)
            frame = 1 + static_cast<int>(random.below(static_cast<std::uint32_t>(scene.frame_count())));
        else if (choice > 10)
            frame = frame % scene.frame_count() + 1;
        const Frame image = renderer.render(scene, frame);
        const double now = resident_megabytes();
        if (4 * i >= 2 * frames)
            (4 * i >= 3 * frames ? late : settled) = std::max(4 * i >= 3 * frames ? late : settled, now);
        if (i % (frames / 20) == 0) std::printf("%6d frames  %7.1f MB\n", i, now), std::fflush(stdout);
        if (random.below(static_cast<std::uint32_t>(frames / checkpoints)) != 0) continue;
        ++checked;
        Renderer cold(small());
        const Frame fresh = cold.render(scene, frame);
        ASSERT_EQ(image.layers.size(), fresh.layers.size());
        for (std::size_t l = 0; l < fresh.layers.size(); ++l)
            ASSERT_TRUE(image.layers[l].copy() == fresh.layers[l].copy())
                << "layer " << fresh.layers[l].name << " of frame " << frame << " after " << i << " frames";
    }
    std::printf(
        "%d frames, %d checked against a cold renderer; at most %.1f MB in the third quarter, %.1f MB in the last\n",
        frames, checked, settled, late);
    EXPECT_GT(checked, 0);
    // The allocator's reserve varies; a sanitizer keeps freed memory.
    if (!test::k_sanitized) {
        EXPECT_LT(late, 1.02 * settled + 32);   // what a cold renderer leaves with the allocator comes in steps
    }
}

TEST(Endurance, MemoryAndImagesStayStableOver120FramesOfKitchen)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    endure(file, 120, 6);
}

TEST(EnduranceFull, MemoryAndImagesStayStableOver10000FramesOfKitchen)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    endure(file, 10'000, 60);
}

}   // namespace
}   // namespace gnomon
