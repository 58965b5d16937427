// SPDX-License-Identifier: Apache-2.0
#pragma once
// The bytes behind a document: buffers from the GLB, from data URIs and from files in the scene's folder, and the
// elements of accessors read out of them.
//
// A buffer without a URI (an extension may fill it), and one that lies in the network, has no bytes here. Accessors on
// it read as zeros in the first case, as those without a buffer view do, and cannot be used in the second.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/math.h"
#include "io/gltf/model.h"

namespace gnomon::io::gltf {

/// What a URI leads to.
struct Resource {
    enum class Kind : std::uint8_t { data, file, remote };
    Kind kind = Kind::file;
    std::string mime_type;             // of a data URI
    std::vector<std::uint8_t> bytes;   // of a data URI
    std::string path;                  // of a file, percent-decoded; relative
};
/// @throws InputError (at the pointer) for one that is no URI, a data URI that is not whole, or a bad escape
Resource parse_uri(const std::string& uri, const std::string& pointer, const Context& context);

class Data {
 public:
    /// Reads all buffers. Buffer views must have been checked against the buffers' lengths afterwards.
    /// @throws InputError
    Data(const Model& model, const std::filesystem::path& file, std::optional<std::span<const std::uint8_t>> bin,
         bool binary, Context& context);

    /// Bytes of all buffers together, a file that several of them name counted once: what expanded geometry is measured
    /// by.
    std::uint64_t total_bytes() const { return total_bytes_; }

    /// Whether every byte that the accessor reads is there; if not, it reads as zeros.
    bool has_bytes(const Accessor& accessor) const;
    /// Why its data can never be had, or empty.
    std::string unreachable(const Accessor& accessor) const;
    /// Bytes of a buffer view; empty if its buffer has none.
    std::span<const std::uint8_t> view_bytes(Index view) const;
    /// The file that a URI leads to, whatever its spelling. Empty for what is in the URI itself, or in the network.
    std::filesystem::path resource_file(const std::string& uri, const std::string& pointer) const;
    /// A file or data URI named by an image. Empty and a warning for a remote one.
    std::vector<std::uint8_t> resource_bytes(const std::string& uri, const std::string& pointer,
                                             std::string& mime_type);

    /// Calls visit(element, components) for each element in order; values as they are stored, sparse ones put in.
    /// Accessors and views must have passed check_model(); sparse indices are looked at again here.
    template <class Visit>
    void for_each(const Accessor& accessor, Visit visit) const;

    /// All elements, normalised integers as fractions: count * components numbers.
    void read(const Accessor& accessor, std::vector<float>& out) const;
    void read_double(const Accessor& accessor, std::vector<double>& out) const;
    /// All numbers of an unsigned integer accessor.
    void read(const Accessor& accessor, std::vector<std::uint32_t>& out) const;

    std::vector<std::uint32_t> sparse_indices(const Accessor& accessor) const;

 private:
    struct Bytes {
        std::vector<std::uint8_t> owned;   // of a data URI
        std::span<const std::uint8_t> span;
        bool remote = false;
    };
    std::filesystem::path find_file(const std::string& path, const std::string& pointer) const;
    std::vector<std::uint8_t> read_file(const std::string& path, const std::string& pointer) const;

    const Model& model_;
    Context& context_;
    std::filesystem::path folder_;                                       // canonical; nothing outside is opened
    std::map<std::filesystem::path, std::vector<std::uint8_t>> files_;   // of buffers, each once
    std::vector<Bytes> buffers_;
    std::uint64_t total_bytes_ = 0;
};

/// A stored component as a number.
double component_value(const std::uint8_t* bytes, Component type);
/// The number a normalised integer stands for [glTF 2.0, 3.11].
double normalized_value(double stored, Component type);

template <class Visit>
void Data::for_each(const Accessor& accessor, Visit visit) const
{
    const int components = accessor.components();
    double element[16] = {};
    const bool zeros = accessor.view == k_absent || view_bytes(accessor.view).empty();
    const std::uint8_t* base = zeros ? nullptr : view_bytes(accessor.view).data() + accessor.offset;
    const std::uint64_t view_stride = zeros ? 0 : model_.views[accessor.view].stride;
    const std::uint64_t stride = view_stride ? view_stride : accessor.packed_stride();

    std::vector<std::uint32_t> overridden;
    const std::uint8_t* values = nullptr;
    if (accessor.sparse && has_bytes(accessor)) {
        overridden = sparse_indices(accessor);
        values = view_bytes(accessor.sparse->value_view).data() + accessor.sparse->value_offset;
    }
    std::size_t next = 0;
    for (std::uint64_t i = 0; i < accessor.count; ++i) {
        const std::uint8_t* from = zeros ? nullptr : base + i * stride;
        if (next < overridden.size() && overridden[next] == i) from = values + next++ * accessor.packed_stride();
        for (int c = 0; c < components; ++c)
            element[c] = from ? component_value(from + accessor.component_offset(c), accessor.component) : 0.0;
        visit(i, std::span<const double>(element, static_cast<std::size_t>(components)));
    }
}

}   // namespace gnomon::io::gltf
