// SPDX-License-Identifier: Apache-2.0
// Light maps on the device against ray-cast ones: the tree, the cut and the sums over the same texels; the maps
// themselves; and the indirect light of complete images, for all methods.
#include "api/scene_access.h"
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include <fmt/format.h>

#include "gnomon/gnomon.h"
#include "light_quadtree/vulkan/gpu_map_light.h"
#include "scene/builtin/builtin.h"
#include "scene_helpers.h"
#include "support.h"

namespace gnomon {
namespace {

using light_quadtree::Clusters;
using light_quadtree::GpuMapLight;
using light_quadtree::LightMap;
using light_quadtree::LightNode;
using light_quadtree::MapLight;
using light_quadtree::MapLightOptions;
using light_quadtree::MapMethod;
using light_quadtree::shared::GpuCluster;

class LightMapVulkan : public test::VulkanTest {};

constexpr float k_node_tolerance = 2e-5f;   // of a node's values, relative to the scene's size or 1
constexpr double k_same_validity = 1e-4;    // fraction of nodes whose validity may differ: at the edge of a threshold
constexpr double k_sum_tolerance = 1e-4;    // of sums over the same clusters, relative to the mean
constexpr double k_sampled_tolerance = 5e-3;   // of sums over the same texels: a sample may fall on the next texel
constexpr double k_texels_that_differ =
    0.01;                                    // fraction of texels where a ray and the rasteriser see different surfaces
constexpr double k_flux_tolerance = 0.01;    // of a map's sum of flux
constexpr double k_image_tolerance = 0.05;   // mean difference of an image's indirect light, relative to its mean

std::shared_ptr<const scene::Scene> lit_scene(const std::string& name)
{
    if (name.starts_with("builtin:")) return std::make_shared<const scene::Scene>(scene::make_builtin(name.substr(8)));
    // Instances, mirrored ones, masked and transparent surfaces, textures; three types of light.
    scene::Scene scene = *test::make_random_scene(std::stoul(name));
    scene::add_default_camera(scene);
    const Scene lit = api::public_scene(std::make_shared<const scene::Scene>(std::move(scene)));
    return api::scene_of(lit.with_light_specs({"point 0 9 4 300 280 260", "spot 8 8 8 -1 -1 -1 40 200 300 200"}));
}

MapLightOptions small(MapMethod method)
{
    MapLightOptions options;
    options.method = method;
    options.map.side = 128;
    return options;
}

struct Stage {
    Stage(const std::string& name, const MapLightOptions& options)
        : scene(lit_scene(name)), state(scene, 0.2), rays(state), tasks(2), map(state, rays, options, tasks)
    {
    }
    std::shared_ptr<const scene::Scene> scene;
    scene::SceneState state;
    ray::RayScene rays;
    Tasks tasks;
    MapLight map;
};

const char* const k_scenes[] = {"builtin:cornell", "builtin:kinetic", "1", "2"};

TEST_F(LightMapVulkan, TreeAndCutEqualTheCpuOverTheSameTexels)
{
    for (const char* name : k_scenes) {
        SCOPED_TRACE(name);
        const Stage stage(name, small(MapMethod::quadtree));
        const LightMap& cast = stage.map.map();
        GpuMapLight light(device_, stage.state, small(MapMethod::quadtree));
        vk::Commands commands(device_);
        light.map().record_tree_over(commands, stage.state, cast.nodes());
        const vk::Buffer nodes = commands.read_back(light.map().nodes()),
                         valid = commands.read_back(light.map().shares()),
                         counts = commands.read_back(light.map().counts()),
                         clusters = commands.read_back(light.map().clusters());
        commands.submit();

        const float size = stage.rays.bounds().diagonal();
        const std::span<const LightNode> made = nodes.as<LightNode>();
        std::size_t wrong = 0, otherwise = 0;
        for (const LightMap::View& view : cast.views())
            for (std::size_t id = view.first; id < view.node(view.levels, 0, 0) && view.on; ++id) {
                const LightNode &a = cast.node(id), &b = made[id];
                const auto near = [](const glm::vec3& p, const glm::vec3& q, float scale) {
                    return glm::length(p - q) <= k_node_tolerance * scale;
                };
                wrong += a.members != b.members || !near(a.position, b.position, size) ||
                         !near(a.normal, b.normal, 1) || !near(a.flux, b.flux, 10 * glm::length(a.flux)) ||
                         std::abs(a.depth - b.depth) > k_node_tolerance ||
                         std::abs(a.area - b.area) > 10 * k_node_tolerance * a.area;
                otherwise += cast.share(id) != valid.as<std::uint32_t>()[id];
            }
        EXPECT_EQ(wrong, 0u);
        EXPECT_LE(static_cast<double>(otherwise), k_same_validity * static_cast<double>(cast.nodes().size()));

        // The same list in the same order, except where a node is at the edge of a threshold.
        const Clusters& expected = stage.map.clusters();
        const std::uint64_t count = light.lights(counts);
        EXPECT_GT(count, 20u);
        if (otherwise > 0) continue;
        ASSERT_EQ(count, expected.size());
        std::size_t other_nodes = 0;
        for (std::size_t c = 0; c < count; ++c) {
            const GpuCluster& cluster = clusters.as<GpuCluster>()[c];
            other_nodes += cluster.node != expected.node[c] || cluster.grid != expected.grid[c];
        }
        EXPECT_EQ(other_nodes, 0u);
    }
}

// The irradiance at the surfaces of some pixels, by both.
struct Sums {
    double difference = 0, mean = 0;
    std::size_t points = 0;
};

Sums compare_sums(const std::shared_ptr<vk::Device>& device, const std::string& name, MapLightOptions options)
{
    options.grid = 0;
    const Stage stage(name, options);
    GpuMapLight light(device, stage.state, options);
    // Points slightly above the surfaces that the light sees.
    light_quadtree::Receivers receivers;
    std::vector<glm::vec4> positions, normals;
    const LightMap& cast = stage.map.map();
    for (const LightMap::View& view : cast.views())
        for (std::size_t id = view.node(view.levels, 0, 0); id < view.end() && view.on; id += 37) {
            const LightNode& texel = cast.node(id);
            if (texel.members == 0 || positions.size() >= 2048) continue;
            positions.emplace_back(texel.position, 1);
            normals.emplace_back(texel.normal, 0);
        }
    const auto count = static_cast<std::uint32_t>(positions.size());
    receivers.resize(count);
    for (std::size_t i = 0; i < count; ++i) receivers.set(i, glm::vec3(positions[i]), glm::vec3(normals[i]));
    light_quadtree::MapLight::Batch batch;
    stage.map.gather_all(receivers, 0, receivers.x.size(), batch);

    const auto image = [&](const char* what) {
        return vk::Image(device, {.name = what,
                                  .width = count,
                                  .height = 1,
                                  .format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                  .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT});
    };
    const vk::Image position = image("positions"), normal = image("normals"), irradiance = image("irradiance");
    const vk::Buffer at(device, "at", count * sizeof(glm::vec4)), facing(device, "facing", count * sizeof(glm::vec4));
    vk::Commands commands(device);
    light.map().record_tree_over(commands, stage.state, cast.nodes());
    const vk::Upload uploads[] = {vk::upload_of(at, std::span<const glm::vec4>(positions)),
                                  vk::upload_of(facing, std::span<const glm::vec4>(normals))};
    commands.upload("points", uploads);
    for (const auto& [from, to] : {std::pair(&at, &position), std::pair(&facing, &normal)})
        commands.pass("to image")
            .reads(*from, vk::Use::copy_source)
            .writes(*to, vk::Use::copy_target)
            .copy([from = from, to = to](vk::Recorder& r) {
                VkBufferImageCopy all{};
                all.imageSubresource = {to->aspect(), 0, 0, 1};
                all.imageExtent = {to->width(), 1, 1};
                r.copy(*from, *to, {&all, 1});
            });
    light.record_light(commands, {&position, &normal, {static_cast<int>(count), 1}}, irradiance);
    const vk::Buffer arrived = commands.read_back(irradiance);
    commands.submit();

    Sums sums;
    sums.points = count;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 a = receivers.irradiance(i), b(arrived.as<glm::vec4>()[i]);
        for (int c = 0; c < 3; ++c)
            sums.difference += static_cast<double>(std::abs(a[c] - b[c])), sums.mean += static_cast<double>(a[c]);
    }
    return sums;
}

TEST_F(LightMapVulkan, SumsEqualTheCpuOverTheSameLights)
{
    for (const char* name : k_scenes)
        for (const MapMethod method : {MapMethod::quadtree, MapMethod::rsm}) {
            SCOPED_TRACE(fmt::format("{}, {}", name, method == MapMethod::rsm ? "samples" : "clusters"));
            const Sums sums = compare_sums(device_, name, small(method));
            EXPECT_GT(sums.points, 100u);
            EXPECT_GT(sums.mean, 0);
            EXPECT_LE(sums.difference / sums.mean, method == MapMethod::rsm ? k_sampled_tolerance : k_sum_tolerance);
            RecordProperty("difference", std::to_string(sums.difference / sums.mean));
        }
}

TEST_F(LightMapVulkan, RasterisedTexelsEqualRayCastOnes)
{
    for (const char* name : k_scenes) {
        SCOPED_TRACE(name);
        const Stage stage(name, small(MapMethod::quadtree));
        const LightMap& cast = stage.map.map();
        const gpu_scene::GpuScene scene(device_, stage.state);
        GpuMapLight light(device_, stage.state, small(MapMethod::quadtree));
        vk::Commands commands(device_);
        light.map().record(commands, scene, stage.state);
        const vk::Buffer nodes = commands.read_back(light.map().nodes());
        commands.submit();

        const float size = stage.rays.bounds().diagonal();
        std::size_t texels = 0, other = 0;
        double flux = 0, drawn_flux = 0;
        for (const LightMap::View& view : cast.views())
            for (std::size_t id = view.node(view.levels, 0, 0); id < view.end() && view.on; ++id) {
                const LightNode &a = cast.node(id), &b = nodes.as<LightNode>()[id];
                for (int c = 0; c < 3; ++c)
                    flux += static_cast<double>(a.flux[c]), drawn_flux += static_cast<double>(b.flux[c]);
                if (a.members == 0 && b.members == 0) continue;
                ++texels;
                const bool same = a.members == b.members && glm::length(a.position - b.position) < 1e-4f * size &&
                                  glm::dot(a.normal, b.normal) > 0.999f && std::abs(a.depth - b.depth) < 1e-4f &&
                                  std::abs(a.area - b.area) <= 1e-2f * a.area &&
                                  glm::length(a.flux - b.flux) <= 1e-2f * glm::length(a.flux) + 1e-12f;
                other += !same;
            }
        EXPECT_GT(texels, 1000u);
        EXPECT_LE(static_cast<double>(other), k_texels_that_differ * static_cast<double>(texels))
            << other << " of " << texels;
        EXPECT_NEAR(drawn_flux / flux, 1, k_flux_tolerance);
        if (std::getenv("GNOMON_IMAGES"))
            fmt::print("{}: {} of {} texels differ; flux {:.5f}\n", name, other, texels, drawn_flux / flux);
    }
}

const Layer& layer(const Frame& image, const std::string& name)
{
    for (const Layer& l : image.layers)
        if (l.name == name) return l;
    throw std::runtime_error("no layer " + name);
}

// The mean difference of indirect light relative to its mean, at pixels where both see the same surface and no mirror.
double image_difference(const Scene& scene, int frame, RenderOptions options)
{
    options.layers = true;
    options.max_depth = 0;
    options.exposure = 0;
    const Frame traced = Renderer(options).render(scene, frame);
    options.renderer = RenderMethod::raster;
    Frame drawn = Renderer(options).render(scene, frame);
    if (const char* folder = std::getenv("GNOMON_IMAGES")) {
        static int number = 0;
        traced.write(std::filesystem::path(folder) / fmt::format("bounce-{}-traced.png", ++number));
        drawn.write(std::filesystem::path(folder) / fmt::format("bounce-{}-raster.png", number));
    }
    const auto &za = layer(traced, "depth").copy(), &zb = layer(drawn, "depth").copy();
    const auto &a = layer(traced, "indirect").copy(), &b = layer(drawn, "indirect").copy();
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < za.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            if (std::abs(za[i] - zb[i]) > 1e-3f * za[i]) continue;
            difference += static_cast<double>(std::abs(a[3 * i + c] - b[3 * i + c]));
            sum += static_cast<double>(a[3 * i + c]);
        }
    EXPECT_GT(sum, 0);
    return difference / sum;
}

