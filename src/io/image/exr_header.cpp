// SPDX-License-Identifier: Apache-2.0
#include "io/image/exr_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <string_view>

#include "gnomon/error.h"

namespace gnomon::io {

namespace {
constexpr std::uint8_t k_magic[4] = {0x76, 0x2f, 0x31, 0x01};
constexpr std::uint32_t k_version = 2;
constexpr std::uint32_t k_version_mask = 0xff, k_tiled = 0x200, k_long_names = 0x400, k_deep = 0x800,
                        k_multipart = 0x1000;
constexpr std::size_t k_longest_name = 255;
constexpr std::uint32_t k_max_tile_side = 2048;
constexpr std::int32_t k_farthest = 1 << 24;   // largest distance of a data window's corner from the origin

// Scan lines per chunk of each compression; 0: not supported (B44 and DWA are lossy, and their decoders are large).
struct Compression {
    const char* name;
    int lines;
};
constexpr Compression k_compressions[] = {{"none", 1},   {"RLE", 1}, {"ZIPS", 1}, {"ZIP", 16}, {"PIZ", 32},
                                          {"PXR24", 16}, {"B44", 0}, {"B44A", 0}, {"DWAA", 0}, {"DWAB", 0}};

// Reads little-endian fields from a range of bytes; every read is checked.
class Reader {
 public:
    Reader(std::span<const std::uint8_t> bytes, std::size_t base, const std::string& name)
        : bytes_(bytes), base_(base), name_(name)
    {
    }
    [[noreturn]] void fail(const std::string& what) const
    {
        throw InputError(name_, fmt::format("byte {}", base_ + at_), what);
    }
    std::size_t at() const { return at_; }
    std::size_t left() const { return bytes_.size() - at_; }
    std::span<const std::uint8_t> take(std::size_t count)
    {
        if (count > left()) fail(fmt::format("{} bytes expected, {} left", count, left()));
        at_ += count;
        return bytes_.subspan(at_ - count, count);
    }
    std::uint8_t byte() { return take(1)[0]; }
    std::uint32_t word()
    {
        const auto b = take(4);
        return b[0] | std::uint32_t{b[1]} << 8 | std::uint32_t{b[2]} << 16 | std::uint32_t{b[3]} << 24;
    }
    std::int32_t integer() { return static_cast<std::int32_t>(word()); }
    std::uint64_t word64()
    {
        const std::uint64_t low = word();
        return low | std::uint64_t{word()} << 32;
    }
    std::string text()
    {
        const auto rest = bytes_.subspan(at_, std::min(left(), k_longest_name + 1));
        const auto end = std::find(rest.begin(), rest.end(), std::uint8_t{0});
        if (end == rest.end()) fail("a name is not terminated");
        at_ += static_cast<std::size_t>(end - rest.begin()) + 1;
        return {rest.begin(), end};
    }

