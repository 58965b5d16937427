// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "base/math.h"
#include "io/gltf/schema.h"

namespace gnomon::io::gltf {

namespace {

using json = nlohmann::json;

constexpr const char* k_parts[] = {"translation", "rotation", "scale"};

json* member(json& object, const char* name)
{
    if (!object.is_object()) return nullptr;
    const auto found = object.find(name);
    return found == object.end() ? nullptr : &*found;
}

// The element of an array of the document that a property refers to; null if there is none.
json* referred(json& document, const char* array, json* index)
{
    json* const list = member(document, array);
    if (!list || !list->is_array() || !index || !index->is_number()) return nullptr;
    const double number = index->get<double>();
    if (!(number >= 0 && number < static_cast<double>(list->size()))) return nullptr;
    return &(*list)[static_cast<std::size_t>(number)];
}

template <class Visit>
void each(json& owner, const char* array, const std::string& pointer, Visit visit)
{
    json* const list = member(owner, array);
    if (!list || !list->is_array()) return;
    const std::string here = at(pointer, array);
    for (std::size_t i = 0; i < list->size(); ++i) visit((*list)[i], at(here, i));
}

// Whether remove_nulls() finds any.
bool has_nulls(const json& value)
{
    if (value.is_array()) return std::any_of(value.begin(), value.end(), [](const json& v) { return has_nulls(v); });
    if (!value.is_object()) return false;
    for (auto item = value.begin(); item != value.end(); ++item) {
        if (item->is_null()) return true;
        if (item->is_structured() && item.key() != "extras" && item.key() != "extensions" && has_nulls(*item))
            return true;
    }
    return false;
}

// Removes null properties. What applications and extensions keep for themselves stays. Its depth is that of the
// document, which the parser limits.
void remove_nulls(json& value, const std::string& pointer, Context& context)
{
    if (value.is_array())
        for (std::size_t i = 0; i < value.size(); ++i) {
            if (value[i].is_structured()) remove_nulls(value[i], at(pointer, i), context);
        }
    if (!value.is_object()) return;
    for (auto item = value.begin(); item != value.end();) {
        if (item->is_null()) {
            context.repair(Fault::null_value, at(pointer, item.key()), [] { return "is null"; });
            item = value.erase(item);
            continue;
        }
        if (item->is_structured() && item.key() != "extras" && item.key() != "extensions")
            remove_nulls(*item, at(pointer, item.key()), context);
        ++item;
    }
}

bool has_no_elements(json* accessor)
{
    json* const count = accessor ? member(*accessor, "count") : nullptr;
    return count && count->is_number() && count->get<double>() == 0;
}

// Leaves out primitives without vertices or triangles, and makes accessors without elements single zeros.
void repair_accessors(json& document, Context& context)
{
    const auto is_empty = [&](json& primitive) {
        if (has_no_elements(referred(document, "accessors", member(primitive, "indices")))) return true;
        json* const attributes = member(primitive, "attributes");
        if (!attributes || !attributes->is_object()) return false;
        for (json& attribute : *attributes)
            if (has_no_elements(referred(document, "accessors", &attribute))) return true;
        return false;
    };
    std::set<const json*> left_out;   // meshes of which nothing is left
    each(document, "meshes", "", [&](json& mesh, const std::string&) {
        json* const primitives = member(mesh, "primitives");
        if (!primitives || !primitives->is_array()) return;
        json kept = json::array();
        for (json& primitive : *primitives)
            if (!is_empty(primitive)) kept.push_back(primitive);
        if (kept.empty())
            left_out.insert(&mesh);   // it stays as it is, and no node shows it
        else if (kept.size() < primitives->size())
            *primitives = std::move(kept);
    });
    if (!left_out.empty())
        each(document, "nodes", "", [&](json& node, const std::string&) {
            if (left_out.contains(referred(document, "meshes", member(node, "mesh")))) {
                for (const char* const name : {"mesh", "skin", "weights"}) node.erase(name);
            }
        });
    each(document, "accessors", "", [&](json& accessor, const std::string& pointer) {
        if (!has_no_elements(&accessor)) return;
        context.repair(Fault::no_elements, pointer, [] { return "has no elements"; });
        for (const char* const name : {"bufferView", "byteOffset", "sparse", "min", "max"}) accessor.erase(name);
        accessor["count"] = 1;
        if (json* const type = member(accessor, "type"); type && *type == "VEC3")
            accessor["min"] = accessor["max"] = json::array({0, 0, 0});
        if (json* const type = member(accessor, "type"); type && *type == "SCALAR")
            accessor["min"] = accessor["max"] = json::array({0});
    });
}

// Replaces the matrix of a node by translation, rotation and scale, whose product it is up to shear.
void take_apart(json& node)
{
    const json& matrix = node["matrix"];
    std::array<double, 16> m{};
    if (!matrix.is_array() || matrix.size() != m.size()) return;
    for (std::size_t i = 0; i < m.size(); ++i) {
        if (!matrix[i].is_number()) return;
        m[i] = matrix[i].get<double>();
        if (!std::isfinite(m[i])) return;
    }
    glm::dmat3 axes;
    glm::dvec3 scale;
    for (int c = 0; c < 3; ++c) {
        const auto k = static_cast<std::size_t>(c) * 4;
        axes[c] = {m[k], m[k + 1], m[k + 2]};
        scale[c] = glm::length(axes[c]);
    }
    if (glm::determinant(axes) < 0) scale.x = -scale.x;
    glm::dquat turn(1, 0, 0, 0);
    if (scale.x != 0 && scale.y != 0 && scale.z != 0) {
        for (int c = 0; c < 3; ++c) axes[c] /= scale[c];
        turn = glm::normalize(glm::quat_cast(axes));
    }
    node.erase("matrix");
    node["translation"] = {m[12], m[13], m[14]};
    node["rotation"] = {turn.x, turn.y, turn.z, turn.w};
    node["scale"] = {scale.x, scale.y, scale.z};
}

void repair_nodes(json& document, Context& context)
{
    std::set<const json*> animated;
    each(document, "animations", "", [&](json& animation, const std::string&) {
        each(animation, "channels", "", [&](json& channel, const std::string&) {
            json* const target = member(channel, "target");
            json* const path = target ? member(*target, "path") : nullptr;
            if (!path || (*path != k_parts[0] && *path != k_parts[1] && *path != k_parts[2])) return;
            if (json* const node = referred(document, "nodes", member(*target, "node"))) animated.insert(node);
        });
    });
    each(document, "nodes", "", [&](json& node, const std::string& pointer) {
        if (!member(node, "matrix")) return;
        bool two = false;
        for (const char* const part : k_parts) two = two || node.contains(part);
        if (two) {
            context.repair(Fault::two_places, pointer, [] { return "has two placements"; });
            for (const char* const part : k_parts) node.erase(part);
        }
        if (!animated.contains(&node)) return;
        context.repair(Fault::animated_matrix, at(pointer, "matrix"), [] { return "is animated"; });
        take_apart(node);
    });
}

// Numbers of values per key of a channel; 0 if it is not known.
std::uint64_t values_of_a_key(json& document, json& target, json& sampler)
{
    json* const path = member(target, "path");
    if (!path || !path->is_string() || !member(target, "node")) return 0;
    json* const interpolation = member(sampler, "interpolation");
    const std::uint64_t each_value = interpolation && *interpolation == "CUBICSPLINE" ? 3 : 1;
    if (*path == k_parts[0] || *path == k_parts[1] || *path == k_parts[2]) return each_value;
    if (*path != "weights") return 0;
    json* const node = referred(document, "nodes", member(target, "node"));
    json* const mesh = node ? referred(document, "meshes", member(*node, "mesh")) : nullptr;
    json* const primitives = mesh ? member(*mesh, "primitives") : nullptr;
    if (!primitives || !primitives->is_array() || primitives->empty()) return 0;
    json* const targets = member(primitives->front(), "targets");
    return targets && targets->is_array() ? each_value * targets->size() : 0;
}

// Leaves out channels that do not have a value for each key.
void repair_channels(json& document, Context& context)
{
    const auto count_of = [&](json* accessor) {
        json* const count = accessor ? member(*accessor, "count") : nullptr;
        return count && count->is_number() ? count->get<double>() : -1;
    };
    std::set<const json*> emptied;
    each(document, "animations", "", [&](json& animation, const std::string& pointer) {
        json* const channels = member(animation, "channels");
        if (!channels || !channels->is_array()) return;
        json kept = json::array();
        for (std::size_t i = 0; i < channels->size(); ++i) {
            json& channel = (*channels)[i];
            json* const target = member(channel, "target");
            json* const sampler = referred(animation, "samplers", member(channel, "sampler"));
            const std::uint64_t of_a_key = target && sampler ? values_of_a_key(document, *target, *sampler) : 0;
            if (of_a_key > 0) {
                const double keys = count_of(referred(document, "accessors", member(*sampler, "input")));
                const double values = count_of(referred(document, "accessors", member(*sampler, "output")));
                if (keys >= 0 && values >= 0 && values != keys * static_cast<double>(of_a_key)) {
                    context.repair(Fault::key_values, at(at(pointer, "channels"), i),
                                   [] { return "has another number of values"; });
                    continue;
                }
            }
            kept.push_back(std::move(channel));
        }
        if (kept.empty() && !channels->empty()) emptied.insert(&animation);
        *channels = std::move(kept);
    });
    // An animation of which nothing is left goes, too.
    json* const animations = member(document, "animations");
    if (!animations || !animations->is_array() || animations->empty()) return;
    json kept = json::array();
    for (json& animation : *animations)
        if (!emptied.contains(&animation)) kept.push_back(std::move(animation));
    if (kept.empty())
        document.erase("animations");
    else
        *animations = std::move(kept);
}

void repair_lights(json& document, Context& context)
{
    json* const extensions = member(document, "extensions");
    json* const extension = extensions ? member(*extensions, "KHR_lights_punctual") : nullptr;
    if (!extension) return;
    each(*extension, "lights", "/extensions/KHR_lights_punctual", [&](json& light, const std::string& pointer) {
        json* const type = member(light, "type");
        if (!type || *type != "spot" || light.contains("spot")) return;
        context.repair(Fault::spot_without_cone, pointer, [] { return "has no cone"; });
        light["spot"] = json::object();
    });
}

// Says what a file of glTF 1.0 is, whose structure is another one.
void refuse_first_version(json& document, Context& context)
{
    json* const asset = member(document, "asset");
    json* const version = asset ? member(*asset, "version") : nullptr;
    const bool first = version && ((version->is_string() && version->get<std::string>().starts_with("1.")) ||
                                   (version->is_number() && version->get<double>() < 2));
    json* const nodes = member(document, "nodes");
    if (first || (!version && nodes && nodes->is_object()))
        context.fail("/asset/version", "glTF 1.0 is not supported; convert it, for example with 'gltf-pipeline'");
}

}   // namespace

void repair_document(json& document, Context& context)
{
    refuse_first_version(document, context);
    if (has_nulls(document)) remove_nulls(document, "", context);
    repair_accessors(document, context);
    repair_nodes(document, context);
    repair_channels(document, context);
    repair_lights(document, context);
}

}   // namespace gnomon::io::gltf