void expect_same_bounce(const Scene& scene, int frame, Indirect how, bool full, Size size)
{
    RenderOptions options;
    options.size = size;
    options.indirect = how;
    options.indirect_at_every_pixel = full;
    const double difference = image_difference(scene, frame, options);
    EXPECT_LE(difference, k_image_tolerance) << static_cast<int>(how) << (full ? ", every pixel" : "");
    if (std::getenv("GNOMON_IMAGES"))
        fmt::print("bounced light, method {}{}: {:.4f} of the mean\n", static_cast<int>(how),
                   full ? ", every pixel" : "", difference);
}

TEST_F(LightMapVulkan, IndirectLightOfCornellEqualsTheCpu)
{
    const Scene scene = load("builtin:cornell");
    for (const Indirect how : {Indirect::quadtree, Indirect::rsm})
        for (const bool full : {false, true}) expect_same_bounce(scene, 12, how, full, {96, 96});
    expect_same_bounce(scene, 12, Indirect::visible, false, {96, 96});
}

TEST_F(LightMapVulkan, IndirectLightOfKineticEqualsTheCpu)
{
    const Scene scene = load("builtin:kinetic");
    expect_same_bounce(scene, 40, Indirect::quadtree, false, {80, 60});
    expect_same_bounce(scene, 40, Indirect::visible, false, {160, 120});
}

TEST_F(LightMapVulkan, IndirectLightOfKitchenEqualsTheCpu)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    const Scene scene = load(file.string());
    expect_same_bounce(scene, 200, Indirect::quadtree, false, {80, 60});
    expect_same_bounce(scene, 200, Indirect::visible, false, {160, 120});
}

}   // namespace
}   // namespace gnomon

#else
TEST(LightMapVulkan, SkippedWithoutVulkan)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif
