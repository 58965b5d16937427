// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a video shows and what rendered it, so that frames and finished videos are reused only where they would be
// rendered to the same bytes.
//
// Each frame carries a stamp: the version, the instruction set, and hashes of the scene and of the options. A finished
// video carries the same and its range and rate. The manifest of a folder of frames holds all of it.

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "gnomon/types.h"
#include "video/delivery.h"

namespace gnomon {
struct RenderOptions;
class Scene;
}   // namespace gnomon
namespace gnomon::scene {
class Scene;
}

namespace gnomon::video {

/// Properties that all frames of a video have in common, and its length.
struct VideoIdentity {
    std::string scene;   // name, for messages
    Size size;
    std::uint64_t fingerprint = 0;         // of everything that pixels depend on, see fingerprint_of
    std::string version;                   // of Gnomon, because another version may render differently
    std::uint64_t scene_fingerprint = 0;   // of the scene alone
    std::string instruction_set{};         // see base/instruction_set.h
    FrameRange frames{1, 1};               // of the whole video
    double fps = 24;
    Delivery delivery{};                // how it is encoded
    std::optional<double> exposure{};   // of the clip, once it is known; the other members decide it
};

/// Hash of everything in the scene that affects images, without names. Cost: its vertices and texels, and at most a
/// thousand evaluations per track.
std::uint64_t fingerprint_of(const scene::Scene& scene);
/// Hash of that and of all options that affect images; the number of threads, for example, does not.
std::uint64_t fingerprint_of(const Scene& scene, const RenderOptions& options);
/// The same, where the hash of the scene is already known.
std::uint64_t fingerprint_of(std::uint64_t of_scene, const Scene& scene, const RenderOptions& options);

/// The text that a frame carries: "VERSION INSTRUCTION_SET SCENE FINGERPRINT".
std::string stamp_of(const VideoIdentity& identity);
/// The text that a finished video carries: its stamp, its range, its rate, and how it is encoded.
std::string comment_of(const VideoIdentity& identity);
/// The stamp in such a text; empty if the text is another one.
std::string stamp_in(const std::string& comment);

/// Why a frame or a finished video is not of this video.
enum class Difference { none, unknown, version, instruction_set, scene, options };
/// @param stamp  empty if it has none
Difference difference_of(const std::string& stamp, const VideoIdentity& identity);
/// The same in words that follow "is" or "are": "rendered by version 0.2.0, not 0.3.0".
std::string describe(Difference difference, const std::string& stamp, const VideoIdentity& identity);

nlohmann::ordered_json manifest_of(const VideoIdentity& identity);
/// Returns nothing if a member is missing or of the wrong kind.
std::optional<VideoIdentity> read_manifest(const nlohmann::ordered_json& manifest);

}   // namespace gnomon::video
