// SPDX-License-Identifier: Apache-2.0
#pragma once
// What each method of rasterised shadows does [Oh and Shin 2004]; one meaning for the renderer, the bench and the
// tests.
//
// | method     | light view                     | textures                                     | look-up reads |
// |------------|--------------------------------|----------------------------------------------|---------------|
// | per_caster | drawn anew, for its depths     | all, each from the casters before it [1]     | textures      |
// | depth      | drawn anew                     | all, each by one draw [2]                    | textures      |
// | coherent   | repaired where something moved | those that a change can alter, by one draw [3] | textures    |
// | items      | repaired where something moved | none                                         | items         |

#include "gnomon/renderer.h"

namespace gnomon::shadow_textures {

/// Whether the light views are kept from frame to frame.
inline constexpr bool keeps_views(ShadowTextures method)
{
    return method == ShadowTextures::coherent || method == ShadowTextures::items;
}

/// Whether each receiver has a texture of its own.
inline constexpr bool makes_textures(ShadowTextures method)
{
    return method == ShadowTextures::per_caster || method == ShadowTextures::depth ||
           method == ShadowTextures::coherent;
}

}   // namespace gnomon::shadow_textures
