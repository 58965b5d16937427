// SPDX-License-Identifier: Apache-2.0
#pragma once
// How images are written to files.

#include <cstdint>

namespace gnomon {

/// The type of an .exr's values. Ids are whole numbers in either case; with `half`, depth and motion stay `single`,
/// because half precision would shift them by pixels and centimetres.
enum class ExrType : std::uint8_t {
    half,    // 16 bits; light above 65,504 is cut there
    single   // 32 bits
};

/// The compression of an .exr. All are without loss but pxr24, which rounds 32-bit values to 24 bits.
enum class ExrCompression : std::uint8_t { none, rle, zips, zip, piz, pxr24 };

/// How Frame::write writes files.
struct ImageOptions {
    int quality = 90;   // of .jpg, 0 to 100
    ExrType exr_type = ExrType::single;
    ExrCompression exr_compression = ExrCompression::zip;
};

}   // namespace gnomon
