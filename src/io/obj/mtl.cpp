// SPDX-License-Identifier: Apache-2.0
#include "io/obj/mtl.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace gnomon::io {

namespace {

constexpr std::size_t k_most_named = 5;   // keywords in a warning

class Parser {
 public:
    Parser(ObjText& text, bool strict) : text_(text), strict_(strict) {}

    std::vector<MtlMaterial> run(std::vector<std::string>& warnings)
    {
        for (std::string_view key = text_.next_statement(); !key.empty(); key = text_.next_statement()) {
            if (key == "newmtl") {
                materials_.emplace_back();
                materials_.back().name = text_.rest();
            } else if (materials_.empty()) {
                ++before_first_;
            } else {
                statement(key, materials_.back());
            }
        }
        warn(warnings);
        return std::move(materials_);
    }

 private:
    void statement(std::string_view key, MtlMaterial& m)
    {
        if (key == "Ka")
            color(m.ambient);
        else if (key == "Kd")
            color(m.diffuse);
        else if (key == "Ks")
            color(m.specular);
        else if (key == "Ke")
            color(m.emissive);
        else if (key == "Tf")
            color(m.filter);
        else if (key == "Ns")
            number(m.exponent);
        else if (key == "Ni")
            number(m.ior);
        else if (key == "Pr")
            number(m.roughness);
        else if (key == "Pm")
            number(m.metallic);
        else if (key == "Tr")
            number(m.transparency);
        else if (key == "illum")
            illum(m);
        else if (key == "d")
            dissolve(m);
        else if (key == "map_Kd")
            map(m.diffuse_map);
        else if (key == "map_d")
            map(m.dissolve_map);
        else if (key == "map_Bump" || key == "map_bump" || key == "bump")
            map(m.bump_map);
        else if (key == "norm" || key == "map_Kn" || key == "map_norm")
            map(m.normal_map);
        else if (key == "map_Ke")
            map(m.emissive_map);
        else if (key == "map_Pr")
            map(m.roughness_map);
        else if (key == "map_Pm")
            map(m.metallic_map);
        else if (key == "map_Ka" || key == "map_aat" || key == "sharpness" || key == "Kt" || key == "aniso" ||
                 key == "anisor" || key == "Pc" || key == "Pcr" || key == "Ps")
            return;   // has no effect here
        else
            unknown(key);
    }

    // The statement has no value that can be read: it is ignored.
    bool ignore(const char* expected)
    {
        if (strict_) {
            const std::string_view word = text_.word();
            text_.fail(word.empty() ? fmt::format("{} is missing", expected)
                                    : fmt::format("expected {}, found '{}'", expected, shown(word)));
        }
        if (ignored_++ == 0) first_ignored_ = text_.line();
        return false;
    }

    bool number(float& value)
    {
        float read = 0;
        if (!text_.try_number(read)) return ignore("a number");
        value = read;
        return true;
    }

    void number(std::optional<float>& value)
    {
        if (float read = 0; number(read)) value = read;
    }

    // Reads a colour; one number is grey. Spectral curves and XYZ are not supported.
    void color(std::optional<glm::vec3>& value)
    {
        glm::vec3 c(0);
        ObjText ahead = text_;
        if (const std::string_view word = ahead.word(); word == "spectral" || word == "xyz") {
            spectral_ += 1;
            return;
        }
        if (!text_.try_number(c.x)) return void(ignore("a colour"));
        if (text_.at_end())
            c = glm::vec3(c.x);
        else if (!text_.try_number(c.y) || !text_.try_number(c.z))
            return void(ignore("a colour's component"));
        value = glm::max(c, glm::vec3(0));
    }

    void illum(MtlMaterial& m)
    {
        if (float value = 0; number(value)) m.illum = static_cast<int>(std::clamp(value, 0.0f, 99.0f));
    }

    void dissolve(MtlMaterial& m)
    {
        if (float value = 0; text_.try_number(value)) {
            m.dissolve = value;
            return;
        }
        ObjText ahead = text_;
        if (ahead.word() == "-halo") text_.word();
        number(m.dissolve);
    }

    // Reads a texture map: options precede the name, which is the rest of the line.
    void map(MtlMap& result)
    {
        result = {};
        while (!text_.at_end()) {
            const ObjText before = text_;
            const std::string_view word = text_.word();
            float unused = 0;
            if (word == "-s" || word == "-o" || word == "-t") {
                glm::vec3 value(word == "-s" ? 1.0f : 0.0f);
                number(value.x);
                if (text_.try_number(value.y)) text_.try_number(value.z);
                if (word == "-s") result.scale = glm::vec2(value);
                if (word == "-o") result.offset = glm::vec2(value);
            } else if (word == "-clamp") {
                result.clamp = text_.word() == "on";
            } else if (word == "-bm") {
                number(result.bump);
            } else if (word == "-mm") {
                number(result.range.x);
                number(result.range.y);
            } else if (word == "-imfchan") {
                const std::string_view channel = text_.word();
                if (channel.size() == 1) result.channel = channel[0];
            } else if (word == "-blendu" || word == "-blendv" || word == "-cc" || word == "-type") {
                text_.word();
            } else if (word == "-boost" || word == "-texres") {
                text_.try_number(unused);
            } else {
                text_ = before;
                result.file = text_.rest();
                break;
            }
        }
    }

    void unknown(std::string_view key)
    {
        if (unknown_.contains(key)) return;
        if (unknown_.size() < k_most_named) {
            names_ += fmt::format("{}'{}'", unknown_.empty() ? "" : ", ", shown(key));
            unknown_.emplace(key);
        } else {
            more_ = true;
        }
    }

    void warn(std::vector<std::string>& warnings) const
    {
        const std::string& file = text_.file();
        if (before_first_ > 0)
            warnings.push_back(fmt::format("{}: statements before the first newmtl are ignored", file));
        if (!unknown_.empty())
            warnings.push_back(fmt::format("{}: {}{} {} not supported and ignored", file, names_,
                                           more_ ? " and further keywords" : "",
                                           unknown_.size() == 1 && !more_ ? "is" : "are"));
        if (spectral_ > 0) warnings.push_back(fmt::format("{}: spectral and XYZ colours are ignored", file));
        if (ignored_ > 0)
            warnings.push_back(fmt::format("{}, line {}: {} not a number: ignored", file, first_ignored_,
                                           ignored_ == 1 ? "1 value is" : fmt::format("{} values are", ignored_)));
        if (std::string commas = text_.comma_warning(); !commas.empty()) warnings.push_back(std::move(commas));
    }

    ObjText& text_;
    bool strict_;
    std::vector<MtlMaterial> materials_;
    std::set<std::string, std::less<>> unknown_;   // those that are named
    std::string names_;
    bool more_ = false;
    std::size_t before_first_ = 0, spectral_ = 0, ignored_ = 0;
    std::uint32_t first_ignored_ = 0;   // line
};

}   // namespace

std::vector<MtlMaterial> parse_mtl(ObjText& text, bool strict, std::vector<std::string>& warnings)
{
    return Parser(text, strict).run(warnings);
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
