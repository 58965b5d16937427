// SPDX-License-Identifier: Apache-2.0
// The lists of members by which structures shared with shaders are checked.
#include <gtest/gtest.h>

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(vk_test)
struct Inner {
    vec2 offset;
    float list[3];
};
struct Outer {
    uint first;
    Inner inner;
    vec3 rows[2];
};
GNOMON_MEMBERS(Inner, offset, list)
GNOMON_MEMBERS(Outer, first, inner, rows)
}

namespace gnomon::vk_test {
namespace {

TEST(SharedMembers, ListNamesOffsetsSizesAndStridesOfNestedMembers)
{
    const auto list = shared_members(static_cast<const shared::Outer*>(nullptr));
    const vk::SharedMember expected[] = {
        {"first", 0, 4, 0}, {"inner.offset", 4, 8, 0}, {"inner.list", 12, 12, 4}, {"rows", 24, 24, 12}};
    ASSERT_EQ(list.size(), std::size(expected));
    for (std::size_t i = 0; i < list.size(); ++i) {
        EXPECT_EQ(list[i].name, expected[i].name);
        EXPECT_EQ(list[i].offset, expected[i].offset);
        EXPECT_EQ(list[i].size, expected[i].size);
        EXPECT_EQ(list[i].stride, expected[i].stride);
    }
}

}   // namespace
}   // namespace gnomon::vk_test
