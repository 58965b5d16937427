// SPDX-License-Identifier: Apache-2.0
#include "base/memory_limit.h"

#include <fmt/format.h>

#include "gnomon/error.h"

namespace gnomon {

void MemoryLimit::refuse(std::string_view what) const
{
    throw MissingError(fmt::format("needs more than the limit of {} MB of memory: {}", bytes_ >> 20, what));
}

}   // namespace gnomon
