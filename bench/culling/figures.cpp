// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/figures.h"

#include <algorithm>

#include "bench/report/image_figures.h"
#include "gnomon/renderer.h"
#include "gnomon/scene_builder.h"

namespace gnomon::bench {

namespace {

constexpr int k_cells = 20;         // of the floor, a side; each is two triangles
constexpr float k_cell = 0.4f;      // metres
constexpr float k_post = 0.012f;    // half the width of a post's top, which floats above the middle of a triangle
constexpr float k_height = 0.08f;   // metres above the floor
constexpr double k_far = 40, k_near = 6;   // distances of the camera: 44 times the pixels

MaterialId color(SceneBuilder& builder, const Vec3& diffuse)
{
    Material material;
    material.base_color = diffuse;
    material.metallic = 0;
    material.roughness = 1;
    material.double_sided = true;
    return builder.material(material);
}

MeshId mesh(SceneBuilder& builder, const std::vector<Vec3>& points)
{
    Mesh made;
    made.positions = points;
    return builder.mesh(made);
}

Scene floor_with_posts()
{
    SceneBuilder builder;
    std::vector<Vec3> floor, posts;
    const float begin = -0.5f * k_cells * k_cell;
    for (int j = 0; j < k_cells; ++j)
        for (int i = 0; i < k_cells; ++i) {
            const float x = begin + static_cast<float>(i) * k_cell, z = begin + static_cast<float>(j) * k_cell;
            const Vec3 a{x, 0, z}, b{x + k_cell, 0, z}, c{x + k_cell, 0, z + k_cell}, d{x, 0, z + k_cell};
            floor.insert(floor.end(), {a, d, c, a, c, b});
            for (const Vec3& corner : {d, b}) {
                const float px = (a.x + c.x + corner.x) / 3, pz = (a.z + c.z + corner.z) / 3;
                posts.insert(posts.end(), {{px - k_post, k_height, pz - k_post},
                                           {px, k_height, pz + k_post},
                                           {px + k_post, k_height, pz - k_post}});
            }
        }
    builder.instance(mesh(builder, floor), color(builder, {0.7f, 0.68f, 0.6f}));
    builder.instance(mesh(builder, posts), color(builder, {0.5f, 0.2f, 0.1f}));
    Light sun;
    sun.type = LightType::directional;
    sun.color = {3, 3, 3};
    builder.light(sun, Transform::look_at({6, 10, 3}, {0, 0, 0}));
    builder.background({0.1f, 0.15f, 0.25f});
    return builder.finish();
}

FrameInput seen_from(double distance)
{
    Camera camera;
    const auto d = static_cast<float>(distance);
    camera.transform = Transform::look_at({0.11f * d, 0.8f * d, 0.6f * d}, {0, 0, 0});
    camera.vertical_fov = 0.4;
    FrameInput input;
    input.camera = camera;
    return input;
}

RenderOptions direct_light(Size size, ShadowCulling culling)
{
    RenderOptions options;
    options.size = size;
    options.shadow_culling = culling;
    options.indirect = Indirect::off;
    return options;
}

std::uint64_t pixels_that_differ(const Image8& a, const Image8& b)
{
    std::uint64_t different = 0;
    for (std::size_t i = 0; i < a.data.size(); i += 3)
        different += !std::equal(a.data.begin() + static_cast<std::ptrdiff_t>(i),
                                 a.data.begin() + static_cast<std::ptrdiff_t>(i + 3),
                                 b.data.begin() + static_cast<std::ptrdiff_t>(i));
    return different;
}

}   // namespace

ZoomFigure zoom_figure(Size size)
{
    const Scene scene = floor_with_posts();
    RenderOptions options = direct_light(size, ShadowCulling::paper);
    options.exposure = 0;
    Renderer published(options);
    options.shadow_culling = ShadowCulling::off;
    Renderer every_ray(options);
    ZoomFigure figure;
    published.render(scene, seen_from(k_far));
    figure.before = image_of(published.render(scene, seen_from(k_far)));
    figure.zoomed = image_of(published.render(scene, seen_from(k_near)));
    published.render(scene, seen_from(k_near));   // everything is traced, and learned
    figure.after = image_of(published.render(scene, seen_from(k_near)));
    figure.zoomed_right = image_of(every_ray.render(scene, seen_from(k_near)));
    figure.wrong_zoomed = pixels_that_differ(figure.zoomed, figure.zoomed_right);
    figure.wrong_after = pixels_that_differ(figure.after, figure.zoomed_right);
    return figure;
}

Image8 scene_figure(const Scene& scene, double time, Size size)
{
    Renderer renderer(direct_light(size, ShadowCulling::off));
    FrameInput input;
    input.time = time;
    return image_of(renderer.render(scene, input));
}

}   // namespace gnomon::bench
