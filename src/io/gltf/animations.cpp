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
#include "io/gltf/pointers.h"
#include "scene/keyframe_track.h"
#include "scene/material_layers.h"
#include "scene/value_tracks.h"

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
    std::uint64_t channel = 0, sampler = 0;
    bool used() const { return animation != k_absent; }
};
struct Moves {
    Source parts[5];   // by Path: translation, rotation, scale, weights, visibility
};

// What a channel animates: a path of a node, or a property of a light, material or camera.
struct Target {
    Index index = 0;   // of the node, light, material or camera
    Path path = Path::translation;
    Property property = Property::none;
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
    /// @param textures  which make room for keys
    Animations(const Model& model, const Data& data, scene::SharedList<scene::Texture>& textures, Context& context)
        : model_(model), data_(data), textures_(textures), context_(context)
    {
        keys_left_ = context.limits.geometry_bytes + context.limits.geometry_bytes_per_byte * data.total_bytes();
    }

    // Finds what an animation of the file moves in the scene, and the times of its first and last key.
    Clip clip(Index index, const PartIds& ids, const Materials& materials)
    {
        const Animation& animation = model_.animations[index];
        Clip result;
        result.clip.name = animation.name;
        for (std::size_t c = 0; c < animation.channels.size(); ++c) {
            const Channel& channel = animation.channels[c];
            const std::string here = at(at(at("/animations", index), "channels"), c);
            const bool is_property = channel.property != Property::none;
            if (!is_property && (channel.path == Path::pointer || channel.path == Path::unknown)) {
                constexpr std::size_t k_shown = 100;
                const char* const why = why_ignored(channel.pointer);
                const std::string pointer = shown_name(channel.pointer.substr(0, k_shown));
                context_.warn(here, why ? fmt::format("animates '{}': {}", pointer, why)
                                    : channel.has_pointer
                                        ? fmt::format("animates '{}', which is not supported: ignored", pointer)
                                        : fmt::format("the path '{}' is not supported: ignored",
                                                      channel.path_word.substr(0, 64)));
                continue;
            }
            if (is_property) {
                if (!is_there(channel, ids, materials)) continue;
                if (const char* const reason = ineffective(channel)) {
                    context_.warn(here, fmt::format("animates '{}': {}", channel.pointer, reason));
                    continue;
                }
            } else if (channel.node == k_absent || ids.nodes[channel.node] == scene::none) {
                continue;
            }
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
            result.targets.try_emplace(
                Target{is_property ? channel.owner : channel.node, channel.path, channel.property}, c);
        }
        return result;
    }

    // Whether the owner of an animated property is in the scene.
    static bool is_there(const Channel& channel, const PartIds& ids, const Materials& materials)
    {
        switch (owner_of(channel.property)) {
            case Owner::light:
                return !ids.lights[channel.owner].empty();
            case Owner::camera:
                return !ids.cameras[channel.owner].empty();
            default:
                return !materials.made_of(channel.owner).empty();
        }
    }

    // Why a property does not bear on its owner; null: it does.
    const char* ineffective(const Channel& channel) const
    {
        switch (channel.property) {
            case Property::light_range:
                if (model_.lights[channel.owner].type == "directional") return "directional lights have none: ignored";
                break;
            case Property::light_inner:
            case Property::light_outer:
                if (model_.lights[channel.owner].type != "spot") return "only spot lights have it: ignored";
                break;
            case Property::base_color:
            case Property::metallic:
            case Property::roughness:
                if (model_.materials[channel.owner].glossiness)
                    return "KHR_materials_pbrSpecularGlossiness takes its place: ignored";
                break;
            case Property::yfov:
                if (!model_.cameras[channel.owner].has_perspective) return "the camera is orthographic: ignored";
                break;
            case Property::ymag:
                if (model_.cameras[channel.owner].has_perspective) return "the camera is a perspective one: ignored";
                break;
            case Property::camera_near:
            case Property::camera_far:
                if ((channel.pointer.find("/perspective/") != std::string::npos) !=
                    model_.cameras[channel.owner].has_perspective)
                    return "the camera is of the other kind: ignored";
                break;
            default:
                break;
        }
        constexpr std::string_view k_base = "/pbrMetallicRoughness/baseColorTexture/";
        if (channel.property >= Property::first_part && channel.pointer.find(k_base) != std::string::npos &&
            model_.materials[channel.owner].alpha_mode == "MASK")
            return "holes of a surface cannot move: ignored";
        return nullptr;
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
        auto [times, values] = keys(sampler);
        return std::make_shared<scene::KeyframeWeights>(interpolation_of(sampler.interpolation), std::move(times),
                                                        std::move(values), targets);
    }

