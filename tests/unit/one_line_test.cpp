// SPDX-License-Identifier: Apache-2.0
// Names and messages contain nothing that changes a terminal.
#include "base/one_line.h"

#include <gtest/gtest.h>

#include "gnomon/error.h"

namespace gnomon {
namespace {

TEST(OneLine, KeepsText)
{
    for (const char* text : {"", "plain", "h\xc3\xa9h\xc3\xa9", "\xe6\x97\xa5\xe6\x9c\xac", "\xf0\x9f\x8c\x8d",
                             "a\xc2\xa0"
                             "b"})
        EXPECT_EQ(one_line(text), text);
}

TEST(OneLine, ReplacesControls)
{
    EXPECT_EQ(one_line("a\x1b[31m\r\n\t\x7f"
                       "b"),
              "a?[31m????b");
    EXPECT_EQ(one_line("\xc2\x9b"
                       "31m\xc2\x85"),
              "?31m?")
        << "U+009B and U+0085";
    EXPECT_EQ(one_line(std::string("a\0b", 3)), "a?b");
}

TEST(OneLine, ReplacesMarksOfDirectionAndSeparators)
{
    for (const char* mark : {"\xe2\x80\xae", "\xe2\x80\xaa", "\xe2\x81\xa6", "\xe2\x81\xa9", "\xe2\x80\x8e",
                             "\xe2\x80\x8f", "\xd8\x9c", "\xe2\x80\xa8", "\xe2\x80\xa9"})
        EXPECT_EQ(one_line(std::string("a") + mark + "b"), "a?b");
    EXPECT_EQ(one_line("\xe2\x80\xaf"), "\xe2\x80\xaf") << "U+202F is a space";
}

TEST(OneLine, ReplacesEveryByteThatIsNotUtf8)
{
    EXPECT_EQ(one_line("a\x9b"
                       "31m"),
              "a?31m")
        << "a control of 8 bits";
    EXPECT_EQ(one_line("\xe9t\xe9"), "?t?") << "Latin-1";
    EXPECT_EQ(one_line("\xc0\x9b"), "??") << "a longer form of U+001B";
    EXPECT_EQ(one_line("\xe0\x82\x9b"), "???") << "a longer form of U+009B";
    EXPECT_EQ(one_line("\xed\xa0\x80"), "???") << "a surrogate";
    EXPECT_EQ(one_line("\xf4\x90\x80\x80"), "????") << "above U+10FFFF";
    EXPECT_EQ(one_line("\xe6\x97"), "??") << "cut off";
    EXPECT_EQ(one_line("\xff"), "?");
}

TEST(OneLine, AppliesToEveryError)
{
    EXPECT_STREQ(UsageError("no '\x1b[2J\n'").what(), "no '?[2J?'");
    EXPECT_STREQ(MissingError("\x9b").what(), "?");
    EXPECT_STREQ(InputError("a\nb", "1:2", "c\xe2\x80\xae").what(), "a?b:1:2: c?");
}

TEST(ShownName, IsShort)
{
    const std::string name = shown_name(std::string(100, 'a'));
    EXPECT_EQ(name, std::string(57, 'a') + "...");
    EXPECT_EQ(shown_name(std::string(56, 'a') + "\xc3\xa9\xc3\xa9\xc3\xa9"), std::string(56, 'a') + "...");
}

}   // namespace
}   // namespace gnomon
