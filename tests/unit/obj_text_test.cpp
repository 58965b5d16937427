// SPDX-License-Identifier: Apache-2.0
#include "io/obj/text.h"

#include <gtest/gtest.h>

#include "gnomon/error.h"

namespace gnomon::io {
namespace {

TEST(ObjText, SplitsStatementsWordsAndNames)
{
    ObjText text("t", "# comment\r\n\n  v 1 2\t3 # four\r\nusemtl  two  words \t\r\no #1\nlast");
    EXPECT_EQ(text.next_statement(), "v");
    EXPECT_EQ(text.line(), 3u);
    EXPECT_EQ(text.number("x"), 1);
    EXPECT_EQ(text.number("x"), 2);
    EXPECT_FALSE(text.at_end());
    EXPECT_EQ(text.number("x"), 3);
    EXPECT_TRUE(text.at_end());
    EXPECT_EQ(text.next_statement(), "usemtl");
    EXPECT_EQ(text.rest(), "two  words");
    EXPECT_EQ(text.next_statement(), "o");
    EXPECT_EQ(text.rest(), "#1");
    EXPECT_EQ(text.next_statement(), "last");
    EXPECT_EQ(text.rest(), "");
    EXPECT_EQ(text.next_statement(), "");
    EXPECT_EQ(text.next_statement(), "");
}

TEST(ObjText, JoinsContinuedLines)
{
    ObjText text("t", "f 1 \\\n 2 \\\r\n3\nunknown a \\\nv 9\nv 4");
    EXPECT_EQ(text.next_statement(), "f");
    for (const float expected : {1.0f, 2.0f, 3.0f}) EXPECT_EQ(text.number("n"), expected);
    EXPECT_TRUE(text.at_end());
    EXPECT_EQ(text.place(), "3:1");
    EXPECT_EQ(text.next_statement(), "unknown");
    EXPECT_EQ(text.next_statement(), "v");   // not the one inside the continued line
    EXPECT_EQ(text.line(), 6u);
    EXPECT_EQ(text.number("n"), 4);
}

TEST(ObjText, ReadsNumbersStrictly)
{
    const auto read = [](std::string_view words) {
        ObjText text("file.obj", words);
        text.next_statement();
        return text.number("a coordinate");
    };
    EXPECT_EQ(read("v .8e-1"), 0.08f);
    EXPECT_EQ(read("v -.5"), -0.5f);
    EXPECT_EQ(read("v +2"), 2);
    EXPECT_EQ(read("v 7."), 7);
    EXPECT_EQ(read("v 1e-400"), 0);
    for (const char* bad : {"v nan", "v inf", "v -inf", "v 1e39", "v 1e999", "v 1,5", "v x", "v 1x", "v +-1", "v",
                            "v 0x10", "v 1.#QNAN", "v --1"}) {
        try {
            read(bad);
            FAIL() << bad;
        } catch (const InputError& error) {
            EXPECT_EQ(error.file(), "file.obj");
            EXPECT_EQ(error.place().substr(0, 2), "1:") << bad;
        }
    }
}

TEST(ObjText, RefusesZeroBytes)
{
    EXPECT_THROW(ObjText("t", std::string_view("v 1\0 2", 6)), InputError);
}

}   // namespace
}   // namespace gnomon::io
