// SPDX-License-Identifier: Apache-2.0
#include "api/outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "base/half.h"
#include "base/one_line.h"
#include "gnomon/error.h"
#include "image/tone_map.h"

namespace gnomon {

namespace {

// What is copied of a layer.
struct Source {
    const Layer* layer = nullptr;
    int first = 0, count = 0;   // channels
};

std::size_t bytes_of_value(PixelFormat format)
{
    switch (format) {
        case PixelFormat::f32:
        case PixelFormat::u32:
            return 4;
        case PixelFormat::f16:
            return 2;
        case PixelFormat::rgba8:
            return 1;
    }
    throw UsageError("no such format of pixels");
}

// Finds a layer, or one channel by its full name.
Source find_source(const Frame& frame, const std::string& name)
{
    for (const Layer& layer : frame.layers) {
        if (layer.name == name) return {&layer, 0, static_cast<int>(layer.channels.size())};
        for (std::size_t c = 0; c < layer.channels.size(); ++c)
            if (name == (layer.name.empty() ? "" : layer.name + ".") + layer.channels[c])
                return {&layer, static_cast<int>(c), 1};
    }
    std::string there;
    for (const Layer& layer : frame.layers)
        if (!layer.name.empty()) there += (there.empty() ? "" : ", ") + layer.name;
    throw UsageError(fmt::format("output '{}': no such layer; beside the image there are: {}", shown_name(name),
                                 there.empty() ? "none" : there));
}

void check_format(const Output& output, const Source& source)
{
    const bool ids = source.layer->format == PixelFormat::u32;
    if (ids != (output.format == PixelFormat::u32))
        throw UsageError(ids ? fmt::format("output '{}': ids need the format u32", shown_name(output.layer))
                             : fmt::format("output '{}': the format u32 is for ids alone", shown_name(output.layer)));
    const std::vector<std::string> color{"R", "G", "B"};
    if (output.format == PixelFormat::rgba8 && !(source.count == 3 && source.layer->channels == color))
        throw UsageError(
            fmt::format("output '{}': the format rgba8 needs the channels R, G and B", shown_name(output.layer)));
}

// The caller's memory with its strides filled in.
struct Target {
    std::byte* first_row = nullptr;
    std::ptrdiff_t pixel_stride = 0, row_stride = 0;
};

// Checks that the pixels, of so many bytes each, do not overlap and lie within the memory.
Target target_of(const Output& output, Size size, std::ptrdiff_t pixel)
{
    if (!output.data) throw UsageError(fmt::format("output '{}': no memory was given", shown_name(output.layer)));
    const std::ptrdiff_t width = size.width, height = size.height;
    const std::ptrdiff_t step = output.pixel_stride == 0 ? pixel : output.pixel_stride;
    if (step < pixel)
        throw UsageError(fmt::format("output '{}': pixels of {} bytes overlap at a pixel stride of {}",
                                     shown_name(output.layer), pixel, output.pixel_stride));
    // Divide instead of multiplying, because products of the caller's numbers may overflow.
    const auto bytes = static_cast<std::ptrdiff_t>(std::min<std::size_t>(output.bytes, PTRDIFF_MAX));
    const auto too_small = [&] {
        return UsageError(fmt::format("output '{}': {} bytes are too few for {} x {} pixels at these strides",
                                      shown_name(output.layer), output.bytes, size.width, size.height));
    };
    if (bytes < pixel || (width > 1 && step > (bytes - pixel) / (width - 1))) throw too_small();
    if (step > PTRDIFF_MAX / std::max<std::ptrdiff_t>(width, 1)) throw too_small();
    const std::ptrdiff_t row = (width - 1) * step + pixel;
    std::ptrdiff_t stride = output.row_stride == 0 ? width * step : output.row_stride;
    const bool upwards = stride < 0;
    if (upwards) stride = stride == PTRDIFF_MIN ? PTRDIFF_MAX : -stride;
    if (height > 1 && stride < row)
        throw UsageError(fmt::format("output '{}': rows of {} bytes overlap at a row stride of {}",
                                     shown_name(output.layer), row, output.row_stride));
    if (height > 1 && stride > (bytes - row) / (height - 1)) throw too_small();
    auto* const data = static_cast<std::byte*>(output.data);
    if (upwards) return {data + (height - 1) * stride, step, -stride};
    return {data, step, stride};
}

// Writes a row of a layer of floats or ids.
void write_row(const Output& output, const Source& source, const std::byte* from, std::byte* to, std::ptrdiff_t step)
{
    const auto count = static_cast<std::size_t>(source.count);
    const Layer& layer = *source.layer;
    from += static_cast<std::size_t>(source.first) * sizeof(float);
    for (int x = 0; x < layer.size.width; ++x, from += layer.pixel_stride, to += step) {
        if (output.format != PixelFormat::f16) {
            std::memcpy(to, from, count * sizeof(float));
            continue;
        }
        for (std::size_t c = 0; c < count; ++c) {
            float value;
            std::memcpy(&value, from + c * sizeof value, sizeof value);
            const std::uint16_t half = half_from_float(value);
            std::memcpy(to + c * sizeof half, &half, sizeof half);
        }
    }
}

// Writes a row of colours as they are shown.
void write_shown_row(const Frame& frame, const Layer& layer, const std::byte* from, std::byte* to, std::ptrdiff_t step,
                     std::vector<float>& rgb, std::vector<std::uint8_t>& shown)
{
    const auto width = static_cast<std::size_t>(layer.size.width);
    rgb.resize(3 * width);
    shown.resize(3 * width);
    for (std::size_t x = 0; x < width; ++x, from += layer.pixel_stride)
        std::memcpy(&rgb[3 * x], from, 3 * sizeof(float));
    image::encode_srgb8(rgb, frame.exposure, frame.tonemap, shown);
    for (std::size_t x = 0; x < width; ++x, to += step) {
        std::memcpy(to, &shown[3 * x], 3);
        to[3] = std::byte{255};
    }
}

// Returns the fewest bytes that a pixel of an output can have, whatever its layer.
std::ptrdiff_t least_pixel(const Output& output)
{
    return static_cast<std::ptrdiff_t>(output.format == PixelFormat::rgba8 ? 4 : bytes_of_value(output.format));
}

}   // namespace

void check_outputs(std::span<const Output> outputs, Size size)
{
    for (const Output& output : outputs) target_of(output, size, least_pixel(output));
}

void write_outputs(const Frame& frame, std::span<const Output> outputs, Tasks& tasks)
{
    // Check all before anything is written.
    std::vector<Source> sources;
    std::vector<Target> targets;
    for (const Output& output : outputs) {
        const Source source = find_source(frame, output.layer);
        check_format(output, source);
        const std::ptrdiff_t values = output.format == PixelFormat::rgba8 ? 4 : source.count;
        const auto pixel = values * static_cast<std::ptrdiff_t>(bytes_of_value(output.format));
        targets.push_back(target_of(output, source.layer->size, pixel));
        sources.push_back(source);
    }

    // An image with alpha is converted as a whole.
    std::vector<std::uint8_t> with_alpha;
    if (frame.background == BackgroundKind::transparent && frame.layer("alpha")) with_alpha = frame.to_srgb8_alpha();
    std::vector<std::uint8_t> blended;
    if (frame.background == BackgroundKind::color && frame.layer("alpha")) blended = frame.to_srgb8();

    struct Scratch {
        std::vector<float> rgb;
        std::vector<std::uint8_t> shown;
    };
    std::vector<Scratch> scratch(static_cast<std::size_t>(tasks.threads()));
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        const Layer& layer = *sources[i].layer;
        tasks.for_each(static_cast<std::size_t>(layer.size.height), [&](std::size_t y, int worker) {
            const auto row = static_cast<std::ptrdiff_t>(y);
            const std::byte* from = static_cast<const std::byte*>(layer.data) + row * layer.row_stride;
            std::byte* to = targets[i].first_row + row * targets[i].row_stride;
            Scratch& own = scratch[static_cast<std::size_t>(worker)];
            const bool is_image = outputs[i].format == PixelFormat::rgba8 && &layer == &frame.layers.front();
            if (is_image && !(with_alpha.empty() && blended.empty())) {
                const std::size_t channels = with_alpha.empty() ? 3 : 4;
                const std::vector<std::uint8_t>& shown = with_alpha.empty() ? blended : with_alpha;
                const auto width = static_cast<std::size_t>(layer.size.width);
                for (std::size_t x = 0; x < width; ++x, to += targets[i].pixel_stride) {
                    to[3] = std::byte{255};
                    std::memcpy(to, &shown[(y * width + x) * channels], channels);
                }
            } else if (outputs[i].format == PixelFormat::rgba8)
                write_shown_row(frame, layer, from, to, targets[i].pixel_stride, own.rgb, own.shown);
            else
                write_row(outputs[i], sources[i], from, to, targets[i].pixel_stride);
        });
    }
}

}   // namespace gnomon
