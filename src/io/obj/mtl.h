// SPDX-License-Identifier: Apache-2.0
#pragma once
// Parses MTL files [Wavefront MTL, Ramey et al. 1995; PBR extension, Kautz et al. 2013] and converts their materials.

#include <optional>
#include <string>
#include <vector>

#include "io/obj/text.h"
#include "scene/material.h"

namespace gnomon::io {

/// A `map_` statement: a file and its options.
struct MtlMap {
    std::string file;   // empty: not given
    glm::vec2 offset{0}, scale{1};
    bool clamp = false;
    float bump = 1;          // -bm
    char channel = 0;        // -imfchan: r g b m l z; 0: not given
    glm::vec2 range{0, 1};   // -mm: base and gain
    bool used() const { return !file.empty(); }
};

struct MtlMaterial {
    std::string name;
    std::optional<glm::vec3> ambient, diffuse, specular, emissive, filter;             // Ka Kd Ks Ke Tf
    std::optional<float> exponent, dissolve, transparency, ior, roughness, metallic;   // Ns d Tr Ni Pr Pm
    int illum = 2;
    MtlMap diffuse_map, dissolve_map, bump_map, normal_map, emissive_map, roughness_map, metallic_map;
};

/// Statements that are not supported are ignored with one warning, and so are those whose value is no number.
/// @param strict  refuses the latter
/// @throws InputError  of `strict`
std::vector<MtlMaterial> parse_mtl(ObjText& text, bool strict, std::vector<std::string>& warnings);

/// Converts everything except the textures.
///
/// Ns: a Phong lobe of exponent n is as wide as a microfacet lobe of alpha = sqrt(2 / (n + 2)) [Walter et al. 2007,
/// 5.2], and roughness = sqrt(alpha). Ks: reflectance at normal incidence = 0.08 luminance(Ks) [Burley 2012], hence
/// none for Ks 0. illum 3, 5, 8 (traced reflection): metallic in proportion to Ks against Kd. illum 4, 6, 7, 9: glass,
/// where d < 1 or (6, 7) Tf transmits light. d < 1 otherwise: blended. Ka above 1: see the function's body.
/// (6, 7) Tf lets light through. d < 1 otherwise: blended. Ka above 1: see the body.
scene::Material material_from_mtl(const MtlMaterial& mtl, std::vector<std::string>& warnings);

}   // namespace gnomon::io
