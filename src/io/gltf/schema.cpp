// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <unordered_map>
#include <unordered_set>

namespace gnomon::io::gltf {

namespace {

using json = nlohmann::json;

constexpr double k_exact_integers = 9007199254740992.0;   // 2^53: integers that JSON numbers represent exactly

const char* type_name(const json& value)
{
    if (value.is_object()) return "an object";
    if (value.is_array()) return "an array";
    if (value.is_string()) return "a string";
    if (value.is_boolean()) return "a boolean";
    if (value.is_null()) return "null";
    return "a number";
}

// A name or an index on the path to a value; converted to text only for messages.
struct Step {
    std::string_view name;
    std::uint64_t index = 0;
};

class Walk {
 public:
    Walk(json& document, Context& context) : document_(document), context_(context) {}

    std::vector<TextureBinding> run()
    {
        if (!document_.is_object())
            context_.fail("", fmt::format("expected an object, found {}", type_name(document_)));
        if (const auto used = document_.find("extensionsUsed"); used != document_.end() && used->is_array())
            for (const json& name : *used)
                if (name.is_string()) used_.insert(name.get<std::string>());
        check_object(document_, document_table());
        return std::move(bindings_);
    }

 private:
    std::string pointer() const
    {
        std::string result;
        for (const Step& step : path_) result = step.name.data() ? at(result, step.name) : at(result, step.index);
        return result;
    }
    [[noreturn]] void fail(const std::string& problem) const { context_.fail(pointer(), problem); }
    [[noreturn]] void wrong_type(const json& value, const char* expected) const
    {
        fail(fmt::format("expected {}, found {}", expected, type_name(value)));
    }

    template <class Body>
    void below(std::string_view name, Body body)
    {
        path_.push_back({name, 0});
        body();
        path_.pop_back();
    }
    template <class Body>
    void below(std::uint64_t index, Body body)
    {
        path_.push_back({{}, index});
        body();
        path_.pop_back();
    }

    void check_object(json& value, const Table& table)
    {
        if (!value.is_object()) wrong_type(value, "an object");
        for (const Rule& rule : table.rules) {
            const auto found = value.find(rule.name);
            if (found == value.end()) {
                if (rule.required) fail(fmt::format("'{}' is missing", rule.name));
                continue;
            }
            bool absent = false;
            below(rule.name, [&] {
                if (repaired_as_absent(*found, rule)) {
                    absent = true;
                    return;
                }
                if (rule.needs && !value.contains(rule.needs)) fail(fmt::format("requires '{}'", rule.needs));
                check_value(*found, rule);
            });
            if (absent) value.erase(found);
        }
        check_names(value, table);
        if (const auto extensions = value.find("extensions"); extensions != value.end())
            below("extensions", [&] { check_extensions(*extensions, table); });
        note_texture(value, table);
    }

    // Whether the property is one of those faults that are repaired by leaving it out. Where an empty array stands for
    // a required one, only those that mean "nothing to do" are taken (an animation without channels).
    bool repaired_as_absent(const json& value, const Rule& rule)
    {
        if (value.is_array() && value.empty() && (!rule.required || rule.may_be_empty)) {
            context_.repair(Fault::empty_array, pointer(), [] { return "must not be empty"; });
            return true;
        }
        if (rule.number_as_default && value.is_number()) {
            context_.repair(Fault::interpolation_type, pointer(), [] { return "expected a string, found a number"; });
            return true;
        }
        if (rule.zero_as_absent && value.is_number() && value.get<double>() == 0) {
            context_.repair(Fault::stride, pointer(), [] { return "0 is out of range"; });
            return true;
        }
        // A number that must be greater than a bound has no nearest value to which it could be clamped.
        if (rule.kind == Kind::number && rule.above_low && !rule.required && value.is_number() &&
            value.get<double>() <= rule.low && std::isfinite(value.get<double>())) {
            context_.repair(Fault::factor_range, pointer(),
                            [&] { return fmt::format("{} is out of range", value.get<double>()); });
            return true;
        }
        return false;
    }

    // Names that are in no table are harmless, but may be misspelt.
    void check_names(const json& value, const Table& table)
    {
        for (auto item = value.begin(); item != value.end(); ++item) {
            const std::string& name = item.key();
            if (name == "extensions" || name == "extras") continue;
            if (std::any_of(table.rules.begin(), table.rules.end(),
                            [&](const Rule& rule) { return name == rule.name; }))
                continue;
            // The tables of some extensions are incomplete.
            const std::string_view owner = path_.size() > 1 ? path_[path_.size() - 2].name : std::string_view();
            if (owner != "extensions") context_.warn(at(pointer(), name), "unknown property");
        }
    }

