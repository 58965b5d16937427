// SPDX-License-Identifier: Apache-2.0
#include "gnomon/picture.h"

#include <fmt/format.h>

#include "base/check.h"
#include "gnomon/error.h"
#include "io/exr.h"
#include "io/image_file.h"
#include "render/film_files.h"
#include "render/tone_map.h"

namespace gnomon {

const Layer* Picture::layer(const std::string& name) const
{
    for (const Layer& candidate : layers)
        if (candidate.name == name) return &candidate;
    return nullptr;
}

std::vector<std::uint8_t> Picture::to_srgb8() const
{
    GNOMON_CHECK(!layers.empty());
    GNOMON_CHECK_EQ(layers.front().data.size(), std::size_t{3} * size.width * size.height);
    std::vector<std::uint8_t> bytes(layers.front().data.size());
    render::encode_srgb8(layers.front().data, exposure, tonemap, bytes);
    return bytes;
}

void Picture::write(const std::filesystem::path& file) const
{
    if (render::output_kind(file) == render::OutputKind::film)
        throw UsageError(fmt::format("{}: one picture is not a film; write .png or .exr", file.string()));
    if (render::is_exr_name(file)) {
        io::write_exr(file, size, layers);
        return;
    }
    Image8 image(size.width, size.height, 3);
    image.data = to_srgb8();
    io::write_png(file, image);
}

}   // namespace gnomon
