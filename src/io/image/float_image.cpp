// SPDX-License-Identifier: Apache-2.0
#include "io/image/float_image.h"

#include <algorithm>

#include "gnomon/error.h"
#include "io/file/read_file.h"
#include "io/image/exr.h"
#include "io/image/exr_header.h"
#include "io/image/hdr.h"
#include "io/image/image_file.h"

namespace gnomon::io {

namespace fs = std::filesystem;

namespace {
// The main image of an OpenEXR file: R G B, or one grey channel.
ImageF color_of(const ExrImage& file, const std::string& name)
{
    if (file.layers.empty()) throw InputError(name, "", "no channels R G B or Y");
    const ExrLayer& layer = file.layers.front();
    const auto find = [&](const char* channel) {
        const auto at = std::find(layer.channels.begin(), layer.channels.end(), channel);
        return at == layer.channels.end() ? -1 : static_cast<int>(at - layer.channels.begin());
    };
    int from[3] = {find("R"), find("G"), find("B")};
    if (from[0] < 0 && from[1] < 0 && from[2] < 0) from[0] = from[1] = from[2] = find("Y");
    if (from[0] < 0 || from[1] < 0 || from[2] < 0) throw InputError(name, "", "no channels R G B or Y");
    ImageF image(file.size.width, file.size.height, 3);
    const std::size_t pixels = image.data.size() / 3, step = layer.channels.size();
    for (std::size_t i = 0; i < pixels; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            image.data[i * 3 + c] = layer.data[i * step + static_cast<std::size_t>(from[c])];
    return image;
}

ImageF color_of(const Image8& encoded)
{
    ImageF image(encoded.width, encoded.height, 3);
    const float* linear = linear_from_srgb8();
    const auto step = static_cast<std::size_t>(encoded.channels);
    const std::size_t pixels = image.data.size() / 3;
    for (std::size_t i = 0; i < pixels; ++i)
        for (std::size_t c = 0; c < 3; ++c) image.data[i * 3 + c] = linear[encoded.data[i * step + (step < 3 ? 0 : c)]];
    return image;
}
}   // namespace

ImageFormat image_format(std::span<const std::uint8_t> bytes)
{
    if (is_exr(bytes)) return ImageFormat::exr;
    return is_hdr(bytes) ? ImageFormat::hdr : ImageFormat::other;
}

std::vector<std::uint8_t> read_image_bytes(const fs::path& file, const FloatImageLimits& limits)
{
    return read_whole_file(file, file.string(), limits.max_file_bytes);
}

ImageF decode_float_image(std::span<const std::uint8_t> bytes, const std::string& name, const FloatImageLimits& limits)
{
    switch (image_format(bytes)) {
        case ImageFormat::exr:
            return color_of(decode_exr(bytes, name, "", limits), name);
        case ImageFormat::hdr:
            return decode_hdr(bytes, name, limits);
        case ImageFormat::other:
            break;
    }
    ImageLimits ldr;
    ldr.max_side = std::min(ldr.max_side, limits.max_side);
    ldr.max_pixels = std::min(ldr.max_pixels, limits.max_pixels);
    return color_of(decode_image(bytes, name, ldr));
}

ImageF read_float_image(const fs::path& file, const FloatImageLimits& limits)
{
    return decode_float_image(read_image_bytes(file, limits), file.string(), limits);
}

}   // namespace gnomon::io