    void check_extensions(json& value, const Table& owner)
    {
        if (!value.is_object()) wrong_type(value, "an object");
        const auto places = extension_places();
        for (auto item = value.begin(); item != value.end();) {
            bool misplaced = false;
            below(item.key(), [&] {
                if (!used_.contains(item.key()))
                    context_.repair(Fault::extension_list, pointer(),
                                    [] { return "the extension is not declared in 'extensionsUsed'"; });
                const auto names = [&](const ExtensionPlace& place) { return item.key() == place.extension; };
                if (std::none_of(places.begin(), places.end(), names)) return;   // unknown to us
                const auto place = std::find_if(places.begin(), places.end(),
                                                [&](const ExtensionPlace& p) { return names(p) && p.owner == &owner; });
                if (place == places.end()) {
                    misplaced = true;
                    context_.repair(Fault::extension_place, pointer(),
                                    [&] { return fmt::format("the extension is not allowed in a {}", owner.name); });
                    return;
                }
                check_object(item.value(), *place->inner);
                if (item.key() == "KHR_materials_ior" && item->contains("ior")) {
                    const double ior = item->at("ior").get<double>();
                    if (ior != 0 && ior < 1)
                        below("ior", [&] { fail(fmt::format("{} is neither 0 nor at least 1", ior)); });
                }
            });
            item = misplaced ? value.erase(item) : std::next(item);
        }
    }

    // Records the set of texture coordinates that a material's texture needs.
    void note_texture(const json& value, const Table& table)
    {
        if (path_.empty() || path_.front().name != "materials" || path_.size() < 2) return;
        const bool is_texture = std::any_of(table.rules.begin(), table.rules.end(), [](const Rule& rule) {
            return rule.kind == Kind::index && rule.target && std::strcmp(rule.target, "/textures") == 0;
        });
        if (!is_texture) return;
        const json* set = value.contains("texCoord") ? &value["texCoord"] : nullptr;
        std::string place = pointer();
        if (const auto extensions = value.find("extensions"); extensions != value.end())
            if (const auto moved = extensions->find("KHR_texture_transform");
                moved != extensions->end() && moved->contains("texCoord"))
                set = &(*moved)["texCoord"];
        bindings_.push_back(
            {std::move(place), path_[1].index, set ? static_cast<std::uint64_t>(set->get<double>()) : 0});
    }

    void check_value(json& value, const Rule& rule)
    {
        switch (rule.kind) {
            case Kind::boolean:
                if (!value.is_boolean()) wrong_type(value, "a boolean");
                break;
            case Kind::integer:
                check_integer(value, rule);
                break;
            case Kind::number:
                check_number(value, rule);
                break;
            case Kind::string:
                if (!value.is_string()) wrong_type(value, "a string");
                break;
            case Kind::version:
                check_version(value);
                break;
            case Kind::code: {
                check_integer(value, {.name = rule.name, .kind = Kind::integer, .low = 0});
                if (std::find(rule.codes.begin(), rule.codes.end(), value.get<double>()) == rule.codes.end())
                    context_.warn(pointer(), fmt::format("{} is not a known value", value.get<double>()));
                break;
            }
            case Kind::word: {
                if (!value.is_string()) wrong_type(value, "a string");
                const std::string& word = value.get_ref<const std::string&>();
                if (std::find(rule.words.begin(), rule.words.end(), word) == rule.words.end())
                    context_.warn(pointer(), fmt::format("'{}' is not a known value", word.substr(0, 64)));
                break;
            }
            case Kind::index:
                check_index(value, rule);
                break;
            case Kind::object:
                check_object(value, *rule.inner);
                break;
            case Kind::attributes:
                check_attributes(value, rule);
                break;
            default:
                check_array(value, rule);
        }
    }

