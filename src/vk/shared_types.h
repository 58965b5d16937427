// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_VK_SHARED_TYPES_H
#define GNOMON_VK_SHARED_TYPES_H
// GLSL's type names for the host, used by the `*_shared.h` headers that C++ and GLSL both include. Blocks have the
// `scalar` layout, which equals C++'s; pipelines still check every member against the shader, by the lists that
// GNOMON_MEMBERS makes.

#ifdef __cplusplus
#include <cstdint>

#include "base/math.h"
#include "vk/shared_members.h"

namespace gnomon::vk::shared {
using uint = std::uint32_t;
using vec2 = glm::vec2;
using vec3 = glm::vec3;
using vec4 = glm::vec4;
using uvec2 = glm::uvec2;
using uvec3 = glm::uvec3;
using uvec4 = glm::uvec4;
using ivec2 = glm::ivec2;
using mat3 = glm::mat3;
using mat4 = glm::mat4;
}   // namespace gnomon::vk::shared
// Opens and closes the namespace of a shared header; empty in GLSL.
#define GNOMON_SHARED_BEGIN(room)    \
    namespace gnomon::room::shared { \
    using namespace gnomon::vk::shared;
#define GNOMON_SHARED_END }
#else
#define GNOMON_SHARED_BEGIN(room)
#define GNOMON_SHARED_END
#endif

#endif
