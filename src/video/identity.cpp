// SPDX-License-Identifier: Apache-2.0
#include "video/identity.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

namespace gnomon::video {

namespace {
constexpr std::string_view k_comment_start = "gnomon ";

struct Stamp {
    std::string version, instruction_set, scene, fingerprint;
};

// Returns nothing if the text is no stamp.
std::optional<Stamp> read_stamp(const std::string& text)
{
    std::istringstream in(text);
    Stamp stamp;
    if (!(in >> stamp.version >> stamp.instruction_set >> stamp.scene >> stamp.fingerprint)) return std::nullopt;
    return stamp;
}

std::string hex(std::uint64_t hash)
{
    return fmt::format("{:016x}", hash);
}
}   // namespace

std::string stamp_of(const VideoIdentity& identity)
{
    return fmt::format("{} {} {} {}", identity.version, identity.instruction_set, hex(identity.scene_fingerprint),
                       hex(identity.fingerprint));
}

std::string comment_of(const VideoIdentity& identity)
{
    return fmt::format("{}{}, frames {}-{} at {:.9g}", k_comment_start, stamp_of(identity), identity.frames.first,
                       identity.frames.last, identity.fps);
}

std::string stamp_in(const std::string& comment)
{
    const std::size_t end = comment.find(", ");
    if (!comment.starts_with(k_comment_start) || end == std::string::npos) return {};
    return comment.substr(k_comment_start.size(), end - k_comment_start.size());
}

Difference difference_of(const std::string& stamp, const VideoIdentity& identity)
{
    if (stamp == stamp_of(identity)) return Difference::none;
    const std::optional<Stamp> read = read_stamp(stamp);
    if (!read) return Difference::unknown;
    // Another version may also compute other hashes, so it is the only difference that can be named.
    if (read->version != identity.version) return Difference::version;
    if (read->scene != hex(identity.scene_fingerprint)) return Difference::scene;
    if (read->fingerprint != hex(identity.fingerprint)) return Difference::options;
    return Difference::instruction_set;
}

std::string describe(Difference difference, const std::string& stamp, const VideoIdentity& identity)
{
    const Stamp read = read_stamp(stamp).value_or(Stamp{});
    switch (difference) {
        case Difference::version:
            return fmt::format("rendered by version {}, not {}", read.version, identity.version);
        case Difference::instruction_set:
            return fmt::format("rendered with the instruction set {}, not {}", read.instruction_set,
                               identity.instruction_set);
        case Difference::scene:
            return "of another scene, or of this one before it was changed";
        case Difference::options:
            return "rendered with other options";
        case Difference::unknown:
            return "without a note of what was rendered";
        case Difference::none:
            break;
    }
    return "of this video";
}

nlohmann::ordered_json manifest_of(const VideoIdentity& identity)
{
    return {{"gnomon", identity.version},
            {"instruction_set", identity.instruction_set},
            {"scene", identity.scene},
            {"width", identity.size.width},
            {"height", identity.size.height},
            {"scene_fingerprint", hex(identity.scene_fingerprint)},
            {"fingerprint", hex(identity.fingerprint)},
            {"first", identity.frames.first},
            {"last", identity.frames.last},
            {"fps", identity.fps}};
}

std::optional<VideoIdentity> read_manifest(const nlohmann::ordered_json& manifest)
{
    try {
        const auto hash = [&](const char* name) {
            return std::stoull(manifest.at(name).get<std::string>(), nullptr, 16);
        };
        VideoIdentity identity;
        identity.version = manifest.at("gnomon").get<std::string>();
        identity.instruction_set = manifest.at("instruction_set").get<std::string>();
        identity.scene = manifest.at("scene").get<std::string>();
        identity.size = {manifest.at("width").get<int>(), manifest.at("height").get<int>()};
        identity.scene_fingerprint = hash("scene_fingerprint");
        identity.fingerprint = hash("fingerprint");
        identity.frames = {manifest.at("first").get<int>(), manifest.at("last").get<int>()};
        identity.fps = manifest.at("fps").get<double>();
        const bool valid = identity.size.width > 0 && identity.size.height > 0 && identity.frames.first >= 1 &&
                           identity.frames.count() > 0 && identity.fps > 0;
        return valid ? std::optional(identity) : std::nullopt;
    } catch (const std::exception&) {
        return std::nullopt;   // of an older version, or damaged
    }
}

}   // namespace gnomon::video
