// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_SCENE_LIGHT_SHARED_H
#define GNOMON_SCENE_LIGHT_SHARED_H
// Constants of lights and of the sky that C++ and shaders agree on.
#define GNOMON_MOST_IRRADIANCE 1e12f   // scene::k_most_irradiance
#define GNOMON_LEAST_SQUARE 1e-30f     // of a distance: its inverse is a number
#define GNOMON_SKY_HAZE_DEPTH 0.08f    // sine of the depression at which the ground's own colour begins
#define GNOMON_SUN_DISC 0.99996f       // cosine: 0.5 degrees across
#define GNOMON_SUN_GLOW 0.25f
#define GNOMON_SUN_GLOW_POWER 250.0f
#endif
