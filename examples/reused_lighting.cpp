// SPDX-License-Identifier: Apache-2.0
// Renders a clip frame by frame, and prints how much of its lighting was reused.
//
//   example_reused_lighting [SCENE [FRAMES]]

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "gnomon/gnomon.h"

int main(int argc, char** argv)
try {
    const gnomon::Scene scene = gnomon::load(argc > 1 ? argv[1] : "builtin:cornell");
    const int frames = std::min(argc > 2 ? std::atoi(argv[2]) : 10, scene.frame_count());

    // Use one renderer for the whole clip, because it caches static lighting.
    gnomon::Renderer renderer({.size = {320, 240}, .shadow_culling = gnomon::ShadowCulling::certified});
    for (int frame = 1; frame <= frames; ++frame) {
        const gnomon::Frame image = renderer.render(scene, frame);
        const auto& shadow = image.counters.shadow;
        const double asked = static_cast<double>(std::max<std::uint64_t>(shadow.rays, 1));
        std::printf("frame %d: %.1f ms, %.1f %% of the shadow rays not traced, %llu rays for indirect light\n", frame,
                    image.milliseconds, 100 * static_cast<double>(shadow.rays_skipped) / asked,
                    static_cast<unsigned long long>(image.counters.indirect.rays));
    }
    return 0;
} catch (const gnomon::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
