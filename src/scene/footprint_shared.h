// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_SCENE_FOOTPRINT_SHARED_H
#define GNOMON_SCENE_FOOTPRINT_SHARED_H
// How an elongated footprint of a texture is covered: src/scene/footprint.h and footprint.cpp say what the numbers
// mean.
#define GNOMON_FOOTPRINT_STRETCH 1.73205081f
#define GNOMON_FOOTPRINT_SAMPLES 6
#define GNOMON_FOOTPRINT_NO_SAMPLE_MORE 1e-3f
#define GNOMON_FOOTPRINT_ONE_LEVEL 0.25f
#define GNOMON_FOOTPRINT_FAR 1e5f
#endif
