// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_RASTER_SHARED_H
#define GNOMON_RASTER_SHARED_H
// Structures shared by the rasterised frame's shaders and the host. Layout: scalar.

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(raster)

/// Constant over a frame.
struct RasterFrame {
    vec3 eye;
    uint orthographic;
    vec3 right;   // scaled by half the view's extent, as in View
    uint width;
    vec3 up;
    uint height;
    vec3 forward;
    vec2 shift;   // as in View
    float pixel_spread;
    float pixel_width;
    uint background;   // as scene::Background::Kind: color, sky, image
    uint stand_in;     // ambient light stands in for indirect light
    vec3 background_color, zenith, horizon, ground, sun_direction, sun_radiance;
    vec3 ambient;
    vec3 open_irradiance;   // of a level surface without objects; 0: surfaces that catch shadows are ordinary ones
    uint surroundings_apart;   // the environment image's light comes from SurroundingLight
    uint backdrop_apart;    // what lies behind the scene goes to the image's fourth component: how much of it is seen
    uint environment_width, environment_height;
    vec3 harmonics[9];
};

#define GNOMON_BACKGROUND_COLOR 0u
#define GNOMON_BACKGROUND_SKY 1u
#define GNOMON_BACKGROUND_IMAGE 2u

/// Push constants of drawing ids.
struct DrawPush {
    mat4 clip_from_offset;   // of a point's offset from the eye
    vec3 eye;
};

/// Push constants of making surfaces from ids.
struct ResolvePush {
    vec2 sample_offset;   // in the pixel
    float weight;         // of the sample
    uint first;           // the sample's first layer
    uint peeled;          // a transparent layer's ids lie over the opaque ones
    uint last;            // of the sample's layers
};

/// Push constants of lighting.
struct ShadePush {
    uint first_light, light_count;
    uint shadowed;   // `visibility` is filled
    uint colors;     // add to the image and, of `layers`, to direct light
    uint layers;
    uint first_lit, lit_count;   // the lights whose layers of lit pixels are bound, to be added to
    uint lit_pixels;             // from one such layer to the next
};

/// Push constants of adding indirect light.
struct BouncePush {
    uint layers;   // also add to the layer of indirect light
};

/// Push constants of adding the light of surroundings.
struct SurroundingPush {
    uint layers;   // also add to the layer of direct light
};

#ifdef __cplusplus
GNOMON_MEMBERS(RasterFrame, eye, orthographic, right, width, up, height, forward, shift, pixel_spread, pixel_width,
               background, stand_in, background_color, zenith, horizon, ground, sun_direction, sun_radiance, ambient,
               open_irradiance, surroundings_apart, backdrop_apart, environment_width, environment_height, harmonics)
GNOMON_MEMBERS(DrawPush, clip_from_offset, eye)
GNOMON_MEMBERS(ResolvePush, sample_offset, weight, first, peeled, last)
GNOMON_MEMBERS(ShadePush, first_light, light_count, shadowed, colors, layers, first_lit, lit_count, lit_pixels)
GNOMON_MEMBERS(BouncePush, layers)
GNOMON_MEMBERS(SurroundingPush, layers)
#endif

GNOMON_SHARED_END
#endif
