// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_SHADING_SHEEN_SHARED_H
#define GNOMON_SHADING_SHEEN_SHARED_H
// The albedo of white fibres (sheen_albedo() in layers.h), coarsely sampled for shaders: row by row of roughness, from
// 0.1 to 1, by the cosine of the view, from 0 to 1. A test holds it against the function.

#define GNOMON_SHEEN_ROWS 5
#define GNOMON_SHEEN_COLUMNS 9
#define GNOMON_SHEEN_ALBEDOS                                                                                        \
    1.0000f, 0.6842f, 0.1281f, 0.0184f, 0.0017f, 0.0001f, 0.0000f, 0.0000f, 0.0000f, 1.0000f, 0.7014f, 0.4278f,     \
        0.2611f, 0.1540f, 0.0850f, 0.0419f, 0.0164f, 0.0031f, 0.8271f, 0.5771f, 0.4286f, 0.3233f, 0.2421f, 0.1770f, \
        0.1238f, 0.0799f, 0.0436f, 0.6792f, 0.5107f, 0.4091f, 0.3345f, 0.2741f, 0.2226f, 0.1773f, 0.1365f, 0.0990f, \
        0.6083f, 0.4744f, 0.3944f, 0.3356f, 0.2875f, 0.2459f, 0.2086f, 0.1740f, 0.1415f

#endif
