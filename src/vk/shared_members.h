// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lists of the members of structures that C++ and GLSL share, so that a pipeline can check every one of them against
// the shader's reflection. GNOMON_MEMBERS stands next to each structure of a `*_shared.h`; it fails to compile where a
// member is left out, and a structure without it cannot be expected of a shader (vk/shader.h, shared_block).

#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

namespace gnomon::vk {

/// A member of a structure; those of a structure within it as "outer.inner".
struct SharedMember {
    std::string name;
    std::size_t offset = 0, size = 0;
    std::size_t stride = 0;   // of arrays, from one element to the next; else 0
};

template <class Member>
void add_shared_member(std::vector<SharedMember>& list, const std::string& name, std::size_t offset)
{
    if constexpr (std::is_array_v<Member>)
        list.push_back({name, offset, sizeof(Member), sizeof(std::remove_extent_t<Member>)});
    else if constexpr (requires(const Member* m) { shared_members(m); })
        for (const SharedMember& inner : shared_members(static_cast<const Member*>(nullptr)))
            list.push_back({name + "." + inner.name, offset + inner.offset, inner.size, inner.stride});
    else
        list.push_back({name, offset, sizeof(Member), 0});
}

}   // namespace gnomon::vk

// For each of up to 64 arguments: step(Struct, argument). [Recursion by __VA_OPT__]
#define GNOMON_EACH_4(...) __VA_ARGS__
#define GNOMON_EACH_3(...) GNOMON_EACH_4(GNOMON_EACH_4(GNOMON_EACH_4(GNOMON_EACH_4(__VA_ARGS__))))
#define GNOMON_EACH_2(...) GNOMON_EACH_3(GNOMON_EACH_3(GNOMON_EACH_3(GNOMON_EACH_3(__VA_ARGS__))))
#define GNOMON_EACH_1(...) GNOMON_EACH_2(GNOMON_EACH_2(GNOMON_EACH_2(GNOMON_EACH_2(__VA_ARGS__))))
#define GNOMON_EACH_NEXT(step, Struct, first, ...) \
    step(Struct, first) __VA_OPT__(GNOMON_EACH_AGAIN GNOMON_EACH_PARENS(step, Struct, __VA_ARGS__))
#define GNOMON_EACH_AGAIN() GNOMON_EACH_NEXT
#define GNOMON_EACH_PARENS ()
#define GNOMON_EACH(step, Struct, ...) GNOMON_EACH_1(GNOMON_EACH_NEXT(step, Struct, __VA_ARGS__))

#define GNOMON_ADD_SIZE(Struct, member) +sizeof(Struct::member)
#define GNOMON_ADD_MEMBER(Struct, member) \
    gnomon::vk::add_shared_member<decltype(Struct::member)>(list, #member, offsetof(Struct, member));

/// All members of a shared structure, in order. Blocks have the scalar layout and members of 4-byte scalars, hence no
/// padding: sizes that do not add up mean that a member is missing from the list.
#define GNOMON_MEMBERS(Struct, ...)                                                        \
    static_assert((0 GNOMON_EACH(GNOMON_ADD_SIZE, Struct, __VA_ARGS__)) == sizeof(Struct), \
                  "GNOMON_MEMBERS(" #Struct ") lacks a member");                           \
    inline std::vector<gnomon::vk::SharedMember> shared_members(const Struct*)             \
    {                                                                                      \
        std::vector<gnomon::vk::SharedMember> list;                                        \
        GNOMON_EACH(GNOMON_ADD_MEMBER, Struct, __VA_ARGS__)                                \
        return list;                                                                       \
    }
