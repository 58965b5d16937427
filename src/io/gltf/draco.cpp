// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/draco.h"

#include <draco/compression/decode.h>
#include <fmt/format.h>

#include <cstring>
#include <map>
#include <set>

#include "base/interruption.h"

namespace gnomon::io::gltf {

namespace {

constexpr int k_triangles = 4;
constexpr std::uint64_t k_alignment = 4;   // of vertices in a buffer view

// What the header of a compressed mesh declares.
struct Sizes {
    std::uint64_t faces = 0, vertices = 0;   // vertices: those that are encoded, without copies along seams
};

// Reads the header of a mesh [Draco bitstream specification 2.2, sections 3.1, 4 and 5.1].
class Header {
 public:
    explicit Header(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    /// @return  none if it is not the header of a triangle mesh of bitstream 2.2
    std::optional<Sizes> read()
    {
        constexpr std::size_t k_header = 11;   // "DRACO", version, geometry, method, flags
        if (bytes_.size() < k_header || std::memcmp(bytes_.data(), "DRACO", 5) != 0) return {};
        const bool version_2_2 = bytes_[5] == 2 && bytes_[6] == 2, mesh = bytes_[7] == 1;
        if (!version_2_2 || !mesh) return {};
        const std::uint8_t method = bytes_[8];
        const bool has_metadata = (bytes_[10] & 0x80) != 0;
        if (has_metadata) return {};   // glTF has metadata of its own
        at_ = k_header;
        Sizes sizes;
        if (method == 0) {   // sequential
            sizes.faces = number(), sizes.vertices = number();
        } else {     // edge breaker
            ++at_;   // the kind of traversal
            sizes.vertices = number(), sizes.faces = number();
        }
        return complete_ ? std::optional(sizes) : std::nullopt;
    }

 private:
    std::uint64_t number()
    {
        std::uint64_t value = 0;
        for (int shift = 0; shift < 35; shift += 7) {
            if (at_ >= bytes_.size()) break;
            const std::uint8_t byte = bytes_[at_++];
            value |= static_cast<std::uint64_t>(byte & 0x7f) << shift;
            if (!(byte & 0x80)) return value;
        }
        complete_ = false;
        return 0;
    }

    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;
    bool complete_ = true;
};

class Decoding {
 public:
    Decoding(Model& model, Data& data, Context& context) : model_(model), data_(data), context_(context)
    {
        bytes_left_ = context.limits.geometry_bytes + context.limits.geometry_bytes_per_byte * data.total_bytes();
    }

    void primitive(Primitive& p, const std::string& here)
    {
        const std::string place = at(at(here, "extensions"), "KHR_draco_mesh_compression");
        if (has_fallback(p)) return;
        if (p.mode < k_triangles) context_.fail(place, "only triangles can be compressed");
        if (p.indices == k_absent) context_.fail(place, "a compressed primitive needs indices");
        const std::span<const std::uint8_t> bytes = data_.view_bytes(p.draco->view);
        const std::unique_ptr<draco::Mesh> mesh = decode(p, bytes, place);
        for (const auto& [name, id] : p.draco->attributes) {
            const auto found = p.attributes.find(name);
            if (found == p.attributes.end())
                context_.fail(at(at(place, "attributes"), name), "the primitive itself has no such attribute");
            attribute(*mesh, id, found->second, name, at(at(place, "attributes"), name));
        }
        indices(*mesh, p.indices, place);
        p.mode = k_triangles;   // strips are decoded to triangles
    }

 private:
    bool has_fallback(const Primitive& p) const
    {
        const auto there = [&](Index accessor) {
            return model_.accessors[accessor].view != k_absent && data_.has_bytes(model_.accessors[accessor]);
        };
        for (const auto& [name, id] : p.draco->attributes)
            if (const auto found = p.attributes.find(name); found == p.attributes.end() || !there(found->second))
                return false;
        return p.indices != k_absent && there(p.indices);
    }

    std::unique_ptr<draco::Mesh> decode(const Primitive& p, std::span<const std::uint8_t> bytes,
                                        const std::string& place)
    {
        const std::optional<Sizes> sizes = Header(bytes).read();
        if (!sizes) context_.fail(place, "is not a mesh of Draco's bitstream 2.2");
        const std::uint64_t corners = model_.accessors[p.indices].count;
        if (3 * sizes->faces != corners)
            context_.fail(place, fmt::format("has {} triangles for {} indices", sizes->faces, corners));
        std::uint64_t vertices = 0;
        for (const auto& [name, index] : p.attributes) vertices = std::max(vertices, model_.accessors[index].count);
        if (sizes->vertices > vertices)
            context_.fail(place, fmt::format("has {} vertices, the primitive {}", sizes->vertices, vertices));
        // Corner tables and decoded attributes take about so much.
        constexpr std::uint64_t k_bytes_per_corner = 32, k_bytes_per_vertex = 64;
        spend(corners * k_bytes_per_corner + vertices * k_bytes_per_vertex, place);

        interruption_point();
        draco::DecoderBuffer buffer;
        buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        draco::Decoder decoder;
        auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
        if (!decoded.ok())
            context_.fail(place, fmt::format("cannot be decoded: {}", decoded.status().error_msg_string()));
        std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
        if (mesh->num_faces() != sizes->faces) context_.fail(place, "is cut off");
        return mesh;
    }

