// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/surroundings.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "base/check.h"
#include "scene/builtin/studio.h"
#include "scene/defaults/default_light.h"
#include "scene/defaults/default_view.h"
#include "scene/defaults/framing.h"
#include "scene/defaults/space_grid.h"
#include "scene/defaults/test_image.h"
#include "scene/file_surfaces.h"

namespace gnomon::scene {

namespace {

constexpr double k_bright = 0.9;          // of the surfaces in view are darker than those that exposure goes by
constexpr float k_least_light = 0.005f;   // of theirs, that a surface must get in order not to look black
constexpr double k_ground_radius = 6;     // in diagonals of the scene
constexpr double k_ground_below = 2e-4;   // likewise, so that what stands on it covers it
constexpr int k_ground_corners = 48;
constexpr glm::vec3 k_ground_color{0.45f};

SceneState state_at_start(const Scene& scene)
{
    return {std::shared_ptr<const Scene>(std::shared_ptr<const Scene>(), &scene), scene.timeline.start};
}

// Whether a scene is spread over the ground, as wide as a place outdoors.
bool is_landscape(const SceneState& state, const SurroundingsOptions& options)
{
    const Box3 box = state.scene().bounds(state.time());
    if (box.empty()) return false;
    const glm::dvec3 size(box.size());
    const double side = std::max(size.x, size.z), other = std::min(size.x, size.z);
    if (!(side >= static_cast<double>(options.landscape_side)) ||
        other < static_cast<double>(options.landscape_depth) * side ||
        size.y > static_cast<double>(options.landscape_height) * side)
        return false;
    // Look straight down from far away.
    constexpr double far = 50;
    TestImageOptions image_options;
    image_options.vertical_fov = 2 * std::atan(0.5 / far);
    image_options.near = side;
    const glm::dmat3 axes(glm::dvec3(1, 0, 0), glm::dvec3(0, 0, -1), glm::dvec3(0, 1, 0));
    const glm::dvec3 eye = glm::dvec3(box.centre()) + glm::dvec3(0, 0.5 * size.y + far * side, 0);
    const TestImage image = draw_test_image(state, eye, axes, image_options);
    return static_cast<double>(image.shown()) * side >= static_cast<double>(options.landscape_cover) * other;
}

// The studio, with so many times its radiance.
std::shared_ptr<const Environment> scaled_studio(float scale)
{
    if (scale == 1) return studio_environment();
    ImageF image = studio_environment()->image();
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] *= scale;
    return std::make_shared<const Environment>(std::move(image));
}

void add_studio(Scene& scene, const SurroundingsOptions& options, float scale)
{
    const auto environment = scaled_studio(scale);
    int number = 0;
    for (const EnvironmentLight& part : environment->lights(options.lights)) {
        Light light;
        light.name = fmt::format("studio {}", number++);
        light.type = LightType::directional;
        light.color = part.irradiance;
        light.of_environment = true;
        light.by_default = true;
        const glm::dvec3 direction(-part.to_light);
        const glm::dvec3 up = std::abs(direction.y) > 0.99 ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0);
        light.node = scene.add_node(light.name, none, glm::inverse(glm::lookAt(glm::dvec3(0), direction, up)));
        scene.lights.push_back(light);
    }
    scene.background = {};
    scene.background.kind = Background::Kind::image;
    scene.background.environment = environment;
    scene.finish();
}

// Whether the first camera stands above what a ground would lie below.
bool looks_from_above(const Scene& scene, const SceneState& state, const Framed& framed)
{
    if (scene.cameras.empty()) return true;
    return state.world(scene.cameras.front().node)[3].y > static_cast<double>(framed.box.low.y);
}

// Whether a scene is seen as a room that is open in front.
bool before_stage(const Scene& scene, const Survey& survey)
{
    const auto room = survey.judged ? survey.room : believed_interior(state_at_start(scene));
    return room && room->stage;
}

