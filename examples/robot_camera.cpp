// SPDX-License-Identifier: Apache-2.0
// The camera of a robot: calibrated by intrinsics, it drives through a hall and lists what it sees.
//
//   example_robot_camera [FRAMES [WIDTH]]     writes robot-1.exr and so on
//
// The layer "depth" holds metres along the view axis, and the layer "id" the object at each pixel's centre. Both are
// unfiltered, so that a pixel's place in space follows from its depth and the intrinsics. The .exr files have all
// layers.

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "gnomon/gnomon.h"
#include "shapes.h"

namespace {

gnomon::Scene make_hall()
{
    gnomon::SceneBuilder builder;
    const gnomon::MeshId cube = add_cube(builder), sphere = add_sphere(builder);
    const auto add = [&](const char* name, const gnomon::MeshId& mesh, const gnomon::Vec3& color,
                         const gnomon::Transform& where) {
        gnomon::InstanceOptions options;
        options.name = name;
        builder.instance(mesh, add_color(builder, color), where, options);
    };
    add("floor", cube, {0.5f, 0.5f, 0.5f}, place(0, -0.1, 0, 8, 0.2, 16));
    add("wall", cube, {0.7f, 0.7f, 0.6f}, place(0, 1.5, -8, 8, 3, 0.2));
    add("crate", cube, {0.6f, 0.4f, 0.2f}, place(-1.2, 0.4, -3, 0.8, 0.8, 0.8));
    add("shelf", cube, {0.2f, 0.4f, 0.6f}, place(2, 1, -5, 0.5, 2, 2));
    add("ball", sphere, {0.8f, 0.1f, 0.1f}, place(0.4, 0.3, -2, 0.3, 0.3, 0.3));
    gnomon::Light light;
    light.color = {120, 120, 120};   // candela
    builder.light(light, gnomon::Transform::translation(0, 4, -1));
    return builder.finish();
}

/// What is seen of one object.
struct Sight {
    std::size_t pixels = 0;
    float nearest = 0;   // metres along the view axis
    int x = 0, y = 0;    // the pixel of the nearest point
};

/// By the value of the layer of ids; 0, where nothing is seen, is left out.
std::map<std::uint32_t, Sight> look(const gnomon::Frame& frame)
{
    const gnomon::Layer* ids = frame.layer("id");
    const gnomon::Layer* depth = frame.layer("depth");
    std::map<std::uint32_t, Sight> seen;
    for (int y = 0; y < frame.size.height; ++y)
        for (int x = 0; x < frame.size.width; ++x) {
            const std::uint32_t id = ids->id(x, y);
            if (id == 0) continue;
            Sight& sight = seen[id];
            const float z = depth->value(x, y);
            if (sight.pixels++ == 0 || z < sight.nearest) sight = {sight.pixels, z, x, y};
        }
    return seen;
}

}   // namespace

int main(int argc, char** argv)
try {
    const int frames = argc > 1 ? std::atoi(argv[1]) : 4;
    const int width = argc > 2 ? std::atoi(argv[2]) : 640;
    const gnomon::Scene hall = make_hall();

    // As calibrated for images of 640 x 480 pixels. The renderer scales them to the size of its own images.
    const gnomon::Intrinsics lens{.fx = 525, .fy = 525, .cx = 322.4, .cy = 238.6, .size = {640, 480}};
    const double scale = width / 640.0;
    gnomon::Renderer renderer({.size = {width, width * 3 / 4}, .layers = true, .ids = true});

    for (int frame = 1; frame <= frames; ++frame) {
        // Drive half a metre a frame, along -Z.
        const float z = 2 - 0.5f * static_cast<float>(frame);
        gnomon::FrameInput input;
        input.camera.emplace();
        input.camera->intrinsics = lens;
        input.camera->transform = gnomon::Transform::look_at({0, 0.6f, z}, {0, 0.5f, z - 1});
        const gnomon::Frame image = renderer.render(hall, input);
        image.write("robot-" + std::to_string(frame) + ".exr");

        std::printf("frame %d\n  object    pixels  nearest  right     down\n", frame);
        for (const auto& [id, sight] : look(image)) {
            // Find the point in the camera's space from the centre of its pixel.
            const double nearest = static_cast<double>(sight.nearest);
            const double right = ((sight.x + 0.5) / scale - lens.cx) / lens.fx * nearest;
            const double down = ((sight.y + 0.5) / scale - lens.cy) / lens.fy * nearest;
            std::printf("  %-8s  %6zu  %5.2f m  %+.2f m  %+.2f m\n", hall.name(hall.instance_of(id)).c_str(),
                        sight.pixels, nearest, right, down);
        }
    }
    return 0;
} catch (const gnomon::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
