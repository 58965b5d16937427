// SPDX-License-Identifier: Apache-2.0
#include "gnomon/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/image.h"
#include "gnomon/error.h"
#include "image/tone_map.h"
#include "io/file/output_name.h"
#include "io/image/exr.h"
#include "io/image/image_file.h"

namespace gnomon {

namespace {

// Returns the bytes of one value.
template <class T>
const T* value_at(const Layer& layer, PixelFormat format, int x, int y, int channel)
{
    const int channels = static_cast<int>(layer.channels.size());
    if (layer.format != format)
        throw UsageError(fmt::format("layer '{}': its values are {}", layer.name,
                                     layer.format == PixelFormat::u32 ? "ids" : "no ids"));
    if (x < 0 || y < 0 || channel < 0 || x >= layer.size.width || y >= layer.size.height || channel >= channels)
        throw UsageError(fmt::format("layer '{}': no channel {} of pixel {} {}: there are {} of {} x {} pixels",
                                     layer.name, channel, x, y, channels, layer.size.width, layer.size.height));
    const auto* row = static_cast<const std::byte*>(layer.data) + y * layer.row_stride;
    return reinterpret_cast<const T*>(row + x * layer.pixel_stride) + channel;
}

template <class T>
std::span<const T> all_values(const Layer& layer, PixelFormat format)
{
    const auto pixels = static_cast<std::size_t>(layer.size.width) * static_cast<std::size_t>(layer.size.height);
    if (pixels == 0) return {};
    const auto pixel = static_cast<std::ptrdiff_t>(layer.channels.size() * sizeof(T));
    if (layer.pixel_stride != pixel || layer.row_stride != layer.size.width * pixel)
        throw UsageError(fmt::format("layer '{}': its values are not adjacent in memory", layer.name));
    return {value_at<T>(layer, format, 0, 0, 0), pixels * layer.channels.size()};
}

}   // namespace

float Layer::value(int x, int y, int channel) const
{
    return *value_at<float>(*this, PixelFormat::f32, x, y, channel);
}

std::uint32_t Layer::id(int x, int y, int channel) const
{
    return *value_at<std::uint32_t>(*this, PixelFormat::u32, x, y, channel);
}

std::span<const float> Layer::values() const
{
    return all_values<float>(*this, PixelFormat::f32);
}

std::span<const std::uint32_t> Layer::ids() const
{
    return all_values<std::uint32_t>(*this, PixelFormat::u32);
}

std::vector<float> Layer::copy() const
{
    const std::span<const float> all = values();
    return {all.begin(), all.end()};
}

const Layer* Frame::layer(const std::string& name) const
{
    for (const Layer& candidate : layers)
        if (candidate.name == name) return &candidate;
    return nullptr;
}

std::vector<std::uint8_t> Frame::to_srgb8() const
{
    if (layers.empty()) throw UsageError("a frame without layers has no image");
    const std::span<const float> rgb = layers.front().values();
    std::vector<std::uint8_t> bytes(rgb.size());
    const Layer* const alpha = background == BackgroundKind::environment ? nullptr : layer("alpha");
    if (!alpha) {
        image::encode_srgb8(rgb, exposure, tonemap, bytes);
        return bytes;
    }
    // Tone-map colours as they are where they cover a pixel, and blend them as linear light.
    const std::vector<std::uint8_t> shown = to_srgb8_alpha();
    const float* linear = linear_from_srgb8();
    const std::span<const float> covered = alpha->values();
    std::vector<float> blended(rgb.size());
    for (std::size_t i = 0; i < rgb.size(); ++i) {
        const float behind = background == BackgroundKind::color ? linear_from_srgb(background_color[i % 3]) : 0.0f;
        const float a = covered[i / 3];
        blended[i] = a * linear[shown[i / 3 * 4 + i % 3]] + (1 - a) * behind;
    }
    image::encode_srgb8(blended, 0, ToneMap::none, bytes);
    return bytes;
}

std::vector<std::uint8_t> Frame::to_srgb8_alpha() const
{
    if (layers.empty()) throw UsageError("a frame without layers has no image");
    const std::span<const float> rgb = layers.front().values();
    const std::size_t pixels = rgb.size() / 3;
    const Layer* const alpha = background == BackgroundKind::environment ? nullptr : layer("alpha");
    std::vector<float> apart(rgb.begin(), rgb.end());
    if (alpha)
        for (std::size_t i = 0; i < rgb.size(); ++i) {
            const float a = alpha->values()[i / 3];
            apart[i] = a > 0 ? rgb[i] / a : 0.0f;
        }
    std::vector<std::uint8_t> opaque(rgb.size()), bytes(pixels * 4);
    image::encode_srgb8(apart, exposure, tonemap, opaque);
    for (std::size_t p = 0; p < pixels; ++p) {
        for (std::size_t c = 0; c < 3; ++c) bytes[4 * p + c] = opaque[3 * p + c];
        const float a = alpha ? std::clamp(alpha->values()[p], 0.0f, 1.0f) : 1.0f;
        bytes[4 * p + 3] = static_cast<std::uint8_t>(std::lround(255 * a));
    }
    return bytes;
}

void Frame::write(const std::filesystem::path& file) const
{
    if (io::output_kind(file) == io::OutputKind::video)
        throw UsageError(fmt::format("{}: one image is not a video; write .png or .exr", file.string()));
    if (io::is_exr_name(file)) {
        std::vector<Layer> written = layers;
        for (Layer& layer : written)
            if (layer.name == "alpha") layer.name.clear();   // the image's channel A
        io::write_exr(file, size, written);
        return;
    }
    const bool transparent = background == BackgroundKind::transparent && layer("alpha");
    Image8 image(size.width, size.height, transparent ? 4 : 3);
    image.data = transparent ? to_srgb8_alpha() : to_srgb8();
    io::write_png(file, image);
}

}   // namespace gnomon
