// SPDX-License-Identifier: Apache-2.0
#include "io/image/exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <new>

#include "base/check.h"
#include "gnomon/error.h"
#include "io/image/exr_header.h"

namespace gnomon::io {

namespace {
constexpr int k_threads = 0;   // OpenEXR starts no threads of its own

class MemoryIn : public Imf::IStream {
 public:
    MemoryIn(std::span<const std::uint8_t> bytes, const std::string& name) : Imf::IStream(name.c_str()), bytes_(bytes)
    {
    }
    bool read(char to[], int count) override
    {
        const auto size = static_cast<std::size_t>(std::max(count, 0));
        if (size > bytes_.size() - at_) throw std::runtime_error("unexpected end of file");
        std::memcpy(to, bytes_.data() + at_, size);
        at_ += size;
        return at_ < bytes_.size();
    }
    std::uint64_t tellg() override { return at_; }
    void seekg(std::uint64_t position) override { at_ = std::min<std::uint64_t>(position, bytes_.size()); }

 private:
    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;
};

struct ChannelName {
    std::string layer, channel;
};

ChannelName split(const std::string& full)
{
    const std::size_t dot = full.rfind('.');
    if (dot == std::string::npos) return {"", full};
    return {full.substr(0, dot), full.substr(dot + 1)};
}

// Files sort channels by name; we use the order R G B A, and L2 before L10.
bool before(const std::string& a, const std::string& b)
{
    constexpr std::string_view colors = "RGBA";
    const auto rank = [&](const std::string& s) { return s.size() == 1 ? colors.find(s[0]) : std::string::npos; };
    if (rank(a) != rank(b)) return rank(a) < rank(b);
    return a.size() != b.size() ? a.size() < b.size() : a < b;
}

std::vector<ExrLayer> layers_of(const std::vector<std::string>& channels, const std::optional<std::string>& only)
{
    std::map<std::string, std::vector<std::string>> found;
    for (const std::string& full : channels) {
        const ChannelName name = split(full);
        if (!only || name.layer == *only) found[name.layer].push_back(name.channel);
    }
    // There is no such layer. Look for a single channel of that name.
    if (found.empty() && only && std::find(channels.begin(), channels.end(), *only) != channels.end()) {
        const ChannelName name = split(*only);
        found[name.layer].push_back(name.channel);
    }
    std::vector<ExrLayer> layers;
    for (auto& [layer, names] : found) {
        std::sort(names.begin(), names.end(), before);
        layers.push_back({layer, std::move(names), {}});
    }
    return layers;
}

// Returns a view of a layer, valid as long as the layer is.
Layer view_of(const ExrLayer& layer, Size size)
{
    const std::size_t channels = layer.channels.size();
    GNOMON_CHECK_EQ(layer.data.size(), channels * static_cast<std::size_t>(size.width) * size.height);
    Layer view;
    view.name = layer.name;
    view.channels = layer.channels;
    view.size = size;
    view.data = layer.data.data();
    view.pixel_stride = static_cast<std::ptrdiff_t>(channels * sizeof(float));
    view.row_stride = size.width * view.pixel_stride;
    return view;
}
}   // namespace

void write_exr(const std::filesystem::path& file, Size size, std::span<const ExrLayer> layers)
{
    std::vector<Layer> views;
    for (const ExrLayer& layer : layers) views.push_back(view_of(layer, size));
    write_exr(file, size, views);
}

ExrImage decode_exr(std::span<const std::uint8_t> bytes, const std::string& name,
                    const std::optional<std::string>& only, const FloatImageLimits& limits)
{
    const ExrHeader header = check_exr(bytes, name, limits);
    ExrImage image{header.size, layers_of(header.channels, only)};
    const std::size_t pixels =
        static_cast<std::size_t>(header.size.width) * static_cast<std::size_t>(header.size.height);

    // Allocate the requested layers.
    std::size_t values = 0;
    for (const ExrLayer& layer : image.layers) values += layer.channels.size() * pixels;
    if (values > limits.max_values) throw InputError(name, "", fmt::format("{} values are more than allowed", values));
    if (image.layers.empty()) return image;
    Imf::FrameBuffer frame;
    for (ExrLayer& layer : image.layers) {
        const std::size_t count = layer.channels.size();
        layer.data.assign(count * pixels, 0.0f);
        for (std::size_t c = 0; c < count; ++c) {
            const std::size_t step = count * sizeof(float);
            frame.insert(
                exr_channel_name(layer.name, layer.channels[c]),
                Imf::Slice::Make(Imf::FLOAT, layer.data.data() + c, {header.x, header.y}, header.size.width,
                                 header.size.height, step, step * static_cast<std::size_t>(header.size.width)));
        }
    }

    // Decode, and translate the library's exceptions.
    try {
        MemoryIn memory(bytes, name);
        Imf::InputFile exr(memory, k_threads);
        if (!exr.isComplete()) throw std::runtime_error("the file is not complete");
        exr.setFrameBuffer(frame);
        exr.readPixels(header.y, header.y + header.size.height - 1);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        std::string what = e.what();
        if (what.find("bad_alloc") != std::string::npos)
            throw std::bad_alloc();   // OpenEXR wraps it in its own exception type
        std::replace(what.begin(), what.end(), '\n', ' ');
        throw InputError(name, "", "OpenEXR: " + what);
    }
    return image;
}

bool is_whole_exr(const std::filesystem::path& file, Size size)
{
    // Accept any size that we can write, even if it exceeds the usual limits of reading.
    FloatImageLimits own;
    own.max_side = std::max(size.width, size.height);
    own.max_pixels = static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
    own.max_file_bytes = std::numeric_limits<std::uint64_t>::max();
    try {
        return check_exr(read_image_bytes(file, own), file.string(), own).size == size;
    } catch (const InputError&) {
        return false;
    }
}

std::vector<std::string> exr_layer_names(std::span<const std::uint8_t> bytes, const std::string& name)
{
    std::vector<std::string> names;
    for (const ExrLayer& layer : layers_of(check_exr(bytes, name, {}).channels, {})) names.push_back(layer.name);
    return names;
}

}   // namespace gnomon::io
