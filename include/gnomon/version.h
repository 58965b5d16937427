// SPDX-License-Identifier: Apache-2.0
#pragma once
// The version of the library.

#include <string_view>

namespace gnomon {

/// The version of the linked library as "MAJOR.MINOR.PATCH".
std::string_view version();

}   // namespace gnomon
