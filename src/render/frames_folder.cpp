// SPDX-License-Identifier: Apache-2.0
#include "render/frames_folder.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "io/atomic_file.h"

namespace gnomon::render {

namespace fs = std::filesystem;

namespace {
constexpr const char* k_manifest = "manifest.json";
constexpr std::uintmax_t k_manifest_limit = 1 << 16;   // bytes

bool is_frame_name(const std::string& name)
{
    return name.starts_with("frame-") && name.ends_with(".png");
}

bool is_ours(const std::string& name)
{
    return is_frame_name(name) || name == k_manifest || name.starts_with(io::k_temporary_prefix);
}

std::vector<fs::path> entries(const fs::path& folder, std::error_code& error)
{
    std::vector<fs::path> found;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
        found.push_back(it->path());
    return found;
}

std::vector<fs::path> entries(const fs::path& folder)
{
    std::error_code error;
    std::vector<fs::path> found = entries(folder, error);
    if (error) throw MissingError(fmt::format("cannot read {}: {}", folder.string(), error.message()));
    return found;
}

nlohmann::ordered_json manifest_of(const FilmIdentity& identity)
{
    return {{"gnomon", identity.version},
            {"scene", identity.scene},
            {"width", identity.size.width},
            {"height", identity.size.height},
            {"fingerprint", fmt::format("{:016x}", identity.fingerprint)}};
}

std::optional<nlohmann::ordered_json> read_manifest(const fs::path& file)
{
    std::error_code error;
    if (fs::file_size(file, error) > k_manifest_limit || error) return std::nullopt;
    std::ifstream in(file);
    auto manifest = nlohmann::ordered_json::parse(in, nullptr, false);
    if (!manifest.is_object()) return std::nullopt;
    return manifest;
}
}   // namespace

FramesFolder::FramesFolder(const fs::path& film) : folder_(film)
{
    folder_ += ".frames";
}

fs::path FramesFolder::file(int frame) const
{
    return folder_ / fmt::format("frame-{:06}.png", frame);
}

void FramesFolder::open(const FilmIdentity& identity, bool keep, bool shared)
{
    std::error_code error;
    const bool made = fs::create_directory(folder_, error);
    if (error) throw MissingError(fmt::format("cannot make {}: {}", folder_.string(), error.message()));

    bool frames = false;
    for (const fs::path& entry : entries(folder_)) {
        const std::string name = entry.filename().string();
        if (!is_ours(name))
            throw UsageError(
                fmt::format("{} holds '{}', which is no frame of a film: move it away", folder_.string(), name));
        frames |= is_frame_name(name);
    }

    const nlohmann::ordered_json manifest = manifest_of(identity);
    const std::optional<nlohmann::ordered_json> found = read_manifest(folder_ / k_manifest);
    const bool same = found && *found == manifest;
    if (frames && !same && (keep || shared))
        throw UsageError(fmt::format("{} holds frames of another scene, size or set of options: remove it{}",
                                     folder_.string(), keep && !shared ? ", or leave out --resume" : ""));
    if (!keep && !shared)
        for (const fs::path& entry : entries(folder_)) fs::remove(entry, error);
    if (same && (keep || shared)) return;
    try {
        io::AtomicFile out(folder_ / k_manifest);
        out.write(manifest.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
        out.commit();
    } catch (...) {
        if (made && !shared) fs::remove(folder_, error);   // a full disk; what is not empty stays
        throw;
    }
}

void FramesFolder::remove()
{
    std::error_code ignored;
    for (const fs::path& entry : entries(folder_, ignored))
        if (is_ours(entry.filename().string())) fs::remove(entry, ignored);
    fs::remove(folder_, ignored);
}

bool FramesFolder::has_frames() const
{
    std::error_code ignored;
    for (const fs::path& entry : entries(folder_, ignored))
        if (is_frame_name(entry.filename().string())) return true;
    return false;
}

}   // namespace gnomon::render
