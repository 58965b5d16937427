// SPDX-License-Identifier: Apache-2.0
#include "api/frame_layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "api/scene_access.h"
#include "base/check.h"
#include "base/instruction_set.h"
#include "frame/state_overlay.h"
#include "gnomon/error.h"
#include "gnomon/ranges.h"
#include "image/tone_map.h"
#include "scene/near_origin.h"
#include "scene/view.h"

namespace gnomon {

namespace api {

namespace {

constexpr Size k_default_size{1280, 720};

// Returns a view of an image.
// @param owner  keeps the image's memory
template <class T>
Layer layer_of(const char* name, std::vector<std::string> channels, const Image<T>& image,
               const std::shared_ptr<const void>& owner)
{
    GNOMON_CHECK_EQ(channels.size(), static_cast<std::size_t>(image.channels));
    Layer layer;
    layer.name = name;
    layer.channels = std::move(channels);
    layer.format = std::is_same_v<T, std::uint32_t> ? PixelFormat::u32 : PixelFormat::f32;
    layer.size = {image.width, image.height};
    layer.data = image.data.data();
    layer.pixel_stride = static_cast<std::ptrdiff_t>(sizeof(T)) * image.channels;
    layer.row_stride = layer.pixel_stride * image.width;
    layer.memory = owner;
    return layer;
}

// Returns the root of the mean variance over all pixels and channels, divided by the image's mean.
double noise_of(const shading::FrameBuffers& buffers)
{
    double mean = 0, square = 0;
    for (const float value : buffers.color.data) mean += static_cast<double>(value);
    for (const float variance : buffers.variance.data) square += static_cast<double>(variance);
    const auto count = static_cast<double>(buffers.color.data.size());
    return mean > 0 ? std::sqrt(square / count) / (mean / count) : 0;
}

// The exposure of an image with the scene's own background where that is left out.
double exposure_before_background(const shading::FrameBuffers& buffers, const scene::Background& background,
                                  const scene::View& view)
{
    std::vector<float> colors = buffers.color.data;
    for (int y = 0; y < buffers.alpha.height; ++y)
        for (int x = 0; x < buffers.alpha.width; ++x) {
            const float behind = 1 - buffers.alpha.pixel(x, y)[0];
            if (!(behind > 0)) continue;
            glm::vec3 origin, direction;
            float near = 0, far = 0;
            view.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, origin, direction, near, far);
            const glm::vec3 radiance = behind * background.radiance(glm::normalize(direction));
            for (int c = 0; c < 3; ++c)
                colors[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(buffers.alpha.width) +
                            static_cast<std::size_t>(x)) +
                       static_cast<std::size_t>(c)] += radiance[c];
        }
    return image::auto_exposure(colors);
}

}   // namespace

void set_overlay(const Image8& image, Frame& result)
{
    result.size = {image.width, image.height};
    result.tonemap = ToneMap::none;
    const auto shown = std::make_shared<ImageF>(image.width, image.height, 3);
    const float* linear = linear_from_srgb8();
    for (std::size_t i = 0; i < image.data.size(); ++i) shown->data[i] = linear[image.data[i]];
    result.layers.push_back(layer_of("", {"R", "G", "B"}, *shown, shown));
}

std::vector<int> overlay_lights(const scene::Scene& scene, const RenderOptions& options)
{
    const int count = static_cast<int>(scene.lights.size());
    const bool paper = options.shadow_culling == ShadowCulling::paper;
    const auto panels = paper ? 0 : static_cast<int>(frame::sized_panels(scene).titles.size());
    const int all = count + panels;
    if (all == 0) throw UsageError("an overlay of shadow states needs a light: the scene has none");
    const auto left_out = [&](int l) {
        return panels > 0 && l < count && scene.lights[static_cast<std::size_t>(l)].of_surface;
    };
    if (options.overlay_light) {
        const int light = *options.overlay_light;
        if (light < 0 || light >= all)
            throw UsageError(fmt::format("no light {}: the scene has {}, numbered from 0", light, all));
        // For a light that approximates a surface, show the first light with size.
        return {left_out(light) ? count : light};
    }
    std::vector<int> lights;
    for (int l = 0; l < all; ++l)
        if (!left_out(l)) lights.push_back(l);
    return lights;
}

frame::OverlayKind overlay_kind(const scene::Scene& scene, const RenderOptions& options, const std::vector<int>& lights)
{
    const auto sized = [&](int l) { return static_cast<std::size_t>(l) >= scene.lights.size(); };
    return {options.shadow_culling == ShadowCulling::paper, std::any_of(lights.begin(), lights.end(), sized)};
}

std::vector<std::string> overlay_titles(const scene::Scene& scene, const std::vector<int>& lights, int frame)
{
    std::vector<std::string> titles;
    const frame::SizedPanels sized = frame::sized_panels(scene);
    const std::string when = frame > 0 ? fmt::format("frame {}  ", frame) : "";
    for (const int l : lights) {
        if (static_cast<std::size_t>(l) >= scene.lights.size()) {
            titles.push_back(when + sized.titles[static_cast<std::size_t>(l) - scene.lights.size()]);
            continue;
        }
        const std::string& name = scene.lights[static_cast<std::size_t>(l)].name;
        const std::string number = fmt::format("light {}", l);
        titles.push_back(fmt::format("{}{}{}{}", when, number, name.empty() || name == number ? "" : ": ",
                                     name == number ? "" : name));
    }
    return titles;
}

