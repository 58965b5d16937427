// SPDX-License-Identifier: Apache-2.0
#pragma once
// Compares two frames layer by layer, to the bit.

#include <gtest/gtest.h>

#include <cstring>

#include "gnomon/frame.h"

namespace gnomon::test {

inline void expect_same(const Frame& got, const Frame& expected)
{
    ASSERT_EQ(got.layers.size(), expected.layers.size());
    for (std::size_t l = 0; l < got.layers.size(); ++l) {
        const Layer &a = got.layers[l], &b = expected.layers[l];
        ASSERT_EQ(a.name, b.name);
        if (a.format == PixelFormat::u32) {
            const auto x = a.ids(), y = b.ids();
            EXPECT_TRUE(std::equal(x.begin(), x.end(), y.begin(), y.end())) << "layer '" << a.name << "'";
            continue;
        }
        const auto x = a.values(), y = b.values();
        ASSERT_EQ(x.size(), y.size());
        std::size_t different = 0;
        for (std::size_t i = 0; i < x.size(); ++i) different += std::memcmp(&x[i], &y[i], sizeof(float)) != 0;
        EXPECT_EQ(different, 0u) << "of " << x.size() << " values of layer '" << a.name << "'";
    }
}

}   // namespace gnomon::test