// The fraction of the surfaces in view that no light from outside reaches. Unlit ones need none.
float share_shut_off(const SceneState& state)
{
    constexpr int k_directions = 48;
    constexpr int k_stride = 3;   // of pixels
    const Scene& scene = state.scene();
    const SpaceGrid grid(scene, state.time());
    if (grid.empty() || scene.cameras.empty()) return 0;
    const Camera& camera = scene.cameras.front();
    const TestImage image = test_image_of(state, camera, state.world(camera.node));
    int asked = 0, dark = 0;
    for (std::size_t i = 0; i < image.pixels.size(); i += k_stride) {
        const TestPixel& pixel = image.pixels[i];
        if (pixel.object == none) continue;
        const Mesh& mesh = scene.meshes[scene.objects[pixel.object].mesh];
        ++asked;
        if (scene.materials[mesh.part_of(pixel.triangle).material].model == ShadingModel::unlit) continue;
        const glm::vec3 from = pixel.position + 2.0f * grid.cell() * pixel.normal;
        bool open = false;
        for (int d = 0; d < k_directions && !open; ++d) {
            const glm::vec3 direction = sphere_direction(d, k_directions);
            open = glm::dot(direction, pixel.normal) > 0 && grid.cast(from, direction).met == SpaceGrid::Met::nothing;
        }
        dark += !open;
    }
    return asked > 0 ? static_cast<float>(dark) / static_cast<float>(asked) : 0;
}

}   // namespace

Reached reached_by_lights(const Scene& scene)
{
    if (scene.lights.empty() || scene.cameras.empty()) return {};
    const SceneState state = state_at_start(scene);
    const SpaceGrid grid(scene, scene.timeline.start);
    if (grid.empty()) return {};
    const Camera& camera = scene.cameras.front();
    const TestImage image = test_image_of(state, camera, state.world(camera.node));
    // The irradiance of a surface by one light.
    const auto arrives = [&](std::size_t l, const glm::vec3& point, const glm::vec3& normal) {
        const LightState& at = state.light(static_cast<LightId>(l));
        const LightSample sample = illuminate(scene.lights[l], at, point);
        const float cosine = glm::dot(sample.to_light, normal);
        if (!at.visible || sample.irradiance == glm::vec3(0) || !(cosine > 0)) return 0.0f;
        // Grid cells at both ends are filled by the surfaces themselves.
        const SpaceGrid::Hit hit = grid.cast(point + 2.0f * grid.cell() * normal, sample.to_light);
        const bool open = hit.met == SpaceGrid::Met::nothing || hit.distance > sample.distance - 2 * grid.cell();
        return open ? cosine * luminance(sample.irradiance) : 0.0f;
    };
    // Of many lights, ask so many, evenly spaced, that the cost stays bounded.
    constexpr std::size_t k_most_lights = 1024;
    const std::size_t step = (scene.lights.size() + k_most_lights - 1) / k_most_lights;
    std::size_t asked = 0, reached = 0;
    std::vector<float> light;   // by pixel of a surface that needs it
    for (const TestPixel& pixel : image.pixels) {
        if (pixel.object == none) continue;
        const Mesh& mesh = scene.meshes[scene.objects[pixel.object].mesh];
        const Material& material = scene.materials[mesh.part_of(pixel.triangle).material];
        ++asked;
        if (material.model == ShadingModel::unlit) {
            ++reached;
            continue;
        }
        float& sum = light.emplace_back(0);
        for (std::size_t l = 0; l < scene.lights.size(); l += step) sum += arrives(l, pixel.position, pixel.normal);
    }
    Reached result;
    result.filled = static_cast<float>(asked) / static_cast<float>(image.pixels.size());
    if (asked > 0) result.share = 1;
    if (light.empty()) return result;
    // What is far darker than the bright parts of the image shows as black there.
    const auto bright = light.begin() + static_cast<std::ptrdiff_t>(k_bright * static_cast<double>(light.size() - 1));
    std::nth_element(light.begin(), bright, light.end());
    result.bright = *bright;
    const float least = k_least_light * *bright;
    for (const float sum : light) reached += sum > 0 && sum >= least;
    result.share = static_cast<float>(reached) / static_cast<float>(asked);
    return result;
}