 private:
    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0, base_;
    const std::string& name_;
};

struct Attributes {
    bool tiled = false;
    std::optional<int> compression;
    std::uint32_t tile_width = 0, tile_height = 0;
    bool has_window = false, has_line_order = false, has_display_window = false;
};

void read_channels(Reader& value, const FloatImageLimits& limits, ExrHeader& header)
{
    while (true) {
        std::string channel = value.text();
        if (channel.empty()) break;
        const std::uint32_t type = value.word();
        if (channel.back() == '.') value.fail(fmt::format("channel '{}' has no name in its layer", channel));
        value.take(4);   // perceptual linearity, reserved
        if (type > 2) value.fail(fmt::format("channel '{}' has unknown type {}", channel, type));
        if (value.integer() != 1 || value.integer() != 1)
            value.fail(fmt::format("channel '{}' is subsampled; not supported", channel));
        if (!header.channels.empty() && !(header.channels.back() < channel))
            value.fail(fmt::format("channel '{}' is out of order or a duplicate", channel));
        header.channels.push_back(std::move(channel));
        if (header.channels.size() > static_cast<std::size_t>(limits.max_channels))
            value.fail(fmt::format("more than {} channels", limits.max_channels));
    }
    if (value.left() > 0) value.fail("bytes after the channel list");
}

// Data and display windows follow the same rules; only the data window is stored.
void read_window(Reader& value, const FloatImageLimits& limits, ExrHeader* header)
{
    const std::int64_t x0 = value.integer(), y0 = value.integer(), x1 = value.integer(), y1 = value.integer();
    const std::int64_t width = x1 - x0 + 1, height = y1 - y0 + 1;
    if (std::max({std::abs(x0), std::abs(y0), std::abs(x1), std::abs(y1)}) > k_farthest)
        value.fail("the window is too far from the origin");
    if (width < 1 || height < 1) value.fail("the window is empty");
    if (!header) return;
    if (width > limits.max_side || height > limits.max_side ||
        static_cast<std::uint64_t>(width * height) > limits.max_pixels)
        value.fail(fmt::format("{} x {} pixels are more than allowed", width, height));
    header->x = static_cast<int>(x0), header->y = static_cast<int>(y0);
    header->size = {static_cast<int>(width), static_cast<int>(height)};
}

// Checks the size of an attribute's value. OpenEXR reads values of known types with their proper length, whatever the
// file says, and would interpret the bytes that follow as another attribute.
void check_value_size(const std::string& attribute, const std::string& type, Reader value)
{
    struct Known {
        std::string_view type;
        std::size_t bytes;
    };
    static constexpr Known k_known[] = {{"box2f", 16},
                                        {"box2i", 16},
                                        {"chromaticities", 32},
                                        {"compression", 1},
                                        {"deepImageState", 1},
                                        {"double", 8},
                                        {"envmap", 1},
                                        {"float", 4},
                                        {"int", 4},
                                        {"keycode", 28},
                                        {"lineOrder", 1},
                                        {"m33d", 72},
                                        {"m33f", 36},
                                        {"m44d", 128},
                                        {"m44f", 64},
                                        {"rational", 8},
                                        {"tiledesc", 9},
                                        {"timecode", 8},
                                        {"v2d", 16},
                                        {"v2f", 8},
                                        {"v2i", 8},
                                        {"v3d", 24},
                                        {"v3f", 12},
                                        {"v3i", 12}};
    const auto wrong = [&] { value.fail(fmt::format("'{}' has a wrong size", attribute)); };
    for (const Known& known : k_known)
        if (type == known.type && value.left() != known.bytes) wrong();
    if (type == "chlist" && attribute != "channels")
        value.fail(fmt::format("'{}' is a second list of channels", attribute));
    if (type == "floatvector" && value.left() % 4 != 0) wrong();
    if (type == "stringvector")
        while (value.left() > 0) value.take(value.word());
    if (type == "preview") {
        const std::uint64_t width = value.word(), height = value.word();
        if (value.left() != 4 * width * height || width * height > value.left()) wrong();
    }
}

void read_attribute(const std::string& attribute, const std::string& type, Reader& value,
                    const FloatImageLimits& limits, ExrHeader& header, Attributes& found)
{
    check_value_size(attribute, type, value);
    const auto expect_type = [&](const char* expected, std::optional<std::size_t> size) {
        if (type != expected) value.fail(fmt::format("'{}' is of type '{}', not '{}'", attribute, type, expected));
        if (size && value.left() != *size) value.fail(fmt::format("'{}' has a wrong size", attribute));
    };
    const auto once = [&](bool seen) {
        if (seen) value.fail(fmt::format("'{}' is a duplicate", attribute));
    };
    if (attribute == "channels") {
        expect_type("chlist", {});
        once(!header.channels.empty());
        read_channels(value, limits, header);
    } else if (attribute == "compression") {
        expect_type("compression", 1);
        once(found.compression.has_value());
        found.compression = value.byte();
        if (*found.compression >= static_cast<int>(std::size(k_compressions)))
            value.fail(fmt::format("unknown compression {}", *found.compression));
        if (k_compressions[*found.compression].lines == 0)
            value.fail(
                fmt::format("{} compression is not supported; use ZIP", k_compressions[*found.compression].name));
    } else if (attribute == "dataWindow") {
        expect_type("box2i", 16);
        once(found.has_window);
        read_window(value, limits, &header);
        found.has_window = true;
    } else if (attribute == "displayWindow") {
        expect_type("box2i", 16);
        once(found.has_display_window);
        read_window(value, limits, nullptr);
        found.has_display_window = true;
    } else if (attribute == "lineOrder") {
        expect_type("lineOrder", 1);
        once(found.has_line_order);
        if (value.byte() > 2) value.fail("unknown line order");
        found.has_line_order = true;
    } else if (attribute == "tiles") {
        expect_type("tiledesc", 9);
        once(found.tile_width > 0);
        found.tile_width = value.word(), found.tile_height = value.word();
        if (found.tile_width < 1 || found.tile_height < 1 || found.tile_width > k_max_tile_side ||
            found.tile_height > k_max_tile_side)
            value.fail(fmt::format("tiles of {} x {} pixels", found.tile_width, found.tile_height));
        if (value.byte() != 0) value.fail("several levels of detail; not supported");
    } else if (attribute == "type") {
        // A single-part file may name its type, but only in accordance with the flags.
        const auto bytes = value.take(value.left());
        const std::string part(bytes.begin(), bytes.end());
        if (part != (found.tiled ? "tiledimage" : "scanlineimage")) value.fail(fmt::format("part type '{}'", part));
    }
}

// Checks that every chunk lies inside the file: its offset, its header, its data.
void check_chunks(Reader& file, std::span<const std::uint8_t> bytes, const ExrHeader& header, const Attributes& found)
{
    const auto parts = [](int whole, std::uint32_t part) {
        return (static_cast<std::uint64_t>(whole) + part - 1) / part;
    };
    const auto lines = static_cast<std::uint32_t>(k_compressions[*found.compression].lines);
    const std::uint64_t chunks =
        found.tiled ? parts(header.size.width, found.tile_width) * parts(header.size.height, found.tile_height)
                    : parts(header.size.height, lines);
    const std::size_t own_header = found.tiled ? 20 : 8;   // coordinates, then the size of the data
    if (chunks > file.left() / (8 + own_header)) file.fail(fmt::format("{} chunks cannot be in this file", chunks));
    const std::size_t table_end = file.at() + 8 * static_cast<std::size_t>(chunks);
    for (std::uint64_t i = 0; i < chunks; ++i) {
        const std::uint64_t offset = file.word64();
        if (offset < table_end || offset > bytes.size() || bytes.size() - offset < own_header)
            file.fail(fmt::format("chunk {} lies outside the file", i));
        const std::uint8_t* p = bytes.data() + offset + own_header - 4;
        const std::uint32_t size =
            p[0] | std::uint32_t{p[1]} << 8 | std::uint32_t{p[2]} << 16 | std::uint32_t{p[3]} << 24;
        if (size > bytes.size() - offset - own_header)
            file.fail(fmt::format("chunk {} declares {} bytes, more than are left", i, size));
    }
}
}   // namespace

bool is_exr(std::span<const std::uint8_t> bytes)
{
    return bytes.size() >= sizeof k_magic && std::memcmp(bytes.data(), k_magic, sizeof k_magic) == 0;
}

ExrHeader check_exr(std::span<const std::uint8_t> bytes, const std::string& name, const FloatImageLimits& limits)
{
    if (!is_exr(bytes)) throw InputError(name, "byte 0", "not an OpenEXR file");
    Reader file(bytes, 0, name);
    file.take(sizeof k_magic);
    ExrHeader header;
    Attributes found;

    // Version and flags.
    const std::uint32_t version = file.word();
    if ((version & k_version_mask) != k_version) file.fail(fmt::format("version {}", version & k_version_mask));
    if (version & (k_deep | k_multipart)) file.fail("deep or multi-part; only flat single images are supported");
    if (version & ~(k_version_mask | k_tiled | k_long_names)) file.fail("unknown flags");
    found.tiled = (version & k_tiled) != 0;

    // Read attributes until an empty name.
    while (true) {
        const std::string attribute = file.text();
        if (attribute.empty()) break;
        const std::string type = file.text();
        const std::uint32_t size = file.word();
        const std::size_t base = file.at();
        Reader value(file.take(size), base, name);
        read_attribute(attribute, type, value, limits, header, found);
    }
    if (header.channels.empty() || !found.compression || !found.has_window || !found.has_display_window ||
        !found.has_line_order)
        file.fail("the header lacks channels, compression, a window or the line order");
    if (found.tiled != (found.tile_width > 0)) file.fail("flags and tile description disagree");

    // Compare the decoded size with the file's.
    const std::uint64_t values =
        std::uint64_t{header.channels.size()} * static_cast<std::uint64_t>(header.size.width) * header.size.height;
    if (values / limits.max_values_per_byte > bytes.size())
        file.fail(fmt::format("{} values cannot be in {} bytes", values, bytes.size()));
    check_chunks(file, bytes, header, found);
    return header;
}

}   // namespace gnomon::io
