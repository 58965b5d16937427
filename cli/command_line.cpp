// SPDX-License-Identifier: Apache-2.0
#include "cli/command_line.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <filesystem>

#include "gnomon/error.h"
#include "options/presets.h"

namespace gnomon::cli {

namespace {
constexpr const char* k_standard_output = "-";

// Removes the name of the subcommand from the front of `words`. "bench culling" is two words; a scene in its place
// means "view".
const options::SubcommandInfo& take_subcommand(std::vector<std::string>& words)
{
    // A scene alone is shown.
    std::error_code none;
    if (words.front().starts_with("builtin:") || std::filesystem::is_regular_file(words.front(), none))
        if (!options::find_subcommand(words.front())) return *options::find_subcommand("view");
    std::string name = words.front();
    words.erase(words.begin());
    if (name == "bench") {
        if (words.empty() || words.front().starts_with("-"))
            throw UsageError("bench needs the name of a benchmark, such as 'bench trace'; see gnomon --help");
        name += " " + words.front();
        words.erase(words.begin());
    }
    if (const options::SubcommandInfo* subcommand = options::find_subcommand(name)) return *subcommand;
    std::vector<std::string> names;
    for (const options::SubcommandInfo& subcommand : options::subcommands()) names.emplace_back(subcommand.name);
    const std::string near = options::nearest(name, names);
    throw UsageError(fmt::format("no subcommand '{}'{}", name,
                                 near.empty() ? "; see gnomon --help" : fmt::format("; did you mean '{}'?", near)));
}

// Throws at the first word that looks like an option.
void refuse_unknown(const options::SubcommandInfo& subcommand, const std::vector<std::string>& words)
{
    for (const std::string& word : words) {
        if (!word.starts_with("-") || word == "-") continue;
        const std::string name = word.substr(0, word.find('='));
        std::vector<std::string> names;
        for (const options::Option& option : options::options())
            if (option.subcommands & bit(subcommand.subcommand)) names.push_back(fmt::format("--{}", option.name));
        const std::string near = options::nearest(name, names);
        throw UsageError(fmt::format("{} has no option {}{}", subcommand.name, name,
                                     near.empty() ? fmt::format("; see gnomon {} --help", subcommand.name)
                                                  : fmt::format("; did you mean {}?", near)));
    }
}

// CLI11 accepts "--resume=no" as --resume and "--json=" as --json.
void refuse_value(const options::Option& option, const std::vector<std::string>& results,
                  const std::vector<std::string>& words)
{
    if (option.kind == options::Kind::flag)
        for (const std::string& result : results)
            if (result != "true") throw UsageError(fmt::format("--{} takes no value, got '{}'", option.name, result));
    if (option.kind == options::Kind::optional_file &&
        std::count(words.begin(), words.end(), fmt::format("--{}=", option.name)))
        throw UsageError(fmt::format("--{}=: a value is missing", option.name));
}

CLI::Option* add(CLI::App& parser, const options::Option& option)
{
    std::string names = fmt::format("--{}", option.name);
    if (option.kind == options::Kind::optional_file)
        return parser.add_flag(fmt::format("{}{{{}}}", names, k_standard_output));
    if (option.letter) names += fmt::format(",-{}", option.letter);
    if (option.kind == options::Kind::flag) return parser.add_flag(names);
    return parser.add_option(names)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)->allow_extra_args(false);
}

// Rewrites "--method paper certified" as "--method paper --method certified", and likewise "--objects 25 50" and
// "--method visible rsm:256". A further word belongs to an option that repeats if it is one of the option's choices,
// begins with one and a colon, or is a number where the option takes numbers.
void expand_lists(std::vector<std::string>& words)
{
    const auto among = [](const std::string& word, std::string_view choices) {
        return !word.empty() && word.find('|') == std::string::npos &&
               ("|" + std::string(choices) + "|").find("|" + word + "|") != std::string::npos;
    };
    const auto belongs = [&](const std::string& word, const options::Option& option) {
        if (option.kind == options::Kind::integer_or_all && word == "all") return true;
        if (option.kind == options::Kind::integer || option.kind == options::Kind::integer_or_all ||
            option.kind == options::Kind::number)
            return options::parse_number(word).has_value();
        return among(option.kind == options::Kind::text ? word.substr(0, word.find(':')) : word, option.choices);
    };
    for (const options::Option& option : options::options()) {
        if (!option.repeats) continue;
        const std::string flag = "--" + std::string(option.name);
        for (std::size_t i = 0; i + 2 < words.size(); ++i)
            if (words[i] == flag && words[i + 1] != flag && belongs(words[i + 2], option))
                words.insert(words.begin() + static_cast<std::ptrdiff_t>(i) + 2, flag);
    }
}
}   // namespace