    // The track of a property; null where it has none.
    scene::NumbersTrack property(const std::map<Property, Source>& sources, Property property)
    {
        const auto at = sources.find(property);
        return at == sources.end() ? nullptr : weights(at->second, static_cast<std::size_t>(components_of(property)));
    }

    std::shared_ptr<const scene::LightTrack> light(const Light& light, const std::map<Property, Source>& sources)
    {
        auto track = std::make_shared<scene::LightTrack>();
        track->rest_color = {light.color[0], light.color[1], light.color[2]};
        track->rest_intensity = light.intensity;
        track->rest_inner_angle = light.inner;
        track->color = property(sources, Property::light_color);
        track->intensity = property(sources, Property::light_intensity);
        track->range = property(sources, Property::light_range);
        track->inner_angle = property(sources, Property::light_inner);
        track->outer_angle = property(sources, Property::light_outer);
        return track;
    }

    std::shared_ptr<const scene::CameraTrack> camera(const std::map<Property, Source>& sources)
    {
        auto track = std::make_shared<scene::CameraTrack>();
        track->vertical_fov = property(sources, Property::yfov);
        track->half_height = property(sources, Property::ymag);
        track->near = property(sources, Property::camera_near);
        track->far = property(sources, Property::camera_far);
        return track;
    }

    scene::MaterialTrack material(const Material& material, const std::map<Property, Source>& sources)
    {
        scene::MaterialTrack track;
        track.rest_emissive = {material.emissive[0], material.emissive[1], material.emissive[2]};
        track.rest_strength = material.emissive_strength;
        track.base_color = property(sources, Property::base_color);
        track.metallic = property(sources, Property::metallic);
        track.roughness = property(sources, Property::roughness);
        track.emissive = property(sources, Property::emissive);
        track.strength = property(sources, Property::emissive_strength);
        if (const auto at = sources.find(Property::base_color); at != sources.end())
            track.alpha_changes = alpha_changes(at->second, material);
        for (const auto& [number, source] : sources) {
            std::optional<scene::MaterialPart> part = part_of(number);
            if (!part) continue;
            part->track = property(sources, number);
            const auto* const texture = std::get_if<scene::TextureUse scene::Material::*>(&part->member);
            if (texture && *texture == &scene::Material::base_color_texture) track.alpha_changes = true;
            track.parts.push_back(*std::move(part));
        }
        return track;
    }

    // The first key's value counts before it as well.
    std::shared_ptr<const scene::VisibilityTrack> visibility(const Source& source)
    {
        const AnimationSampler& sampler = sampler_of(source);
        auto track = std::make_shared<scene::VisibilityTrack>();
        const auto [times, values] = keys(sampler);
        for (std::size_t i = 0; i < std::min(times.size(), values.size()); ++i) {
            track->times.push_back(i == 0 ? std::numeric_limits<double>::lowest() : times[i]);
            track->visible.push_back(values[i] != 0);
        }
        return track;
    }

    /// Refuses more keys of nodes than the size of the file allows, before any of them takes memory.
    void expect(const std::map<Index, Moves>& moves)
    {
        std::uint64_t left = keys_left_;
        for (const auto& [node, move] : moves)
            for (const Path path : {Path::translation, Path::rotation, Path::scale, Path::visibility}) {
                const Source& source = move.parts[static_cast<int>(path)];
                if (!source.used()) continue;
                take_from(left, sampler_of(source).input);
                take_from(left, sampler_of(source).output);
            }
    }

