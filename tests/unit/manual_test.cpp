// SPDX-License-Identifier: Apache-2.0
// The documentation of options is complete and matches the table.
#include "cli/manual.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>
#include <vector>

#include "options/option_table.h"
#include "places.h"

namespace gnomon::cli {
namespace {

TEST(Manual, ManPageDocumentsEveryOption)
{
    const std::string manual = manual_page(), bash = bash_completion(), zsh = zsh_completion(),
                      fish = fish_completion();
    for (const options::Option& option : options::options()) {
        if (!option.built) continue;
        const std::string name(option.name);
        std::string escaped;
        for (const char c : "--" + name) escaped += c == '-' ? "\\-" : std::string(1, c);
        const std::string bold = option.letter ? "\\fB" : ".B ";   // after its letter
        EXPECT_NE(manual.find(bold + escaped), std::string::npos) << name;
        EXPECT_NE(bash.find("--" + name), std::string::npos) << name;
        EXPECT_NE(zsh.find("--" + name), std::string::npos) << name;
        EXPECT_NE(fish.find(" -l " + name + " "), std::string::npos) << name;
    }
}

// Help and guide list options in the order of the table.
TEST(Manual, OptionsOfAGroupAreContiguous)
{
    for (const options::SubcommandInfo& subcommand : options::subcommands()) {
        std::vector<std::string_view> groups;
        for (const options::Option& option : options::options())
            if ((option.subcommands & bit(subcommand.subcommand)) && (groups.empty() || groups.back() != option.group))
                groups.push_back(option.group);
        const std::set<std::string_view> different(groups.begin(), groups.end());
        EXPECT_EQ(groups.size(), different.size()) << subcommand.name;
    }
}

// `gnomon_documents FOLDER` regenerates the page.
TEST(Manual, OptionsPageOfTheGuideIsUpToDate)
{
    std::ostringstream page;
    page << std::ifstream(gnomon::test::places::source_folder + "/docs/guide/options.md").rdbuf();
    EXPECT_EQ(page.str(), options_page()) << "build gnomon_documents, and let it write options.md";
}

TEST(Manual, OptionsOfTheBlenderAddOnAreTheOnesOfTheTable)
{
    std::ostringstream table;
    table << std::ifstream(gnomon::test::places::source_folder + "/blender/gnomon_render/options.json").rdbuf();
    EXPECT_EQ(table.str(), options_json()) << "build gnomon_documents, and let it write options.json";
}

}   // namespace
}   // namespace gnomon::cli
