// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads whole files into memory safely: regular files only, with a size limit, never blocking on a FIFO or device.
// Resolves names that files give for other files, which must stay inside the scene's folder.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace gnomon::io {

/// @param shown_as  the name for messages
/// @throws InputError  missing, not a regular file, larger than the limit, unreadable
std::vector<std::uint8_t> read_whole_file(const std::filesystem::path& file, const std::string& shown_as,
                                          std::uint64_t limit = 1ull << 31);

/// Resolves a relative name below a folder. Symbolic links are followed and must end below one of the roots.
/// @param roots  real (canonical) folders whose contents may be opened
/// @param why    gets the problem as text if the result is empty
std::filesystem::path resolve_inside(const std::filesystem::path& folder, const std::string& name,
                                     const std::vector<std::filesystem::path>& roots, std::string& why);

}   // namespace gnomon::io
