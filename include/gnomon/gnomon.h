// SPDX-License-Identifier: Apache-2.0
#pragma once
// Includes the whole public interface: load a scene, render images of it.

#include "gnomon/arithmetic.h"
#include "gnomon/compare.h"
#include "gnomon/devices.h"
#include "gnomon/error.h"
#include "gnomon/frame.h"
#include "gnomon/frame_input.h"
#include "gnomon/ids.h"
#include "gnomon/math.h"
#include "gnomon/ranges.h"
#include "gnomon/renderer.h"
#include "gnomon/scene.h"
#include "gnomon/scene_builder.h"
#include "gnomon/scene_parts.h"
#include "gnomon/types.h"
#include "gnomon/version.h"
#include "gnomon/video.h"
