// SPDX-License-Identifier: Apache-2.0
// The options of `gnomon render` as JSON, for hosts that show them in panels of their own.
#include <nlohmann/json.hpp>

#include "cli/manual.h"
#include "options/option_table.h"

namespace gnomon::cli {

namespace {

const char* name_of(options::Kind kind)
{
    using enum options::Kind;
    switch (kind) {
        case integer:
            return "integer";
        case integer_or_auto:
            return "integer_or_auto";
        case integer_or_all:
            return "integer_or_all";
        case number:
            return "number";
        case number_or_auto:
            return "number_or_auto";
        case choice:
            return "choice";
        case flag:
            return "flag";
        default:
            return "text";
    }
}

}   // namespace

std::string options_json()
{
    nlohmann::ordered_json table = nlohmann::ordered_json::object();
    for (const options::Option& option : options::options()) {
        if (!option.built || (option.subcommands & options::bit(options::Subcommand::render)) == 0) continue;
        table[std::string(option.name)] = {
            {"kind", name_of(option.kind)}, {"fallback", option.fallback},
            {"choices", option.choices},    {"range", {option.range.low, option.range.high}},
            {"group", option.group},        {"help", option.help},
        };
    }
    return table.dump(2) + "\n";
}

}   // namespace gnomon::cli
