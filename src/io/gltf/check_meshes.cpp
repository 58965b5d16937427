// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <map>
#include <string_view>

#include "io/gltf/check.h"

namespace gnomon::io::gltf {

namespace {

using Role = AccessorUse::Role;

struct Format {
    Shape shape;
    Component component;
    bool normalized = false;
};
using Formats = std::vector<Format>;

bool matches(const Accessor& accessor, const Formats& formats)
{
    return std::any_of(formats.begin(), formats.end(), [&](const Format& f) {
        return f.shape == accessor.shape && f.component == accessor.component && f.normalized == accessor.normalized;
    });
}

Formats formats(std::initializer_list<Shape> shapes, std::initializer_list<Format> components)
{
    Formats result;
    for (const Shape shape : shapes)
        for (Format f : components) f.shape = shape, result.push_back(f);
    return result;
}

constexpr Shape k_any = Shape::unknown;
constexpr Format k_float{k_any, Component::f32};
constexpr Format k_u8n{k_any, Component::u8, true}, k_u16n{k_any, Component::u16, true};
constexpr Format k_i8n{k_any, Component::i8, true}, k_i16n{k_any, Component::i16, true};
constexpr Format k_u8{k_any, Component::u8}, k_u16{k_any, Component::u16}, k_i8{k_any, Component::i8},
    k_i16{k_any, Component::i16};

// A parsed attribute name: "TEXCOORD_1" gives TEXCOORD and 1. The number is -1 if the name must have none.
struct Semantic {
    std::string base;
    int set = -1;
    bool valid = false;
};

Semantic parse_semantic(const std::string& name, bool morph)
{
    Semantic s;
    if (name == "POSITION" || name == "NORMAL" || name == "TANGENT") return {name, -1, true};
    const auto underscore = name.find('_');
    if (underscore == std::string::npos) return s;
    s.base = name.substr(0, underscore);
    const std::string digits = name.substr(underscore + 1);
    const bool known =
        s.base == "TEXCOORD" || s.base == "COLOR" || (!morph && (s.base == "JOINTS" || s.base == "WEIGHTS"));
    constexpr std::size_t most_digits = 4;
    if (!known || digits.empty() || digits.size() > most_digits || (digits.size() > 1 && digits[0] == '0')) return s;
    if (!std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; })) return s;
    s.set = std::stoi(digits);
    s.valid = true;
    return s;
}

// The accessor formats that a semantic may have [glTF 2.0, 3.7.2.1; KHR_mesh_quantization].
Formats allowed_formats(const std::string& base, bool morph, bool quantized)
{
    using enum Shape;
    if (base == "POSITION")
        return quantized ? morph ? formats({vec3}, {k_float, k_i8, k_i8n, k_i16, k_i16n})
                                 : formats({vec3}, {k_float, k_i8, k_i8n, k_u8, k_u8n, k_i16, k_i16n, k_u16, k_u16n})
                         : formats({vec3}, {k_float});
    if (base == "NORMAL" || (base == "TANGENT" && morph))
        return quantized ? formats({vec3}, {k_float, k_i8n, k_i16n}) : formats({vec3}, {k_float});
    if (base == "TANGENT") return quantized ? formats({vec4}, {k_float, k_i8n, k_i16n}) : formats({vec4}, {k_float});
    if (base == "TEXCOORD") {
        if (quantized && !morph)
            return formats({vec2}, {k_float, k_u8, k_u8n, k_u16, k_u16n, k_i8, k_i8n, k_i16, k_i16n});
        return morph ? formats({vec2}, {k_float, k_i8n, k_i16n, k_u8n, k_u16n})
                     : formats({vec2}, {k_float, k_u8n, k_u16n});
    }
    if (base == "COLOR")
        return morph ? formats({vec3, vec4}, {k_float, k_i8n, k_i16n, k_u8n, k_u16n})
                     : formats({vec3, vec4}, {k_float, k_u8n, k_u16n});
    if (base == "JOINTS") return formats({vec4}, {k_u8, k_u16});
    return formats({vec4}, {k_float, k_u8n, k_u16n});   // WEIGHTS
}

class Check {
 public:
    Check(const Model& model, Uses& uses, Context& context) : model_(model), uses_(uses), context_(context)
    {
        const auto& used = model.extensions_used;
        quantized_ = std::find(used.begin(), used.end(), "KHR_mesh_quantization") != used.end();
    }