CommandLine parse_command_line(const std::vector<std::string>& arguments)
{
    CommandLine line;
    line.command = "gnomon";
    for (const std::string& word : arguments) line.command += " " + options::shell_word(word);
    std::vector<std::string> words = arguments;
    if (words.empty()) throw UsageError("a subcommand is missing; see gnomon --help");
    if (words.front() == "--version") return line.version = true, line;
    if (words.front() == "--help" || words.front() == "-h" || words.front() == "help") return line.help = true, line;
    line.subcommand = &take_subcommand(words);
    line.values = options::OptionValues(line.subcommand->subcommand);

    // Set aside the words after "--", which are no options whatever they begin with.
    const auto dashes = std::find(words.begin(), words.end(), "--");
    const std::vector<std::string> plain(dashes == words.end() ? dashes : dashes + 1, words.end());
    words.erase(dashes, words.end());
    expand_lists(words);

    // Build a parser for this subcommand's options from the table.
    CLI::App parser;
    parser.set_help_flag();
    parser.allow_extras();
    std::vector<std::pair<const options::Option*, CLI::Option*>> known;
    for (const options::Option& option : options::options())
        if (option.subcommands & bit(line.subcommand->subcommand)) known.emplace_back(&option, add(parser, option));
    try {
        parser.parse(std::vector<std::string>(words.rbegin(), words.rend()));   // CLI11 expects them in reverse order
    } catch (const CLI::ArgumentMismatch& error) {
        const std::string text = error.what();   // "--out: 1 required ..."
        throw UsageError(fmt::format("{}: a value is missing", text.substr(0, text.find(':'))));
    } catch (const CLI::ParseError& error) {
        throw UsageError(fmt::format("{}: {}", line.subcommand->name, error.what()));
    }

    // Check the results, unknown options first because their values look like positional arguments.
    std::vector<std::string> rest = parser.remaining();
    refuse_unknown(*line.subcommand, rest);
    rest.insert(rest.end(), plain.begin(), plain.end());
    for (const auto& [option, parsed] : known) {
        if (parsed->count() == 0) continue;
        refuse_value(*option, parsed->results(), words);
        if (option->name == "help") line.help = true;
        if (option->name == "version") line.version = true;
    }
    if (line.help || line.version) return line;
    if (!line.subcommand->built) throw UsageError(fmt::format("{}: not built yet", line.subcommand->name));

    // Store the values and the positional arguments; the --config file sets only options that were not given.
    for (const auto& [option, parsed] : known)
        if (parsed->count() > 0) line.values.set(*option, parsed->results());
    line.positionals = rest;
    if (line.positionals.size() != static_cast<std::size_t>(line.subcommand->positionals))
        throw UsageError(fmt::format("{} takes {} argument{} and got {}: gnomon {} {}", line.subcommand->name,
                                     line.subcommand->positionals, line.subcommand->positionals == 1 ? "" : "s",
                                     line.positionals.size(), line.subcommand->name, line.subcommand->arguments));
    if (line.values.given("config")) read_config(line.values.text("config"), *line.subcommand, line.values);
    if (options::find_option(line.subcommand->subcommand, "preset")) options::apply_preset(line.values);
    return line;
}

}   // namespace gnomon::cli
