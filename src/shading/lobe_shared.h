// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_SHADING_LOBE_SHARED_H
#define GNOMON_SHADING_LOBE_SHARED_H
// Sizes and ranges of the tables of the glossy lobe (glossy.h, transformed_cosines.h), which shaders read as well.

#define GNOMON_COSINE_ROWS 20                 // of fits: roughness, evenly spaced from the first
#define GNOMON_COSINE_COLUMNS 20              // of fits: sine of half the angle of the view
#define GNOMON_COSINE_FIRST_ROUGHNESS 0.05f   // of a fit
#define GNOMON_COSINE_LEAST_VIEW 2e-3f        // cosine of the view of a fit
#define GNOMON_LOBE_LEAST_ROUGHNESS 0.05f     // of a lobe: below it, a mirror ray shows the same
#define GNOMON_BENT_VIEW 1e-3f         // cosine of the view to which normals are bent that face it less than a lobe
#define GNOMON_LOBE_LEAST_VIEW 5e-4f   // cosine of the view: seen more edge-on, a surface counts as a mirror
#define GNOMON_ALBEDO_SIDE 32          // of the square table of albedos: roughness, cosine of the view

#endif
