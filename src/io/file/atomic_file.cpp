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

// The file that a chain of symbolic links names; it need not exist.
fs::path followed(const fs::path& asked)
{
    constexpr int k_most_links = 40;   // as the kernel's
    fs::path file = asked;
    std::error_code error;
    for (int links = 0; fs::is_symlink(fs::symlink_status(file, error)); ++links) {
        if (links == k_most_links) fail(asked, ELOOP);
        const fs::path next = fs::read_symlink(file, error);
        if (error) fail(asked, error.value());
        file = next.is_absolute() ? next : file.parent_path() / next;
    }
    return file;
}

// Writes a file or a folder from the system's memory to the disk. Returns 0 or the error.
int sync(const fs::path& path, int flags)
{
    const int descriptor = ::open(path.empty() ? "." : path.c_str(), O_RDONLY | O_CLOEXEC | flags);
    if (descriptor < 0) return errno;
    int error = 0;
    while (::fsync(descriptor) != 0 && (error = errno) == EINTR) error = 0;
    ::close(descriptor);
    return error == EINVAL || error == ENOTSUP ? 0 : error;   // of file systems that have nothing to sync
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
    // Reject devices and pipes, because renaming would replace them.
    std::error_code ignored;
    const fs::file_status status = fs::status(target, ignored);
    if (fs::is_directory(status)) fail(asked_, EISDIR);
    if (fs::exists(status) && !fs::is_regular_file(status))
        throw MissingError(fmt::format("cannot write {}: not an ordinary file", asked_.string()));
    // Resolve symbolic links: renaming would replace the link, not its target.
    target_ = followed(target);

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
    // Sync the contents before the name, and by name: a program that wrote to the file may have replaced it.
    if (const int error = sync(temporary_, 0)) fail(asked_, error);
    if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail(asked_, errno);
    committed_ = true;
    if (const int error = sync_folder(target_.parent_path())) fail(asked_, error);
}

int sync_folder(const fs::path& folder)
{
    const int error = sync(folder, O_DIRECTORY);
    return error == EACCES ? 0 : error;   // a folder that may be written, but not read
}

}   // namespace gnomon::io