namespace {

void add_ground_below(Scene& scene, const char* name, const Framed& framed)
{
    const glm::dvec3 middle(framed.box.centre());
    const double radius = k_ground_radius * framed.size;
    Material material;
    material.name = name;
    material.base_color = k_ground_color;
    material.roughness = 1;
    material.catches_shadows = true;
    Mesh mesh;
    mesh.name = material.name;
    mesh.positions.emplace_back(0);
    for (int i = 0; i < k_ground_corners; ++i) {
        const double angle = 2 * k_pi * i / k_ground_corners;
        mesh.positions.emplace_back(radius * std::cos(angle), 0, -radius * std::sin(angle));
        mesh.triangles.emplace_back(0, 1 + i, 1 + (i + 1) % k_ground_corners);
    }
    mesh.parts = {{static_cast<MaterialId>(scene.materials.size()), 0, static_cast<std::uint32_t>(k_ground_corners)}};
    const glm::dvec3 place(middle.x, static_cast<double>(framed.box.low.y) - k_ground_below * framed.size, middle.z);
    const NodeId node = scene.add_node(material.name, none, glm::translate(glm::dmat4(1), place));
    scene.nodes[node].mesh = static_cast<MeshId>(scene.meshes.size());
    scene.nodes[node].by_default = true;
    scene.materials.push_back(std::move(material));
    scene.meshes.push_back(std::move(mesh));
    scene.finish();
}

}   // namespace

void add_ground(Scene& scene, const char* name)
{
    if (!scene.objects.empty()) add_ground_below(scene, name, box_of_clip(scene));
}

void add_surroundings(Scene& scene, const SurroundingsOptions& options, const Survey& survey)
{
    GNOMON_CHECK(!scene.child_begin.empty());   // after finish()
    const bool has_own = !scene.lights.empty();
    bool ground = options.ground.value_or(false);
    std::optional<Framed> framed;   // of the clip, once it was needed
    const auto clip = [&]() -> const Framed& {
        if (survey.clip) return *survey.clip;
        if (!framed) framed = box_of_clip(scene);
        return *framed;
    };
    const auto ground_suits = [&](const SceneState& state) {
        if (options.ground) return *options.ground;
        if (scene.objects.empty()) return false;
        return looks_from_above(scene, state, clip());
    };
    const Reached reached = reached_by_lights(scene);
    if (!(has_own && reached.share >= options.enough_reached)) {
        const char* const why =
            has_own ? "no light in the scene reaches half of what is in view" : "no light in the scene";
        const SceneState state = state_at_start(scene);
        const auto room = survey.judged ? survey.room : believed_interior(state);
        if (room && !room->stage) {
            add_light_of_place(scene, *room, why);
        } else if (is_landscape(state, options)) {
            add_sky_and_sun(scene, nullptr, why);
            ground = ground_suits(state);
        } else {
            // A closed shell that is seen through its one-sided walls would be black inside.
            if (!room && has_shells(scene) && share_shut_off(state) > options.shut_off && open_shells(scene) > 0)
                scene.warnings.emplace_back("one-sided walls around what is in view cast no shadow");
            ground = options.ground || !room ? ground_suits(state) : false;
            add_studio(scene, options, 1);
            scene.warnings.push_back(fmt::format("{}: added a studio{}", why, ground ? " and a ground" : ""));
        }
    } else if (options.fill > 0 && reached.bright > 0 && reached.filled < options.enough_filled &&
               !scene.objects.empty() && scene.cameras.front().fit && !before_stage(scene, survey)) {
        // Objects before nothing, and shadows into which no light comes, are black.
        const glm::vec3 up = studio_environment()->irradiance({0, 1, 0});
        add_studio(scene, options, options.fill * reached.bright / luminance(up));
        scene.warnings.emplace_back("no surroundings in the scene: added a dim studio around what its lights reach");
    }
    if (ground && !scene.objects.empty())
        add_ground_below(scene, options.ground ? k_wanted_ground : k_default_ground, clip());
}

}   // namespace gnomon::scene
