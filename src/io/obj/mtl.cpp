// SPDX-License-Identifier: Apache-2.0
#include "io/obj/mtl.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace gnomon::io {

namespace {

constexpr std::size_t k_most_unknown_keywords = 10;

// Reads a colour; one number is grey. Spectral curves and XYZ are not supported.
std::optional<glm::vec3> color(ObjText& text, bool& unsupported)
{
    glm::vec3 c(0);
    if (!text.try_number(c.x)) {
        const std::string_view word = text.word();
        if (word == "spectral" || word == "xyz") return unsupported = true, std::nullopt;
        text.fail(word.empty() ? "a colour is missing" : fmt::format("expected a colour, found '{}'", shown(word)));
    }
    if (text.at_end()) return glm::vec3(c.x);
    c.y = text.number("a colour's second component");
    c.z = text.number("a colour's third component");
    return glm::max(c, glm::vec3(0));
}

bool is_on(ObjText& text)
{
    return text.word() == "on";
}

// Reads a texture map: options precede the name, which is the rest of the line.
MtlMap map(ObjText& text)
{
    MtlMap result;
    while (!text.at_end()) {
        ObjText before = text;
        const std::string_view word = text.word();
        float ignored = 0;
        if (word == "-s" || word == "-o" || word == "-t") {
            glm::vec3 value(word == "-s" ? 1.0f : 0.0f);
            value.x = text.number("a number");
            if (text.try_number(value.y)) text.try_number(value.z);
            if (word == "-s") result.scale = glm::vec2(value);
            if (word == "-o") result.offset = glm::vec2(value);
        } else if (word == "-clamp") {
            result.clamp = is_on(text);
        } else if (word == "-bm") {
            result.bump = text.number("a number");
        } else if (word == "-mm") {
            result.range.x = text.number("a number");
            result.range.y = text.number("a number");
        } else if (word == "-imfchan") {
            const std::string_view channel = text.word();
            if (channel.size() == 1) result.channel = channel[0];
        } else if (word == "-blendu" || word == "-blendv" || word == "-cc" || word == "-type") {
            text.word();
        } else if (word == "-boost" || word == "-texres") {
            text.try_number(ignored);
        } else {
            text = before;
            result.file = text.rest();
            break;
        }
    }
    return result;
}

}   // namespace

std::vector<MtlMaterial> parse_mtl(ObjText& text, std::vector<std::string>& warnings)
{
    std::vector<MtlMaterial> materials;
    std::set<std::string, std::less<>> unknown;
    const auto warn = [&](const std::string& what) {
        warnings.push_back(fmt::format("{}, line {}: {}", text.file(), text.line(), what));
    };
    for (std::string_view key = text.next_statement(); !key.empty(); key = text.next_statement()) {
        if (key == "newmtl") {
            materials.emplace_back();
            materials.back().name = text.rest();
            continue;
        }
        if (materials.empty()) {
            if (unknown.emplace("newmtl").second) warn("statements before the first newmtl are ignored");
            continue;
        }
        MtlMaterial& m = materials.back();
        bool unsupported = false;
        if (key == "Ka")
            m.ambient = color(text, unsupported);
        else if (key == "Kd")
            m.diffuse = color(text, unsupported);
        else if (key == "Ks")
            m.specular = color(text, unsupported);
        else if (key == "Ke")
            m.emissive = color(text, unsupported);
        else if (key == "Tf")
            m.filter = color(text, unsupported);
        else if (key == "Ns")
            m.exponent = text.number("a number");
        else if (key == "Ni")
            m.ior = text.number("a number");
        else if (key == "Pr")
            m.roughness = text.number("a number");
        else if (key == "Pm")
            m.metallic = text.number("a number");
        else if (key == "Tr")
            m.transparency = text.number("a number");
        else if (key == "illum")
            m.illum = static_cast<int>(std::clamp(text.number("a number"), 0.0f, 99.0f));
        else if (key == "d") {
            float value = 0;
            if (!text.try_number(value)) {   // -halo
                text.word();
                value = text.number("a number");
            }
            m.dissolve = value;
        } else if (key == "map_Kd")
            m.diffuse_map = map(text);
        else if (key == "map_d")
            m.dissolve_map = map(text);
        else if (key == "map_Bump" || key == "map_bump" || key == "bump")
            m.bump_map = map(text);
        else if (key == "norm" || key == "map_Kn" || key == "map_norm")
            m.normal_map = map(text);
        else if (key == "map_Ke")
            m.emissive_map = map(text);
        else if (key == "map_Pr")
            m.roughness_map = map(text);
        else if (key == "map_Pm")
            m.metallic_map = map(text);
        else if (key == "map_Ka" || key == "map_aat" || key == "sharpness" || key == "Kt" || key == "aniso" ||
                 key == "anisor" || key == "Pc" || key == "Pcr" || key == "Ps")
            continue;   // has no effect here
        else if (unknown.size() < k_most_unknown_keywords && unknown.emplace(key).second)
            warn(fmt::format("'{}' is not supported and ignored", shown(key)));
        if (unsupported && unknown.emplace("spectral").second) warn("spectral and XYZ colours are ignored");
    }
    return materials;
}

