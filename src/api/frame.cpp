// SPDX-License-Identifier: Apache-2.0
#include "gnomon/frame.h"

#include <fmt/format.h>

#include "base/check.h"
#include "gnomon/error.h"
#include "image/tone_map.h"
#include "io/file/output_name.h"
#include "io/image/exr.h"
#include "io/image/image_file.h"

namespace gnomon {

const Layer* Frame::layer(const std::string& name) const
{
    for (const Layer& candidate : layers)
        if (candidate.name == name) return &candidate;
    return nullptr;
}

std::vector<std::uint8_t> Frame::to_srgb8() const
{
    GNOMON_CHECK(!layers.empty());
    GNOMON_CHECK_EQ(layers.front().data.size(), std::size_t{3} * size.width * size.height);
    std::vector<std::uint8_t> bytes(layers.front().data.size());
    image::encode_srgb8(layers.front().data, exposure, tonemap, bytes);
    return bytes;
}

void Frame::write(const std::filesystem::path& file) const
{
    if (io::output_kind(file) == io::OutputKind::video)
        throw UsageError(fmt::format("{}: one image is not a video; write .png or .exr", file.string()));
    if (io::is_exr_name(file)) {
        io::write_exr(file, size, layers);
        return;
    }
    Image8 image(size.width, size.height, 3);
    image.data = to_srgb8();
    io::write_png(file, image);
}

}   // namespace gnomon
