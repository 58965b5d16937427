// SPDX-License-Identifier: Apache-2.0
#include "io/file/scene_folder.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/one_line.h"

namespace gnomon::io {

namespace {

constexpr std::size_t k_most_entries = 20'000;   // of a folder that is searched

std::string in_lower_case(std::string text)
{
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

// The entry of a folder whose name is the same but for the case of letters; the first of several in the order of names.
std::string entry_like(const std::filesystem::path& folder, const std::string& name)
{
    const std::string wanted = in_lower_case(name);
    std::string found;
    std::error_code error;
    std::size_t left = k_most_entries;
    for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end && left > 0;
         at.increment(error), --left) {
        std::string entry = at->path().filename().string();
        if (in_lower_case(entry) == wanted && (found.empty() || entry < found)) found = std::move(entry);
    }
    return found;
}

}   // namespace

std::string name_like(const std::filesystem::path& folder, const std::string& name)
{
    namespace fs = std::filesystem;
    std::string plain = name;
    std::replace(plain.begin(), plain.end(), '\\', '/');
    if (plain.size() > 1 && plain.front() == '"' && plain.back() == '"') plain = plain.substr(1, plain.size() - 2);
    if (plain.empty() || plain.back() == '/') return {};   // a folder
    const bool elsewhere = fs::path(plain).is_absolute() || (plain.size() > 1 && plain[1] == ':');
    std::error_code error;
    if (!elsewhere && fs::exists(folder / plain, error) && !error) return plain;

    // Follow the path with letters of either case, then look for the file's name alone.
    const auto follow = [&](const fs::path& path) {
        fs::path done;
        for (const fs::path& part : path) {
            if (part == "." || part.empty()) continue;
            const std::string entry =
                fs::exists(folder / done / part, error) ? part.string() : entry_like(folder / done, part.string());
            if (entry.empty() || part == "..") return std::string();
            done /= entry;
        }
        return done.string();
    };
    if (!elsewhere)
        if (std::string found = follow(plain); !found.empty()) return found;
    return follow(fs::path(plain.substr(plain.find_last_of("/:") + 1)));
}

SceneFolder::SceneFolder(const std::filesystem::path& scene_file)
{
    std::error_code error;
    folder_ = std::filesystem::canonical(scene_file.has_parent_path() ? scene_file.parent_path() : ".", error);
    if (error) folder_.clear();
}

std::optional<std::filesystem::path> SceneFolder::find(std::string name, std::string& problem) const
{
    std::replace(name.begin(), name.end(), '\\', '/');
    if (folder_.empty()) return problem = "does not exist", std::nullopt;
    const bool has_drive = name.size() > 1 && name[1] == ':';
    std::filesystem::path found;
    if (has_drive)
        problem = "is an absolute path";
    else
        found = resolve_inside(folder_, name, {folder_}, problem);
    if (!found.empty()) return found;

    // Look for a file that was probably meant, which must lie in the folder as well.
    if (name.find('\0') != std::string::npos) return std::nullopt;
    const std::string likely = name_like(folder_, name);
    std::string why;
    if (!likely.empty()) found = resolve_inside(folder_, likely, {folder_}, why);
    if (found.empty()) return std::nullopt;
    problem += fmt::format(": '{}' is read instead", one_line(likely));
    return found;
}

}   // namespace gnomon::io
