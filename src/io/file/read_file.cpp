// SPDX-License-Identifier: Apache-2.0
#include "io/file/read_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "base/interruption.h"
#include "gnomon/error.h"

namespace gnomon::io {

namespace {
constexpr std::size_t k_piece = std::size_t{1} << 24;   // bytes between interruption points

struct Descriptor {
    int fd;
    ~Descriptor()
    {
        if (fd >= 0) close(fd);
    }
};
}   // namespace

std::vector<std::uint8_t> read_whole_file(const std::filesystem::path& file, const std::string& shown_as,
                                          std::uint64_t limit)
{
    // Open without blocking, because opening a FIFO without a writer would wait forever.
    const Descriptor descriptor{open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)};
    if (descriptor.fd < 0) throw InputError(shown_as, "", fmt::format("cannot be opened: {}", std::strerror(errno)));
    struct stat status {};
    if (fstat(descriptor.fd, &status) != 0 || !S_ISREG(status.st_mode))
        throw InputError(shown_as, "", "is not a regular file");
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size > limit)
        throw InputError(shown_as, "", fmt::format("has {} bytes, more than the {} allowed", size, limit));

    std::vector<std::uint8_t> bytes(size);
    std::size_t done = 0;
    while (done < bytes.size()) {
        interruption_point();
        const ssize_t got = read(descriptor.fd, bytes.data() + done, std::min(bytes.size() - done, k_piece));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw InputError(shown_as, "", fmt::format("cannot be read: {}", std::strerror(errno)));
        if (got == 0) break;
        done += static_cast<std::size_t>(got);
    }
    bytes.resize(done);
    return bytes;
}

std::filesystem::path resolve_inside(const std::filesystem::path& folder, const std::string& name,
                                     const std::vector<std::filesystem::path>& roots, std::string& why)
{
    namespace fs = std::filesystem;
    why.clear();
    if (name.empty() || name.find('\0') != std::string::npos) {
        why = "is not a file name";
        return {};
    }
    const fs::path relative(name);
    if (relative.is_absolute()) {
        why = "is an absolute path; only files below the scene's folder are opened";
        return {};
    }
    std::error_code error;
    fs::path real = fs::canonical(folder / relative, error);
    if (error) {
        why = error == std::errc::no_such_file_or_directory ? "does not exist" : error.message();
        return {};
    }
    const bool inside = std::any_of(roots.begin(), roots.end(), [&](const fs::path& root) {
        return std::mismatch(root.begin(), root.end(), real.begin(), real.end()).first == root.end();
    });
    if (!inside) {
        why = "lies outside the scene's folder";
        return {};
    }
    if (!fs::is_regular_file(real, error)) {
        why = "is not a regular file";
        return {};
    }
    return real;
}

}   // namespace gnomon::io
