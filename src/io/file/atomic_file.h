// SPDX-License-Identifier: Apache-2.0
#pragma once
// A file that is whole or not there: written under a temporary name in the target's folder, then renamed.
//
// Errors of write and close are reported, which is where file systems say that a disk is full. There is no fsync: after
// a power failure a file may be empty, and readers that care check what they find (see is_whole_png).

#include <cstddef>
#include <filesystem>
#include <string_view>

namespace gnomon::io {

class AtomicFile {
 public:
    /// Creates the temporary file.
    /// @throws MissingError, with the reason, if the folder cannot be written or the target is no ordinary file
    explicit AtomicFile(const std::filesystem::path& target) : AtomicFile(target, {}) {}
    /// The same, with the temporary file in another folder where a rename from there is possible: what a killed process
    /// leaves is then found where its other leavings are. The folder may be empty: beside the target.
    AtomicFile(const std::filesystem::path& target, const std::filesystem::path& folder);
    /// Removes the temporary file if it was not committed.
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// @throws MissingError
    void write(const void* data, std::size_t size);
    void write(std::string_view text) { write(text.data(), text.size()); }

    /// For programs that write by name; they may replace the file.
    const std::filesystem::path& temporary() const { return temporary_; }

    /// Gives the file its name. Nothing may be written afterwards.
    /// @throws MissingError
    void commit();

 private:
    std::filesystem::path asked_;    // as the caller gave it: for messages
    std::filesystem::path target_;   // symbolic links followed
    std::filesystem::path temporary_;
    int descriptor_ = -1;
    bool committed_ = false;
};

/// What every temporary name of ours begins with.
inline constexpr std::string_view k_temporary_prefix = ".gnomon-";

}   // namespace gnomon::io
