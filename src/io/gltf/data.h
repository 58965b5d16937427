// SPDX-License-Identifier: Apache-2.0
#pragma once
// The binary data of a document: buffers from the GLB, data URIs and files in the scene's folder, and the elements of
// accessors in them.
//
// A buffer without a URI (an extension may fill it) and a remote buffer have no bytes here. Accessors on the former
// read as zeros, like those without a buffer view; accessors on the latter cannot be used.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/interruption.h"
#include "base/math.h"
#include "io/gltf/model.h"

namespace gnomon::io::gltf {

/// The resource that a URI refers to.
struct Resource {
    enum class Kind : std::uint8_t {
        data,
        file,
        remote,
        drive,      // an absolute path such as C:/a.png
        file_uri,   // file:///a.png
    };
    Kind kind = Kind::file;
    std::string mime_type;             // of a data URI
    std::vector<std::uint8_t> bytes;   // of a data URI
    std::string path;                  // of a file, percent-decoded; relative. Of drive and file_uri: the name alone
};
/// @throws InputError (at the pointer)  not a URI, or an incomplete data URI
Resource parse_uri(const std::string& uri, const std::string& pointer, Context& context);

class Data {
 public:
    /// Reads all buffers. The caller must check buffer views against the buffers' lengths before.
    /// @throws InputError
    Data(const Model& model, const std::filesystem::path& file, std::optional<std::span<const std::uint8_t>> bin,
         bool binary, Context& context);

    /// Bytes of all buffers together, counting a file that several of them use once: the basis of the limits on
    /// geometry.
    std::uint64_t total_bytes() const { return total_bytes_; }

    /// Whether all bytes of the accessor are available; if not, it reads as zeros.
    bool has_bytes(const Accessor& accessor) const;
    /// The reason why its data cannot be loaded, or empty.
    std::string unreachable(const Accessor& accessor) const;
    /// Bytes of a buffer; empty if there are none.
    std::span<const std::uint8_t> buffer_bytes(Index buffer) const { return buffers_[buffer].span; }
    /// Bytes of a buffer view; empty if its buffer has none.
    std::span<const std::uint8_t> view_bytes(Index view) const;
    /// The file that an image's URI refers to, independent of its spelling. Empty for data URIs and remote resources.
    /// @param missing  set if there is no such file in the folder or below; the result is then empty
    std::filesystem::path resource_file(const std::string& uri, const std::string& pointer, bool& missing) const;
    /// The contents of a file or data URI that an image uses. Nothing, with a warning, for a remote one.
    std::optional<std::vector<std::uint8_t>> resource_bytes(const std::string& uri, const std::string& pointer,
                                                            std::string& mime_type);

    /// Adds a buffer of decoded data, for buffer views that are added to the model.
    /// @return  its index, after those of the model
    Index add_buffer(std::vector<std::uint8_t> bytes);

    /// Calls visit(element, components) for each element in order, with values as stored and sparse values substituted.
    /// Accessors and views must have passed check_model(); sparse indices are checked again here.
    template <class Visit>
    void for_each(const Accessor& accessor, Visit visit) const;

    /// Reads all elements, with normalised integers as fractions: count * components numbers.
    void read(const Accessor& accessor, std::vector<float>& out) const;
    void read_double(const Accessor& accessor, std::vector<double>& out) const;
    /// Reads all numbers of an unsigned integer accessor.
    void read(const Accessor& accessor, std::vector<std::uint32_t>& out) const;

    std::vector<std::uint32_t> sparse_indices(const Accessor& accessor) const;

 private:
    struct Bytes {
        std::vector<std::uint8_t> owned;   // of a data URI
        std::span<const std::uint8_t> span;
        bool remote = false;
    };
    // What an image's URI refers to. Of an absolute path the name alone is taken, unless reading is strict.
    Resource image_resource(const std::string& uri, const std::string& pointer) const;
    // The name of a file that probably was meant, if there is none with this name.
    std::string meant(const std::string& path, const std::string& pointer) const;
    std::filesystem::path find_file(const std::string& path, const std::string& pointer) const;
    std::vector<std::uint8_t> read_file(const std::string& path, const std::string& pointer) const;

    const Model& model_;
    Context& context_;
    mutable std::set<std::string> renamed_;   // files that were found with another name, each counted once
    std::filesystem::path folder_;            // canonical; no file outside is opened
    std::map<std::filesystem::path, std::vector<std::uint8_t>> files_;   // files of buffers, each read once
    std::vector<Bytes> buffers_;
    std::uint64_t total_bytes_ = 0;
};

/// A stored component as a number.
double component_value(const std::uint8_t* bytes, Component type);
/// The value of a normalised integer [glTF 2.0, 3.11].
double normalized_value(double stored, Component type);

inline constexpr std::uint64_t k_elements_a_step = 1 << 16;   // between interruption points

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
        if (i % k_elements_a_step == 0) interruption_point();
        const std::uint8_t* from = zeros ? nullptr : base + i * stride;
        if (next < overridden.size() && overridden[next] == i) from = values + next++ * accessor.packed_stride();
        for (int c = 0; c < components; ++c)
            element[c] = from ? component_value(from + accessor.component_offset(c), accessor.component) : 0.0;
        visit(i, std::span<const double>(element, static_cast<std::size_t>(components)));
    }
}

}   // namespace gnomon::io::gltf
