// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/text.h"

#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "gnomon/error.h"

namespace gnomon::io::gltf {

namespace {

constexpr std::uint32_t k_magic = 0x46546c67;        // "glTF"
constexpr std::uint32_t k_chunk_json = 0x4e4f534a;   // "JSON"
constexpr std::uint32_t k_chunk_bin = 0x004e4942;    // "BIN"
constexpr std::uint64_t k_header_bytes = 12, k_chunk_header_bytes = 8;

std::uint32_t u32_at(std::string_view bytes, std::uint64_t offset)
{
    std::uint32_t value = 0;
    for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<std::uint8_t>(bytes[offset + i]);
    return value;
}

// "line:column" of a byte of the text, both from 1; for a GLB the byte in the file.
std::string place_of(const Container& container, std::uint64_t offset)
{
    if (container.binary) return fmt::format("byte {}", container.json_begin + offset);
    std::uint64_t line = 1, column = 1;
    for (std::uint64_t i = 0; i < offset && i < container.json.size(); ++i) {
        ++column;
        if (container.json[i] == '\n') ++line, column = 1;
    }
    return fmt::format("{}:{}", line, column);
}

// Bounds the nesting depth and the number of values before parsing, in a walk over the text without recursion.
void check_nesting(const Container& container, const Context& context)
{
    const std::string_view text = container.json;
    int depth = 0;
    std::uint64_t values = 1;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string) {
            if (c == '\\')
                ++i;   // skip the escaped character
            else if (c == '"')
                in_string = false;
            continue;
        }
        if (c == '"') in_string = true;
        if (c == '{' || c == '[') ++depth, ++values;
        if (c == '}' || c == ']') --depth;
        if (c == ',') ++values;
        if (depth > context.limits.json_depth)
            throw InputError(context.file(), place_of(container, i),
                             fmt::format("JSON is nested deeper than {} levels", context.limits.json_depth));
        if (values > context.limits.json_values)
            throw InputError(context.file(), place_of(container, i),
                             fmt::format("JSON holds more than {} values", context.limits.json_values));
    }
}

}   // namespace

Container open_container(std::string_view bytes, bool named_glb, Context& context)
{
    const auto fail = [&](std::uint64_t offset, const std::string& problem) {
        throw InputError(context.file(), fmt::format("byte {}", offset), problem);
    };
    const bool has_magic = bytes.size() >= 4 && u32_at(bytes, 0) == k_magic;
    Container result;
    if (!has_magic && !named_glb) {
        result.json = bytes;
        // [glTF 2.0, 2.7]: UTF-8 without a byte order mark.
        if (bytes.substr(0, 3) == "\xef\xbb\xbf") {
            if (context.strict()) throw InputError(context.file(), "1:1", "JSON begins with a byte order mark");
            context.repair(Fault::byte_order_mark, "", [] { return ""; });
            result.json.remove_prefix(3);
        }
        return result;
    }

    // Check the header.
    result.binary = true;
    if (bytes.size() < k_header_bytes) fail(bytes.size(), "GLB ends inside its header");
    if (!has_magic) fail(0, "not a GLB: it does not begin with 'glTF'");
    if (const std::uint32_t version = u32_at(bytes, 4); version != 2)
        fail(4, fmt::format("GLB version {} is not supported, only 2", version));
    const std::uint64_t length = u32_at(bytes, 8);
    if (length < k_header_bytes + k_chunk_header_bytes) fail(8, fmt::format("GLB length {} is too small", length));
    if (length > bytes.size()) fail(8, fmt::format("GLB declares {} bytes, but the file has {}", length, bytes.size()));
    if (length < bytes.size()) context.warn("", "GLB is followed by data that does not belong to it");

    // Read chunk by chunk.
    std::uint64_t offset = k_header_bytes;
    for (int index = 0; offset < length; ++index) {
        if (length - offset < k_chunk_header_bytes) fail(offset, "GLB ends inside a chunk's header");
        const std::uint64_t size = u32_at(bytes, offset);
        const std::uint32_t type = u32_at(bytes, offset + 4);
        const std::uint64_t begin = offset + k_chunk_header_bytes;
        if (size % 4 != 0) fail(offset, fmt::format("chunk length {} is not a multiple of 4", size));
        if (size > length - begin)
            fail(offset, fmt::format("chunk of {} bytes does not fit the GLB's length {}", size, length));
        if (index == 0 && type != k_chunk_json)
            fail(offset + 4, fmt::format("the first chunk must be JSON, its type is {:#010x}", type));
        if (type == k_chunk_json) {
            if (index != 0) fail(offset + 4, "a second JSON chunk");
            if (size == 0) fail(offset, "the JSON chunk is empty");
            result.json = bytes.substr(begin, size);
            result.json_begin = begin;
        } else if (type == k_chunk_bin) {
            if (result.bin) fail(offset + 4, "a second binary chunk");
            if (index != 1) fail(offset + 4, "the binary chunk must be the second");
            result.bin.emplace(reinterpret_cast<const std::uint8_t*>(bytes.data()) + begin, size);
        } else {
            context.warn("", fmt::format("unknown GLB chunk type {:#010x}", type));
        }
        offset = begin + size;
    }
    return result;
}

nlohmann::json parse_json(const Container& container, const Context& context)
{
    const auto fail = [&](std::uint64_t offset, const std::string& problem) {
        throw InputError(context.file(), place_of(container, offset), problem);
    };
    if (container.json.size() > context.limits.json_bytes)
        fail(0, fmt::format("JSON of {} bytes is too large, the limit is {}", container.json.size(),
                            context.limits.json_bytes));
    if (container.json.substr(0, 3) == "\xef\xbb\xbf") fail(0, "JSON begins with a byte order mark");
    check_nesting(container, context);

    try {
        return nlohmann::json::parse(container.json.begin(), container.json.end());
    } catch (const nlohmann::json::parse_error& error) {
        fail(error.byte > 0 ? error.byte - 1 : 0, "invalid JSON");
    } catch (const nlohmann::json::exception&) {
        fail(0, "invalid JSON: a number is out of range");
    }
    return {};   // not reached
}

}   // namespace gnomon::io::gltf
