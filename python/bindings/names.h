// SPDX-License-Identifier: Apache-2.0
#pragma once
// The names that Python has for the values of the public enums: those of the command line, and one table for each enum.

#include <pybind11/pybind11.h>

#include <string>

#include "gnomon/gnomon.h"

namespace gnomon::python {

namespace py = pybind11;

/// A value of an enum and its name.
template <class E>
struct Name {
    const char* name;
    E value;
};

/// The table of an enum.
template <class E>
inline constexpr Name<E> k_names[] = {};

template <>
inline constexpr Name<Mobility> k_names<Mobility>[] = {
    {"fixed", Mobility::fixed}, {"may_move", Mobility::may_move}, {"may_deform", Mobility::may_deform}};
template <>
inline constexpr Name<Wrap> k_names<Wrap>[] = {
    {"repeat", Wrap::repeat}, {"mirror", Wrap::mirror}, {"clamp", Wrap::clamp}};
template <>
inline constexpr Name<Filter> k_names<Filter>[] = {{"nearest", Filter::nearest}, {"linear", Filter::linear}};
template <>
inline constexpr Name<ShadingModel> k_names<ShadingModel>[] = {{"metallic_roughness", ShadingModel::metallic_roughness},
                                                               {"whitted", ShadingModel::whitted},
                                                               {"unlit", ShadingModel::unlit}};
template <>
inline constexpr Name<AlphaMode> k_names<AlphaMode>[] = {
    {"opaque", AlphaMode::opaque}, {"mask", AlphaMode::mask}, {"blend", AlphaMode::blend}};
template <>
inline constexpr Name<LightType> k_names<LightType>[] = {
    {"point", LightType::point}, {"spot", LightType::spot}, {"directional", LightType::directional}};
template <>
inline constexpr Name<Falloff> k_names<Falloff>[] = {{"inverse_square", Falloff::inverse_square},
                                                     {"constant", Falloff::constant}};
template <>
inline constexpr Name<SpotProfile> k_names<SpotProfile>[] = {
    {"smooth", SpotProfile::smooth}, {"cosine", SpotProfile::cosine}, {"smooth-cosine", SpotProfile::smooth_cosine}};
template <>
inline constexpr Name<AreaLightShape> k_names<AreaLightShape>[] = {
    {"rectangle", AreaLightShape::rectangle}, {"disc", AreaLightShape::disc}, {"sphere", AreaLightShape::sphere}};
template <>
inline constexpr Name<RenderMethod> k_names<RenderMethod>[] = {{"trace", RenderMethod::trace},
                                                               {"raster", RenderMethod::raster}};
template <>
inline constexpr Name<PixelFilter> k_names<PixelFilter>[] = {{"auto", PixelFilter::automatic},
                                                             {"box", PixelFilter::box},
                                                             {"gaussian", PixelFilter::gaussian},
                                                             {"blackman-harris", PixelFilter::blackman_harris}};
template <>
inline constexpr Name<ToneMap> k_names<ToneMap>[] = {
    {"none", ToneMap::none}, {"neutral", ToneMap::neutral}, {"agx", ToneMap::agx}, {"aces", ToneMap::aces}};
template <>
inline constexpr Name<BackgroundKind> k_names<BackgroundKind>[] = {{"environment", BackgroundKind::environment},
                                                                   {"transparent", BackgroundKind::transparent},
                                                                   {"color", BackgroundKind::color}};
template <>
inline constexpr Name<ShadowCulling> k_names<ShadowCulling>[] = {
    {"off", ShadowCulling::off}, {"paper", ShadowCulling::paper}, {"certified", ShadowCulling::certified}};
template <>
inline constexpr Name<Indirect> k_names<Indirect>[] = {
    {"off", Indirect::off}, {"rsm", Indirect::rsm}, {"quadtree", Indirect::quadtree}, {"visible", Indirect::visible}};
template <>
inline constexpr Name<IndirectOn> k_names<IndirectOn>[] = {
    {"auto", IndirectOn::automatic}, {"cpu", IndirectOn::cpu}, {"vulkan", IndirectOn::vulkan}};
template <>
inline constexpr Name<ShadowTextures> k_names<ShadowTextures>[] = {{"off", ShadowTextures::off},
                                                                   {"per-caster", ShadowTextures::per_caster},
                                                                   {"depth", ShadowTextures::depth},
                                                                   {"coherent", ShadowTextures::coherent},
                                                                   {"items", ShadowTextures::items}};
template <>
inline constexpr Name<Accelerator> k_names<Accelerator>[] = {{"embree", Accelerator::embree},
                                                             {"kdtree", Accelerator::kdtree}};
template <>
inline constexpr Name<Arithmetic> k_names<Arithmetic>[] = {{"portable", Arithmetic::portable},
                                                           {"native", Arithmetic::native}};
template <>
inline constexpr Name<Overlay> k_names<Overlay>[] = {{"none", Overlay::none},
                                                     {"shadow-states", Overlay::shadow_states},
                                                     {"redrawn", Overlay::redrawn},
                                                     {"clusters", Overlay::clusters}};
template <>
inline constexpr Name<ExrType> k_names<ExrType>[] = {{"half", ExrType::half}, {"float", ExrType::single}};
template <>
inline constexpr Name<ExrCompression> k_names<ExrCompression>[] = {
    {"none", ExrCompression::none}, {"rle", ExrCompression::rle}, {"zips", ExrCompression::zips},
    {"zip", ExrCompression::zip},   {"piz", ExrCompression::piz}, {"pxr24", ExrCompression::pxr24}};

/// The value of a name.
/// @throws UsageError  no value has it: the message lists those there are
template <class E>
E value_of(const std::string& name, const std::string& where)
{
    std::string names;
    for (const Name<E>& row : k_names<E>) {
        if (name == row.name) return row.value;
        names += std::string(names.empty() ? "" : ", ") + "'" + row.name + "'";
    }
    throw UsageError(where + ": no value '" + name + "'; there are " + names);
}

/// The name of a value.
template <class E>
const char* name_of(E value)
{
    for (const Name<E>& row : k_names<E>)
        if (value == row.value) return row.name;
    return "";
}

}   // namespace gnomon::python