    void attribute(const draco::Mesh& mesh, Index id, Index index, const std::string& name, const std::string& place)
    {
        Accessor& accessor = model_.accessors[index];
        if (!accessor.known() || accessor.sparse) context_.fail(place, "is of a kind that cannot be compressed");
        const draco::PointAttribute* const from = mesh.GetAttributeByUniqueId(id);
        if (!from) context_.fail(place, fmt::format("there is no compressed attribute {}", id));
        if (mesh.num_points() != accessor.count)
            context_.fail(place, fmt::format("has {} vertices, the accessor {}", mesh.num_points(), accessor.count));
        if (from->num_components() != accessor.components())
            context_.fail(place, fmt::format("has {} components, the accessor {}", from->num_components(),
                                             accessor.components()));
        if (!decoded_.insert(index).second) return;   // primitives that share an accessor have the same data
        const std::uint64_t stride = (accessor.element_bytes() + k_alignment - 1) / k_alignment * k_alignment;
        spend(accessor.count * stride, place);
        std::vector<std::uint8_t> bytes(accessor.count * stride);
        const bool copied = copy(*from, accessor, stride, bytes);
        if (!copied) context_.fail(place, "has values that the accessor's type cannot hold");
        if (accessor.component == Component::f32 && (name == "NORMAL" || name == "TANGENT"))
            make_unit(accessor, stride, bytes);
        refer_to(accessor, std::move(bytes), stride);
    }

    // Scales the first three numbers of each element to unit length: quantisation loses it.
    static void make_unit(const Accessor& accessor, std::uint64_t stride, std::vector<std::uint8_t>& bytes)
    {
        for (std::uint64_t i = 0; i < accessor.count; ++i) {
            glm::vec3 v;
            std::memcpy(&v, bytes.data() + i * stride, sizeof v);
            const float length = glm::length(v);
            v = length > 0 && std::isfinite(length) ? v / length : glm::vec3(0, 0, 1);
            std::memcpy(bytes.data() + i * stride, &v, sizeof v);
        }
    }

    static bool copy(const draco::PointAttribute& from, const Accessor& accessor, std::uint64_t stride,
                     std::vector<std::uint8_t>& bytes)
    {
        switch (accessor.component) {
            case Component::i8:
                return copy_as<std::int8_t>(from, accessor, stride, bytes);
            case Component::u8:
                return copy_as<std::uint8_t>(from, accessor, stride, bytes);
            case Component::i16:
                return copy_as<std::int16_t>(from, accessor, stride, bytes);
            case Component::u16:
                return copy_as<std::uint16_t>(from, accessor, stride, bytes);
            case Component::u32:
                return copy_as<std::uint32_t>(from, accessor, stride, bytes);
            case Component::f32:
                return copy_as<float>(from, accessor, stride, bytes);
            default:
                return false;
        }
    }

    template <class T>
    static bool copy_as(const draco::PointAttribute& from, const Accessor& accessor, std::uint64_t stride,
                        std::vector<std::uint8_t>& bytes)
    {
        T element[16] = {};
        const int components = accessor.components();
        for (std::uint64_t i = 0; i < accessor.count; ++i) {
            const draco::AttributeValueIndex value =
                from.mapped_index(draco::PointIndex(static_cast<std::uint32_t>(i)));
            if (value.value() >= from.size() ||
                !from.ConvertValue<T>(value, static_cast<std::int8_t>(components), element))
                return false;
            for (int c = 0; c < components; ++c)
                std::memcpy(bytes.data() + i * stride + accessor.component_offset(c), &element[c], sizeof(T));
        }
        return true;
    }

    void indices(const draco::Mesh& mesh, Index index, const std::string& place)
    {
        if (!decoded_.insert(index).second) return;
        Accessor& accessor = model_.accessors[index];
        spend(accessor.count * sizeof(std::uint32_t), place);
        std::vector<std::uint8_t> bytes(accessor.count * sizeof(std::uint32_t));
        for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
            const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(f));
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t vertex = face[k].value();
                std::memcpy(bytes.data() + (3 * std::size_t{f} + k) * sizeof vertex, &vertex, sizeof vertex);
            }
        }
        accessor.component = Component::u32;
        refer_to(accessor, std::move(bytes), 0);
    }

    void refer_to(Accessor& accessor, std::vector<std::uint8_t> bytes, std::uint64_t stride)
    {
        const std::uint64_t length = bytes.size();
        BufferView view;
        view.buffer = data_.add_buffer(std::move(bytes));
        view.length = length;
        view.stride = stride;
        accessor.view = static_cast<Index>(model_.views.size());
        accessor.offset = 0;
        accessor.min.clear(), accessor.max.clear();
        model_.views.push_back(view);
    }

    void spend(std::uint64_t bytes, const std::string& place)
    {
        if (bytes > bytes_left_) context_.fail(place, "is far larger than the size of the file allows");
        bytes_left_ -= bytes;
    }

    Model& model_;
    Data& data_;
    Context& context_;
    std::uint64_t bytes_left_ = 0;
    std::set<Index> decoded_;   // accessors
};

}   // namespace

void decode_draco(Model& model, Data& data, Context& context)
{
    Decoding decoding(model, data, context);
    for (std::size_t m = 0; m < model.meshes.size(); ++m)
        for (std::size_t i = 0; i < model.meshes[m].primitives.size(); ++i) {
            Primitive& p = model.meshes[m].primitives[i];
            if (p.draco) decoding.primitive(p, at(at(at("/meshes", m), "primitives"), i));
        }
}

}   // namespace gnomon::io::gltf
