// SPDX-License-Identifier: Apache-2.0
#include "video/identity.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

#include "gnomon/ranges.h"

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
    const std::string encoding = text_of(identity.delivery);
    return fmt::format("{}{}, frames {}-{} at {:.9g}{}{}", k_comment_start, stamp_of(identity), identity.frames.first,
                       identity.frames.last, identity.fps, encoding.empty() ? "" : ", ", encoding);
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

namespace {
nlohmann::ordered_json json_of(const Delivery& delivery)
{
    return {{"container", extension_of(delivery.container)},
            {"codec", name_of(delivery.codec)},
            {"quality", delivery.quality},
            {"alpha", delivery.alpha},
            {"deep", delivery.deep},
            {"audio", delivery.audio.string()},
            {"audio_hash", hex(delivery.audio_hash)},
            {"timecode", delivery.timecode}};
}

std::uint64_t hash_in(const nlohmann::ordered_json& json, const char* name)
{
    return std::stoull(json.at(name).get<std::string>(), nullptr, 16);
}

// Throws if a member is missing, of the wrong kind, or not among what there is.
Delivery delivery_in(const nlohmann::ordered_json& json)
{
    Delivery delivery;
    delivery.container = container_of("video" + json.at("container").get<std::string>());
    delivery.codec = codec_named(json.at("codec").get<std::string>());
    delivery.quality = json.at("quality").get<int>();
    delivery.alpha = json.at("alpha").get<bool>();
    delivery.deep = json.at("deep").get<bool>();
    delivery.audio = json.at("audio").get<std::string>();
    delivery.audio_hash = hash_in(json, "audio_hash");
    delivery.timecode = json.at("timecode").get<std::string>();
    return delivery;
}
}   // namespace

nlohmann::ordered_json manifest_of(const VideoIdentity& identity)
{
    nlohmann::ordered_json exposure;   // null if it is not known
    if (identity.exposure) exposure = *identity.exposure;
    return {{"gnomon", identity.version},
            {"instruction_set", identity.instruction_set},
            {"scene", identity.scene},
            {"width", identity.size.width},
            {"height", identity.size.height},
            {"scene_fingerprint", hex(identity.scene_fingerprint)},
            {"fingerprint", hex(identity.fingerprint)},
            {"first", identity.frames.first},
            {"last", identity.frames.last},
            {"fps", identity.fps},
            {"encoding", json_of(identity.delivery)},
            {"exposure", exposure}};
}

std::optional<VideoIdentity> read_manifest(const nlohmann::ordered_json& manifest)
{
    try {
        VideoIdentity identity;
        identity.version = manifest.at("gnomon").get<std::string>();
        identity.instruction_set = manifest.at("instruction_set").get<std::string>();
        identity.scene = manifest.at("scene").get<std::string>();
        identity.size = {manifest.at("width").get<int>(), manifest.at("height").get<int>()};
        identity.scene_fingerprint = hash_in(manifest, "scene_fingerprint");
        identity.fingerprint = hash_in(manifest, "fingerprint");
        identity.frames = {manifest.at("first").get<int>(), manifest.at("last").get<int>()};
        identity.fps = manifest.at("fps").get<double>();
        identity.delivery = delivery_in(manifest.at("encoding"));
        const nlohmann::ordered_json& exposure = manifest.at("exposure");
        if (!exposure.is_null()) identity.exposure = exposure.get<double>();
        const bool valid = identity.size.width > 0 && identity.size.height > 0 && identity.frames.first >= 1 &&
                           identity.frames.count() > 0 && identity.fps > 0 &&
                           ranges::exposure.contains(identity.exposure.value_or(0));
        return valid ? std::optional(identity) : std::nullopt;
    } catch (const std::exception&) {
        return std::nullopt;   // of an older version, or damaged
    }
}

}   // namespace gnomon::video
