// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gnomon/error.h"
#include "gnomon/video.h"
#include "image/bitmap_font.h"
#include "io/image/image_file.h"

namespace gnomon {

namespace {
constexpr int k_widest_sheet = 1920;   // pixels; larger images are scaled down to fit
constexpr int k_gap = 8;
constexpr int k_dot = 2;   // pixels per dot of the font
constexpr int k_line_height = k_dot * (image::k_glyph_height + 4);
constexpr std::uint8_t k_background = 24;   // grey value of the background: dark, so that brightness can be judged
constexpr std::uint8_t k_ink = 210;

// An output pixel is the mean, in linear light, of the box of input pixels that it covers, including fractions.
struct Box {
    int first = 0, last = 0;   // inclusive
    float first_weight = 1, last_weight = 1;
    float weight(int i) const { return i == first ? first_weight : i == last ? last_weight : 1.0f; }
};

std::vector<Box> boxes(int from, int to)
{
    std::vector<Box> result(static_cast<std::size_t>(to));
    const double ratio = static_cast<double>(from) / to;
    for (int i = 0; i < to; ++i) {
        const double low = i * ratio, high = std::min<double>(from, (i + 1) * ratio);
        Box& box = result[static_cast<std::size_t>(i)];
        box.first = static_cast<int>(low);
        box.last = std::clamp(static_cast<int>(std::ceil(high)) - 1, box.first, from - 1);
        box.first_weight = static_cast<float>(std::min<double>(box.first + 1, high) - low);
        box.last_weight = static_cast<float>(high - box.last);
        if (box.first == box.last) box.last_weight = box.first_weight;
    }
    return result;
}

void paste_smaller(const Image8& image, int width, int height, Image8& sheet, int left, int top)
{
    const float* linear = linear_from_srgb8();
    const std::vector<Box> columns = boxes(image.width, width), rows = boxes(image.height, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const Box &across = columns[static_cast<std::size_t>(x)], &down = rows[static_cast<std::size_t>(y)];
            float sum[3] = {0, 0, 0}, total = 0;
            for (int v = down.first; v <= down.last; ++v) {
                for (int u = across.first; u <= across.last; ++u) {
                    const float weight = across.weight(u) * down.weight(v);
                    const std::uint8_t* p = image.pixel(u, v);
                    for (int c = 0; c < 3; ++c) sum[c] += weight * linear[p[image.channels >= 3 ? c : 0]];
                    total += weight;
                }
            }
            std::uint8_t* out = sheet.pixel(left + x, top + y);
            for (int c = 0; c < 3; ++c)
                out[c] = static_cast<std::uint8_t>(std::lround(255.0f * srgb_from_linear(sum[c] / total)));
        }
    }
}
}   // namespace

void write_contact_sheet(const std::vector<std::filesystem::path>& pngs, const std::vector<std::string>& labels,
                         int columns, const std::filesystem::path& out)
{
    if (pngs.empty() || columns < 1 || labels.size() != pngs.size())
        throw UsageError(fmt::format("{}: a contact sheet needs at least one image and column, and a label per image",
                                     out.string()));
    Image8 image = io::read_image(pngs.front());
    const int limit = std::max(1, (k_widest_sheet - k_gap) / columns - k_gap);
    const int width = std::min(image.width, limit);
    const int height = std::max(1, static_cast<int>(std::int64_t{image.height} * width / image.width));
    const Size first{image.width, image.height};

    const int rows = (static_cast<int>(pngs.size()) + columns - 1) / columns;
    const int cell_height = height + k_line_height + k_gap;
    Image8 sheet(k_gap + columns * (width + k_gap), k_gap + rows * cell_height, 3);
    std::fill(sheet.data.begin(), sheet.data.end(), k_background);
    for (std::size_t i = 0; i < pngs.size(); ++i) {
        if (i > 0) image = io::read_image(pngs[i]);
        if (Size{image.width, image.height} != first)
            throw UsageError(
                fmt::format("{}: its size differs from that of {}", pngs[i].string(), pngs.front().string()));
        const int left = k_gap + static_cast<int>(i) % columns * (width + k_gap);
        const int top = k_gap + static_cast<int>(i) / columns * cell_height;
        paste_smaller(image, width, height, sheet, left, top);
        image::draw_text(sheet, labels[i], left, top + height + 2 * k_dot, width, k_dot, k_ink);
    }
    io::write_png(out, sheet);
}

}   // namespace gnomon
