// SPDX-License-Identifier: Apache-2.0
#pragma once
// Writes a file atomically: under a temporary name in the target's folder, which is then renamed.
//
// Errors of write and close are reported, which is where file systems report a full disk. A committed file is on the
// disk, and so is its name: it survives a loss of power.

#include <cstddef>
#include <filesystem>
#include <string_view>

namespace gnomon::io {

class AtomicFile {
 public:
    /// Creates the temporary file.
    /// @throws MissingError  with the reason: the folder is not writable, or the target is not a regular file
    explicit AtomicFile(const std::filesystem::path& target) : AtomicFile(target, {}) {}
    /// The same with the temporary file in another folder, if a rename from there is possible, so that files left by a
    /// killed process are all in one place. If `folder` is empty, the target's is used.
    AtomicFile(const std::filesystem::path& target, const std::filesystem::path& folder);
    /// Removes the temporary file if it was not committed.
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// @throws MissingError
    void write(const void* data, std::size_t size);
    void write(std::string_view text) { write(text.data(), text.size()); }

    /// For programs that write to a file by name; they may replace it.
    const std::filesystem::path& temporary() const { return temporary_; }

    /// Renames the temporary file to its final name, and waits until both are on the disk. Nothing may be written
    /// afterwards.
    /// @throws MissingError
    void commit();

 private:
    std::filesystem::path asked_;    // as given by the caller, for messages
    std::filesystem::path target_;   // symbolic links followed
    std::filesystem::path temporary_;
    int descriptor_ = -1;
    bool committed_ = false;
};

/// Waits until the names of a folder's files are on the disk. An empty path is the current folder.
/// @return 0, or the number of the error
int sync_folder(const std::filesystem::path& folder);

/// The prefix of all temporary names.
inline constexpr std::string_view k_temporary_prefix = ".gnomon-";

}   // namespace gnomon::io
