// SPDX-License-Identifier: Apache-2.0
#include "gnomon/version.h"

namespace gnomon {

std::string_view version()
{
    return GNOMON_VERSION;
}

}   // namespace gnomon
