// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/context.h"

#include <fmt/format.h>

#include "gnomon/error.h"

namespace gnomon::io::gltf {

void Context::fail(const std::string& pointer, const std::string& problem) const
{
    throw InputError(file_, pointer.empty() ? "/" : pointer, problem);
}

void Context::warn(const std::string& pointer, const std::string& problem)
{
    // Count the same problem at other places, so that each cause is one warning.
    for (Warning& known : warnings_)
        if (known.problem == problem) {
            ++known.number;
            return;
        }
    if (warnings_.size() >= limits.warnings) {
        ++omitted_;
        return;
    }
    warnings_.push_back({pointer.empty() ? "/" : pointer, problem, 1});
}

std::vector<std::string> Context::take_warnings()
{
    std::vector<std::string> all = repairs_.warnings();
    for (const Warning& warning : warnings_)
        all.push_back(warning.number == 1
                          ? fmt::format("{}: {}", warning.first, warning.problem)
                          : fmt::format("{} and {} more: {}", warning.first, warning.number - 1, warning.problem));
    if (omitted_ > 0) all.push_back(fmt::format("{} further warnings were omitted", omitted_));
    omitted_ = 0;
    warnings_.clear();
    return all;
}

std::string at(const std::string& pointer, std::string_view name)
{
    constexpr std::size_t longest = 120;   // longer names are cut in messages
    const bool cut = name.size() > longest;
    std::string result = pointer + '/';
    for (const char c : name.substr(0, longest)) {
        if (c == '~')
            result += "~0";
        else if (c == '/')
            result += "~1";
        else
            result += c;
    }
    return cut ? result + "..." : result;
}

std::string at(const std::string& pointer, std::uint64_t index)
{
    return pointer + '/' + std::to_string(index);
}

}   // namespace gnomon::io::gltf
