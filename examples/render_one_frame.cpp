// SPDX-License-Identifier: Apache-2.0
// The shortest complete program: loads a scene and writes one image.
//
//   example_render_one_frame [SCENE [FRAME [OUT.png]]]

#include <cstdio>
#include <cstdlib>

#include "gnomon/gnomon.h"

int main(int argc, char** argv)
try {
    const gnomon::Scene scene = gnomon::load(argc > 1 ? argv[1] : "builtin:cornell");
    const int frame = argc > 2 ? std::atoi(argv[2]) : 1;

    gnomon::Renderer renderer({.size = {512, 512}});
    const gnomon::Frame image = renderer.render(scene, frame);
    image.write(argc > 3 ? argv[3] : "frame.png");

    std::printf("%.1f ms, %llu shadow rays\n", image.milliseconds,
                static_cast<unsigned long long>(image.counters.shadow.rays));
    return 0;
} catch (const gnomon::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
