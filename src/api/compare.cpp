// SPDX-License-Identifier: Apache-2.0
#include "gnomon/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "api/check_options.h"
#include "image/flip.h"
#include "image/image_metrics.h"
#include "io/image/exr.h"
#include "io/image/float_image.h"
#include "io/image/hdr.h"
#include "io/image/image_file.h"

namespace gnomon {

namespace {

// An image with the values of its file.
struct Loaded {
    ImageF image;
    std::vector<std::string> channels;
    bool linear = false;
};

Loaded load_exr(std::span<const std::uint8_t> bytes, const std::string& name, const std::string& layer)
{
    io::ExrImage image = io::decode_exr(bytes, name, layer);
    if (image.layers.empty()) {
        std::string there;
        for (const std::string& other : io::exr_layer_names(bytes, name))
            if (!other.empty()) there += (there.empty() ? "" : ", ") + other;
        throw UsageError(fmt::format("{}: no layer '{}'; there are: {}", name, layer, there.empty() ? "none" : there));
    }
    io::ExrLayer& found = image.layers.front();
    Loaded loaded;
    loaded.image.width = image.size.width, loaded.image.height = image.size.height;
    loaded.image.channels = static_cast<int>(found.channels.size());
    loaded.image.data = std::move(found.data);
    loaded.channels = std::move(found.channels);
    loaded.linear = true;
    return loaded;
}

Loaded load_image(const std::filesystem::path& file, const std::string& layer)
{
    const std::string name = file.string();
    const std::vector<std::uint8_t> bytes = io::read_image_bytes(file);
    const io::ImageFormat format = io::image_format(bytes);
    if (format == io::ImageFormat::exr) return load_exr(bytes, name, layer);
    if (!layer.empty()) throw UsageError(fmt::format("{}: only OpenEXR files have layers", name));

    Loaded loaded;
    if (format == io::ImageFormat::hdr) {
        loaded.image = io::decode_hdr(bytes, name);
        loaded.channels = {"R", "G", "B"};
        loaded.linear = true;
        return loaded;
    }
    const Image8 encoded = io::decode_image(bytes, name);
    loaded.image = ImageF(encoded.width, encoded.height, encoded.channels);
    std::transform(encoded.data.begin(), encoded.data.end(), loaded.image.data.begin(),
                   [](std::uint8_t byte) { return static_cast<float>(byte) / 255.0f; });
    static const std::vector<std::string> names[] = {{"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
    loaded.channels = names[encoded.channels - 1];
    return loaded;
}

bool is_color(const Loaded& image)
{
    return image.channels.front() == "R" || image.channels.front() == "Y";
}

// Returns the colour channels as three.
ImageF color_of(const Loaded& image)
{
    const ImageF& from = image.image;
    ImageF color(from.width, from.height, 3);
    const auto step = static_cast<std::size_t>(from.channels);
    for (std::size_t i = 0; i < color.data.size() / 3; ++i)
        for (std::size_t c = 0; c < 3; ++c) color.data[i * 3 + c] = from.data[i * step + (step < 3 ? 0 : c)];
    return color;
}

ImageF decoded(ImageF image)
{
    for (float& value : image.data) value = linear_from_srgb(value);
    return image;
}

// Compares images of different kinds by their colour alone, in linear light if either is linear.
void bring_together(Loaded& a, Loaded& b, const std::string& names)
{
    if (a.channels == b.channels && a.linear == b.linear) return;
    if (!is_color(a) || !is_color(b)) throw UsageError(fmt::format("{}: different channels", names));
    for (Loaded* one : {&a, &b}) {
        one->image = color_of(*one);
        one->channels = {"R", "G", "B"};
        if (one->linear || a.linear == b.linear) continue;
        one->image = decoded(std::move(one->image));
    }
    a.linear = b.linear = a.linear || b.linear;
}

double peak_of(const Loaded& reference)
{
    if (!reference.linear) return 1;
    float largest = 0;
    for (const float value : reference.image.data)
        if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
    return largest > 0 ? largest : 1;
}
}   // namespace

CompareResult compare(const std::filesystem::path& test, const std::filesystem::path& reference,
                      const CompareOptions& options)
{
    check_range("threads are", options.threads, ranges::threads);
    Loaded a = load_image(test, options.layer), b = load_image(reference, options.layer);
    const std::string names = fmt::format("{} and {}", test.string(), reference.string());
    if (a.image.width != b.image.width || a.image.height != b.image.height)
        throw UsageError(fmt::format("{}: sizes differ, {}x{} and {}x{}", names, a.image.width, a.image.height,
                                     b.image.width, b.image.height));
    bring_together(a, b, names);

    Tasks tasks(options.threads);
    const double peak = peak_of(b);
    const double mse = image::mean_squared_error(a.image, b.image);
    CompareResult result;
    result.size = {b.image.width, b.image.height};
    result.rmse = std::sqrt(mse);
    result.relmse = image::relative_mse(a.image, b.image);
    result.psnr = image::psnr(mse, peak);
    result.max_abs = image::max_abs_difference(a.image, b.image);
    result.pixels_different = image::pixels_different(a.image, b.image);
    if (options.ssim) result.ssim = image::ssim(a.image, b.image, peak, tasks);

    const bool visible = is_color(b) || b.image.channels == 1 || b.image.channels == 3;
    if (!visible && !options.heatmap.empty())
        throw UsageError(fmt::format("{}: a heat map needs 1 or 3 channels", names));
    if (visible && (options.flip || !options.heatmap.empty())) {
        ImageF test_color = color_of(a), reference_color = color_of(b);
        if (!b.linear) {
            test_color = decoded(std::move(test_color));
            reference_color = decoded(std::move(reference_color));
        }
        const ImageF errors = b.linear ? image::flip_hdr(test_color, reference_color, tasks)
                                       : image::flip_ldr(test_color, reference_color, tasks);
        result.flip = image::mean_of(errors);
        if (!options.heatmap.empty()) io::write_png(options.heatmap, image::heat_map(errors));
    }
    return result;
}

}   // namespace gnomon