    void primitive(const Primitive& p, const std::string& here,
                   const std::vector<std::vector<const TextureBinding*>>& bindings)
    {
        // Check attributes: names, formats, equal counts, sets without gaps.
        std::map<std::string, int> sets;
        std::uint64_t count = 0;
        const std::string attributes = at(here, "attributes");
        for (const auto& [name, index] : p.attributes) {
            const std::string place = at(attributes, name);
            const std::uint64_t have = attribute(name, index, false, place);
            if (have == 0) continue;
            if (count == 0) count = have;
            if (have != count) fail(place, fmt::format("has {} elements, another attribute has {}", have, count));
            const Semantic semantic = parse_semantic(name, false);
            if (semantic.set >= 0) sets[semantic.base] = std::max(sets[semantic.base], semantic.set + 1);
        }
        for (const auto& [base, total] : sets)
            for (int set = 0; set < total; ++set)
                if (!p.attributes.contains(fmt::format("{}_{}", base, set))) {
                    const auto problem = [&, name = base, number = set] {
                        return fmt::format("'{0}_{1}' is missing, though there are higher sets of {0}", name, number);
                    };
                    if (base == "JOINTS" || base == "WEIGHTS") fail(attributes, problem());
                    context_.repair(Fault::attribute_gap, attributes, problem);
                }
        if (sets["JOINTS"] != sets["WEIGHTS"])
            fail(attributes, fmt::format("{} sets of JOINTS, but {} of WEIGHTS", sets["JOINTS"], sets["WEIGHTS"]));
        if (!p.has("POSITION")) context_.warn(attributes, "no POSITION: not drawn");
        if (p.has("TANGENT") && !p.has("NORMAL")) context_.warn(at(attributes, "TANGENT"), "TANGENT without NORMAL");

        if (p.indices != k_absent) indices(p.indices, count, at(here, "indices"));
        targets(p, count, here);

        // Check that the primitive has the texture coordinates that the material's textures need.
        if (p.material == k_absent) return;
        for (const TextureBinding* binding : bindings[p.material])
            if (!p.attributes.contains(fmt::format("TEXCOORD_{}", binding->texcoord)))
                context_.repair(Fault::missing_texcoord, at(here, "material"), [&] {
                    return fmt::format("the texture {} requires 'TEXCOORD_{}'", binding->pointer, binding->texcoord);
                });
    }

 private:
    [[noreturn]] void fail(const std::string& pointer, const std::string& problem) const
    {
        context_.fail(pointer, problem);
    }

    // Returns the accessor's count, or 0 if it cannot be known.
    std::uint64_t attribute(const std::string& name, Index index, bool morph, const std::string& place)
    {
        const Accessor& accessor = model_.accessors[index];
        const bool own = !name.empty() && name[0] == '_';
        const Semantic semantic = own ? Semantic{name, -1, true} : parse_semantic(name, morph);
        if (!semantic.valid) {
            context_.repair(Fault::unknown_attribute, place, [] { return "is not an attribute of glTF"; });
            return 0;
        }
        AccessorUse& use = uses_.accessor(index, Role::vertex, place);
        if (accessor.view != k_absent) {
            const BufferView& view = model_.views[accessor.view];
            uses_.view(accessor.view, Uses::ViewRole::vertex, place);
            uses_.vertex_view(index, place);
            const std::uint64_t stride = view.stride ? view.stride : accessor.packed_stride();
            if (accessor.known() &&
                (accessor.offset % 4 != 0 || (view.offset + accessor.offset) % 4 != 0 || stride % 4 != 0))
                context_.repair(Fault::alignment, place,
                                [] { return "vertex data must be aligned to multiples of 4 bytes"; });
        }
        if (!accessor.known()) return 0;
        if (own) {
            if (accessor.component == Component::u32) fail(place, "attributes cannot have the type unsigned int");
            return accessor.count;
        }
        const auto format_problem = [&] { return fmt::format("cannot be {}", accessor.format()); };
        if (!matches(accessor, allowed_formats(semantic.base, morph, true))) fail(place, format_problem());
        if (!quantized_ && !matches(accessor, allowed_formats(semantic.base, morph, false)))
            context_.repair(Fault::extension_list, place, format_problem);   // of KHR_mesh_quantization
        if (semantic.base == "POSITION" && (accessor.min.empty() || accessor.max.empty()))
            context_.repair(Fault::bounds, place, [] { return "POSITION must declare min and max"; });
        if (semantic.base != "POSITION") use.not_position = true;
        if (semantic.base == "NORMAL" && !morph) use.unit = true;
        if (semantic.base == "TANGENT" && !morph) use.tangent = true;
        return accessor.count;
    }

