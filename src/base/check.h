// SPDX-License-Identifier: Apache-2.0
#pragma once
// Checks of internal invariants. They stay active in release builds, print both operands, and throw InternalError, so
// that a program that embeds the library can shut down in an orderly way. Never use them for errors that a user or a
// file can cause.

#include <fmt/core.h>

#include <string_view>

#include "gnomon/error.h"

namespace gnomon {

[[noreturn]] void fail_check(std::string_view file, int line, std::string_view what);

}   // namespace gnomon

#define GNOMON_CHECK(condition) \
    ((condition) ? void() : ::gnomon::fail_check(__FILE__, __LINE__, "check failed: " #condition))

#define GNOMON_CHECK_OP(op, a, b)                                                                          \
    do {                                                                                                   \
        const auto& gnomon_a = (a);                                                                        \
        const auto& gnomon_b = (b);                                                                        \
        if (!(gnomon_a op gnomon_b))                                                                       \
            ::gnomon::fail_check(                                                                          \
                __FILE__, __LINE__,                                                                        \
                ::fmt::format("check failed: {} ({} against {})", #a " " #op " " #b, gnomon_a, gnomon_b)); \
    } while (false)

#define GNOMON_CHECK_EQ(a, b) GNOMON_CHECK_OP(==, a, b)
#define GNOMON_CHECK_LT(a, b) GNOMON_CHECK_OP(<, a, b)
#define GNOMON_CHECK_LE(a, b) GNOMON_CHECK_OP(<=, a, b)
