// SPDX-License-Identifier: Apache-2.0
// Edits a scene that was loaded: adds a chair, and dims the first light.
//
//   example_edit_scene [SCENE [WIDTH]]     writes before.png and after.png
//
// A SceneBuilder opens a scene, and makes another one of what was changed. Both scenes share the geometry that they
// have in common, and ids of the one are ids of the other, as long as their parts are in both.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "gnomon/gnomon.h"
#include "shapes.h"

namespace {

/// Adds a chair of six boxes below one node, so that it can be moved and removed as a whole.
/// @param transform  of a chair that is 1 metre high, stands on y = 0 and faces +Z
gnomon::NodeId add_chair(gnomon::SceneBuilder& builder, const gnomon::Transform& transform)
{
    const gnomon::MeshId cube = add_cube(builder);
    const gnomon::MaterialId wood = add_color(builder, {0.45f, 0.25f, 0.1f});
    const gnomon::NodeId chair = builder.node(transform, {.mobility = gnomon::Mobility::may_move, .name = "chair"});
    const auto board = [&](const gnomon::Transform& where) {
        gnomon::InstanceOptions options;
        options.parent = chair;
        builder.instance(cube, wood, where, options);
    };
    board(place(0, 0.45, 0, 0.45, 0.05, 0.45));     // the seat
    board(place(0, 0.78, -0.2, 0.45, 0.4, 0.04));   // the back
    for (const double x : {-0.2, 0.2})              // the legs
        for (const double z : {-0.2, 0.2}) board(place(x, 0.22, z, 0.04, 0.44, 0.04));
    return chair;
}

void render(gnomon::Renderer& renderer, const gnomon::Scene& scene, const std::string& file)
{
    const gnomon::Frame image = renderer.render(scene, 1);
    image.write(file);
    std::printf("%s: %zu objects, %zu lights, %.1f ms\n", file.c_str(), scene.instances().size(), scene.lights().size(),
                image.milliseconds);
}

}   // namespace

int main(int argc, char** argv)
try {
    const gnomon::Scene before = gnomon::load(argc > 1 ? argv[1] : "builtin:cornell");
    const int width = argc > 2 ? std::atoi(argv[2]) : 512;

    // A fixed exposure, so that the second image shows less light.
    gnomon::Renderer renderer({.size = {width, width}, .exposure = 0.0});
    render(renderer, before, "before.png");

    // Stand the chair where the lower left of the image shows a surface.
    const gnomon::Pick spot = renderer.pick(width / 4, width * 24 / 25);
    if (!spot.hit) throw gnomon::UsageError("nothing is seen where the chair would stand");
    const double height = 0.2 * static_cast<double>(spot.depth);
    gnomon::SceneBuilder builder(before);
    const gnomon::NodeId chair = add_chair(
        builder, gnomon::Transform::translation(spot.position.x, spot.position.y, spot.position.z) *
                     gnomon::Transform::rotation({0, 1, 0}, 0.7) * gnomon::Transform::scaling(height, height, height));

    // Dim the light. Its id is that of the scene before.
    if (!before.lights().empty()) {
        const gnomon::LightId first = before.lights().front();
        gnomon::Light light = before.light(first);
        light.color = {0.4f * light.color.x, 0.4f * light.color.y, 0.4f * light.color.z};
        builder.set_light(first, light);
    }
    const gnomon::Scene after = builder.finish();
    render(renderer, after, "after.png");
    std::printf("the new node is '%s'\n", after.name(chair).c_str());
    return 0;
} catch (const gnomon::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
