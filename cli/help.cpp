// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "cli/command_line.h"
#include "gnomon/version.h"

namespace gnomon::cli {

namespace {
constexpr std::size_t k_width = 100;
constexpr std::size_t k_column = 32;   // column at which explanations begin

// Breaks text at blanks into lines of at most k_width columns; all but the first are indented.
std::string wrapped(const std::string& text, std::size_t indent)
{
    std::string result;
    std::size_t used = indent;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(' ', at), text.size());
        const std::size_t length = end - at;
        if (at > 0 && used + 1 + length > k_width) {
            result += "\n" + std::string(indent, ' ');
            used = indent;
        } else if (at > 0) {
            result += ' ';
            ++used;
        }
        result += text.substr(at, length);
        used += length;
        at = end + 1;
    }
    return result;
}

// A name and its explanation.
std::string row(const std::string& left, const std::string& right)
{
    std::string text = "  " + left;
    if (text.size() + 2 > k_column) {
        text += "\n" + std::string(k_column, ' ');
    } else {
        text.resize(k_column, ' ');
    }
    return text + wrapped(right, k_column) + "\n";
}

std::string left_of(const options::Option& option)
{
    std::string text = option.letter ? fmt::format("-{}, ", option.letter) : "    ";
    text += fmt::format("--{}", option.name);
    if (option.kind == options::Kind::optional_file) return text + fmt::format("[={}]", option.argument);
    if (option.kind == options::Kind::choice)
        return text + " " + (option.choices.size() < 22 ? std::string(option.choices) : std::string(option.argument));
    return option.argument.empty() ? text : fmt::format("{} {}", text, option.argument);
}

std::string right_of(const options::Option& option)
{
    std::string text(option.help);
    if (option.kind == options::Kind::choice && option.choices.size() >= 22)
        text += fmt::format(": {}", option.choices);
    if (!option.fallback.empty()) text += fmt::format(" ({})", option.fallback);
    if (!option.built) text += "; not built yet";
    if (!option.built_choices.empty()) text += fmt::format("; built so far: {}", option.built_choices);
    return text;
}
}   // namespace

std::string help_text(const options::SubcommandInfo* subcommand)
{
    std::string text;
    if (!subcommand) {
        text = fmt::format(
            "gnomon {}: renders animated 3D scenes, caches their lighting and recomputes only what changed\n\n"
            "usage: gnomon SUBCOMMAND ...\n\n",
            version());
        for (const options::SubcommandInfo& each : options::subcommands())
            text += row(std::string(each.name) + (each.arguments.empty() ? "" : " ") + std::string(each.arguments),
                        std::string(each.summary) + (each.built ? "" : "; not built yet"));
        return text +
               "\ngnomon SCENE shows it, as gnomon view SCENE does.\n"
               "gnomon SUBCOMMAND --help explains the options of a subcommand.\n"
               "SCENE: a file, or builtin:cornell, builtin:kinetic, builtin:spheres?objects=300&dynamic=10.\n"
               "Exit codes: 0 success, 1 a comparison or check failed, 2 invalid arguments, 3 invalid input file,\n"
               "4 a device, a driver, ffmpeg or disk space is missing, 5 internal error, 130 interrupted.\n";
    }
    text = fmt::format("gnomon {}: {}\n\nusage: gnomon {} {}{}[options]\n", subcommand->name, subcommand->summary,
                       subcommand->name, subcommand->arguments, subcommand->arguments.empty() ? "" : " ");
    std::string_view group;
    for (const options::Option& option : options::options()) {
        if (!(option.subcommands & bit(subcommand->subcommand))) continue;
        if (option.group != group) text += fmt::format("\n{}\n", option.group);
        group = option.group;
        text += row(left_of(option), right_of(option));
    }
    return text + "\nDefaults are given in parentheses.\n";
}

}   // namespace gnomon::cli
