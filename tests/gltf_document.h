// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small glTF documents for tests: data in one buffer, and JSON around it.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "io/load.h"
#include "scene/scene.h"
#include "support.h"

namespace gnomon::test {

// Builds a document: all data goes into one buffer, with a view and an accessor for each piece.
class Document {
 public:
    template <class T>
    int accessor(const std::vector<T>& values, const char* type, int component, int components,
                 const std::string& more = "")
    {
        while (bytes_.size() % 4) bytes_ += '\0';
        const std::size_t begin = bytes_.size();
        bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        views_ += fmt::format("{}{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}}}", views_.empty() ? "" : ",",
                              begin, values.size() * sizeof(T));
        accessors_ += fmt::format("{}{{\"bufferView\":{},\"type\":\"{}\",\"componentType\":{},\"count\":{}{}}}",
                                  accessors_.empty() ? "" : ",", views_count_++, type, component,
                                  values.size() / static_cast<std::size_t>(components), more);
        return accessor_count_++;
    }
    /// An accessor with the given JSON.
    int raw_accessor(const std::string& json)
    {
        accessors_ += (accessors_.empty() ? "" : ",") + json;
        return accessor_count_++;
    }
    /// Adds properties to the last buffer view.
    void extend_last_view(const std::string& more) { views_.insert(views_.size() - 1, more); }
    int floats(const std::vector<float>& values, const char* type, int components, bool bounds = false)
    {
        std::string more;
        if (bounds) {
            std::string low, high;
            for (int c = 0; c < components; ++c) {
                float least = values[static_cast<std::size_t>(c)], most = least;
                for (std::size_t i = static_cast<std::size_t>(c); i < values.size();
                     i += static_cast<std::size_t>(components))
                    least = std::min(least, values[i]), most = std::max(most, values[i]);
                low += fmt::format("{}{}", c ? "," : "", least);
                high += fmt::format("{}{}", c ? "," : "", most);
            }
            more = fmt::format(",\"min\":[{}],\"max\":[{}]", low, high);
        }
        return accessor(values, type, 5126, components, more);
    }
    int positions(const std::vector<float>& values) { return floats(values, "VEC3", 3, true); }
    int times(const std::vector<float>& values) { return floats(values, "SCALAR", 1, true); }

    /// Writes a document with the given members beside buffers and accessors, and loads it.
    scene::Scene load(const std::string& rest, const std::string& extensions = "",
                      const io::ReadOptions& options = {}) const
    {
        std::ofstream(folder_ / "data.bin", std::ios::binary) << bytes_;
        std::string text = R"({"asset":{"version":"2.0"},)" + extensions;
        if (!bytes_.empty())
            text += fmt::format(
                "\"buffers\":[{{\"byteLength\":{},\"uri\":\"data.bin\"}}],\"bufferViews\":[{}],\"accessors\":[{}],",
                bytes_.size(), views_, accessors_);
        std::ofstream(folder_ / "a.gltf") << text + rest + "}";
        return io::load_gltf(folder_ / "a.gltf", {}, options);
    }
    test::ScratchFolder& folder() { return folder_; }

 private:
    test::ScratchFolder folder_;
    std::string bytes_, views_, accessors_;
    int views_count_ = 0, accessor_count_ = 0;
};

/// One node with one mesh of these primitives.
inline std::string one_mesh(const std::string& primitives, const std::string& more = "")
{
    return fmt::format(R"("meshes":[{{"primitives":[{}]{}}}],"nodes":[{{"mesh":0}}])", primitives, more);
}

}   // namespace gnomon::test
