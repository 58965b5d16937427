// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_SHADOW_TEXTURES_TEXTURES_SHARED_H
#define GNOMON_SHADOW_TEXTURES_TEXTURES_SHARED_H
// The location of the shadow texture of one receiver in one view: rows of whole words, one bit per texel.

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(shadow_textures)

struct TexturePlace {
    uint first_word;
    uint row_words;   // 0: no texture, the receiver is not in view
    ivec2 corner;     // the texture's first texel, in the atlas's page
    int columns, rows;
};

#ifdef __cplusplus
GNOMON_MEMBERS(TexturePlace, first_word, row_words, corner, columns, rows)
#endif

GNOMON_SHARED_END

#endif
