// SPDX-License-Identifier: Apache-2.0
#include "scene/builtin/builtin.h"

#include <fmt/format.h>

#include <charconv>

#include "gnomon/error.h"

namespace gnomon::scene {

namespace {

constexpr const char* k_known =
    "builtin:cornell, builtin:kinetic, builtin:spheres?objects=N&dynamic=PERCENT (or movers=N; vertices=N, seed=N, "
    "crowd=1)";

[[noreturn]] void refuse(const std::string& what)
{
    throw UsageError(what + "; known: " + k_known);
}

template <class T>
T parse_number(std::string_view key, std::string_view text, T low, T high)
{
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    // The condition is written so that NaN is out of range, too.
    if (error != std::errc() || end != text.data() + text.size() || !(value >= low && value <= high))
        refuse(fmt::format("builtin:spheres: {} must be a number from {} to {}, not '{}'", key, low, high, text));
    return value;
}

SpheresOptions parse_spheres(std::string_view parameters)
{
    SpheresOptions options;
    while (!parameters.empty()) {
        const std::size_t stop = std::min(parameters.find('&'), parameters.size());
        const std::string_view item = parameters.substr(0, stop);
        parameters.remove_prefix(std::min(stop + 1, parameters.size()));
        const std::size_t equals = std::min(item.find('='), item.size());
        const std::string_view key = item.substr(0, equals);
        const std::string_view value = item.substr(std::min(equals + 1, item.size()));
        if (key == "objects")
            options.objects = parse_number(key, value, 1, 1'000'000);
        else if (key == "dynamic")
            options.dynamic = parse_number(key, value, 0.0, 100.0);
        else if (key == "movers")
            options.dynamic_objects = parse_number(key, value, 0, 1'000'000);
        else if (key == "vertices")
            options.vertices = parse_number(key, value, 5, 1'000'000);
        else if (key == "seed")
            options.seed = parse_number<std::uint64_t>(key, value, 0, ~std::uint64_t{0});
        else if (key == "crowd")
            options.crowd = parse_number(key, value, 0, 1) == 1;
        else
            refuse(fmt::format("builtin:spheres has no parameter '{}'", key));
    }
    if (options.dynamic_objects > options.objects)
        refuse(fmt::format("builtin:spheres: {} dynamic objects among {} objects", options.dynamic_objects,
                           options.objects));
    return options;
}

}   // namespace

Scene make_builtin(std::string_view name)
{
    const std::size_t question = std::min(name.find('?'), name.size());
    const std::string_view base = name.substr(0, question);
    const std::string_view parameters = name.substr(std::min(question + 1, name.size()));
    if (base == "spheres") return make_spheres(parse_spheres(parameters));
    if (base != "cornell" && base != "kinetic") refuse(fmt::format("no built-in scene '{}'", base));
    if (!parameters.empty()) refuse(fmt::format("builtin:{} takes no parameters, not '{}'", base, parameters));
    return base == "cornell" ? make_cornell() : make_kinetic();
}

}   // namespace gnomon::scene
