// SPDX-License-Identifier: Apache-2.0
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>

#include "base/check.h"
#include "base/half.h"
#include "gnomon/error.h"
#include "gnomon/version.h"
#include "io/file/atomic_file.h"
#include "io/image/exr.h"
#include "io/image/exr_header.h"

namespace gnomon::io {

namespace {
constexpr int k_threads = 0;   // OpenEXR starts no threads of its own
constexpr float k_largest_half = 65504.0f;

struct Compression {
    Imf::Compression compression;
    std::size_t lines;   // of a chunk
};
constexpr Compression k_compressions[] = {
    // by ExrCompression
    {Imf::NO_COMPRESSION, 1},   {Imf::RLE_COMPRESSION, 1},  {Imf::ZIPS_COMPRESSION, 1},
    {Imf::ZIP_COMPRESSION, 16}, {Imf::PIZ_COMPRESSION, 32}, {Imf::PXR24_COMPRESSION, 16},
};

class MemoryOut : public Imf::OStream {
 public:
    MemoryOut() : Imf::OStream("image") {}
    void write(const char data[], int count) override
    {
        const auto size = static_cast<std::size_t>(count);
        if (at_ + size > bytes.size()) bytes.resize(at_ + size);
        std::memcpy(bytes.data() + at_, data, size);
        at_ += size;
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t position) override { at_ = static_cast<std::size_t>(position); }

    std::vector<char> bytes;

