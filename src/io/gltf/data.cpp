// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "gnomon/error.h"
#include "io/file/read_file.h"
#include "io/file/scene_folder.h"

namespace gnomon::io::gltf {

namespace {

template <class T>
double load(const std::uint8_t* bytes)
{
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return static_cast<double>(value);
}

constexpr std::uint64_t k_glb_padding = 3;   // a binary chunk ends on a multiple of four

constexpr const char* k_no_file_uri = "file URIs are not allowed: use a path relative to the scene's folder";

// Whether a path leads out of the folder that it is relative to.
bool leads_out(const std::string& path)
{
    const std::filesystem::path normal = std::filesystem::path(path).lexically_normal();
    return normal.empty() || normal.is_absolute() || *normal.begin() == "..";
}

// Why a resource is not loaded that lies neither in the file nor in its folder; null: it may.
const char* why_elsewhere(const Resource& resource)
{
    switch (resource.kind) {
        case Resource::Kind::remote:
            return "is a remote resource; only files in the scene's folder and data URIs are loaded";
        case Resource::Kind::drive:
            return "is an absolute path; only files in the scene's folder and data URIs are loaded";
        default:
            return nullptr;
    }
}

}   // namespace

double component_value(const std::uint8_t* bytes, Component type)
{
    switch (type) {
        case Component::i8:
            return load<std::int8_t>(bytes);
        case Component::u8:
            return load<std::uint8_t>(bytes);
        case Component::i16:
            return load<std::int16_t>(bytes);
        case Component::u16:
            return load<std::uint16_t>(bytes);
        case Component::u32:
            return load<std::uint32_t>(bytes);
        case Component::f32:
            return load<float>(bytes);
        default:
            return 0;
    }
}

double normalized_value(double stored, Component type)
{
    switch (type) {
        case Component::i8:
            return std::max(stored / 127.0, -1.0);
        case Component::u8:
            return stored / 255.0;
        case Component::i16:
            return std::max(stored / 32767.0, -1.0);
        case Component::u16:
            return stored / 65535.0;
        default:
            return stored;
    }
}

Data::Data(const Model& model, const std::filesystem::path& file, std::optional<std::span<const std::uint8_t>> bin,
           bool binary, Context& context)
    : model_(model), context_(context)
{
    std::error_code error;
    folder_ = std::filesystem::canonical(file.has_parent_path() ? file.parent_path() : ".", error);
    buffers_.resize(model.buffers.size());
    for (std::size_t i = 0; i < model.buffers.size(); ++i) {
        const Buffer& buffer = model.buffers[i];
        Bytes& bytes = buffers_[i];
        const std::string here = at("/buffers", i);
        const std::string uri_place = at(here, "uri");
        bool counted = true;
        if (!buffer.uri) {
            if (i != 0 || !binary) continue;   // a placeholder
            if (!bin) context.fail(here, "refers to the GLB's binary chunk, but there is none");
            bytes.span = *bin;
            if (bytes.span.size() > buffer.length + k_glb_padding)
                context.warn(here, "the GLB's binary chunk is longer than the buffer");
        } else {
            Resource resource = parse_uri(*buffer.uri, uri_place, context);
            if (resource.kind == Resource::Kind::file_uri) context.fail(uri_place, k_no_file_uri);
            if (const char* const why = why_elsewhere(resource)) {
                context.warn(uri_place, why);
                bytes.remote = true;
                continue;
            }
            if (resource.kind == Resource::Kind::data) {
                if (resource.mime_type != "application/octet-stream" && resource.mime_type != "application/gltf-buffer")
                    context.repair(Fault::buffer_type, uri_place,
                                   [&] { return fmt::format("a buffer cannot be of type '{}'", resource.mime_type); });
                bytes.owned = std::move(resource.bytes);
                bytes.span = bytes.owned;
            } else {
                const auto [file_bytes, fresh] = files_.try_emplace(find_file(resource.path, uri_place));
                if (fresh) file_bytes->second = read_file(resource.path, uri_place);
                bytes.span = file_bytes->second;
                counted = fresh;
            }
        }
        if (bytes.span.size() < buffer.length)
            context.fail(at(here, "byteLength"),
                         fmt::format("declares {} bytes, but there are only {}", buffer.length, bytes.span.size()));
        bytes.span = bytes.span.first(buffer.length);
        if (counted) total_bytes_ += buffer.length;
    }
    if (binary && bin && (model.buffers.empty() || model.buffers[0].uri))
        context.warn("", "no buffer uses the GLB's binary chunk");
}

std::string Data::meant(const std::string& path, const std::string& pointer) const
{
    std::error_code error;
    if (context_.strict() || path.find('\0') != std::string::npos) return path;
    const bool elsewhere = leads_out(path);
    if (!elsewhere && (std::filesystem::exists(folder_ / path, error) || error)) return path;
    // Of a path that leads out of the folder, only the file's name is looked for.
    const std::string name = elsewhere ? std::filesystem::path(path).filename().string() : path;
    const std::string likely = name == "." || name == ".." ? std::string() : name_like(folder_, name);
    if (likely.empty()) return path;
    if (renamed_.insert(path).second) context_.repair(Fault::file_name, pointer, [] { return std::string(); });
    return likely;
}

std::filesystem::path Data::find_file(const std::string& path, const std::string& pointer) const
{
    std::string problem;
    std::filesystem::path found = resolve_inside(folder_, meant(path, pointer), {folder_}, problem);
    if (found.empty()) context_.fail(pointer, fmt::format("'{}' {}", path.substr(0, 200), problem));
    return found;
}

Resource Data::image_resource(const std::string& uri, const std::string& pointer) const
{
    Resource resource = parse_uri(uri, pointer, context_);
    const bool absolute = resource.kind == Resource::Kind::drive || resource.kind == Resource::Kind::file_uri;
    if (resource.kind == Resource::Kind::file_uri && context_.strict()) context_.fail(pointer, k_no_file_uri);
    if (absolute && !context_.strict()) {
        resource.kind = Resource::Kind::file;
        std::string path(1, '/');
        path += resource.path;
        resource.path = std::move(path);
    }
    return resource;
}

std::filesystem::path Data::resource_file(const std::string& uri, const std::string& pointer, bool& missing) const
{
    const Resource resource = image_resource(uri, pointer);
    missing = false;
    if (resource.kind != Resource::Kind::file) return {};
    if (resource.path.find('\0') == std::string::npos) {
        const std::string path = meant(resource.path, pointer);
        std::error_code error;
        if (leads_out(path))
            missing = !context_.strict();   // nothing outside is opened
        else
            missing = std::filesystem::status(folder_ / path, error).type() == std::filesystem::file_type::not_found;
    }
    return missing ? std::filesystem::path() : find_file(resource.path, pointer);
}

std::vector<std::uint8_t> Data::read_file(const std::string& path, const std::string& pointer) const
{
    const std::filesystem::path found = find_file(path, pointer);
    const std::string shown = path.substr(0, 200);
    try {
        return read_whole_file(found, shown, context_.limits.file_bytes);
    } catch (const InputError& error) {
        context_.fail(pointer, fmt::format("'{}' {}", shown, error.problem()));
    }
}

std::optional<std::vector<std::uint8_t>> Data::resource_bytes(const std::string& uri, const std::string& pointer,
                                                              std::string& mime_type)
{
    Resource resource = image_resource(uri, pointer);
    if (const char* const why = why_elsewhere(resource)) {
        context_.warn(pointer, std::string(why) + "; its textures are left out");
        return std::nullopt;
    }
    if (resource.kind == Resource::Kind::data) {
        mime_type = resource.mime_type;
        return std::move(resource.bytes);
    }
    return read_file(resource.path, pointer);
}

Index Data::add_buffer(std::vector<std::uint8_t> bytes)
{
    Bytes& buffer = buffers_.emplace_back();
    buffer.owned = std::move(bytes);
    buffer.span = buffer.owned;
    return static_cast<Index>(buffers_.size() - 1);
}

std::span<const std::uint8_t> Data::view_bytes(Index view) const
{
    const BufferView& v = model_.views[view];
    const std::span<const std::uint8_t> all = buffers_[v.buffer].span;
    return all.empty() ? all : all.subspan(v.offset, v.length);
}

bool Data::has_bytes(const Accessor& accessor) const
{
    if (!accessor.known()) return false;
    const auto filled = [&](Index view) { return view != k_absent && !view_bytes(view).empty(); };
    if (accessor.view == k_absent && !accessor.sparse) return false;
    if (accessor.view != k_absent && !filled(accessor.view)) return false;
    return !accessor.sparse || (filled(accessor.sparse->index_view) && filled(accessor.sparse->value_view));
}

std::string Data::unreachable(const Accessor& accessor) const
{
    if (!accessor.known()) return "has an unknown type";
    std::vector<Index> views;
    if (accessor.view != k_absent) views.push_back(accessor.view);
    if (accessor.sparse) views.insert(views.end(), {accessor.sparse->index_view, accessor.sparse->value_view});
    for (const Index view : views) {
        if (buffers_[model_.views[view].buffer].remote)
            return fmt::format("lies in buffer {}, which is a remote resource", model_.views[view].buffer);
        if (const auto& compression = model_.views[view].compression;
            compression && view_bytes(view).empty() && buffers_[compression->buffer].remote)
            return fmt::format("is compressed in buffer {}, which is a remote resource", compression->buffer);
    }
    return {};
}

std::vector<std::uint32_t> Data::sparse_indices(const Accessor& accessor) const
{
    std::vector<std::uint32_t> indices;
    if (!accessor.sparse || !has_bytes(accessor)) return indices;
    const Sparse& sparse = *accessor.sparse;
    const std::uint8_t* from = view_bytes(sparse.index_view).data() + sparse.index_offset;
    const std::uint64_t size = sparse.index_type == Component::u8 ? 1 : sparse.index_type == Component::u16 ? 2 : 4;
    indices.reserve(sparse.count);
    for (std::uint64_t i = 0; i < sparse.count; ++i)
        indices.push_back(static_cast<std::uint32_t>(component_value(from + i * size, sparse.index_type)));
    return indices;
}

void Data::read(const Accessor& accessor, std::vector<float>& out) const
{
    out.clear();
    out.reserve(accessor.count * static_cast<std::uint64_t>(accessor.components()));
    for_each(accessor, [&](std::uint64_t, std::span<const double> element) {
        // What is not finite has been repaired (Fault::not_finite): it is zero.
        for (const double stored : element) {
            const double v = std::isfinite(stored) ? stored : 0;
            out.push_back(static_cast<float>(accessor.normalized ? normalized_value(v, accessor.component) : v));
        }
    });
}

void Data::read_double(const Accessor& accessor, std::vector<double>& out) const
{
    out.clear();
    out.reserve(accessor.count * static_cast<std::uint64_t>(accessor.components()));
    for_each(accessor, [&](std::uint64_t, std::span<const double> element) {
        for (const double v : element) out.push_back(accessor.normalized ? normalized_value(v, accessor.component) : v);
    });
}

void Data::read(const Accessor& accessor, std::vector<std::uint32_t>& out) const
{
    out.clear();
    out.reserve(accessor.count * static_cast<std::uint64_t>(accessor.components()));
    for_each(accessor, [&](std::uint64_t, std::span<const double> element) {
        for (const double v : element) out.push_back(static_cast<std::uint32_t>(v));
    });
}

}   // namespace gnomon::io::gltf
