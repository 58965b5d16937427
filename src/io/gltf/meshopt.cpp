// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/meshopt.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include "base/interruption.h"

namespace gnomon::io::gltf {

namespace {

using Compression = Compression;

// The reason why a view's numbers break the rules of its mode and filter, or empty [EXT_meshopt_compression].
std::string fault_of(const Compression& c)
{
    if (c.mode == "ATTRIBUTES") {
        if (c.stride % 4 != 0) return fmt::format("a stride of {} bytes is not a multiple of 4", c.stride);
        if (c.filter == "OCTAHEDRAL" && c.stride != 4 && c.stride != 8)
            return "the filter 'OCTAHEDRAL' needs a stride of 4 or 8 bytes";
        if (c.filter == "QUATERNION" && c.stride != 8) return "the filter 'QUATERNION' needs a stride of 8 bytes";
        const bool known =
            c.filter == "NONE" || c.filter == "OCTAHEDRAL" || c.filter == "QUATERNION" || c.filter == "EXPONENTIAL";
        return known ? "" : fmt::format("the filter '{}' is not known", c.filter.substr(0, 40));
    }
    if (c.mode != "TRIANGLES" && c.mode != "INDICES")
        return fmt::format("the mode '{}' is not known", c.mode.substr(0, 40));
    if (c.filter != "NONE") return "indices cannot have a filter";
    if (c.stride != 2 && c.stride != 4) return fmt::format("indices cannot have {} bytes", c.stride);
    if (c.mode == "TRIANGLES" && c.count % 3 != 0) return fmt::format("{} indices are not whole triangles", c.count);
    return {};
}

bool decode(const Compression& c, std::span<const std::uint8_t> from, std::vector<std::uint8_t>& to)
{
    if (c.mode == "TRIANGLES")
        return meshopt_decodeIndexBuffer(to.data(), c.count, c.stride, from.data(), from.size()) == 0;
    if (c.mode == "INDICES")
        return meshopt_decodeIndexSequence(to.data(), c.count, c.stride, from.data(), from.size()) == 0;
    if (meshopt_decodeVertexBuffer(to.data(), c.count, c.stride, from.data(), from.size()) != 0) return false;
    if (c.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(to.data(), c.count, c.stride);
    if (c.filter == "QUATERNION") meshopt_decodeFilterQuat(to.data(), c.count, c.stride);
    if (c.filter == "EXPONENTIAL") meshopt_decodeFilterExp(to.data(), c.count, c.stride);
    return true;
}

}   // namespace

void decode_meshopt(Model& model, Data& data, Context& context)
{
    std::uint64_t bytes_left =
        context.limits.geometry_bytes + context.limits.geometry_bytes_per_byte * data.total_bytes();
    for (Index i = 0; i < model.views.size(); ++i) {
        if (!model.views[i].compression || !data.view_bytes(i).empty()) continue;
        const Compression c = *model.views[i].compression;
        const std::string place = at(at(at("/bufferViews", i), "extensions"), "EXT_meshopt_compression");
        if (const std::string fault = fault_of(c); !fault.empty()) context.fail(place, fault);
        const std::uint64_t buffer_length = model.buffers[c.buffer].length;
        if (c.offset > buffer_length || c.length > buffer_length - c.offset)
            context.fail(place, fmt::format("bytes {} to {} are not in buffer {}, which has {}", c.offset,
                                            c.offset + c.length, c.buffer, buffer_length));
        if (c.count > bytes_left / c.stride) context.fail(place, "is far larger than the size of the file allows");
        const std::uint64_t size = c.count * c.stride;
        bytes_left -= size;
        if (size != model.views[i].length)
            context.fail(place,
                         fmt::format("is decoded to {} bytes, the buffer view has {}", size, model.views[i].length));
        const std::span<const std::uint8_t> from = data.buffer_bytes(c.buffer);
        if (from.empty()) continue;   // remote: accessors in this view cannot be read
        interruption_point();
        std::vector<std::uint8_t> to(size);
        if (!decode(c, from.subspan(c.offset, c.length), to)) context.fail(place, "cannot be decoded");
        model.views[i].buffer = data.add_buffer(std::move(to));
        model.views[i].offset = 0;
    }
}

}   // namespace gnomon::io::gltf
