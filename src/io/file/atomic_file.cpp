// SPDX-License-Identifier: Apache-2.0
#include "io/file/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "gnomon/error.h"

namespace gnomon::io {

namespace fs = std::filesystem;

namespace {
[[noreturn]] void fail(const fs::path& file, int error)
{
    throw MissingError(fmt::format("cannot write {}: {}", file.string(), std::strerror(error)));
}

// Whether a file can be renamed from one folder to the other.
bool on_one_disk(const fs::path& a, const fs::path& b)
{
    struct stat of_a {
    }, of_b{};
    const auto name = [](const fs::path& folder) { return folder.empty() ? "." : folder.c_str(); };
    return ::stat(name(a), &of_a) == 0 && ::stat(name(b), &of_b) == 0 && of_a.st_dev == of_b.st_dev;
}

// The name is short, whatever the target's is, and unique across files and processes.
fs::path temporary_in(const fs::path& folder)
{
    static std::atomic<unsigned> count{0};
    return folder / fmt::format("{}{}-{}.tmp", k_temporary_prefix, ::getpid(), count++);
}
}   // namespace

AtomicFile::AtomicFile(const fs::path& target, const fs::path& folder) : asked_(target), target_(target)
{
    if (target.filename().empty()) throw MissingError(fmt::format("cannot write '{}': no file name", target.string()));
    // Resolve symbolic links: renaming would replace the link, not its target.
    std::error_code error, ignored;
    if (fs::is_symlink(target, ignored)) target_ = fs::weakly_canonical(target, error);
    if (error) fail(asked_, error.value());
    // Reject devices and pipes, because renaming would replace them.
    const fs::file_status status = fs::status(target_, ignored);
    if (fs::is_directory(status)) fail(asked_, EISDIR);
    if (fs::exists(status) && !fs::is_regular_file(status))
        throw MissingError(fmt::format("cannot write {}: not an ordinary file", asked_.string()));

    const bool elsewhere = !folder.empty() && on_one_disk(folder, target_.parent_path());
    do {
        temporary_ = temporary_in(elsewhere ? folder : target_.parent_path());
        descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (descriptor_ < 0 && (errno == EEXIST || errno == EINTR));
    if (descriptor_ < 0) fail(asked_, errno);
}

AtomicFile::~AtomicFile()
{
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!committed_) ::unlink(temporary_.c_str());
}

void AtomicFile::write(const void* data, std::size_t size)
{
    const char* p = static_cast<const char*>(data);
    while (size > 0) {
        const ssize_t n = ::write(descriptor_, p, size);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail(asked_, errno);
        p += n;
        size -= static_cast<std::size_t>(n);
    }
}

void AtomicFile::commit()
{
    const int descriptor = descriptor_;
    descriptor_ = -1;
    if (::close(descriptor) != 0 && errno != EINTR) fail(asked_, errno);
    if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail(asked_, errno);
    committed_ = true;
}

}   // namespace gnomon::io
