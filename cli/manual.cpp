// SPDX-License-Identifier: Apache-2.0
#include "cli/manual.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <vector>

#include "gnomon/version.h"
#include "options/option_table.h"

namespace gnomon::cli {

namespace {

bool shown(const options::Option& option)
{
    return option.built;
}

std::string_view choices_of(const options::Option& option)
{
    if (option.kind != options::Kind::choice) return {};
    return option.built_choices.empty() ? option.choices : option.built_choices;
}

std::string replaced(const std::string& text, std::string_view from, std::string_view to)
{
    std::string result;
    for (std::size_t at = 0;;) {
        const std::size_t next = text.find(from, at);
        result.append(text, at, next - at);
        if (next == std::string::npos) return result;
        result.append(to);
        at = next + from.size();
    }
}

// Escapes text for a manual page: a backslash begins a command, and so does a dot or a quote at the beginning of a
// line; a plain hyphen may be set as a character that cannot be copied to a shell.
std::string roff(std::string_view text)
{
    std::string result = replaced(replaced(std::string(text), "\\", "\\e"), "-", "\\-");
    const bool command = result.starts_with('.') || result.starts_with('\'');
    return command ? fmt::format("\\&{}", result) : result;
}

std::string roff_option(const options::Option& option)
{
    std::string text = ".TP\n.B ";
    if (option.letter) text += fmt::format("\\-{}\\fR, \\fB", option.letter);
    text += roff(fmt::format("--{}", option.name));
    const std::string_view choices = choices_of(option);
    const std::string argument = roff(choices.empty() ? option.argument : choices);
    if (option.kind == options::Kind::optional_file)
        text += fmt::format("\\fR[=\\fI{}\\fR]", argument);
    else if (!argument.empty())
        text += fmt::format(" \\fI{}\\fR", argument);
    text += fmt::format("\n{}", roff(option.help));
    if (!option.fallback.empty()) text += fmt::format(" ({})", roff(option.fallback));
    return text + "\n";
}

std::vector<std::string_view> words_of(std::string_view text, char between)
{
    std::vector<std::string_view> words;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find(between), text.size());
        if (end > 0) words.push_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return words;
}

// The first words of all subcommands, each once.
std::vector<std::string> first_words()
{
    std::vector<std::string> words;
    for (const options::SubcommandInfo& subcommand : options::subcommands()) {
        const std::string word(words_of(subcommand.name, ' ')[0]);
        if (subcommand.built && std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
    }
    return words;
}

// The second words of the subcommands that begin with `first`, such as "bench".
std::vector<std::string> second_words(std::string_view first)
{
    std::vector<std::string> words;
    for (const options::SubcommandInfo& subcommand : options::subcommands()) {
        const auto parts = words_of(subcommand.name, ' ');
        if (subcommand.built && parts.size() > 1 && parts[0] == first) words.emplace_back(parts[1]);
    }
    return words;
}

// The built options of a subcommand, in the order of the table.
std::vector<const options::Option*> options_of(options::Subcommand subcommand)
{
    std::vector<const options::Option*> list;
    for (const options::Option& option : options::options())
        if (shown(option) && (option.subcommands & bit(subcommand))) list.push_back(&option);
    return list;
}

// Turns "render an image" into "Renders an image."
std::string sentence(std::string_view summary)
{
    const std::size_t end = std::min(summary.find(' '), summary.size());
    return fmt::format("{}{}s{}.", static_cast<char>(std::toupper(static_cast<unsigned char>(summary.front()))),
                       summary.substr(1, end - 1), summary.substr(end));
}

std::string single_quoted(std::string_view text)
{
    return fmt::format("'{}'", replaced(std::string(text), "'", "'\\''"));
}

constexpr std::string_view k_scenes = "builtin:cornell builtin:kinetic builtin:spheres";

}   // namespace

std::string manual_page()
{
    std::string text = fmt::format(
        ".TH GNOMON 1 \"\" \"gnomon {}\" \"User Commands\"\n.SH NAME\ngnomon \\- render animated 3D scenes, "
        "recomputing only the lighting that changed\n.SH SYNOPSIS\n",
        version());
    for (const options::SubcommandInfo& subcommand : options::subcommands())
        if (subcommand.built)
            text += fmt::format(".B gnomon {}\n{}{}[options]\n.br\n", subcommand.name, roff(subcommand.arguments),
                                subcommand.arguments.empty() ? "" : " ");
    text +=
        ".SH DESCRIPTION\nSCENE is a file (.gltf, .glb, .obj, .ply, .stl, .aff), or builtin:cornell, builtin:kinetic, "
        "builtin:spheres?objects=300&dynamic=10. Defaults are given in parentheses.\n";
    for (const options::SubcommandInfo& subcommand : options::subcommands()) {
        if (!subcommand.built) continue;
        text += fmt::format(".SH \"GNOMON {}\"\n{}\n", roff(subcommand.name), roff(sentence(subcommand.summary)));
        std::string_view group;
        for (const options::Option* option : options_of(subcommand.subcommand)) {
            if (option->group == "Everywhere") continue;
            if (option->group != group) text += fmt::format(".SS {}\n", roff(option->group));
            group = option->group;
            text += roff_option(*option);
        }
    }
    text += ".SH \"EVERYWHERE\"\n";
    for (const options::Option* option : options_of(options::Subcommand::info))
        if (option->group == "Everywhere") text += roff_option(*option);
    text +=
        ".SH EXIT STATUS\n0 success; 1 a comparison or check failed; 2 invalid arguments; 3 invalid input file; 4 a "
        "device, a driver, ffmpeg or disk space is missing; 5 internal error; 130 interrupted. Every failure prints "
        "one line on standard error and leaves no partial output file.\n";
    return text;
}

// Like the manual page, but also with subcommands and options that are not built, so that the page is the same for
// every build.
std::string options_page()
{
    std::string text =
        "# Options\n\nThis page lists every option of every subcommand. It is generated from the table that also gives "
        "`gnomon SUBCOMMAND --help`,\nthe manual page, the shell completions and the viewer's panel. Defaults are "
        "given in parentheses.\n[Choosing options](README.md#choosing-options) says which options suit which task.\n";
    const auto add_row = [&](const options::Option& option) {
        std::string name = fmt::format("--{}", option.name);
        if (option.letter) name = fmt::format("-{}, {}", option.letter, name);
        const std::string_view argument = option.kind == options::Kind::choice ? option.choices : option.argument;
        if (!argument.empty())
            name += option.kind == options::Kind::optional_file ? fmt::format("[={}]", argument)
                                                                : fmt::format(" {}", argument);
        std::string help(option.help);
        if (!option.fallback.empty()) help += fmt::format(" ({})", option.fallback);
        const auto cell = [](const std::string& words) { return replaced(words, "|", "\\|"); };
        text += fmt::format("| `{}` | {} |\n", cell(name), replaced(cell(help), "*", "\\*"));
    };
    constexpr std::string_view k_table = "\n| | |\n|---|---|\n";
    for (const options::SubcommandInfo& subcommand : options::subcommands()) {
        text += fmt::format("\n## gnomon {}{}{}\n\n{}\n", subcommand.name, subcommand.arguments.empty() ? "" : " ",
                            subcommand.arguments, sentence(subcommand.summary));
        std::string_view group;
        for (const options::Option& option : options::options()) {
            if (!(option.subcommands & bit(subcommand.subcommand)) || option.group == "Everywhere") continue;
            if (option.group != group) text += fmt::format("\n**{}**\n{}", option.group, k_table);
            group = option.group;
            add_row(option);
        }
    }
    text += fmt::format("\n## Everywhere\n{}", k_table);
    for (const options::Option& option : options::options())
        if ((option.subcommands & bit(options::Subcommand::info)) && option.group == "Everywhere") add_row(option);
    return text;
}

std::string bash_completion()
{
    // Complete the subcommand, which has two words after "bench".
    std::string text =
        "# bash completion for gnomon\n"
        "_gnomon()\n{\n"
        "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} subcommand=${COMP_WORDS[1]}\n"
        "    [[ $subcommand == bench && $COMP_CWORD -gt 2 ]] && subcommand=\"bench ${COMP_WORDS[2]}\"\n"
        "    COMPREPLY=()\n"
        "    if [[ $COMP_CWORD -eq 1 ]]; then\n";
    text +=
        fmt::format("        COMPREPLY=($(compgen -W \"{} --help --version\" -- \"$cur\"))\n        return\n    fi\n",
                    fmt::join(first_words(), " "));
    text += fmt::format(
        "    if [[ $COMP_CWORD -eq 2 && $subcommand == bench ]]; then\n"
        "        COMPREPLY=($(compgen -W \"{}\" -- \"$cur\"))\n        return\n    fi\n",
        fmt::join(second_words("bench"), " "));

    // Complete the choices of the previous option.
    text += "    case \"$subcommand $prev\" in\n";
    for (const options::SubcommandInfo& subcommand : options::subcommands()) {
        if (!subcommand.built) continue;
        for (const options::Option* option : options_of(subcommand.subcommand)) {
            const std::string_view choices = choices_of(*option);
            if (choices.empty()) continue;
            text += fmt::format("        \"{} --{}\") COMPREPLY=($(compgen -W \"{}\" -- \"$cur\")); return ;;\n",
                                subcommand.name, option->name, replaced(std::string(choices), "|", " "));
        }
    }

    // Complete the names of options, else files and built-in scenes.
    text += "    esac\n    if [[ $cur == -* ]]; then\n        case \"$subcommand\" in\n";
    for (const options::SubcommandInfo& subcommand : options::subcommands()) {
        if (!subcommand.built) continue;
        std::string names;
        for (const options::Option* option : options_of(subcommand.subcommand))
            names += fmt::format(" --{}", option->name);
        text += fmt::format("            \"{}\") COMPREPLY=($(compgen -W \"{}\" -- \"$cur\")) ;;\n", subcommand.name,
                            names.substr(1));
    }
    text += "        esac\n        return\n    fi\n";
    text += fmt::format("    COMPREPLY=($(compgen -f -- \"$cur\") $(compgen -W \"{}\" -- \"$cur\"))\n}}\n", k_scenes);
    text += "complete -o filenames -F _gnomon gnomon\n";
    return text;
}

std::string zsh_completion()
{
    // Complete the subcommand, which has two words after "bench".
    std::string text =
        "#compdef gnomon\n"
        "_gnomon() {\n"
        "    local subcommand=$words[2]\n"
        "    if (( CURRENT == 2 )); then\n";
    text += fmt::format("        compadd {} --help --version\n        return\n    fi\n", fmt::join(first_words(), " "));
    text += fmt::format(
        "    if [[ $subcommand == bench ]]; then\n"
        "        if (( CURRENT == 3 )); then\n            compadd {}\n            return\n        fi\n"
        "        subcommand=\"bench $words[3]\"\n    fi\n",
        fmt::join(second_words("bench"), " "));

    // Complete the choices of the previous option.
    text += "    case \"$subcommand $words[CURRENT-1]\" in\n";
    for (const options::SubcommandInfo& subcommand : options::subcommands()) {
        if (!subcommand.built) continue;
        for (const options::Option* option : options_of(subcommand.subcommand))
            if (const std::string_view choices = choices_of(*option); !choices.empty())
                text += fmt::format("        \"{} --{}\") compadd {}; return ;;\n", subcommand.name, option->name,
                                    replaced(std::string(choices), "|", " "));
    }

    // Complete the names of options, else files and built-in scenes.
    text += "    esac\n    if [[ $words[CURRENT] == -* ]]; then\n        case $subcommand in\n";
    for (const options::SubcommandInfo& subcommand : options::subcommands()) {
        if (!subcommand.built) continue;
        std::string names;
        for (const options::Option* option : options_of(subcommand.subcommand))
            names += fmt::format(" --{}", option->name);
        text += fmt::format("            \"{}\") compadd --{} ;;\n", subcommand.name, names);
    }
    text += fmt::format("        esac\n        return\n    fi\n    compadd -Q {}\n    _files\n}}\n_gnomon \"$@\"\n",
                        k_scenes);
    return text;
}

std::string fish_completion()
{
    // Complete the subcommand, which has two words after "bench".
    std::string text("# fish completion for gnomon\n");
    for (const std::string& word : first_words()) {
        std::string_view summary = word == "bench" ? "run a benchmark" : "";
        for (const options::SubcommandInfo& subcommand : options::subcommands())
            if (subcommand.name == word) summary = subcommand.summary;
        text += fmt::format("complete -c gnomon -n __fish_use_subcommand -a {} -d {}\n", word, single_quoted(summary));
    }
    text += fmt::format(
        "complete -c gnomon -n '__fish_seen_subcommand_from bench; and not __fish_seen_subcommand_from {0}' -f -a "
        "'{0}'\n",
        fmt::join(second_words("bench"), " "));

    // Describe the options of each subcommand with their choices.
    for (const options::SubcommandInfo& subcommand : options::subcommands()) {
        if (!subcommand.built) continue;
        std::string when;
        for (const std::string_view word : words_of(subcommand.name, ' '))
            when += fmt::format("{}__fish_seen_subcommand_from {}", when.empty() ? "" : "; and ", word);
        for (const options::Option* option : options_of(subcommand.subcommand)) {
            text += fmt::format("complete -c gnomon -n '{}' -l {}", when, option->name);
            if (option->letter) text += fmt::format(" -s {}", option->letter);
            const std::string_view choices = choices_of(*option);
            if (!choices.empty())
                text += fmt::format(" -x -a '{}'", replaced(std::string(choices), "|", " "));
            else if (option->kind != options::Kind::flag && option->kind != options::Kind::optional_file)
                text += " -r";
            text += fmt::format(" -d {}\n", single_quoted(option->help));
        }
    }
    return text;
}

}   // namespace gnomon::cli