void set_layers(frame::FrameEngine& engine, const scene::Scene& scene, const scene::View& view,
                const RenderOptions& options, std::optional<double> exposure, Frame& result)
{
    shading::FrameBuffers& buffers = engine.buffers();
    if (engine.is_reference()) result.noise = noise_of(buffers);
    result.tonemap = options.tonemap;
    const bool apart = options.background != BackgroundKind::environment && engine.shown() == frame::Shown::light;
    result.exposure = exposure ? *exposure
                      : apart  ? exposure_before_background(buffers, scene.background, view)
                               : image::auto_exposure(buffers.color.data);
    if (engine.shown() == frame::Shown::redrawn) {
        engine.paint_redrawn(result.exposure);
        result.tonemap = ToneMap::none;
        result.exposure = 0;
    }

    const std::shared_ptr<const void> owner = engine.shared_buffers();
    const auto add = [&](const char* name, std::vector<std::string> channels, const auto& image) {
        result.layers.push_back(layer_of(name, std::move(channels), image, owner));
    };
    add("", {"R", "G", "B"}, buffers.color);
    if (apart) {
        add("alpha", {"A"}, buffers.alpha);
        result.background = options.background;
        std::copy(std::begin(options.background_color), std::end(options.background_color), result.background_color);
    }
    if (options.ids) add("id", {"object", "material"}, buffers.ids);
    if (options.motion) add("motion", {"X", "Y"}, buffers.motion);
    if (!options.layers) return;
    add("depth", {"Z"}, buffers.depth);
    add("normal", {"X", "Y", "Z"}, buffers.normal);
    add("albedo", {"R", "G", "B"}, buffers.albedo);
    add("direct", {"R", "G", "B"}, buffers.direct);
    if (engine.has_indirect()) add("indirect", {"R", "G", "B"}, buffers.indirect);
    if (engine.is_reference()) {
        add("variance", {"R", "G", "B"}, buffers.variance);
        add("irradiance", {"R", "G", "B"}, buffers.irradiance);
        add("irradiance_variance", {"R", "G", "B"}, buffers.irradiance_variance);
    }
    std::vector<std::string> lights;
    for (std::size_t l = 0; l < scene.lights.size(); ++l) lights.push_back(fmt::format("L{}", l));
    if (!lights.empty()) add("shadow", std::move(lights), buffers.shadow);
}

void describe(const scene::View& view, const glm::dvec3& origin, const RenderOptions& options, Frame& result)
{
    const glm::dmat4 to_camera = glm::inverse(scene::translated(scene::matrix_of(view), origin));
    // The offset from the eye gives the coordinates; a perspective divides them by the distance along the axis.
    const glm::dvec3 right = glm::dvec3(view.right) / glm::dot(glm::dvec3(view.right), glm::dvec3(view.right)),
                     up = glm::dvec3(view.up) / glm::dot(glm::dvec3(view.up), glm::dvec3(view.up)), ahead(view.forward),
                     eye = glm::dvec3(view.eye) + origin;
    const glm::dvec2 shift(view.shift);
    const double near = view.near > 0 ? static_cast<double>(view.near) : 1;
    const glm::dvec3 per_distance = view.orthographic ? glm::dvec3(0) : ahead;
    const double without = view.orthographic ? 1 : 0;
    const glm::dvec3 rows[4] = {0.5 * (right + (1 - shift.x) * per_distance), 0.5 * ((1 + shift.y) * per_distance - up),
                                ahead, per_distance};
    const double constants[4] = {0.5 * (1 - shift.x) * without, 0.5 * (1 + shift.y) * without, -near, without};
    for (std::size_t row = 0; row < 4; ++row) {
        for (int column = 0; column < 3; ++column)
            result.world_to_image.m[4 * static_cast<std::size_t>(column) + row] = rows[row][column];
        result.world_to_image.m[12 + row] = constants[row] - glm::dot(rows[row], eye);
    }
    for (int i = 0; i < 16; ++i) result.world_to_camera.m[static_cast<std::size_t>(i)] = to_camera[i / 4][i % 4];
    result.instruction_set = instruction_set_of(options);
}

std::string instruction_set_of(const RenderOptions& options)
{
    return options.arithmetic == Arithmetic::portable ? std::string("auto")
                                                      : fmt::format("native-{}", instruction_set_name());
}

void check_overlay(const scene::Scene& scene, const RenderOptions& options, Size size)
{
    if (options.overlay == Overlay::redrawn && scene.lights.empty() && frame::sized_panels(scene).titles.empty())
        throw UsageError("an overlay of what was redrawn needs a light: the scene has none");
    if (options.overlay != Overlay::shadow_states) return;
    const std::size_t panels = overlay_lights(scene, options).size();
    if (static_cast<std::int64_t>(size.width) * size.height * static_cast<std::int64_t>(panels) > ranges::k_max_pixels)
        throw UsageError(
            fmt::format("an overlay of {} lights has more than {} million pixels: choose one with --overlay-light",
                        panels, ranges::k_max_pixels / 1'000'000));
}

Size rendered_size(Size wanted, Size of_camera)
{
    if (wanted.width > 0) return wanted;
    return of_camera.width > 0 ? of_camera : k_default_size;
}

}   // namespace api

Size default_size(const Scene& scene, const std::string& camera)
{
    const scene::Scene& inside = *api::scene_of(scene);
    return api::rendered_size({}, inside.cameras[scene::find_camera(inside, camera)].resolution);
}

Size image_size(const Scene& scene, const RenderOptions& options)
{
    const scene::Scene& inside = *api::scene_of(scene);
    const Size size = options.size.width > 0 ? options.size : default_size(scene, options.camera);
    api::check_overlay(inside, options, size);
    if (options.overlay != Overlay::shadow_states) return size;
    const std::vector<int> lights = api::overlay_lights(inside, options);
    return frame::overlay_size(size, lights.size(), api::overlay_kind(inside, options, lights));
}

}   // namespace gnomon
