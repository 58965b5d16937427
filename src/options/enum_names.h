// SPDX-License-Identifier: Apache-2.0
#pragma once
// The names of the public interface's choices, one table an enum: the command line parses by it, --help and completions
// list it, and JSON and messages print it.

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "gnomon/error.h"
#include "gnomon/renderer.h"
#include "gnomon/video.h"

namespace gnomon::options {

template <class E>
struct EnumName {
    std::string_view name;
    E value;
    bool offered = true;   // as a choice on the command line
};

/// The table of an enum, in the order in which its choices are listed; specialised for each.
template <class E>
inline constexpr std::nullptr_t k_enum_names = nullptr;

template <>
inline constexpr EnumName<RenderMethod> k_enum_names<RenderMethod>[] = {
    {"trace", RenderMethod::trace},
    {"raster", RenderMethod::raster},
};
template <>
inline constexpr EnumName<Accelerator> k_enum_names<Accelerator>[] = {
    {"embree", Accelerator::embree},
    {"kdtree", Accelerator::kdtree},
};
template <>
inline constexpr EnumName<Arithmetic> k_enum_names<Arithmetic>[] = {
    {"auto", Arithmetic::portable},
    {"native", Arithmetic::native},
};
template <>
inline constexpr EnumName<ToneMap> k_enum_names<ToneMap>[] = {
    {"none", ToneMap::none},
    {"neutral", ToneMap::neutral},
    {"agx", ToneMap::agx},
    {"aces", ToneMap::aces},
};
template <>
inline constexpr EnumName<PixelFilter> k_enum_names<PixelFilter>[] = {
    {"auto", PixelFilter::automatic},
    {"box", PixelFilter::box},
    {"gaussian", PixelFilter::gaussian},
    {"blackman-harris", PixelFilter::blackman_harris},
};
template <>
inline constexpr EnumName<Overlay> k_enum_names<Overlay>[] = {
    {"none", Overlay::none, false},
    {"shadow-states", Overlay::shadow_states},
    {"redrawn", Overlay::redrawn},
    {"clusters", Overlay::clusters},
};
template <>
inline constexpr EnumName<ShadowCulling> k_enum_names<ShadowCulling>[] = {
    {"off", ShadowCulling::off},
    {"paper", ShadowCulling::paper},
    {"certified", ShadowCulling::certified},
};
template <>
inline constexpr EnumName<ShadowTextures> k_enum_names<ShadowTextures>[] = {
    {"off", ShadowTextures::off, false}, {"per-caster", ShadowTextures::per_caster},
    {"depth", ShadowTextures::depth},    {"coherent", ShadowTextures::coherent},
    {"items", ShadowTextures::items},
};
template <>
inline constexpr EnumName<Indirect> k_enum_names<Indirect>[] = {
    {"off", Indirect::off},
    {"rsm", Indirect::rsm},
    {"quadtree", Indirect::quadtree},
    {"visible", Indirect::visible},
};
template <>
inline constexpr EnumName<IndirectOn> k_enum_names<IndirectOn>[] = {
    {"auto", IndirectOn::automatic},
    {"cpu", IndirectOn::cpu},
    {"vulkan", IndirectOn::vulkan},
};
template <>
inline constexpr EnumName<VideoCodec> k_enum_names<VideoCodec>[] = {
    {"auto", VideoCodec::automatic}, {"h264", VideoCodec::h264}, {"h265", VideoCodec::h265},
    {"prores", VideoCodec::prores},  {"vp9", VideoCodec::vp9},   {"ffv1", VideoCodec::ffv1},
};
template <>
inline constexpr EnumName<ExrType> k_enum_names<ExrType>[] = {
    {"half", ExrType::half},
    {"float", ExrType::single},
};
template <>
inline constexpr EnumName<ExrCompression> k_enum_names<ExrCompression>[] = {
    {"none", ExrCompression::none}, {"rle", ExrCompression::rle}, {"zips", ExrCompression::zips},
    {"zip", ExrCompression::zip},   {"piz", ExrCompression::piz}, {"pxr24", ExrCompression::pxr24},
};

namespace detail {
template <class E>
constexpr std::size_t choices_length()
{
    std::size_t length = 0;
    for (const auto& entry : k_enum_names<E>)
        if (entry.offered) length += entry.name.size() + (length > 0);
    return length;
}
template <class E>
constexpr auto join_choices()
{
    std::array<char, choices_length<E>()> text{};
    std::size_t at = 0;
    for (const auto& entry : k_enum_names<E>) {
        if (!entry.offered) continue;
        if (at > 0) text[at++] = '|';
        for (const char c : entry.name) text[at++] = c;
    }
    return text;
}
template <class E>
inline constexpr auto k_choices_text = join_choices<E>();
}   // namespace detail

/// The names that the command line takes, as option_table.h has choices: "off|paper|certified".
template <class E>
inline constexpr std::string_view k_choices{detail::k_choices_text<E>.data(), detail::k_choices_text<E>.size()};

/// @throws InternalError for a value without a name
template <class E>
std::string_view name_of(E value)
{
    for (const auto& entry : k_enum_names<E>)
        if (entry.value == value) return entry.name;
    throw InternalError(
        fmt::format("a choice among {} has the value {}, which has no name", k_choices<E>, static_cast<int>(value)));
}

/// "off, paper or certified"
std::string listed(std::string_view choices);

/// @param option  without dashes, for the message
/// @throws UsageError naming the choices
template <class E>
E parse_enum(std::string_view option, std::string_view word)
{
    for (const auto& entry : k_enum_names<E>)
        if (entry.offered && entry.name == word) return entry.value;
    throw UsageError(fmt::format("--{} {}: expected {}", option, word, listed(k_choices<E>)));
}

}   // namespace gnomon::options
