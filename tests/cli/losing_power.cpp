// SPDX-License-Identifier: Apache-2.0
// A disk that loses power, for the program to meet: preloaded, it takes away what the program did not sync.
//
// GNOMON_POWER_FAILS_AT=N     at the Nth rename, counted from 1, by SIGKILL; without it, when the program ends
// GNOMON_SYNCS_DO_NOTHING=1   nothing is synced: what a program that forgets it would leave
//
// File systems may keep what was not synced, or lose it; here it is always lost. A file whose name was not synced is
// removed, and one whose contents were not is empty.
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Inode = std::pair<dev_t, ino_t>;

struct Name {
    fs::path path;
    Inode folder;   // that contains it
    bool is_folder = false, synced = false;
};

struct Disk {
    std::mutex mutex;
    std::set<Inode> synced;   // contents
    std::vector<Name> names;
    int renames = 0;
};

Disk& disk()
{
    static Disk* const one = new Disk;   // never destroyed: the program ends before
    return *one;
}

template <class Function>
Function* real(const char* name)
{
    return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

Inode inode_of(const struct stat& status)
{
    return {status.st_dev, status.st_ino};
}

void note_name(const char* path, bool is_folder)
{
    std::error_code ignored;
    Name name{fs::absolute(path, ignored), {}, is_folder};
    struct stat folder {};
    if (::stat(name.path.parent_path().c_str(), &folder) == 0) name.folder = inode_of(folder);
    disk().names.push_back(std::move(name));
}

// The caller holds the mutex, and keeps it: nothing is written afterwards.
void lose()
{
    std::error_code ignored;
    for (const Name& name : disk().names) {
        struct stat status {};
        if (!name.synced)
            fs::remove_all(name.path, ignored);
        else if (!name.is_folder && ::stat(name.path.c_str(), &status) == 0 &&
                 !disk().synced.contains(inode_of(status)))
            static_cast<void>(!::truncate(name.path.c_str(), 0));
    }
    disk().names.clear();
}

__attribute__((destructor)) void lose_at_the_end()
{
    const std::scoped_lock lock(disk().mutex);
    lose();
}

}   // namespace

extern "C" {

ssize_t write(int file, const void* data, size_t size)
{
    static auto* const original = real<ssize_t(int, const void*, size_t)>("write");
    struct stat status {};
    {
        const std::scoped_lock lock(disk().mutex);
        if (!disk().synced.empty() && ::fstat(file, &status) == 0) disk().synced.erase(inode_of(status));
    }
    return original(file, data, size);
}

int fsync(int file)
{
    if (::getenv("GNOMON_SYNCS_DO_NOTHING")) return 0;
    struct stat status {};
    if (::fstat(file, &status) != 0) return -1;
    const std::scoped_lock lock(disk().mutex);
    disk().synced.insert(inode_of(status));
    for (Name& name : disk().names) name.synced = name.synced || name.folder == inode_of(status);
    return 0;
}

int rename(const char* from, const char* to) noexcept
{
    static auto* const original = real<int(const char*, const char*)>("rename");
    const std::scoped_lock lock(disk().mutex);
    if (const int result = original(from, to)) return result;
    note_name(to, false);
    const char* const fails_at = ::getenv("GNOMON_POWER_FAILS_AT");
    if (++disk().renames == (fails_at ? std::atoi(fails_at) : 0)) {
        lose();
        ::kill(::getpid(), SIGKILL);
    }
    return 0;
}

int mkdir(const char* path, mode_t mode) noexcept
{
    static auto* const original = real<int(const char*, mode_t)>("mkdir");
    const std::scoped_lock lock(disk().mutex);
    const int result = original(path, mode);
    if (result == 0) note_name(path, true);
    return result;
}

void _exit(int status)
{
    lose_at_the_end();
    for (;;) ::syscall(SYS_exit_group, status);
}

void _Exit(int status) noexcept
{
    _exit(status);
}

}   // extern "C"