 private:
    // Whether the fourth number of colours is ever another one than the material's own. Says so if that has no effect.
    bool alpha_changes(const Source& source, const Material& material)
    {
        const AnimationSampler& sampler = sampler_of(source);
        const bool cubic = sampler.interpolation == Interpolation::cubic_spline;
        bool changes = false;
        data_.for_each(model_.accessors[sampler.output], [&](std::uint64_t i, std::span<const double> color) {
            const bool is_tangent = cubic && i % 3 != 1;
            changes = changes || static_cast<float>(color[3]) != (is_tangent ? 0 : material.base_color[3]);
        });
        if (changes && material.alpha_mode == "MASK")
            context_.warn(at(at(at("/animations", source.animation), "channels"), source.channel),
                          "the alpha of a surface with holes cannot change: its colour changes alone");
        return changes;
    }

    const AnimationSampler& sampler_of(const Source& source) const
    {
        return model_.animations[source.animation].samplers[source.sampler];
    }

    // Bound the memory of all channels together, like that of geometry, because many channels may share one accessor.
    std::uint64_t take_from(std::uint64_t& left, Index accessor)
    {
        const Accessor& a = model_.accessors[accessor];
        const std::uint64_t each = sizeof(double) * static_cast<std::uint64_t>(a.components());
        if (a.count > left / each)
            context_.fail(at("/accessors", accessor), "animations have far more keys than the size of the file allows");
        left -= a.count * each;
        return a.count * each;
    }
    std::vector<double> numbers(Index accessor)
    {
        const Accessor& a = model_.accessors[accessor];
        context_.memory.take(take_from(keys_left_, accessor), textures_,
                             {context_.file(), at("/accessors", accessor), "the keys of the animations"});
        std::vector<double> values;
        data_.read_double(a, values);
        return values;
    }
    // The times of a sampler's keys, and all numbers of their values. Keys that are not later than the ones before them
    // are left out (Fault::key_order).
    std::pair<std::vector<double>, std::vector<double>> keys(const AnimationSampler& sampler)
    {
        std::pair<std::vector<double>, std::vector<double>> result(numbers(sampler.input), numbers(sampler.output));
        auto& [times, values] = result;
        if (times.empty() || values.size() % times.size() != 0) return result;
        const std::size_t each = values.size() / times.size();
        std::size_t kept = 0;
        for (std::size_t i = 0; i < times.size(); ++i) {
            if (kept > 0 && !(times[i] > times[kept - 1])) continue;
            times[kept] = times[i];
            for (std::size_t k = 0; k < each; ++k) values[kept * each + k] = values[i * each + k];
            ++kept;
        }
        times.resize(kept);
        values.resize(kept * each);
        return result;
    }
    // The times of the first and the last key.
    std::pair<double, double> span(Index accessor)
    {
        const auto [known, fresh] = spans_.try_emplace(accessor);
        if (fresh)
            data_.for_each(model_.accessors[accessor], [&, &times = known->second](std::uint64_t i, auto key) {
                if (i == 0) times.first = key[0];
                times.second = i == 0 ? key[0] : std::max(times.second, key[0]);
            });
        return known->second;
    }

    std::optional<KeyChannel<glm::dvec3>> vectors(const Source& source)
    {
        if (!source.used()) return std::nullopt;
        const AnimationSampler& sampler = sampler_of(source);
        auto [times, v] = keys(sampler);
        KeyChannel<glm::dvec3> channel{interpolation_of(sampler.interpolation), std::move(times), {}};
        for (std::size_t i = 0; i + 2 < v.size(); i += 3) channel.values.emplace_back(v[i], v[i + 1], v[i + 2]);
        return channel;
    }

