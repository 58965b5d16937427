// SPDX-License-Identifier: Apache-2.0
// Whether a sanitizer watches: it reserves terabytes of address space, which then cannot be limited, and is slow.
#pragma once

namespace gnomon::test {

#if defined(GNOMON_SANITIZED)
inline constexpr bool k_sanitized = true;
#else
inline constexpr bool k_sanitized = false;
#endif

}   // namespace gnomon::test
