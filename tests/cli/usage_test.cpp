// SPDX-License-Identifier: Apache-2.0
// Wrong usage: exit code 2 and one helpful line.
#include "gnomon/version.h"
#include "options/option_table.h"
#include "options/option_values.h"
#include "run_program.h"

namespace gnomon::test {
namespace {

struct Wrong {
    std::vector<std::string> arguments;
    std::string about;
};

TEST(Usage, EveryUsageErrorIsOneLineAndExitCode2)
{
    const ScratchFolder folder;
    const std::string out = folder / "out.png";
    const std::string scene = "builtin:cornell";
    const ScratchFolder scenes;
    const std::string slow = scenes / "slow.aff";   // 5 frames in 40,000 s
    std::ofstream(slow) << "a 0 40000 5\n";
    const std::vector<Wrong> mistakes = {
        {{}, "--help"},
        {{""}, "--help"},
        {{"rendr", scene}, "did you mean 'render'"},
        {{"bench"}, "--help"},
        {{"bench", "trase", scene}, "did you mean 'bench trace'"},
        {{"bench", "all"}, "--report DIR"},
        {{"render"}, "render SCENE -o OUT"},
        {{"render", scene}, "-o OUT"},
        {{"render", scene, scene, "-o", out}, "takes 1 argument"},
        {{"render", scene, "-o"}, "a value is missing"},
        {{"render", scene, "-o", ""}, "--out"},
        {{"render", scene, "-o", out, "--sizes", "8x8"}, "did you mean --size?"},
        {{"render", scene, "-o", out, "--frobnicate"}, "--frobnicate"},
        {{"render", scene, "-o", out, "-x"}, "-x"},
        {{"render", scene, "-o", out, "--size", "8"}, "WxH"},
        {{"render", scene, "-o", out, "--size", "30000x30000"}, "million pixels"},
        {{"render", scene, "-o", out, "--size", "0x8"}, "WxH"},
        {{"render", scene, "-o", out, "--size", "8x8x8"}, "WxH"},
        {{"render", scene, "-o", out, "--size", "99999999999x8"}, "WxH"},
        {{"render", scene, "-o", out, "--samples", "0"}, "1 to 4096"},
        {{"render", scene, "-o", out, "--ids"}, "--ids needs .exr output"},
        {{"render", scene, "-o", out, "--motion"}, "--motion needs .exr output"},
        {{"render", scene, "-o", out, "--samples", "2.5"}, "whole number"},
        {{"render", scene, "-o", out, "--samples", "1", "--samples", "2"}, "given 2 times"},
        {{"render", scene, "-o", out, "--max-depth", "65"}, "0 to 64"},
        {{"render", scene, "-o", out, "--exposure", "bright"}, "auto, auto-frame or a number"},
        {{"render", scene, "-o", out, "--exposure", "nan"}, "auto, auto-frame or a number"},
        {{"render", scene, "-o", out, "--tonemap", "video"}, "none, neutral, agx or aces"},
        {{"render", scene, "-o", out, "--frame", "0"}, "from 1"},
        {{"render", scene, "-o", out, "--frame", "41"}, "1 to 40"},
        {{"render", scene, "-o", out, "--frames", "5-4"}, "A-B"},
        {{"render", scene, "-o", out, "--frames", "1-2"}, "2 frames need a name"},
        {{"render", scene, "-o", out, "--frame", "1", "--frames", "1-2"}, "exclude each other"},
        {{"render", scene, "-o", out, "--chunk", "3/2"}, "I/N"},
        {{"render", scene, "-o", out, "--camera", "none such"}, "none such"},
        {{"bench", "trace", scene, "--camera", "none such"}, "none such"},
        {{"bench", "culling", scene, "--camera", "1"}, "'1'"},
        {{"bench", "indirect", scene, "--camera", "none such"}, "none such"},
        {{"bench", "indirect", scene, "--max-depth", "3"}, "no option --max-depth"},
        {{"render", scene, "-o", out, "--light", "spot 1 2 3"}, "3 numbers instead of 10"},
        {{"render", scene, "-o", out, "--light", "point 0 0 0 1 1 x"}, "'x'"},
        {{"render", scene, "-o", out, "--light", "sun 0 0 0"}, "unknown kind"},
        {{"render", scene, "-o", out, "--light", "spot 0 0 0 0 0 0 30 1 1 1"}, "no length"},
        {{"render", scene, "-o", out, "--light", "spot 0 0 0 0 0 1 91 1 1 1"}, "half-angle"},
        {{"render", scene, "-o", out, "--threads", "-1"}, "0 to 1024"},
        {{"render", scene, "-o", out, "--turntable", "0"}, "--turntable"},
        {{"render", scene, "-o", folder / "out.bmp"}, ".png, .jpg, .exr"},
        {{"render", scene, "-o", folder / "out"}, ".png, .jpg, .exr"},
        {{"render", scene, "-o", folder / "{frame:4}.png"}, "{frame:04}"},
        {{"render", scene, "-o", folder / "{frame:04}.mp4"}, "leave out"},
        {{"render", scene, "-o", folder / "a.mp4", "--size", "1x16"}, "2 to 16385 a side"},
        {{"render", scene, "-o", folder / "a.mp4", "--size", "2x16386", "--chunk", "1/2"}, "2 to 16385 a side"},
        {{"render", slow, "-o", folder / "a.mp4"}, "0.0001 frames a second"},
        {{"info", slow, "--json=" + scenes.path().string() + "/./slow.aff"}, "which is read"},
        {{"compare", slow, slow, "--heatmap", slow}, "which is read"},
        {{"render", scene, "-o", out, "--contact-sheet", folder / "./out.png"}, "would overwrite an image"},
        {{"render", scene, "-o", folder / "{frame}.png", "--contact-sheet", folder / "7.png"},
         "would overwrite an image"},
        {{"render", scene, "-o", out, "--resume=no"}, "--resume takes no value"},
        {{"render", scene, "-o", out, "--quiet=5"}, "--quiet takes no value"},
        {{"render", scene, "-o", out, "--json="}, "a value is missing"},
        {{"info", "--", scene, "--json"}, "takes 1 argument"},
        {{"render", "builtin:nothing", "-o", out}, "nothing"},
        {{"info", folder / "scene.xyz"}, "xyz"},
        {{"compare", out}, "takes 2 arguments"},
        {{"compare", out, out, "--fail-above", "rmse"}, "METRIC=X"},
        {{"compare", out, out, "--fail-above", "beauty=1"}, "METRIC=X"},
        {{"compare", out, out, "--metric", "beauty"}, "flip"},
        {{"devices", "extra"}, "takes 0 arguments"},
    };
    for (const Wrong& wrong : mistakes) {
        SCOPED_TRACE(testing::PrintToString(wrong.arguments));
        expect_failure(run(wrong.arguments), 2, wrong.about);
    }
    EXPECT_TRUE(names_in(folder.path()).empty());
}

// The first of an option's choices that is not built.
std::string unbuilt_choice(const options::Option& option)
{
    const auto among = [](const std::string& choice, std::string_view list) {
        return ("|" + std::string(list) + "|").find("|" + choice + "|") != std::string::npos;
    };
    std::istringstream choices{std::string(option.choices)};
    for (std::string choice; std::getline(choices, choice, '|');)
        if (!among(choice, option.built_choices)) return choice;
    return {};
}

TEST(Usage, NothingAfterTwoDashesIsAnOption)
{
    expect_failure(run({"info", "--json", "--", "-no-such-scene.obj"}), 3, "-no-such-scene.obj: cannot be opened");
    EXPECT_EQ(run({"info", "--json", "--", "builtin:cornell"}).json()["frames"], 40);
}

TEST(Usage, RefusesChoicesThatAreNotBuilt)
{
    const ScratchFolder folder;
    const std::string out = folder / "out.png";
    for (const options::Option& option : options::options()) {
        if (!(option.subcommands & options::bit(options::Subcommand::render))) continue;
        std::vector<std::string> arguments{"render", "builtin:cornell", "-o", out, "--" + std::string(option.name)};
        if (!option.built) {
            if (option.kind != options::Kind::flag)
                arguments.emplace_back(option.fallback.empty() ? "1" : option.fallback);
            SCOPED_TRACE(option.name);
            expect_failure(run(arguments), 2, "not built yet");
        } else if (!option.built_choices.empty()) {
            arguments.push_back(unbuilt_choice(option));
            SCOPED_TRACE(option.name);
            expect_failure(run(arguments), 2, "not built yet; built: ");
        }
    }
    EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(Usage, DefaultsAreValidAndBuilt)
{
    for (const options::Option& option : options::options()) {
        if (!option.built || option.fallback.empty()) continue;
        EXPECT_NO_THROW(options::check_value(option, std::string(option.fallback))) << option.name;
    }
}

TEST(Usage, HelpListsEveryOptionWithinTheLineWidth)
{
    for (const options::SubcommandInfo& subcommand : options::subcommands()) {
        std::vector<std::string> arguments;
        const std::size_t blank = subcommand.name.find(' ');
        arguments.emplace_back(subcommand.name.substr(0, blank));
        if (blank != std::string_view::npos) arguments.emplace_back(subcommand.name.substr(blank + 1));
        arguments.emplace_back("--help");
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0);
        EXPECT_EQ(outcome.err, "");
        for (const options::Option& option : options::options()) {
            const std::size_t at =
                outcome.out.find("  --" + std::string(option.name) + (option.argument.empty() ? "" : " "));
            const bool short_form = outcome.out.find(", --" + std::string(option.name)) != std::string::npos;
            const bool with_file = outcome.out.find("  --" + std::string(option.name) + "[=") != std::string::npos;
            EXPECT_EQ(at != std::string::npos || short_form || with_file,
                      options::find_option(subcommand.subcommand, option.name) != nullptr)
                << subcommand.name << " " << option.name;
        }
        for (std::size_t at = 0; at < outcome.out.size();) {
            const std::size_t end = outcome.out.find('\n', at);
            EXPECT_LE(end - at, 100u) << outcome.out.substr(at, end - at);
            at = end + 1;
        }
    }
}

TEST(Usage, VersionAndHelpNeedNoSubcommand)
{
    EXPECT_EQ(run({"--version"}).out, "gnomon " + std::string(version()) + "\n");
    EXPECT_EQ(run({"info", "--version"}).out, run({"--version"}).out);
    const Outcome help = run({"--help"});
    EXPECT_EQ(help.code, 0);
    for (const options::SubcommandInfo& subcommand : options::subcommands())
        EXPECT_NE(help.out.find(subcommand.name), std::string::npos) << subcommand.name;
}

TEST(Usage, SuggestsTheNearestWord)
{
    const std::vector<std::string> words{"render", "info", "devices"};
    EXPECT_EQ(options::nearest("rendre", words), "render");
    EXPECT_EQ(options::nearest("inf", words), "info");
    EXPECT_EQ(options::nearest("xyzzy", words), "");
    EXPECT_EQ(options::nearest("", words), "");
}

TEST(Usage, ParsesValuesStrictly)
{
    EXPECT_EQ(options::parse_size("640x480"), (Size{640, 480}));
    EXPECT_EQ(options::parse_range("3-9"), (FrameRange{3, 9}));
    EXPECT_EQ(options::parse_range("3"), (FrameRange{3, 3}));
    EXPECT_EQ(options::parse_chunk("2/5")->of, 5);
    EXPECT_EQ(options::parse_number("-2.5e1"), -25.0);
    for (const char* wrong : {"", "x", "1x", "x1", "1x-1", "1 x1", "0x0", "1,x1"})
        EXPECT_FALSE(options::parse_size(wrong)) << wrong;
    for (const char* wrong : {"", "-", "1-", "-1", "0-2", "2-1", "1-2-3", "a"})
        EXPECT_FALSE(options::parse_range(wrong)) << wrong;
    for (const char* wrong : {"", "/", "0/1", "2/1", "1/", "1"}) EXPECT_FALSE(options::parse_chunk(wrong)) << wrong;
    for (const char* wrong : {"", "inf", "nan", "1e999", "1.", "0x10", "1 "})
        EXPECT_EQ(options::parse_number(wrong).has_value(), std::string(wrong) == "1.") << wrong;
}

}   // namespace
}   // namespace gnomon::test