    std::optional<KeyChannel<glm::dquat>> rotations(const Source& source)
    {
        if (!source.used()) return std::nullopt;
        const AnimationSampler& sampler = sampler_of(source);
        auto [times, v] = keys(sampler);
        KeyChannel<glm::dquat> channel{interpolation_of(sampler.interpolation), std::move(times), {}};
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
    scene::SharedList<scene::Texture>& textures_;
    Context& context_;
    std::uint64_t keys_left_ = 0;
    std::map<Index, std::pair<double, double>> spans_;   // by accessor of key times
};

// Gives a material what its animated parts need: the block of layers, and transmission that is never quite 0.
void prepare(const Material& source, const scene::MaterialTrack& track, scene::Material& material)
{
    bool layers = false, transmits = false, thick = source.layers && source.layers->thickness > 0;
    for (const scene::MaterialPart& part : track.parts) {
        layers = layers || part.of_layers();
        if (const auto* const number = std::get_if<float scene::Material::*>(&part.member))
            transmits = transmits || *number == &scene::Material::transmission;
        if (const auto* const number = std::get_if<float scene::MaterialLayers::*>(&part.member))
            thick = thick || *number == &scene::MaterialLayers::thickness;
    }
    if (!layers && !transmits) return;
    scene::MaterialLayers block = material.layers ? *material.layers : scene::MaterialLayers();
    block.thin_walled = !thick;
    material.layers = std::make_shared<const scene::MaterialLayers>(block);
    // The class of a surface is the same at all times.
    if (transmits) track.apply(0, material);
}

// Gives the parts of the scene that a light, camera or material of the file became the tracks of its properties.
void set_tracks(Animations& animations, const Model& model, const std::pair<Owner, Index>& owner,
                const std::map<Property, Source>& sources, const PartIds& ids, const Materials& materials,
                scene::Scene& out)
{
    const auto [kind, index] = owner;
    if (kind == Owner::light) {
        const auto track = animations.light(model.lights[index], sources);
        for (const scene::LightId id : ids.lights[index]) out.lights[id].track = track;
    } else if (kind == Owner::camera) {
        const auto track = animations.camera(sources);
        for (const scene::CameraId id : ids.cameras[index]) out.cameras[id].track = track;
    } else {
        const scene::MaterialTrack track = animations.material(model.materials[index], sources);
        for (const Materials::Made& made : materials.made_of(index)) {
            auto own = std::make_shared<scene::MaterialTrack>(track);
            if (made.emits_nowhere) own->emissive = own->strength = nullptr;
            prepare(model.materials[index], *own, out.materials[made.id]);
            out.materials[made.id].track = std::move(own);
        }
    }
}

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

void build_animations(const Model& model, const Data& data, const PartIds& ids, const Materials& materials,
                      const std::string& chosen, scene::Scene& out, Context& context)
{
    Animations animations(model, data, out.textures, context);
    std::vector<Clip> clips;
    for (Index a = 0; a < model.animations.size(); ++a) clips.push_back(animations.clip(a, ids, materials));
    choose_clips(clips, chosen, context);

    // Let the playing clips move their targets. If two animate the same part of a node, or the same property, the first
    // one is used.
    std::map<Index, Moves> moves;
    std::map<std::pair<Owner, Index>, std::map<Property, Source>> properties;
    for (Index a = 0; a < clips.size(); ++a) {
        out.clips.push_back(clips[a].clip);
        if (!clips[a].clip.plays) continue;
        bool told = false;
        for (const auto& [target, channel] : clips[a].targets) {
            Source& source = target.property == Property::none
                                 ? moves[target.index].parts[static_cast<int>(target.path)]
                                 : properties[{owner_of(target.property), target.index}][target.property];
            if (!source.used()) {
                source = {a, channel, model.animations[a].channels[channel].sampler};
            } else if (!told) {
                told = true;
                context.warn(
                    at(at(at("/animations", a), "channels"), channel),
                    fmt::format("animates a property that animation {} animates already: ignored", source.animation));
            }
        }
    }

    animations.expect(moves);
    for (const auto& [index, move] : moves) {
        const Node& source = model.nodes[index];
        scene::Node& node = out.nodes[ids.nodes[index]];
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

    for (const auto& [owner, sources] : properties) set_tracks(animations, model, owner, sources, ids, materials, out);

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
