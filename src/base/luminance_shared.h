// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_LUMINANCE_SHARED_H
#define GNOMON_LUMINANCE_SHARED_H
// The weights of luminance(), base/math.h, for shaders.

#define GNOMON_LUMINANCE_RED 0.2126
#define GNOMON_LUMINANCE_GREEN 0.7152
#define GNOMON_LUMINANCE_BLUE 0.0722

#endif
