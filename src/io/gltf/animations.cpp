// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include "base/one_line.h"
#include "gnomon/error.h"
#include "io/gltf/build.h"
#include "scene/keyframe_track.h"

namespace gnomon::io::gltf {

namespace {

using scene::KeyChannel;
using scene::KeyInterpolation;

KeyInterpolation interpolation_of(Interpolation i)
{
    return i == Interpolation::step           ? KeyInterpolation::step
           : i == Interpolation::cubic_spline ? KeyInterpolation::cubic_spline
                                              : KeyInterpolation::linear;
}

// The sampler and animation that animate each part of a node.
struct Source {
    Index animation = k_absent;
    std::uint64_t sampler = 0;
    bool used() const { return animation != k_absent; }
};
struct Moves {
    Source parts[5];   // by Path: translation, rotation, scale, weights, visibility
};

// What a channel animates.
struct Target {
    Index node = 0;
    Path path = Path::translation;
    friend auto operator<=>(const Target&, const Target&) = default;
};

// An animation of the file: what it moves in the scene, with the number of the channel.
struct Clip {
    scene::Clip clip;
    std::map<Target, std::size_t> targets;
};

// "0 walk, 1 run, ..."
std::string names_of(const std::vector<Clip>& clips)
{
    constexpr std::size_t shown = 8;
    std::string text;
    for (std::size_t i = 0; i < std::min(clips.size(), shown); ++i)
        text += fmt::format("{}{}{}{}", i == 0 ? "" : ", ", i, clips[i].clip.name.empty() ? "" : " ",
                            shown_name(clips[i].clip.name));
    return clips.size() > shown ? text + ", ..." : text;
}

class Animations {
 public:
    Animations(const Model& model, const Data& data, Context& context) : model_(model), data_(data), context_(context)
    {
        keys_left_ = context.limits.geometry_bytes + context.limits.geometry_bytes_per_byte * data.total_bytes();
    }

    // Finds what an animation of the file moves in the scene, and the times of its first and last key.
    Clip clip(Index index, const std::vector<scene::NodeId>& node_ids)
    {
        const Animation& animation = model_.animations[index];
        Clip result;
        result.clip.name = animation.name;
        for (std::size_t c = 0; c < animation.channels.size(); ++c) {
            const Channel& channel = animation.channels[c];
            const std::string here = at(at(at("/animations", index), "channels"), c);
            if (channel.path == Path::pointer || channel.path == Path::unknown) {
                constexpr std::size_t k_shown = 100;
                context_.warn(here, channel.has_pointer ? fmt::format("animates '{}', which is not supported: ignored",
                                                                      shown_name(channel.pointer.substr(0, k_shown)))
                                                        : fmt::format("the path '{}' is not supported: ignored",
                                                                      channel.path_word.substr(0, 64)));
                continue;
            }
            if (channel.node == k_absent || node_ids[channel.node] == scene::none) continue;
            const AnimationSampler& sampler = animation.samplers[channel.sampler];
            if (sampler.interpolation == Interpolation::unknown) {
                context_.warn(here, "its interpolation is not supported: ignored");
                continue;
            }
            if (channel.path == Path::visibility && sampler.interpolation != Interpolation::step) {
                context_.warn(here, "visibility can only change in steps: ignored");
                continue;
            }
            if (!usable(sampler, here)) continue;
            const auto [first, last] = span(sampler.input);
            const bool fresh = result.targets.empty();
            result.clip.start = fresh ? first : std::min(result.clip.start, first);
            result.clip.end = fresh ? last : std::max(result.clip.end, last);
            result.targets.try_emplace({channel.node, channel.path}, c);
        }
        return result;
    }

    // Returns whether the keys of a channel can be used; adds a warning if not.
    bool usable(const AnimationSampler& sampler, const std::string& pointer)
    {
        const Accessor& input = model_.accessors[sampler.input];
        const Accessor& output = model_.accessors[sampler.output];
        for (const Accessor* accessor : {&input, &output})
            if (const std::string reason = data_.unreachable(*accessor); !reason.empty())
                context_.fail(pointer, fmt::format("an accessor {}", reason));
        // Without data all times would be zero, so there is no animation.
        if (!data_.has_bytes(input)) return context_.warn(pointer, "key times have no data: ignored"), false;
        return true;
    }

