// SPDX-License-Identifier: Apache-2.0
#include "bench/indirect/vulkan.h"

#include "gnomon/error.h"
#include "light_quadtree/map_light.h"

#ifdef GNOMON_VULKAN
#include <algorithm>

#include "base/clocks.h"
#include "light_quadtree/vulkan/gpu_map_light.h"
#include "vk/device_timer.h"

namespace gnomon::bench {

namespace {

using light_quadtree::GpuMapLight;
using light_quadtree::MapSurfaces;

constexpr std::size_t k_listed_per_row = 1024;   // points per row of a list laid out as an image

// Positions and normals on the device, and their irradiance.
struct Points {
    vk::Image position, normal, irradiance;
    vk::Buffer sent_position, sent_normal;

    void fit(const std::shared_ptr<vk::Device>& device, Size size)
    {
        const auto width = static_cast<std::uint32_t>(size.width), height = static_cast<std::uint32_t>(size.height);
        if (position && position.width() == width && position.height() == height) return;
        const auto image = [&](const char* name) {
            return vk::Image(device, {.name = name,
                                      .width = width,
                                      .height = height,
                                      .format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                      .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT});
        };
        position = image("positions"), normal = image("normals"), irradiance = image("irradiance");
        const std::size_t bytes = std::size_t{width} * height * sizeof(glm::vec4);
        sent_position = vk::Buffer(device, "positions", bytes);
        sent_normal = vk::Buffer(device, "normals", bytes);
    }
    void send(vk::Commands& commands, std::span<const glm::vec4> positions, std::span<const glm::vec4> normals) const
    {
        const vk::Upload uploads[] = {vk::upload_of(sent_position, positions), vk::upload_of(sent_normal, normals)};
        commands.upload("send surfaces", uploads);
        for (const auto& [from, to] : {std::pair(&sent_position, &position), std::pair(&sent_normal, &normal)})
            commands.pass("surfaces to images")
                .reads(*from, vk::Use::copy_source)
                .writes(*to, vk::Use::copy_target)
                .copy([from = from, to = to](vk::Recorder& r) {
                    VkBufferImageCopy all{};
                    all.imageSubresource = {to->aspect(), 0, 0, 1};
                    all.imageExtent = {to->width(), to->height(), 1};
                    r.copy(*from, *to, {&all, 1});
                });
        commands.submit();
    }
};

void surfaces_of(const SeenImage& image, std::vector<glm::vec4>& positions, std::vector<glm::vec4>& normals)
{
    positions.clear(), normals.clear();
    for (const SeenPoint& seen : image.points) {
        // Keep points that do not reflect diffusely, because they can be receivers of the grid.
        const bool there = seen.point.object != scene::none;
        positions.emplace_back(seen.point.position, there ? 1 : 0);
        normals.emplace_back(seen.point.normal, 0);
    }
}

class VulkanMapMethod final : public IndirectMethod {
 public:
    VulkanMapMethod(const light_quadtree::MapLightOptions& options, const scene::SceneState& state)
        : device_(vk::Device::open()),
          commands_(device_),
          timer_(device_),
          scene_(device_, state),
          light_(device_, state, options)
    {
        light_.map().record(commands_, scene_, state);
        times_.made = submit();
    }

    int grid_step(Size size) const override { return light_.grid_step(size); }

    bool forget() override
    {
        light_.forget();
        return true;
    }

    void begin_frame(const scene::SceneState& state, const ray::RayScene&, Tasks&) override
    {
        scene_.update(commands_, state);
        commands_.submit();
        light_.map().record(commands_, scene_, state);
        times_.begun = submit();
        count_ = light_.read_count(commands_);
        commands_.submit();
    }

    void light(const SeenImage& image, Tasks&, glm::vec3* irradiance) override
    {
        // Upload the surfaces.
        surfaces_of(image, positions_, normals_);
        points_.fit(device_, image.size);
        points_.send(commands_, positions_, normals_);

        // The light of the grid is kept by GpuMapLight, if the surfaces are those of the frame before.
        MapSurfaces surfaces = seen(image, points_);
        surfaces.kept = positions_ == last_positions_ && normals_ == last_normals_;
        last_positions_ = positions_, last_normals_ = normals_;
        light_.record_grid(commands_, surfaces);

        // Compute and read back the irradiance.
        light_.record_light(commands_, surfaces, points_.irradiance);
        times_.lit = submit();
        const vk::Buffer arrived = commands_.read_back(points_.irradiance);
        commands_.submit();
        for (std::size_t i = 0; i < image.points.size(); ++i) irradiance[i] = glm::vec3(arrived.as<glm::vec4>()[i]);
        eye_ = surfaces;
    }

