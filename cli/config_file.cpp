// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "cli/command_line.h"
#include "gnomon/error.h"

namespace gnomon::cli {

namespace {
constexpr std::uintmax_t k_limit = 1 << 20;   // largest size of a --config file, in bytes

std::string word_of(const nlohmann::json& value)
{
    return value.is_string() ? value.get<std::string>() : value.dump();
}
}   // namespace

void read_config(const std::filesystem::path& file, const options::SubcommandInfo& subcommand,
                 options::OptionValues& values)
{
    // Read the file and parse it.
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error) throw InputError(file.string(), "", error.message());
    if (size > k_limit)
        throw InputError(file.string(), "", fmt::format("the file has {} bytes; the limit is {}", size, k_limit));
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    nlohmann::json document;
    try {
        document = nlohmann::json::parse(text);
    } catch (const nlohmann::json::parse_error& problem) {
        throw InputError(file.string(), fmt::format("byte {}", problem.byte), "invalid JSON");
    } catch (const nlohmann::json::exception&) {   // the exception carries no position
        throw InputError(file.string(), "", "a number is out of range");
    }
    if (!document.is_object()) throw InputError(file.string(), "", "expected a JSON object of options");

    // Set each option that the command line does not give.
    for (const auto& [key, value] : document.items()) {
        const std::string place = "/" + key;
        const options::Option* option = options::find_option(subcommand.subcommand, key);
        if (!option || key == "config" || key == "help" || key == "version") {
            std::vector<std::string> names;
            for (const options::Option& candidate : options::options())
                if ((candidate.subcommands & bit(subcommand.subcommand)) && candidate.name != key)
                    names.emplace_back(candidate.name);
            const std::string near = options::nearest(key, names);
            throw InputError(file.string(), place,
                             fmt::format("{} has no such option{}", subcommand.name,
                                         near.empty() ? "" : fmt::format("; did you mean '{}'?", near)));
        }

        // Convert the value to words: a flag is a boolean, a repeated option an array, any other a string or a number.
        std::vector<std::string> words;
        if (option->kind == options::Kind::flag ||
            (option->kind == options::Kind::optional_file && value.is_boolean())) {
            if (!value.is_boolean()) throw InputError(file.string(), place, "expected true or false");
            if (!value.get<bool>()) continue;
            words.emplace_back(option->kind == options::Kind::flag ? "true" : "-");
        } else if (value.is_array() && option->repeats) {
            for (const nlohmann::json& element : value) {
                if (!element.is_string()) throw InputError(file.string(), place, "expected an array of strings");
                words.push_back(element.get<std::string>());
            }
        } else if (value.is_string() || value.is_number()) {
            words.push_back(word_of(value));
        } else {
            throw InputError(file.string(), place, fmt::format("expected {}", option->argument));
        }
        if (values.given(key) || words.empty()) continue;   // the command line takes precedence
        try {
            values.set(*option, std::move(words));
        } catch (const UsageError& problem) {
            throw InputError(file.string(), place, problem.what());
        }
    }
}

}   // namespace gnomon::cli