    std::shared_ptr<const scene::TransformTrack> transform(const Node& node, const Moves& moves)
    {
        return std::make_shared<scene::KeyframeTrack>(rest_parts(node), vectors(moves.parts[0]),
                                                      rotations(moves.parts[1]), vectors(moves.parts[2]));
    }

    std::shared_ptr<const scene::WeightsTrack> weights(const Source& source, std::size_t targets)
    {
        const AnimationSampler& sampler = sampler_of(source);
        std::vector<double> values = numbers(sampler.output);
        return std::make_shared<scene::KeyframeWeights>(interpolation_of(sampler.interpolation), numbers(sampler.input),
                                                        std::move(values), targets);
    }

    // The first key's value counts before it as well.
    std::shared_ptr<const scene::VisibilityTrack> visibility(const Source& source)
    {
        const AnimationSampler& sampler = sampler_of(source);
        auto track = std::make_shared<scene::VisibilityTrack>();
        const std::vector<double> times = numbers(sampler.input), values = numbers(sampler.output);
        for (std::size_t i = 0; i < std::min(times.size(), values.size()); ++i) {
            track->times.push_back(i == 0 ? std::numeric_limits<double>::lowest() : times[i]);
            track->visible.push_back(values[i] != 0);
        }
        return track;
    }

 private:
    const AnimationSampler& sampler_of(const Source& source) const
    {
        return model_.animations[source.animation].samplers[source.sampler];
    }

    // Bound the memory of all channels together, like that of geometry, because many channels may share one accessor.
    std::vector<double> numbers(Index accessor)
    {
        const Accessor& a = model_.accessors[accessor];
        const std::uint64_t each = sizeof(double) * static_cast<std::uint64_t>(a.components());
        if (a.count > keys_left_ / each)
            context_.fail(at("/accessors", accessor), "animations have far more keys than the size of the file allows");
        keys_left_ -= a.count * each;
        std::vector<double> values;
        data_.read_double(a, values);
        return values;
    }
    // The times of the first and the last key.
    std::pair<double, double> span(Index accessor)
    {
        const auto [known, fresh] = spans_.try_emplace(accessor);
        if (fresh)
            data_.for_each(model_.accessors[accessor], [&, &times = known->second](std::uint64_t i, auto key) {
                if (i == 0) times.first = key[0];
                times.second = key[0];
            });
        return known->second;
    }

    std::optional<KeyChannel<glm::dvec3>> vectors(const Source& source)
    {
        if (!source.used()) return std::nullopt;
        const AnimationSampler& sampler = sampler_of(source);
        KeyChannel<glm::dvec3> channel{interpolation_of(sampler.interpolation), numbers(sampler.input), {}};
        const std::vector<double> v = numbers(sampler.output);
        for (std::size_t i = 0; i + 2 < v.size(); i += 3) channel.values.emplace_back(v[i], v[i + 1], v[i + 2]);
        return channel;
    }

    std::optional<KeyChannel<glm::dquat>> rotations(const Source& source)
    {
        if (!source.used()) return std::nullopt;
        const AnimationSampler& sampler = sampler_of(source);
        KeyChannel<glm::dquat> channel{interpolation_of(sampler.interpolation), numbers(sampler.input), {}};
        const std::vector<double> v = numbers(sampler.output);
        const bool cubic = sampler.interpolation == Interpolation::cubic_spline;
        for (std::size_t i = 0; i + 3 < v.size(); i += 4) {
            glm::dquat q(v[i + 3], v[i], v[i + 1], v[i + 2]);
            const bool is_key = !cubic || i / 4 % 3 == 1;
            const double length = glm::length(q);
            if (is_key) q = length > 0 ? q * (1 / length) : glm::dquat(1, 0, 0, 0);
            channel.values.push_back(q);
        }
        return channel;
    }

