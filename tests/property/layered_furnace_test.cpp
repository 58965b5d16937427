// SPDX-License-Identifier: Apache-2.0
// A white furnace for layered materials: a white square under an even environment of radiance 1 shows at most that.
#include <gtest/gtest.h>

#include "gnomon/gnomon.h"
#include "host_scene.h"

namespace gnomon {
namespace {

float seen(const Material& material, double tilt)
{
    SceneBuilder b;
    const test::Shape shape = test::square(2);
    b.instance(b.mesh(shape.mesh()), b.material(material),
               Transform::translation(0, 0, -4) * Transform::rotation({1, 0, 0}, tilt));
    const std::vector<float> even(std::size_t{64} * 32 * 3, 1.0f);
    b.environment({.width = 64, .height = 32, .pixels = even});
    b.camera(test::camera_along_z());
    Renderer renderer(test::plain({32, 32}));
    return renderer.render(b.finish(), 1).layers.front().value(16, 17, 1);
}

TEST(LayeredFurnace, NoMaterialShowsMoreThanItsSurroundings)
{
    MaterialLayers coat, rough_coat, sheen, specular, iridescence, thin, brushed;
    coat.clearcoat = rough_coat.clearcoat = 1, rough_coat.clearcoat_roughness = .6f;
    sheen.sheen_color = {1, 1, 1}, sheen.sheen_roughness = .5f;
    specular.specular_color = {20, 20, 20};
    iridescence.iridescence = 1;
    thin.thin_walled = true;
    brushed.anisotropy = 1;
    const std::pair<const char*, const MaterialLayers*> cases[] = {
        {"coat", &coat},       {"rough coat", &rough_coat},   {"sheen", &sheen}, {"specular", &specular},
        {"brushed", &brushed}, {"iridescence", &iridescence}, {"thin", &thin}};
    for (const auto& [name, layers] : cases)
        for (const float roughness : {0.0f, .3f, 1.0f})
            for (const double tilt : {0.0, -1.2}) {
                Material material{.base_color = {1, 1, 1}, .double_sided = true, .roughness = roughness};
                if (layers == &thin) material.transmission = 1;
                material.layers = *layers;
                const float there = seen(material, tilt);
                EXPECT_LE(there, 1.02f) << name << ' ' << roughness << ' ' << tilt;
                EXPECT_GE(there, .85f) << name << ' ' << roughness << ' ' << tilt;
            }
}

}   // namespace
}   // namespace gnomon
