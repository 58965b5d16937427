// SPDX-License-Identifier: Apache-2.0
// Whether a sanitizer is active: it reserves terabytes of address space, so that address space cannot be limited, and
// it is slow.
#pragma once

// ThreadSanitizer, with either compiler.
#if defined(__SANITIZE_THREAD__)
#define GNOMON_SANITIZED_THREAD
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define GNOMON_SANITIZED_THREAD
#endif
#endif

namespace gnomon::test {

#if defined(GNOMON_SANITIZED_THREAD)
inline constexpr bool k_sanitized_thread = true;
#else
inline constexpr bool k_sanitized_thread = false;
#endif

#if defined(GNOMON_SANITIZED)
inline constexpr bool k_sanitized = true;
#else
inline constexpr bool k_sanitized = false;
#endif

/// Multiplies all time limits, which only have to catch what never ends.
inline constexpr int k_patience = k_sanitized ? 20 : 1;

}   // namespace gnomon::test