    const Model& model_;
    const Data& data_;
    Context& context_;
    std::uint64_t keys_left_ = 0;
    std::map<Index, std::pair<double, double>> spans_;   // by accessor of key times
};

// Decides which clips play. Without a choice: the first, and each further one that animates nothing that a playing one
// animates.
void choose_clips(std::vector<Clip>& clips, const std::string& chosen, Context& context)
{
    if (clips.empty() || chosen == "all") {
        for (Clip& clip : clips) clip.clip.plays = true;
        return;
    }
    if (!chosen.empty()) {
        const auto named =
            std::find_if(clips.begin(), clips.end(), [&](const Clip& clip) { return clip.clip.name == chosen; });
        std::size_t number = clips.size();
        const char* const end = chosen.data() + chosen.size();
        if (named != clips.end())
            number = static_cast<std::size_t>(named - clips.begin());
        else if (const auto [stop, error] = std::from_chars(chosen.data(), end, number);
                 error != std::errc() || stop != end)
            number = clips.size();
        if (number >= clips.size())
            throw UsageError(fmt::format("no animation '{}'; there are: {}", shown_name(chosen), names_of(clips)));
        clips[number].clip.plays = true;
        return;
    }
    std::set<Target> moved;
    std::size_t still = 0;
    for (Clip& clip : clips) {
        clip.clip.plays = std::none_of(clip.targets.begin(), clip.targets.end(),
                                       [&](const auto& entry) { return moved.contains(entry.first); });
        if (!clip.clip.plays) ++still;
        if (clip.clip.plays)
            for (const auto& [target, channel] : clip.targets) moved.insert(target);
    }
    if (still > 0)
        context.warn("/animations",
                     fmt::format("{} of {} animations do not play, because they animate what one before them animates; "
                                 "there are: {}",
                                 still, clips.size(), names_of(clips)));
}

}   // namespace

scene::TransformParts rest_parts(const Node& node)
{
    scene::TransformParts parts;
    if (node.translation) parts.translation = {(*node.translation)[0], (*node.translation)[1], (*node.translation)[2]};
    if (node.scale) parts.scale = {(*node.scale)[0], (*node.scale)[1], (*node.scale)[2]};
    if (node.rotation) {
        const auto& r = *node.rotation;
        const glm::dquat q(r[3], r[0], r[1], r[2]);
        const double length = glm::length(q);
        parts.rotation = length > 0 ? q * (1 / length) : glm::dquat(1, 0, 0, 0);
    }
    return parts;
}

void build_animations(const Model& model, const Data& data, const std::vector<scene::NodeId>& node_ids,
                      const std::string& chosen, scene::Scene& out, Context& context)
{
    Animations animations(model, data, context);
    std::vector<Clip> clips;
    for (Index a = 0; a < model.animations.size(); ++a) clips.push_back(animations.clip(a, node_ids));
    choose_clips(clips, chosen, context);

    // Let the playing clips move their targets. If two animate the same part of a node, the first one is used.
    std::map<Index, Moves> moves;
    for (Index a = 0; a < clips.size(); ++a) {
        out.clips.push_back(clips[a].clip);
        if (!clips[a].clip.plays) continue;
        bool told = false;
        for (const auto& [target, channel] : clips[a].targets) {
            Source& source = moves[target.node].parts[static_cast<int>(target.path)];
            if (!source.used()) {
                source = {a, model.animations[a].channels[channel].sampler};
            } else if (!told) {
                told = true;
                context.warn(
                    at(at(at("/animations", a), "channels"), channel),
                    fmt::format("animates a property that animation {} animates already: ignored", source.animation));
            }
        }
    }

    for (const auto& [index, move] : moves) {
        const Node& source = model.nodes[index];
        scene::Node& node = out.nodes[node_ids[index]];
        if (move.parts[0].used() || move.parts[1].used() || move.parts[2].used()) {
            node.transform = animations.transform(source, move);
            node.animated = true;
        }
        if (move.parts[4].used()) {
            node.visibility = animations.visibility(move.parts[4]);
            node.animated = true;
        }
        if (move.parts[3].used() && node.mesh != scene::none)
            node.weights = animations.weights(move.parts[3], out.meshes[node.mesh].morph_targets.size());
    }

    // The clip lasts from the first key to the last one.
    constexpr double default_rate = 24;
    double start = std::numeric_limits<double>::infinity(), end = -start;
    for (const Clip& clip : clips)
        if (clip.clip.plays && !clip.targets.empty())
            start = std::min(start, clip.clip.start), end = std::max(end, clip.clip.end);
    out.timeline.start = start <= end ? start : 0;
    out.timeline.end = start <= end ? end : 0;
    out.timeline.fps = default_rate;
    const double seconds = out.timeline.end - out.timeline.start;
    out.timeline.frames = scene::Timeline::frames_in(seconds, default_rate);
    if (out.timeline.frames == scene::k_most_frames)
        context.warn("/animations", fmt::format("the clip lasts {} s: frames after the first {} are left out", seconds,
                                                scene::k_most_frames));
}

}   // namespace gnomon::io::gltf
