// SPDX-License-Identifier: Apache-2.0
#include "places.h"

#ifndef GNOMON_PROGRAM
#define GNOMON_PROGRAM ""
#endif
#ifndef GNOMON_FAILING_VULKAN
#define GNOMON_FAILING_VULKAN ""
#endif
#ifndef GNOMON_LOSING_POWER
#define GNOMON_LOSING_POWER ""
#endif

namespace gnomon::test::places {

const std::string scenes = GNOMON_SCENES_DEFAULT, source_folder = GNOMON_SOURCE_DIR, program = GNOMON_PROGRAM,
                  failing_vulkan = GNOMON_FAILING_VULKAN, losing_power = GNOMON_LOSING_POWER;

}   // namespace gnomon::test::places
