// SPDX-License-Identifier: Apache-2.0
#pragma once
// Radiance images in memory.

#include <cstdint>
#include <string>
#include <vector>

namespace gnomon::test {

inline std::vector<std::uint8_t> hdr_file(const std::string& resolution, const std::vector<std::uint8_t>& pixels,
                                          const std::string& variables = "FORMAT=32-bit_rle_rgbe\n")
{
    const std::string header = "#?RADIANCE\n" + variables + "\n" + resolution + "\n";
    std::vector<std::uint8_t> bytes(header.begin(), header.end());
    bytes.insert(bytes.end(), pixels.begin(), pixels.end());
    return bytes;
}

/// One row of equal pixels in the newer run-length encoding.
inline std::vector<std::uint8_t> even_row(int width, const std::uint8_t (&rgbe)[4])
{
    std::vector<std::uint8_t> row{2, 2, static_cast<std::uint8_t>(width >> 8), static_cast<std::uint8_t>(width & 255)};
    for (const std::uint8_t component : rgbe)
        for (int left = width; left > 0; left -= 127) {
            row.push_back(static_cast<std::uint8_t>(128 + (left < 127 ? left : 127)));
            row.push_back(component);
        }
    return row;
}

}   // namespace gnomon::test
