// SPDX-License-Identifier: Apache-2.0
#include "cli/serve/upload.h"

#include <cstring>

#include "gnomon/error.h"

namespace gnomon::cli {

namespace {

using Json = nlohmann::json;

constexpr int k_deepest = 64;                  // levels of JSON: comparing files is recursive
constexpr std::size_t k_glb_header = 12 + 8;   // of the file and of its first chunk

std::uint32_t word_at(const std::string& file, std::size_t at)
{
    std::uint32_t word;
    std::memcpy(&word, file.data() + at, sizeof word);
    return word;
}

Json parse(const char* begin, const char* end)
{
    const auto check = [](int depth, Json::parse_event_t, Json&) {
        if (depth > k_deepest) throw UsageError("the scene is nested too deeply");
        return true;
    };
    Json json = Json::parse(begin, end, check, false);
    if (!json.is_object()) throw UsageError("the scene is no glTF: not a JSON object");
    return json;
}

const Json* member(const Json& object, const char* name)
{
    if (!object.is_object()) return nullptr;
    const auto found = object.find(name);
    return found == object.end() ? nullptr : &*found;
}

// A list of numbers of a node; `fallback` if it has none or another.
template <std::size_t n>
std::array<double, n> numbers(const Json& node, const char* name, const std::array<double, n>& fallback)
{
    const Json* list = member(node, name);
    std::array<double, n> values = fallback;
    if (!list || !list->is_array() || list->size() != n) return values;
    for (std::size_t i = 0; i < n; ++i) {
        if (!(*list)[i].is_number()) return fallback;
        values[i] = (*list)[i].get<double>();
    }
    return values;
}

Transform local_of(const Json& node)
{
    if (member(node, "matrix")) return {numbers<16>(node, "matrix", Transform{}.m)};
    const auto t = numbers<3>(node, "translation", {0, 0, 0}), s = numbers<3>(node, "scale", {1, 1, 1});
    const auto [x, y, z, w] = numbers<4>(node, "rotation", {0, 0, 0, 1});
    return {{s[0] * (1 - 2 * (y * y + z * z)), s[0] * 2 * (x * y + z * w), s[0] * 2 * (x * z - y * w), 0,
             s[1] * 2 * (x * y - z * w), s[1] * (1 - 2 * (x * x + z * z)), s[1] * 2 * (y * z + x * w), 0,
             s[2] * 2 * (x * z + y * w), s[2] * 2 * (y * z - x * w), s[2] * (1 - 2 * (x * x + y * y)), 0, t[0], t[1],
             t[2], 1}};
}

// As Transform has it; the fuzzer links this file without the library.
Transform product(const Transform& outer, const Transform& inner)
{
    Transform result;
    for (std::size_t column = 0; column < 4; ++column)
        for (std::size_t row = 0; row < 4; ++row) {
            double sum = 0;
            for (std::size_t k = 0; k < 4; ++k) sum += outer.m[4 * k + row] * inner.m[4 * column + k];
            result.m[4 * column + row] = sum;
        }
    return result;
}

// The node with a camera to the world, through the nodes above it.
Transform camera_of(const Json& nodes)
{
    std::map<std::size_t, std::size_t> above;
    std::size_t camera = nodes.size();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (camera == nodes.size() && member(nodes[i], "camera")) camera = i;
        const Json* below = member(nodes[i], "children");
        if (!below || !below->is_array()) continue;
        for (const Json& child : *below)
            if (child.is_number_unsigned()) above.emplace(child.get<std::size_t>(), i);
    }
    if (camera == nodes.size()) throw UsageError("the scene has no camera");
    Transform to_world = local_of(nodes[camera]);
    std::size_t steps = 0;
    for (auto at = above.find(camera); at != above.end(); at = above.find(at->second)) {
        if (++steps > nodes.size()) throw UsageError("the scene's nodes form a cycle");
        to_world = product(local_of(nodes[at->second]), to_world);
    }
    return to_world;
}

}   // namespace

Upload read_upload(const std::string& file)
{
    Upload upload;
    upload.is_binary = file.size() >= k_glb_header && file.compare(0, 4, "glTF") == 0;
    if (upload.is_binary) {
        const std::size_t length = word_at(file, 12);
        if (length > file.size() - k_glb_header) throw UsageError("the scene is cut off");
        upload.rest = parse(file.data() + k_glb_header, file.data() + k_glb_header + length);
        upload.binary = file.substr(k_glb_header + length);
    } else {
        upload.rest = parse(file.data(), file.data() + file.size());
    }

    const Json* nodes = member(upload.rest, "nodes");
    if (!nodes || !nodes->is_array()) throw UsageError("the scene has no nodes");
    upload.camera_to_world = camera_of(*nodes);
    if (const Json* extensions = member(upload.rest, "extensions"))
        upload.has_lights = member(*extensions, "KHR_lights_punctual") != nullptr;
    for (Json& node : upload.rest["nodes"]) {
        upload.matrices.push_back(member(node, "matrix") ? local_of(node) : Transform{});
        // What is left says that there is a matrix, or that another way of placing the node is in use.
        if (member(node, "matrix")) node["matrix"] = nullptr;
        if (member(node, "camera"))
            for (const char* name : {"matrix", "translation", "rotation", "scale"}) node.erase(name);
    }
    upload.rest.erase("cameras");
    return upload;
}

}   // namespace gnomon::cli
