// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

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
    Source parts[4];   // by Path: translation, rotation, scale, weights
};

class Animations {
 public:
    Animations(const Model& model, const Data& data, Context& context) : model_(model), data_(data), context_(context)
    {
        keys_left_ = context.limits.geometry_bytes + context.limits.geometry_bytes_per_byte * data.total_bytes();
    }

    double end() const { return end_; }

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
        return std::make_shared<scene::KeyframeWeights>(interpolation_of(sampler.interpolation), times(sampler.input),
                                                        std::move(values), targets);
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
    std::vector<double> times(Index accessor)
    {
        std::vector<double> values = numbers(accessor);
        end_ = std::max(end_, values.back());
        return values;
    }

    std::optional<KeyChannel<glm::dvec3>> vectors(const Source& source)
    {
        if (!source.used()) return std::nullopt;
        const AnimationSampler& sampler = sampler_of(source);
        KeyChannel<glm::dvec3> channel{interpolation_of(sampler.interpolation), times(sampler.input), {}};
        const std::vector<double> v = numbers(sampler.output);
        for (std::size_t i = 0; i + 2 < v.size(); i += 3) channel.values.emplace_back(v[i], v[i + 1], v[i + 2]);
        return channel;
    }

    std::optional<KeyChannel<glm::dquat>> rotations(const Source& source)
    {
        if (!source.used()) return std::nullopt;
        const AnimationSampler& sampler = sampler_of(source);
        KeyChannel<glm::dquat> channel{interpolation_of(sampler.interpolation), times(sampler.input), {}};
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
    double end_ = 0;
};

}   // namespace

scene::TransformParts rest_parts(const Node& node)
{
    scene::TransformParts parts;
    if (node.translation) parts.translation = {(*node.translation)[0], (*node.translation)[1], (*node.translation)[2]};
    if (node.scale) parts.scale = {(*node.scale)[0], (*node.scale)[1], (*node.scale)[2]};
    if (node.rotation) {
        const auto& r = *node.rotation;
        parts.rotation = glm::normalize(glm::dquat(r[3], r[0], r[1], r[2]));
    }
    return parts;
}

void build_animations(const Model& model, const Data& data, const std::vector<scene::NodeId>& node_ids,
                      scene::Scene& out, Context& context)
{
    // All animations play together. If two animate the same part of a node, the first in the file is used.
    Animations animations(model, data, context);
    std::map<Index, Moves> moves;
    for (Index a = 0; a < model.animations.size(); ++a) {
        const Animation& animation = model.animations[a];
        bool told = false;
        for (std::size_t c = 0; c < animation.channels.size(); ++c) {
            const Channel& channel = animation.channels[c];
            const std::string here = at(at(at("/animations", a), "channels"), c);
            if (channel.path == Path::pointer || channel.path == Path::unknown) {
                context.warn(here,
                             fmt::format("the path '{}' is not supported: ignored", channel.path_word.substr(0, 64)));
                continue;
            }
            if (channel.node == k_absent || node_ids[channel.node] == scene::none) continue;
            const AnimationSampler& sampler = animation.samplers[channel.sampler];
            if (sampler.interpolation == Interpolation::unknown) {
                context.warn(here, "its interpolation is not supported: ignored");
                continue;
            }
            if (!animations.usable(sampler, here)) continue;
            Source& source = moves[channel.node].parts[static_cast<int>(channel.path)];
            if (!source.used()) {
                source = {a, channel.sampler};
            } else if (!told) {
                told = true;
                context.warn(here, fmt::format("animates a property that animation {} animates already: ignored",
                                               source.animation));
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
        if (move.parts[3].used() && node.mesh != scene::none)
            node.weights = animations.weights(move.parts[3], out.meshes[node.mesh].morph_targets.size());
    }

    // The last frame is the last one that is not beyond the end of the longest animation.
    constexpr double default_rate = 24;
    out.timeline.start = 0;
    out.timeline.end = animations.end();
    out.timeline.fps = default_rate;
    const double last = std::floor(out.timeline.end * default_rate + 1e-6);
    out.timeline.frames = static_cast<int>(std::min(last, scene::k_most_frames - 1.0)) + 1;
    if (last >= scene::k_most_frames)
        context.warn("/animations", fmt::format("the clip lasts {} s: frames after the first {} are left out",
                                                out.timeline.end, scene::k_most_frames));
}

}   // namespace gnomon::io::gltf
