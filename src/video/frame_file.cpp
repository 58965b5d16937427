// SPDX-License-Identifier: Apache-2.0
#include "video/frame_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "io/image/image_file.h"

namespace gnomon::video {

namespace {
// Fills the colours of pixels that nothing covers. From level to level, four pixels become one with the mean of those
// that have a colour; then those without one take it from the level above [Gortler et al. 1996, push and pull].
// Cost: 4/3 of the pixels, twice.
template <class T>
void fill_uncovered(Image<T>& image)
{
    struct Level {
        int width = 0, height = 0;
        std::vector<std::array<std::uint32_t, 3>> colors;
        std::vector<std::uint8_t> known;
        std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
    };
    const auto sized = [](int width, int height) {
        Level level{width, height, {}, {}};
        level.colors.resize(static_cast<std::size_t>(width) * height);
        level.known.resize(level.colors.size());
        return level;
    };
    std::vector<Level> levels{sized(image.width, image.height)};
    for (std::size_t i = 0; i < levels[0].colors.size(); ++i) {
        const T* p = image.data.data() + 4 * i;
        levels[0].known[i] = p[3] > 0;
        levels[0].colors[i] = {p[0], p[1], p[2]};
    }

    // Average what is known, up to a single pixel.
    while (levels.back().width > 1 || levels.back().height > 1) {
        const Level& fine = levels.back();
        Level coarse = sized((fine.width + 1) / 2, (fine.height + 1) / 2);
        for (int y = 0; y < coarse.height; ++y)
            for (int x = 0; x < coarse.width; ++x) {
                std::array<std::uint32_t, 3> sum{};
                std::uint32_t count = 0;
                for (int v = 2 * y; v < std::min(2 * y + 2, fine.height); ++v)
                    for (int u = 2 * x; u < std::min(2 * x + 2, fine.width); ++u) {
                        if (!fine.known[fine.at(u, v)]) continue;
                        ++count;
                        for (std::size_t c = 0; c < 3; ++c) sum[c] += fine.colors[fine.at(u, v)][c];
                    }
                coarse.known[coarse.at(x, y)] = count > 0;
                for (std::size_t c = 0; c < 3 && count > 0; ++c)
                    coarse.colors[coarse.at(x, y)][c] = (sum[c] + count / 2) / count;
            }
        levels.push_back(std::move(coarse));
    }

    // Hand the colours down to where none is known.
    for (std::size_t l = levels.size() - 1; l-- > 0;) {
        Level& fine = levels[l];
        const Level& coarse = levels[l + 1];
        for (int y = 0; y < fine.height; ++y)
            for (int x = 0; x < fine.width; ++x)
                if (!fine.known[fine.at(x, y)]) fine.colors[fine.at(x, y)] = coarse.colors[coarse.at(x / 2, y / 2)];
    }
    for (std::size_t i = 0; i < levels[0].colors.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) image.data[4 * i + c] = static_cast<T>(levels[0].colors[i][c]);
}
}   // namespace

void write_video_frame(const Frame& frame, const Delivery& delivery, const std::filesystem::path& file,
                       const std::string& stamp)
{
    const int channels = delivery.alpha ? 4 : 3;
    if (delivery.deep) {
        Image16 image(frame.size.width, frame.size.height, channels);
        image.data = delivery.alpha ? frame.to_srgb16_alpha() : frame.to_srgb16();
        if (delivery.alpha) fill_uncovered(image);
        for (std::uint16_t& value : image.data) value = ten_bits(value);
        io::write_png(file, image, stamp);
        return;
    }
    Image8 image(frame.size.width, frame.size.height, channels);
    image.data = delivery.alpha ? frame.to_srgb8_alpha() : frame.to_srgb8();
    if (delivery.alpha) fill_uncovered(image);
    io::write_png(file, image, stamp);
}

}   // namespace gnomon::video
