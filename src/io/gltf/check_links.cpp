// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "io/gltf/check.h"
#include "io/gltf/pointers.h"

namespace gnomon::io::gltf {

namespace {

using Role = AccessorUse::Role;

void check_camera(const Camera& camera, const std::string& here, Context& context)
{
    if (camera.has_perspective == camera.has_orthographic)
        context.fail(here, "must have exactly one of 'perspective' and 'orthographic'");
    if ((camera.type == "perspective" && !camera.has_perspective) ||
        (camera.type == "orthographic" && !camera.has_orthographic))
        context.fail(here, fmt::format("'{}' is missing, though it is the type", camera.type));
    const std::string place = at(here, camera.has_perspective ? "perspective" : "orthographic");
    if (camera.far && *camera.far <= camera.near)
        context.repair(Fault::camera_depth, place, [] { return "zfar must be greater than znear"; });
    if (camera.has_perspective && camera.yfov >= k_pi) context.warn(at(place, "yfov"), "should be less than pi");
    if (!camera.has_orthographic) return;
    if (camera.xmag == 0) context.fail(at(place, "xmag"), "must not be zero");
    if (camera.ymag == 0) context.fail(at(place, "ymag"), "must not be zero");
    if (camera.xmag < 0 || camera.ymag < 0) context.warn(place, "xmag and ymag should not be negative");
}

void check_light(const Light& light, const std::string& here, Context& context)
{
    if (light.type == "spot" && !light.has_spot) context.fail(here, "'spot' is missing, though it is the type");
    if (light.has_spot && light.outer <= light.inner)
        context.repair(Fault::cone, at(here, "spot"),
                       [] { return "outerConeAngle must be greater than innerConeAngle"; });
    for (const float c : light.color)
        if (!std::isfinite(c * light.intensity)) context.fail(at(here, "intensity"), "is too large");
}

void check_image(const Model& model, Index index, Uses& uses, Context& context)
{
    const Image& image = model.images[index];
    const std::string here = at("/images", index);
    if (image.uri && image.view != k_absent)
        context.repair(Fault::image_source, here, [] { return "has both 'uri' and 'bufferView'"; });
    if (!image.uri && image.view == k_absent && !image.extended)
        context.repair(Fault::image_source, here, [] { return "has neither 'uri' nor 'bufferView'"; });
    if (image.view == k_absent) return;
    if (image.mime_type.empty())
        context.repair(Fault::image_source, at(here, "bufferView"), [] { return "requires 'mimeType'"; });
    uses.view(image.view, Uses::ViewRole::image, at(here, "bufferView"));
    if (model.views[image.view].stride != 0)
        context.repair(Fault::stride, at(here, "bufferView"),
                       [] { return "the buffer view of an image cannot have a stride"; });
}

void check_skin(const Model& model, Index index, Uses& uses, Context& context)
{
    const Skin& skin = model.skins[index];
    if (skin.inverse_bind == k_absent) return;
    const std::string place = at(at("/skins", index), "inverseBindMatrices");
    const Accessor& accessor = model.accessors[skin.inverse_bind];
    uses.accessor(skin.inverse_bind, Role::inverse_bind, place);
    if (accessor.view != k_absent) {
        uses.view(accessor.view, Uses::ViewRole::inverse_bind, place);
        if (model.views[accessor.view].stride != 0)
            context.repair(Fault::stride, place,
                           [] { return "the buffer view of inverse bind matrices cannot have a stride"; });
    }
    if (!accessor.known()) context.fail(place, "has an unknown type");
    if (accessor.shape != Shape::mat4 || accessor.component != Component::f32)
        context.fail(place, fmt::format("inverse bind matrices cannot be {}", accessor.format()));
    if (accessor.count < skin.joints.size())
        context.fail(place, fmt::format("{} matrices for {} joints", accessor.count, skin.joints.size()));
}

void check_material(const Material& material, const std::string& here, const Context& context)
{
    for (const float e : material.emissive)
        if (!std::isfinite(e * material.emissive_strength)) context.fail(here, "the emitted light is too large");
    const std::pair<const TextureInfo*, const char*> uses[] = {
        {&material.base_color_texture, "baseColorTexture"},
        {&material.metallic_roughness_texture, "metallicRoughnessTexture"},
        {&material.normal_texture, "normalTexture"},
        {&material.occlusion_texture, "occlusionTexture"},
        {&material.emissive_texture, "emissiveTexture"},
        {material.glossiness ? &material.glossiness->diffuse_texture : nullptr, "diffuseTexture"},
        {material.glossiness ? &material.glossiness->specular_texture : nullptr, "specularGlossinessTexture"}};
    const auto check = [&](const TextureInfo& info, const char* name) {
        const float sum = info.offset.x + info.offset.y + info.scale.x + info.scale.y + info.rotation + info.factor;
        if (!std::isfinite(sum)) context.fail(at(here, name), "a number is too large");
    };
    for (const auto& [info, name] : uses)
        if (info) check(*info, name);
    if (material.layers) {
        const Layers& l = *material.layers;
        for (const LayerTexture& texture : k_layer_textures) check(l.*texture.info, texture.property);
        float sum = l.anisotropy_rotation + l.iridescence_ior + l.iridescence_thickness_least +
                    l.iridescence_thickness_most + l.thickness + l.attenuation_distance + l.dispersion;
        for (const float c : l.specular_color) sum += c;
        if (!std::isfinite(sum)) context.fail(here, "a number is too large");
    }
    if (!std::isfinite(material.ior + material.alpha_cutoff)) context.fail(here, "a number is too large");
}

bool format_fits(const Accessor& accessor, Path path)
{
    const bool fraction = accessor.component == Component::f32
                              ? !accessor.normalized
                              : accessor.normalized && accessor.component != Component::u32;
    const bool plain = accessor.component == Component::f32 && !accessor.normalized;
    switch (path) {
        case Path::translation:
        case Path::scale:
            return accessor.shape == Shape::vec3 && plain;
        case Path::rotation:
            return accessor.shape == Shape::vec4 && fraction;
        case Path::weights:
            return accessor.shape == Shape::scalar && fraction;
        case Path::visibility:
            return accessor.shape == Shape::scalar && accessor.component == Component::u8 && !accessor.normalized;
        default:
            return true;
    }
}

bool format_fits(const Accessor& accessor, Property property)
{
    const int n = components_of(property);
    const Shape shape = n == 1 ? Shape::scalar : n == 2 ? Shape::vec2 : n == 3 ? Shape::vec3 : Shape::vec4;
    const bool is_float = accessor.component == Component::f32;
    const bool fraction = accessor.normalized && !is_float && accessor.component != Component::u32;
    return accessor.shape == shape && (fraction || (is_float && !accessor.normalized));
}

// Compares counts by division, because a document's numbers may be as large as 2^53.
void check_counts(const Accessor& input, const Accessor& output, std::uint64_t each, const std::string& place,
                  const Context& context)
{
    if (output.count % each != 0 || output.count / each != input.count)
        context.fail(place,
                     fmt::format("{} values for {} keys, expected {} for each", output.count, input.count, each));
}

// Checks the output's format and count against the property that a pointer animates.
void check_property(const Model& model, const Animation& animation, const Channel& channel, const std::string& place,
                    const Context& context)
{
    const AnimationSampler& sampler = animation.samplers[channel.sampler];
    const Accessor& input = model.accessors[sampler.input];
    const Accessor& output = model.accessors[sampler.output];
    if (!output.known() || !input.known() || sampler.interpolation == Interpolation::unknown) return;
    if (!format_fits(output, channel.property))
        context.fail(at(place, "sampler"), fmt::format("'{}' cannot be {}", channel.pointer, output.format()));
    check_counts(input, output, sampler.interpolation == Interpolation::cubic_spline ? 3 : 1, at(place, "sampler"),
                 context);
}

}   // namespace

void check_animation(const Model& model, Index index, Uses& uses, Context& context)
{
    const Animation& animation = model.animations[index];
    const std::string here = at("/animations", index);

    // Check the accessors of samplers.
    for (std::size_t i = 0; i < animation.samplers.size(); ++i) {
        const AnimationSampler& sampler = animation.samplers[i];
        const std::string place = at(at(here, "samplers"), i);
        const std::string input_place = at(place, "input"), output_place = at(place, "output");
        for (const auto& [accessor, role, pointer] :
             {std::tuple(sampler.input, Role::animation_input, input_place),
              std::tuple(sampler.output, Role::animation_output, output_place)}) {
            uses.accessor(accessor, role, pointer);
            const Index view = model.accessors[accessor].view;
            if (view == k_absent) continue;
            if (model.views[view].stride != 0)
                context.repair(Fault::stride, pointer,
                               [] { return "the buffer view of animation data cannot have a stride"; });
            uses.view(view, Uses::ViewRole::other, pointer);
        }
        const Accessor& input = model.accessors[sampler.input];
        if (!input.known()) continue;
        if (input.shape != Shape::scalar || input.component != Component::f32 || input.normalized)
            context.fail(input_place, fmt::format("key times cannot be {}", input.format()));
        if (input.min.empty() || input.max.empty())
            context.repair(Fault::bounds, input_place, [] { return "key times must declare min and max"; });
        if (sampler.interpolation == Interpolation::cubic_spline && input.count < 2)
            context.fail(input_place, "a cubic spline needs at least 2 keys");
    }

    // Check the targets of channels.
    std::set<std::tuple<Index, std::string>> seen;
    for (std::size_t i = 0; i < animation.channels.size(); ++i) {
        const Channel& channel = animation.channels[i];
        const std::string place = at(at(here, "channels"), i);
        const std::string target = at(place, "target");
        if (channel.sampler >= animation.samplers.size())
            context.fail(at(place, "sampler"), fmt::format("refers to {}, but there are {} samplers", channel.sampler,
                                                           animation.samplers.size()));
        if (channel.has_pointer && channel.path != Path::pointer)
            context.fail(at(at(target, "extensions"), "KHR_animation_pointer"), "the path must be 'pointer'");
        if (channel.has_pointer && channel.node != k_absent)
            context.fail(at(target, "node"), "cannot be combined with KHR_animation_pointer");
        if (channel.property != Property::none) {
            check_property(model, animation, channel, place, context);
            continue;
        }
        if (channel.node == k_absent || channel.path == Path::pointer || channel.path == Path::unknown) continue;
        if (!seen.insert({channel.node, channel.path_word}).second) {
            context.repair(Fault::channel, target, [] { return "another channel has the same target"; });
            continue;
        }

        const Node& node = model.nodes[channel.node];
        const bool moves = channel.path != Path::weights;
        if (moves && channel.path != Path::visibility && node.matrix)
            context.fail(target, "the node has a matrix, which cannot be animated");
        const std::size_t targets = node.mesh == k_absent ? 0 : model.meshes[node.mesh].targets();
        if (!moves && targets == 0) {
            context.repair(Fault::channel, target, [] { return "the node has no morph targets"; });
            continue;
        }

        // Check the output's format and count against the target.
        const AnimationSampler& sampler = animation.samplers[channel.sampler];
        const Accessor& input = model.accessors[sampler.input];
        const Accessor& output = model.accessors[sampler.output];
        if (!output.known() || !input.known() || sampler.interpolation == Interpolation::unknown) continue;
        if (!format_fits(output, channel.path))
            context.fail(at(place, "sampler"), fmt::format("{} cannot be {}", channel.path_word, output.format()));
        const bool cubic = sampler.interpolation == Interpolation::cubic_spline;
        if (channel.path == Path::rotation) {
            AccessorUse& use = uses.accessor(sampler.output, Role::animation_output, place);
            use.quaternion = true;
            use.cubic = cubic;
        }
        check_counts(input, output, (cubic ? 3u : 1u) * static_cast<std::uint64_t>(moves ? 1 : targets),
                     at(place, "sampler"), context);
    }
}

std::vector<AccessorUse> check_links(const Model& model, const std::vector<TextureBinding>& bindings, Context& context)
{
    std::vector<std::vector<const TextureBinding*>> by_material(model.materials.size());
    for (const TextureBinding& binding : bindings)
        if (binding.material < by_material.size()) by_material[binding.material].push_back(&binding);

    Uses uses(model, context);
    for (Index i = 0; i < model.images.size(); ++i) check_image(model, i, uses, context);
    for (Index i = 0; i < model.meshes.size(); ++i) check_mesh(model, i, by_material, uses, context);
    for (Index i = 0; i < model.skins.size(); ++i) check_skin(model, i, uses, context);
    for (Index i = 0; i < model.animations.size(); ++i) check_animation(model, i, uses, context);
    for (Index i = 0; i < model.cameras.size(); ++i) check_camera(model.cameras[i], at("/cameras", i), context);
    for (Index i = 0; i < model.lights.size(); ++i)
        check_light(model.lights[i], at("/extensions/KHR_lights_punctual/lights", i), context);
    for (Index i = 0; i < model.materials.size(); ++i) check_material(model.materials[i], at("/materials", i), context);
    return uses.take();
}

}   // namespace gnomon::io::gltf