    void indices(Index index, std::uint64_t vertices, const std::string& place)
    {
        const Accessor& accessor = model_.accessors[index];
        AccessorUse& use = uses_.accessor(index, Role::index, place);
        if (vertices > 0) use.vertices = use.vertices == 0 ? vertices : std::min(use.vertices, vertices);
        if (accessor.view != k_absent) {
            uses_.view(accessor.view, Uses::ViewRole::index, place);
            if (model_.views[accessor.view].stride != 0)
                context_.repair(Fault::stride, place, [] { return "the buffer view of indices cannot have a stride"; });
        }
        if (!accessor.known()) return;
        const bool fits = accessor.shape == Shape::scalar && !accessor.normalized &&
                          (accessor.component == Component::u8 || accessor.component == Component::u16 ||
                           accessor.component == Component::u32);
        if (!fits) fail(place, fmt::format("indices cannot be {}", accessor.format()));
    }

    void targets(const Primitive& p, std::uint64_t count, const std::string& here)
    {
        for (std::size_t t = 0; t < p.targets.size(); ++t) {
            const std::string place = at(at(here, "targets"), t);
            for (const auto& [name, index] : p.targets[t]) {
                const std::string target = at(place, name);
                const std::uint64_t have = attribute(name, index, true, target);
                if (!p.attributes.contains(name))
                    context_.repair(Fault::target_attribute, target,
                                    [] { return "the primitive itself has no such attribute"; });
                if (have != 0 && count != 0 && have != count)
                    fail(target, fmt::format("has {} elements, the primitive has {} vertices", have, count));
            }
        }
    }

    const Model& model_;
    Uses& uses_;
    Context& context_;
    bool quantized_ = false;
};

}   // namespace

Uses::Uses(const Model& model, Context& context)
    : model_(model),
      context_(context),
      accessors_(model.accessors.size()),
      views_(model.views.size(), ViewRole::none),
      view_accessor_(model.views.size(), k_absent)
{
    constexpr int array_buffer = 34962, element_array_buffer = 34963;
    for (std::size_t i = 0; i < model.views.size(); ++i) {
        if (model.views[i].target == array_buffer) views_[i] = ViewRole::vertex;
        if (model.views[i].target == element_array_buffer) views_[i] = ViewRole::index;
    }
    for (std::size_t i = 0; i < model.accessors.size(); ++i) {
        if (!model.accessors[i].sparse) continue;
        const std::string here = at(at("/accessors", i), "sparse");
        view(model.accessors[i].sparse->index_view, ViewRole::other, at(at(here, "indices"), "bufferView"));
        view(model.accessors[i].sparse->value_view, ViewRole::other, at(at(here, "values"), "bufferView"));
    }
}

AccessorUse& Uses::accessor(Index accessor, Role role, const std::string& pointer)
{
    AccessorUse& use = accessors_[accessor];
    if (use.role == Role::none) use.role = role, use.user = pointer;
    if (use.role != role)
        context_.fail(pointer, fmt::format("accessor {} already has another use: {}", accessor, use.user));
    return use;
}

void Uses::view(Index view, ViewRole role, const std::string& pointer)
{
    if (views_[view] == ViewRole::none) views_[view] = role;
    if (views_[view] != role)
        context_.repair(Fault::buffer_target, pointer, [&] {
            return fmt::format("buffer view {} is declared or used for another kind of data", view);
        });
}

void Uses::vertex_view(Index accessor, const std::string& pointer)
{
    const Index view = model_.accessors[accessor].view;
    if (model_.views[view].stride != 0) return;
    if (view_accessor_[view] == k_absent) view_accessor_[view] = accessor;
    if (view_accessor_[view] != accessor)
        context_.repair(Fault::stride, pointer, [&] {
            return fmt::format("buffer view {} must have a stride, since several accessors use it", view);
        });
}

void check_mesh(const Model& model, Index index, const std::vector<std::vector<const TextureBinding*>>& bindings,
                Uses& uses, Context& context)
{
    const Mesh& mesh = model.meshes[index];
    const std::string here = at("/meshes", index);
    Check check(model, uses, context);
    const std::size_t targets = mesh.targets();
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
        const std::string place = at(at(here, "primitives"), i);
        check.primitive(mesh.primitives[i], place, bindings);
        if (mesh.primitives[i].targets.size() != targets)
            context.fail(at(place, "targets"), fmt::format("has {} morph targets, the first primitive has {}",
                                                           mesh.primitives[i].targets.size(), targets));
    }
    if (mesh.weights && mesh.weights->size() != targets)
        context.repair(Fault::weight_count, at(here, "weights"), [&] {
            return fmt::format("has {} weights for {} morph targets", mesh.weights->size(), targets);
        });
}

}   // namespace gnomon::io::gltf