    void check_array(json& value, const Rule& rule)
    {
        // Check the length.
        if (!value.is_array()) wrong_type(value, "an array");
        if (value.empty()) fail("must not be empty");
        if (rule.kind == Kind::objects && value.size() > context_.limits.elements)
            fail(fmt::format("has {} elements, the limit is {}", value.size(), context_.limits.elements));
        if (value.size() < rule.min_items || value.size() > rule.max_items) {
            if (rule.min_items == rule.max_items)
                fail(fmt::format("expected {} elements, found {}", rule.min_items, value.size()));
            fail(fmt::format("expected {} to {} elements, found {}", rule.min_items, rule.max_items, value.size()));
        }
        // Check the elements, and that strings and indices are unique.
        std::unordered_set<std::uint64_t> seen;
        std::unordered_set<std::string_view> seen_text;
        for (std::size_t i = 0; i < value.size(); ++i) {
            json& element = value[i];
            below(i, [&] {
                switch (rule.kind) {
                    case Kind::numbers:
                        check_number(element, rule);
                        break;
                    case Kind::strings:
                        if (!element.is_string()) wrong_type(element, "a string");
                        if (!seen_text.insert(element.get_ref<const std::string&>()).second)
                            context_.repair(Fault::extension_list, pointer(), [] { return "is a duplicate"; });
                        break;
                    case Kind::indices:
                        check_index(element, rule);
                        if (!seen.insert(static_cast<std::uint64_t>(element.get<double>())).second)
                            fail("is a duplicate");
                        break;
                    case Kind::objects:
                        check_object(element, *rule.inner);
                        break;
                    default:
                        check_attributes(element, rule);
                }
            });
        }
    }

    void check_attributes(const json& value, const Rule& rule)
    {
        if (!value.is_object()) wrong_type(value, "an object");
        if (value.empty()) fail("must not be empty");
        for (auto item = value.begin(); item != value.end(); ++item)
            below(item.key(), [&] { check_index(item.value(), rule); });
    }

    void check_number(json& value, const Rule& rule)
    {
        if (!value.is_number()) wrong_type(value, "a number");
        const double number = value.get<double>();
        if (!std::isfinite(number)) fail("is not finite");
        if (number >= rule.low && !(rule.above_low && number == rule.low) && number <= rule.high) return;
        // Clamp what exceeds a range, such as a factor of 1.00000012.
        const auto problem = [&] { return fmt::format("{} is out of range", number); };
        const double nearest = std::clamp(number, rule.low, rule.high);
        if (rule.above_low && nearest == rule.low) fail(problem());
        context_.repair(Fault::factor_range, pointer(), problem);
        value = nearest;
    }

    void check_integer(const json& value, const Rule& rule)
    {
        if (!value.is_number()) wrong_type(value, "an integer");
        const double number = value.get<double>();
        if (number != std::floor(number)) fail(fmt::format("{} is not an integer", number));
        if (number < rule.low || number > rule.high || number > k_exact_integers)
            fail(fmt::format("{} is out of range", number));
    }

    void check_index(const json& value, const Rule& rule)
    {
        check_integer(value, {.name = rule.name, .kind = Kind::integer, .low = 0});
        if (!rule.target) return;
        const std::uint64_t size = size_of(rule.target);
        const double number = value.get<double>();
        if (number >= static_cast<double>(size))
            fail(fmt::format("refers to index {} of '{}', which has {} elements", number, rule.target, size));
    }

    void check_version(const json& value)
    {
        if (!value.is_string()) wrong_type(value, "a string");
        const std::string& text = value.get_ref<const std::string&>();
        const auto dot = text.find('.');
        const auto digits = [](std::string_view part) {
            return !part.empty() && part.size() < 6 &&
                   std::all_of(part.begin(), part.end(), [](char c) { return c >= '0' && c <= '9'; });
        };
        if (dot == std::string::npos || !digits(std::string_view(text).substr(0, dot)) ||
            !digits(std::string_view(text).substr(dot + 1)))
            fail(fmt::format("'{}' is not a version of the form major.minor", text.substr(0, 64)));
    }

    std::uint64_t size_of(const char* target)
    {
        if (const auto known = sizes_.find(target); known != sizes_.end()) return known->second;
        const json::json_pointer where{std::string(target)};
        std::uint64_t size = 0;
        try {
            if (document_.contains(where) && document_.at(where).is_array()) size = document_.at(where).size();
        } catch (const json::exception&) {
            size = 0;   // a part of the path is not an object; that is reported elsewhere
        }
        return sizes_[target] = size;
    }

    json& document_;
    Context& context_;
    std::vector<Step> path_;
    std::unordered_set<std::string> used_;
    std::unordered_map<std::string, std::uint64_t> sizes_;
    std::vector<TextureBinding> bindings_;
};

}   // namespace

std::vector<TextureBinding> check_schema(json& document, Context& context)
{
    if (!context.strict()) repair_document(document, context);
    return Walk(document, context).run();
}

}   // namespace gnomon::io::gltf