    void sample(std::span<const SeenPoint> points, glm::vec3* irradiance) override
    {
        if (points.empty()) return;
        const std::size_t rows = (points.size() + k_listed_per_row - 1) / k_listed_per_row;
        positions_.assign(rows * k_listed_per_row, glm::vec4(0)),
            normals_.assign(rows * k_listed_per_row, glm::vec4(0));
        for (std::size_t i = 0; i < points.size(); ++i) {
            const glm::ivec2 pixel(glm::floor(points[i].place));
            positions_[i] =
                glm::vec4(points[i].point.position, static_cast<float>(pixel.y * eye_.size.width + pixel.x + 1));
            normals_[i] = glm::vec4(points[i].point.normal, 0);
        }
        listed_.fit(device_, {static_cast<int>(k_listed_per_row), static_cast<int>(rows)});
        listed_.send(commands_, positions_, normals_);
        MapSurfaces surfaces = eye_;
        surfaces.position = &listed_.position, surfaces.normal = &listed_.normal;
        light_.record_listed(commands_, surfaces, listed_.irradiance);
        const vk::Buffer arrived = commands_.read_back(listed_.irradiance);
        commands_.submit();
        for (std::size_t i = 0; i < points.size(); ++i) irradiance[i] = glm::vec3(arrived.as<glm::vec4>()[i]);
    }

    IndirectWork end_frame() override
    {
        const light_quadtree::GpuLightMap::Work& work = light_.map().work();
        return {light_.lights(count_), 0, work.texels, work.nodes, light_.bytes()};
    }

    const IndirectTimes* own_times() const override { return &times_; }

 private:
    static MapSurfaces seen(const SeenImage& image, const Points& points)
    {
        return {&points.position, &points.normal,         image.size,
                image.view.eye,   image.view.pixel_width, image.view.pixel_spread};
    }
    IndirectTimes::Took submit()
    {
        const double cpu = cpu_ms();
        timer_.start();
        commands_.submit();
        const double ms = timer_.stop();
        return {ms, cpu_ms() - cpu};
    }

    std::shared_ptr<vk::Device> device_;
    vk::Commands commands_;
    vk::DeviceTimer timer_;
    gpu_scene::GpuScene scene_;
    GpuMapLight light_;
    IndirectTimes times_;
    Points points_, listed_;
    MapSurfaces eye_{};   // the latest image
    std::vector<glm::vec4> positions_, normals_;
    std::vector<glm::vec4> last_positions_, last_normals_;   // of the image before
    vk::Buffer count_;
};

}   // namespace

std::unique_ptr<IndirectMethod> make_vulkan_map_method(const light_quadtree::MapLightOptions& options,
                                                       const scene::SceneState& state, const ray::RayScene&, Tasks&)
{
    return std::make_unique<VulkanMapMethod>(options, state);
}

LargeGather measure_large_gather(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                                 Tasks& tasks)
{
    LargeGather result;
    // Trace the image, and draw the light map with its repeated clusters.
    const std::shared_ptr<vk::Device> device = vk::Device::open();
    SeenImage image;
    see_image(state, rays, view, 0, tasks, image);
    result.size = image.size;
    light_quadtree::MapLightOptions options;
    options.levels.limit = 4;
    options.grid = 0;
    const gpu_scene::GpuScene scene(device, state);
    GpuMapLight light(device, state, options);
    vk::Commands commands(device);
    light.map().record(commands, scene, state);
    light.map().record_repeated(commands, static_cast<std::uint32_t>(result.clusters));

    // Upload the surfaces, and time the gather.
    std::vector<glm::vec4> positions, normals;
    surfaces_of(image, positions, normals);
    Points points;
    points.fit(device, image.size);
    points.send(commands, positions, normals);
    vk::DeviceTimer timer(device);
    light.record_light(commands,
                       {&points.position, &points.normal, image.size, view.eye, view.pixel_width, view.pixel_spread},
                       points.irradiance);
    timer.start();
    commands.submit();
    result.ms = timer.stop();
    return result;
}

std::string vulkan_device_name()
{
    return vk::Device::open()->info().name;
}

}   // namespace gnomon::bench

#else

namespace gnomon::bench {

namespace {
[[noreturn]] void missing()
{
    throw MissingError("this program was built without Vulkan, which --renderer raster needs");
}
}   // namespace

std::unique_ptr<IndirectMethod> make_vulkan_map_method(const light_quadtree::MapLightOptions&, const scene::SceneState&,
                                                       const ray::RayScene&, Tasks&)
{
    missing();
}
LargeGather measure_large_gather(const scene::SceneState&, const ray::RayScene&, const scene::View&, Tasks&)
{
    missing();
}
std::string vulkan_device_name()
{
    missing();
}

}   // namespace gnomon::bench

#endif
