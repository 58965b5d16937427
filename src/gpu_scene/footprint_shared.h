// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_FOOTPRINT_SHARED_H
#define GNOMON_FOOTPRINT_SHARED_H
// Constants of anisotropic texture filtering: scene::k_stretch and scene::k_most_samples.
#define GNOMON_FOOTPRINT_STRETCH 1.73205081
#define GNOMON_FOOTPRINT_SAMPLES 6
#endif