 private:
    std::size_t at_ = 0;
};

// Whether a layer is written with half precision. Depth and motion would shift by centimetres and pixels.
bool is_halved(const Layer& layer, ExrType type)
{
    return type == ExrType::half && layer.format == PixelFormat::f32 && layer.name != "depth" && layer.name != "motion";
}

// A copy of a layer with half precision. Values beyond its range become its largest ones.
std::vector<std::uint16_t> halved(const Layer& layer)
{
    const std::size_t count = layer.channels.size(), width = static_cast<std::size_t>(layer.size.width);
    std::vector<std::uint16_t> values(count * width * static_cast<std::size_t>(layer.size.height));
    std::size_t i = 0;
    for (int y = 0; y < layer.size.height; ++y) {
        const char* pixel = static_cast<const char*>(layer.data) + y * layer.row_stride;
        for (std::size_t x = 0; x < width; ++x, pixel += layer.pixel_stride)
            for (std::size_t c = 0; c < count; ++c) {
                float value;
                std::memcpy(&value, pixel + c * sizeof value, sizeof value);
                if (std::isfinite(value)) value = std::clamp(value, -k_largest_half, k_largest_half);
                values[i++] = half_from_float(value);
            }
    }
    return values;
}

// OpenEXR multiplies row vectors, so its matrices are transposed: stored by row, they are ours stored by column.
Imath::M44f matrix_of(const std::array<double, 16>& m)
{
    Imath::M44f matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = static_cast<float>(m[static_cast<std::size_t>(i)]);
    return matrix;
}

void add_metadata(Imf::Header& header, const ExrMetadata& metadata)
{
    Imf::addChromaticities(header, Imf::Chromaticities());   // those of Rec. 709
    if (metadata.fps > 0) {
        // A rate of television is a multiple of 1/1001; others are written as they are, up to a millionth.
        const double above = std::round(metadata.fps * 1001), whole = std::round(metadata.fps);
        const bool television = std::abs(metadata.fps * 1001 - above) < 1e-3 && std::abs(metadata.fps - whole) > 1e-6;
        const bool fits = metadata.fps < 1000;
        const int below = television ? 1001 : std::abs(metadata.fps - whole) <= 1e-6 || !fits ? 1 : 1'000'000;
        Imf::addFramesPerSecond(header,
                                Imf::Rational(static_cast<int>(std::lround(std::min(metadata.fps, 1e6) * below)),
                                              static_cast<unsigned>(below)));
    }
    if (metadata.world_to_camera) {
        // OpenEXR's camera looks along +Z.
        std::array<double, 16> m = *metadata.world_to_camera;
        for (std::size_t column = 0; column < 4; ++column) m[4 * column + 2] = -m[4 * column + 2];
        Imf::addWorldToCamera(header, matrix_of(m));
    }
    if (metadata.world_to_image) Imf::addWorldToNDC(header, matrix_of(*metadata.world_to_image));
    header.insert("gnomon.version", Imf::StringAttribute(std::string(version())));
    if (metadata.frame > 0) header.insert("gnomon.frame", Imf::IntAttribute(metadata.frame));
    header.insert("gnomon.time", Imf::DoubleAttribute(metadata.time));
    header.insert("gnomon.exposure", Imf::DoubleAttribute(metadata.exposure));
    if (!metadata.instruction_set.empty())
        header.insert("gnomon.instructionSet", Imf::StringAttribute(metadata.instruction_set));
}

void write_pixels(MemoryOut& memory, Size size, std::span<const Layer> layers, const ImageOptions& options,
                  const ExrMetadata& metadata)
{
    Imf::Header header(size.width, size.height);
    header.compression() = k_compressions[static_cast<std::size_t>(options.exr_compression)].compression;
    add_metadata(header, metadata);
    Imf::FrameBuffer frame;
    std::vector<std::vector<std::uint16_t>> halves;
    for (const Layer& layer : layers) {
        GNOMON_CHECK(layer.size == size && layer.data);
        GNOMON_CHECK(layer.format == PixelFormat::f32 || layer.format == PixelFormat::u32);
        GNOMON_CHECK(layer.pixel_stride > 0 && layer.row_stride > 0);
        const std::size_t count = layer.channels.size();
        // The library takes a pointer to writable memory, but does not write to it.
        char* base = const_cast<char*>(static_cast<const char*>(layer.data));
        Imf::PixelType type = layer.format == PixelFormat::u32 ? Imf::UINT : Imf::FLOAT;
        std::size_t value = sizeof(float), pixel = static_cast<std::size_t>(layer.pixel_stride),
                    row = static_cast<std::size_t>(layer.row_stride);
        if (is_halved(layer, options.exr_type)) {
            halves.push_back(halved(layer));
            base = reinterpret_cast<char*>(halves.back().data());
            type = Imf::HALF;
            value = sizeof(std::uint16_t), pixel = count * value, row = static_cast<std::size_t>(size.width) * pixel;
        }
        for (std::size_t c = 0; c < count; ++c) {
            const std::string name = exr_channel_name(layer.name, layer.channels[c]);
            header.channels().insert(name, Imf::Channel(type));
            frame.insert(name, Imf::Slice(type, base + c * value, pixel, row));
        }
    }
    Imf::OutputFile exr(memory, header, k_threads);
    exr.setFrameBuffer(frame);
    exr.writePixels(size.height);
}
}   // namespace

std::size_t room_in_exr(Size size, ExrCompression compression)
{
    // OpenEXR can write larger chunks, but cannot read them. It assumes that all chunks are complete.
    const std::size_t lines = k_compressions[static_cast<std::size_t>(compression)].lines;
    const std::size_t chunk = sizeof(float) * lines * static_cast<std::size_t>(size.width);
    return std::min<std::size_t>(k_max_exr_channels, std::numeric_limits<std::int32_t>::max() / chunk);
}

void write_exr(const std::filesystem::path& file, Size size, std::span<const Layer> layers, const ImageOptions& options,
               const ExrMetadata& metadata)
{
    GNOMON_CHECK(size.width > 0 && size.height > 0 && !layers.empty());
    std::size_t channels = 0;
    for (const Layer& layer : layers) channels += layer.channels.size();
    const std::size_t room = room_in_exr(size, options.exr_compression);
    if (channels > room)
        throw UsageError(fmt::format("{}: {} channels; an .exr of {} x {} pixels has room for {}", file.string(),
                                     channels, size.width, size.height, room));
    AtomicFile out(file);
    MemoryOut memory;
    try {
        write_pixels(memory, size, layers, options, metadata);
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        throw MissingError(fmt::format("cannot write {}: {}", file.string(), e.what()));
    }
    out.write(memory.bytes.data(), memory.bytes.size());
    out.commit();
}

}   // namespace gnomon::io
