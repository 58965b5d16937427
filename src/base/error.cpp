// SPDX-License-Identifier: Apache-2.0
#include "gnomon/error.h"

#include <fmt/format.h>

#include "base/check.h"
#include "base/one_line.h"

namespace gnomon {

Error::Error(const std::string& message) : std::runtime_error(one_line(message)) {}

InputError::InputError(std::string file, std::string place, std::string what)
    : Error(place.empty() ? fmt::format("{}: {}", file, what) : fmt::format("{}:{}: {}", file, place, what)),
      file_(std::move(file)),
      place_(std::move(place)),
      problem_(std::move(what))
{
}

void fail_check(std::string_view file, int line, std::string_view what)
{
    // Keep the path from src/ on, so that messages do not contain folders of the build machine.
    if (const auto at = file.rfind("/src/"); at != std::string_view::npos) file.remove_prefix(at + 1);
    throw InternalError(fmt::format("{}:{}: {}", file, line, what));
}

}   // namespace gnomon
