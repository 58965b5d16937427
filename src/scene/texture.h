// SPDX-License-Identifier: Apache-2.0
#pragma once
// Textures: 8-bit images with a mip chain, sampled with wrapping and trilinear filtering.
//
// u runs from the left column, v from the top row (glTF and AFF alike; importers of other formats flip). Coordinates
// are reduced to one period before they become texel indices, because AFF files use values from -196 to 328.

#include <string>
#include <vector>

#include "base/image.h"
#include "base/math.h"
#include "scene/ids.h"

namespace gnomon::scene {

enum class Wrap : std::uint8_t { repeat, mirror, clamp };
enum class Filter : std::uint8_t { nearest, linear };

struct Sampler {
    Wrap wrap_u = Wrap::repeat;
    Wrap wrap_v = Wrap::repeat;
    Filter magnify = Filter::linear;
    Filter minify = Filter::linear;
    bool mipmaps = true;
    friend bool operator==(const Sampler&, const Sampler&) = default;
};

/// An image prepared for sampling. Colour is filtered in linear light; alpha and data textures are filtered as stored.
class Texture {
 public:
    /// @param image  1 to 4 channels: grey, grey + alpha, RGB, RGBA; not empty
    /// @param srgb   whether colour channels are sRGB-encoded
    Texture(std::string name, const Image8& image, bool srgb, Sampler sampler);

    const std::string& name() const { return name_; }
    int width() const { return levels_.front().width; }
    int height() const { return levels_.front().height; }
    bool srgb() const { return srgb_; }
    bool has_alpha() const { return has_alpha_; }
    const Sampler& sampler() const { return sampler_; }
    /// RGBA8 levels, finest first. Colour stays encoded as in the file.
    const std::vector<Image8>& levels() const { return levels_; }
    std::size_t bytes() const;

    /// Linear RGBA at uv.
    /// @param footprint  the sample's width in uv units times the texture's larger side in texels; at or below 1 the
    ///                   finest level is used
    glm::vec4 sample(glm::vec2 uv, float footprint) const;
    /// Alpha of the finest level, bilinear, for shadow rays.
    float alpha(glm::vec2 uv) const;
    /// Alpha of a texel of the finest level, 0 to 255, wrapped as the sampler says; x and y from -1 to two periods.
    std::uint8_t alpha_texel(int x, int y) const;

 private:
    glm::vec4 texel(const Image8& level, int x, int y) const;
    glm::vec4 bilinear(const Image8& level, glm::vec2 uv) const;
    float bilinear_alpha(const Image8& level, glm::vec2 uv) const;
    glm::vec4 nearest(const Image8& level, glm::vec2 uv) const;

    std::string name_;
    std::vector<Image8> levels_;
    Sampler sampler_;
    bool srgb_ = true;
    bool has_alpha_ = false;
};

/// A reference to a texture from a material.
struct TextureUse {
    TextureId texture = none;
    int texcoord = 0;   // index of the mesh's set
    // KHR_texture_transform: uv' = offset + R(rotation) (scale * uv), rotation counter-clockwise in radians.
    glm::vec2 offset{0};
    glm::vec2 scale{1};
    float rotation = 0;

    bool used() const { return texture != none; }
    glm::vec2 apply(glm::vec2 uv) const;
};

}   // namespace gnomon::scene