scene::Material material_from_mtl(const MtlMaterial& mtl, std::vector<std::string>& warnings)
{
    constexpr float specular_scale = 0.08f;    // reflectance at normal incidence of Ks 1
    constexpr float least_traced_ks = 0.05f;   // below this, illum 3 is not treated as a mirror
    constexpr glm::vec3 default_color(0.8f);

    scene::Material m;
    m.name = mtl.name;
    m.double_sided = true;   // the format has no sides, and files use either orientation
    m.base_color = glm::min(mtl.diffuse.value_or(default_color), glm::vec3(1));
    // A map multiplied by black would be invisible; such files mean the map alone.
    if (mtl.diffuse_map.used() && m.base_color == glm::vec3(0)) m.base_color = glm::vec3(1);

    const glm::vec3 ks = glm::min(mtl.specular.value_or(glm::vec3(0)), glm::vec3(1));
    const float exponent = std::max(mtl.exponent.value_or(0.0f), 0.0f);
    m.roughness = luminance(ks) > 0 ? std::sqrt(std::sqrt(2.0f / (exponent + 2.0f))) : 1.0f;
    const float head_on = std::sqrt(specular_scale * luminance(ks));
    m.ior = (1 + head_on) / (1 - head_on);
    const bool traces = mtl.illum == 3 || mtl.illum == 5 || mtl.illum == 8;
    if (traces && luminance(ks) > least_traced_ks) {
        m.metallic = luminance(ks) / (luminance(ks) + luminance(m.base_color));
        m.base_color = glm::min(m.base_color + ks, glm::vec3(1));
    }
    if (mtl.roughness || mtl.roughness_map.used()) m.roughness = std::clamp(mtl.roughness.value_or(1.0f), 0.0f, 1.0f);
    if (mtl.metallic || mtl.metallic_map.used()) {
        m.metallic = std::clamp(mtl.metallic.value_or(1.0f), 0.0f, 1.0f);
        m.base_color = glm::min(mtl.diffuse.value_or(default_color), glm::vec3(1));
    }
    if (mtl.roughness || mtl.metallic || mtl.roughness_map.used() || mtl.metallic_map.used()) m.ior = 1.5f;

    // If both are given, d is used, because some exporters write Tr inverted.
    const float opacity = std::clamp(mtl.dissolve.value_or(1 - mtl.transparency.value_or(0.0f)), 0.0f, 1.0f);
    const bool refracts = mtl.illum == 6 || mtl.illum == 7;
    const bool glass = refracts || mtl.illum == 4 || mtl.illum == 9;
    float through = 1 - opacity;
    if (refracts && opacity == 1) through = std::clamp(luminance(mtl.filter.value_or(glm::vec3(1))), 0.0f, 1.0f);
    if (mtl.dissolve_map.used()) {
        m.alpha_mode = scene::AlphaMode::mask;
    } else if (glass && through > 0) {
        m.transmission = through;
        m.ior = std::clamp(mtl.ior.value_or(1.5f), 1.0f, 4.0f);
        if (!mtl.roughness) m.roughness = 0;
        // Transmitted light is tinted by Tf, because Kd of glass is black in most files.
        const glm::vec3 tint = glm::min(mtl.filter.value_or(glm::vec3(1)), glm::vec3(1));
        m.base_color = glm::mix(m.base_color, tint, through);
    } else if (opacity < 1) {
        m.alpha_mode = scene::AlphaMode::blend;
        m.alpha = opacity;
    }

    m.emissive = mtl.emissive.value_or(glm::vec3(mtl.emissive_map.used() ? 1.0f : 0.0f));
    // DEVIATION(Wavefront MTL, Ka): a surface that reflects more ambient light than there is must be an emitter;
    // renderers without Ke write their lights in this way.
    if (mtl.ambient && m.emissive == glm::vec3(0) && std::max({mtl.ambient->x, mtl.ambient->y, mtl.ambient->z}) > 1) {
        m.emissive = *mtl.ambient;
        warnings.push_back(fmt::format("material '{}': Ka above 1 is interpreted as emitted light", shown(mtl.name)));
    }
    return m;
}

}   // namespace gnomon::io
