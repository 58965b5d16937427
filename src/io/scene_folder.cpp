// SPDX-License-Identifier: Apache-2.0
#include "io/scene_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "gnomon/error.h"

namespace gnomon::io {

namespace fs = std::filesystem;

namespace {
struct Descriptor {
    int value = -1;
    ~Descriptor()
    {
        if (value >= 0) close(value);
    }
};
}   // namespace

SceneFolder::SceneFolder(const fs::path& scene_file)
{
    std::error_code error;
    const fs::path parent = scene_file.has_parent_path() ? scene_file.parent_path() : fs::path(".");
    folder_ = fs::canonical(parent, error);
    if (error) folder_.clear();
}

std::optional<fs::path> SceneFolder::find(std::string name, std::string& problem) const
{
    std::replace(name.begin(), name.end(), '\\', '/');
    const fs::path relative(name);
    if (name.empty()) return problem = "has no name", std::nullopt;
    if (relative.is_absolute() || (name.size() > 1 && name[1] == ':'))
        return problem = "has an absolute path: only the scene's own folder may be read", std::nullopt;
    if (folder_.empty()) return problem = "cannot be found", std::nullopt;

    // Resolve links first: what counts is where the file really lies.
    std::error_code error;
    const fs::path resolved = fs::canonical(folder_ / relative, error);
    const auto leaves = [&] {
        const fs::path lexical = (folder_ / relative).lexically_normal();
        return std::mismatch(folder_.begin(), folder_.end(), lexical.begin(), lexical.end()).first != folder_.end();
    };
    if (error && leaves()) return problem = "lies outside the scene's folder", std::nullopt;
    if (error) return problem = "cannot be found", std::nullopt;
    if (std::mismatch(folder_.begin(), folder_.end(), resolved.begin(), resolved.end()).first != folder_.end())
        return problem = "lies outside the scene's folder", std::nullopt;
    if (!fs::is_regular_file(resolved, error)) return problem = "is not a regular file", std::nullopt;
    return resolved;
}

std::string read_whole_file(const fs::path& file, const std::string& shown_name, std::uint64_t limit)
{
    const auto refuse = [&](const std::string& what) { throw InputError(shown_name, "", what); };

    // Look before opening: to open a FIFO is to wait, to open a device may do anything.
    struct stat status {};
    if (stat(file.c_str(), &status) != 0) refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
    if (!S_ISREG(status.st_mode)) refuse("is not a regular file");
    const Descriptor in{open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)};
    if (in.value < 0) refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
    if (fstat(in.value, &status) != 0 || !S_ISREG(status.st_mode)) refuse("is not a regular file");
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size > limit) refuse(fmt::format("is too large: {} bytes, the limit is {}", size, limit));

    std::string bytes(size, '\0');
    std::size_t have = 0;
    while (have < bytes.size()) {
        const ssize_t got = read(in.value, bytes.data() + have, bytes.size() - have);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
        if (got == 0) break;
        have += static_cast<std::size_t>(got);
    }
    bytes.resize(have);
    return bytes;
}

}   // namespace gnomon::io
