// SPDX-License-Identifier: Apache-2.0
#include "raster/raster_frame.h"

#include <algorithm>

#include "base/check.h"
#include "gpu_scene/scene_blocks.h"
#include "scene/environment.h"

namespace gnomon::raster {

namespace {

using shared::BouncePush;
using shared::DrawPush;
using shared::ResolvePush;
using shared::ShadePush;
using vk::Use;

constexpr std::uint32_t k_visibility_vert[] =
#include "raster/visibility.vert.inc"
    ;
constexpr std::uint32_t k_visibility_frag[] =
#include "raster/visibility.frag.inc"
    ;
constexpr std::uint32_t k_masked_vert[] =
#include "raster/visibility_masked.vert.inc"
    ;
constexpr std::uint32_t k_masked_frag[] =
#include "raster/visibility_masked.frag.inc"
    ;
constexpr std::uint32_t k_peel_frag[] =
#include "raster/visibility_peel.frag.inc"
    ;
constexpr std::uint32_t k_resolve_comp[] =
#include "raster/resolve.comp.inc"
    ;
constexpr std::uint32_t k_shade_comp[] =
#include "raster/shade.comp.inc"
    ;
constexpr std::uint32_t k_bounce_comp[] =
#include "raster/bounce.comp.inc"
    ;

constexpr VkFormat k_id_format = VK_FORMAT_R32G32_UINT;
constexpr VkFormat k_depth_format = VK_FORMAT_D32_SFLOAT;
constexpr VkFormat k_wide_format = VK_FORMAT_R32G32B32A32_SFLOAT;
constexpr float k_nearest = 1e-6f;   // scene units: what a perspective view without a near plane begins at

// From one light's layer of what is lit to the next. Each can be bound: whole multiples of 256 bytes always can.
std::size_t lit_pixels(Size size)
{
    const std::size_t pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
    return (pixels + 63) / 64 * 64;
}

}   // namespace

void frustum_planes(const scene::View& view, glm::vec4 (&planes)[6])
{
    // In units of the half extent: x is inside where |x| <= reach, and reach grows with distance or is 1.
    const glm::vec3 x = view.right / glm::dot(view.right, view.right), y = view.up / glm::dot(view.up, view.up);
    const glm::vec3 reach = view.orthographic ? glm::vec3(0) : view.forward;
    const float constant = view.orthographic ? 1.0f : 0.0f;
    const auto plane = [&](const glm::vec3& n, float at_eye) { return glm::vec4(n, at_eye - glm::dot(n, view.eye)); };
    planes[0] = plane(reach + x, constant);
    planes[1] = plane(reach - x, constant);
    planes[2] = plane(reach + y, constant);
    planes[3] = plane(reach - y, constant);
    planes[4] = plane(view.forward, -view.near);
    planes[5] = std::isfinite(view.far) ? plane(-view.forward, view.far) : glm::vec4(0, 0, 0, 1);
}

RasterFrame::RasterFrame(const scene::SceneState& state) : RasterFrame(vk::Device::open(), state) {}

RasterFrame::RasterFrame(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state)
    : device_(device), described_(state.shared_scene()), scene_(device, state), commands_(device)
{
    make_pipelines();
    frame_ = vk::Buffer(device_, "frame", sizeof(shared::RasterFrame));
    environment_ = vk::Buffer(device_, "environment", 4 * sizeof(float));
    if (const auto& environment = described_->background.environment;
        environment && described_->background.kind == scene::Background::Kind::image) {
        const ImageF& image = environment->image();
        std::vector<float> wide(image.data.size() / 3 * 4, 0.0f);
        for (std::size_t i = 0; i < wide.size() / 4; ++i) std::copy_n(&image.data[3 * i], 3, &wide[4 * i]);
        environment_ = vk::Buffer(device_, "environment", wide.size() * sizeof(float));
        const vk::Upload upload = vk::upload_of(environment_, std::span<const float>(wide));
        commands_.upload("send environment", {&upload, 1});
        commands_.submit();
    }
}

void RasterFrame::make_pipelines()
{
    using vk::ComputeDesc;
    using vk::GraphicsDesc;
    const vk::BlockExpectation draw_push = vk::shared_push<DrawPush>();
    const std::vector frame_block{vk::shared_block<shared::RasterFrame>("Frame")};
    opaque_ = vk::Pipeline(device_, GraphicsDesc{.name = "ids",
                                                 .vertex = {"visibility.vert", k_visibility_vert},
                                                 .fragment = {"visibility.frag", k_visibility_frag},
                                                 .colors = {k_id_format},
                                                 .depth = k_depth_format,
                                                 .blocks = vk::all_blocks(draw_push, gpu_scene::draw_blocks())});
    masked_ = vk::Pipeline(device_, GraphicsDesc{.name = "ids with holes",
                                                 .vertex = {"visibility_masked.vert", k_masked_vert},
                                                 .fragment = {"visibility_masked.frag", k_masked_frag},
                                                 .colors = {k_id_format},
                                                 .depth = k_depth_format,
                                                 .blocks = vk::all_blocks(draw_push, gpu_scene::scene_data_blocks())});
    peel_ = vk::Pipeline(device_, GraphicsDesc{.name = "peel",
                                               .vertex = {"visibility.vert", k_visibility_vert},
                                               .fragment = {"visibility_peel.frag", k_peel_frag},
                                               .colors = {k_id_format},
                                               .depth = k_depth_format,
                                               .blocks = vk::all_blocks(draw_push, gpu_scene::draw_blocks())});
    resolve_ =
        vk::Pipeline(device_, ComputeDesc{.name = "surfaces",
                                          .code = {"resolve.comp", k_resolve_comp},
                                          .blocks = vk::all_blocks(vk::shared_push<ResolvePush>(),
                                                                   gpu_scene::scene_data_blocks(), frame_block)});
    shade_ = vk::Pipeline(
        device_,
        ComputeDesc{.name = "lights",
                    .code = {"shade.comp", k_shade_comp},
                    .blocks = vk::all_blocks(vk::shared_push<ShadePush>(), frame_block,
                                             std::vector{vk::shared_block<gpu_scene::shared::GpuLight>("lights")})});
    bounce_ = vk::Pipeline(device_, ComputeDesc{.name = "bounced light",
                                                .code = {"bounce.comp", k_bounce_comp},
                                                .blocks = vk::all_blocks(vk::shared_push<BouncePush>(), frame_block)});
}

// Images of the image's size; kept from frame to frame.
void RasterFrame::fit(Size size, const RasterOptions& options, std::size_t lights)
{
    const auto width = static_cast<std::uint32_t>(size.width), height = static_cast<std::uint32_t>(size.height);
    constexpr VkImageUsageFlags made = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    constexpr VkImageUsageFlags drawn = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    constexpr VkImageUsageFlags depth = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    const auto image = [&](const char* name, VkFormat format, VkImageUsageFlags usage) {
        return vk::Image(device_, {.name = name, .width = width, .height = height, .format = format, .usage = usage});
    };
    if (size != size_) {
        opaque_ids_ = image("opaque ids", k_id_format, drawn);
        opaque_depth_ = image("opaque depth", k_depth_format, depth);
        surfaces_.position = image("position", k_wide_format, made);
        surfaces_.normal = image("normal", k_wide_format, made);
        surfaces_.geometric = image("geometric normal", k_wide_format, made);
        surfaces_.diffuse = image("diffuse", k_wide_format, made);
        surfaces_.specular = image("specular", k_wide_format, made);
        surfaces_.ids = image("ids", k_id_format, made);
        color_ = image("colour", k_wide_format, made);
        through_ = image("through", k_wide_format, made);
        share_ = image("share", k_wide_format, made);
        size_ = size;
    }
    // What only some frames need is one pixel large in the others.
    const auto fitting = [&](vk::Image& there, const vk::ImageDesc& wanted) {
        const vk::ImageDesc& has = there.desc();
        if (!there || has.width != wanted.width || has.height != wanted.height || has.layers != wanted.layers)
            there = vk::Image(device_, wanted);
    };
    const bool peels = scene_.has_transparent();
    const auto optional = [&](bool needed, const char* name, VkFormat format, VkImageUsageFlags usage) {
        return vk::ImageDesc{
            .name = name, .width = needed ? width : 1, .height = needed ? height : 1, .format = format, .usage = usage};
    };
    fitting(peeled_ids_, optional(peels, "peeled ids", k_id_format, drawn));
    fitting(peel_depth_[0], optional(peels, "peel depth 0", k_depth_format, depth));
    fitting(peel_depth_[1], optional(peels, "peel depth 1", k_depth_format, depth));
    fitting(direct_, optional(options.layers, "direct", k_wide_format, made));
    fitting(indirect_, optional(options.layers && bounced_, "indirect", k_wide_format, made));
    fitting(irradiance_, optional(bounced_ != nullptr, "irradiance", k_wide_format, made));
    vk::ImageDesc visible = optional(visibility_ != nullptr, "light visibility", VK_FORMAT_R8_UNORM, made | drawn);
    visible.array = true;
    if (visibility_) visible.layers = std::max(1u, std::min(options.light_batch, static_cast<std::uint32_t>(lights)));
    fitting(lights_visible_, visible);
    const VkDeviceSize one = lit_pixels(size) * sizeof(float);
    if (options.layers) device_->check_storage_range("lit", one);
    const VkDeviceSize lit_bytes = options.layers ? std::max<VkDeviceSize>(lights, 1) * one : sizeof(float);
    if (lit_.bytes() != lit_bytes) lit_ = vk::Buffer(device_, "lit", lit_bytes);
}

void RasterFrame::send_frame(const scene::View& view)
{
    const scene::Background& background = described_->background;
    shared::RasterFrame f{};
    f.eye = view.eye;
    f.orthographic = view.orthographic ? 1 : 0;
    f.right = view.right, f.up = view.up, f.forward = view.forward;
    f.width = static_cast<std::uint32_t>(view.size.width);
    f.height = static_cast<std::uint32_t>(view.size.height);
    f.pixel_spread = view.pixel_spread;
    f.pixel_width = view.pixel_width;
    f.background = static_cast<std::uint32_t>(background.kind);
    f.background_color = background.color;
    f.zenith = background.zenith, f.horizon = background.horizon, f.ground = background.ground;
    f.sun_direction = background.sun_direction, f.sun_radiance = background.sun_radiance;
    f.ambient = described_->ambient;
    f.stand_in = bounced_ ? 0 : 1;
    if (background.kind == scene::Background::Kind::image) {
        f.environment_width = static_cast<std::uint32_t>(background.environment->image().width);
        f.environment_height = static_cast<std::uint32_t>(background.environment->image().height);
        std::copy(background.environment->harmonics().begin(), background.environment->harmonics().end(), f.harmonics);
    }
    const vk::Upload upload = vk::upload_of(frame_, std::span<const shared::RasterFrame>(&f, 1));
    commands_.upload("send view", {&upload, 1});
}

// Offset from the eye to clip space, with reversed depth: 1 at the near plane, 0 far away.
DrawPush RasterFrame::draw_push(const scene::View& view, glm::vec2 offset) const
{
    const glm::vec3 x = view.right / glm::dot(view.right, view.right), y = -view.up / glm::dot(view.up, view.up);
    glm::vec4 rows[4] = {glm::vec4(x, 0), glm::vec4(y, 0), glm::vec4(0), glm::vec4(view.forward, 0)};
    if (view.orthographic) {
        const float far = std::isfinite(view.far) ? view.far : unlimited_far_;
        rows[2] = glm::vec4(-view.forward, far) / (far - view.near);
        rows[3] = glm::vec4(0, 0, 0, 1);
    } else {
        const float near = std::max(view.near, k_nearest);
        rows[2] = std::isfinite(view.far) ? near / (view.far - near) * glm::vec4(-view.forward, view.far)
                                          : glm::vec4(0, 0, 0, near);
    }
    // The sample's place in the pixel: the image moves the other way.
    const glm::vec2 move = -2.0f * (offset - 0.5f) / glm::vec2(view.size.width, view.size.height);
    rows[0] += move.x * rows[3];
    rows[1] += move.y * rows[3];
    DrawPush push{};
    push.clip_from_offset = glm::transpose(glm::mat4(rows[0], rows[1], rows[2], rows[3]));
    push.eye = view.eye;
    return push;
}

void RasterFrame::draw_groups(vk::Recorder& r, scene::SurfaceClass surface) const
{
    for (const gpu_scene::DrawGroup& group : scene_.groups()) {
        if (group.surface != surface) continue;
        r.cull(group.cull);
        r.draw_indexed_indirect(scene_.commands_buffer, group.first * sizeof(VkDrawIndexedIndirectCommand),
                                group.count);
    }
}

void RasterFrame::draw_ids(const DrawPush& push)
{
    const auto has = [&](scene::SurfaceClass surface) {
        return std::any_of(scene_.groups().begin(), scene_.groups().end(),
                           [&](const gpu_scene::DrawGroup& g) { return g.surface == surface; });
    };
    commands_.pass("ids")
        .reads(scene_.objects, Use::storage_read)
        .reads(scene_.draws, Use::storage_read)
        .reads(scene_.materials, Use::storage_read)
        .reads(scene_.textures, Use::storage_read)
        .reads(scene_.texels, Use::sampled)
        .reads(scene_.texcoords, Use::storage_read)
        .reads(scene_.colors, Use::storage_read)
        .reads(scene_.positions, Use::vertices)
        .reads(scene_.indices, Use::vertices)
        .reads(scene_.commands_buffer, Use::indirect)
        .color({.image = &opaque_ids_, .clear = VkClearColorValue{}})
        .depth({.image = &opaque_depth_, .clear = 0.0f})
        .render([&](vk::Recorder& r) {
            const auto bind = [&](const vk::Pipeline& pipeline) {
                r.bind(pipeline);
                r.set("objects", scene_.objects);
                r.set("draws", scene_.draws);
                r.push(push);
                r.vertex_buffer(0, scene_.positions);
                r.index_buffer(scene_.indices);
            };
            if (has(scene::SurfaceClass::opaque)) {
                bind(opaque_);
                draw_groups(r, scene::SurfaceClass::opaque);
            }
            if (has(scene::SurfaceClass::masked)) {
                bind(masked_);
                r.set("materials", scene_.materials);
                r.set("textures", scene_.textures);
                r.set_texels("texels", scene_.texels, gpu_scene::GpuScene::k_texel_format);
                r.set("texcoords", scene_.texcoords);
                r.set("colors", scene_.colors);
                draw_groups(r, scene::SurfaceClass::masked);
            }
        });
}

void RasterFrame::peel(const DrawPush& push, const vk::Image& last_depth, const vk::Image& depth)
{
    commands_.pass("peel")
        .reads(scene_.objects, Use::storage_read)
        .reads(scene_.draws, Use::storage_read)
        .reads(scene_.positions, Use::vertices)
        .reads(scene_.indices, Use::vertices)
        .reads(scene_.commands_buffer, Use::indirect)
        .reads(opaque_depth_, Use::sampled)
        .reads(last_depth, Use::sampled)
        .color({.image = &peeled_ids_, .clear = VkClearColorValue{}})
        .depth({.image = &depth, .clear = 0.0f})
        .render([&](vk::Recorder& r) {
            r.bind(peel_);
            r.set("objects", scene_.objects);
            r.set("draws", scene_.draws);
            r.set("opaque_depth", opaque_depth_);
            r.set("last_depth", last_depth);
            r.push(push);
            r.vertex_buffer(0, scene_.positions);
            r.index_buffer(scene_.indices);
            draw_groups(r, scene::SurfaceClass::transparent);
        });
}

void RasterFrame::resolve(const ResolvePush& push)
{
    commands_.pass("surfaces")
        .reads(scene_.objects, Use::storage_read)
        .reads(scene_.draws, Use::storage_read)
        .reads(scene_.materials, Use::storage_read)
        .reads(scene_.textures, Use::storage_read)
        .reads(scene_.texels, Use::sampled)
        .reads(scene_.texcoords, Use::storage_read)
        .reads(scene_.colors, Use::storage_read)
        .reads(scene_.positions, Use::storage_read)
        .reads(scene_.normals, Use::storage_read)
        .reads(scene_.indices, Use::storage_read)
        .reads(frame_, Use::storage_read)
        .reads(environment_, Use::sampled)
        .reads(opaque_ids_, Use::sampled)
        .reads(peeled_ids_, Use::sampled)
        .writes(color_)
        .writes(through_)
        .writes(share_)
        .writes(surfaces_.position)
        .writes(surfaces_.normal)
        .writes(surfaces_.geometric)
        .writes(surfaces_.diffuse)
        .writes(surfaces_.specular)
        .writes(surfaces_.ids)
        .compute([&](vk::Recorder& r) {
            r.bind(resolve_);
            r.set("objects", scene_.objects);
            r.set("draws", scene_.draws);
            r.set("materials", scene_.materials);
            r.set("textures", scene_.textures);
            r.set_texels("texels", scene_.texels, gpu_scene::GpuScene::k_texel_format);
            r.set("texcoords", scene_.texcoords);
            r.set("colors", scene_.colors);
            r.set("positions", scene_.positions);
            r.set("normals", scene_.normals);
            r.set("indices", scene_.indices);
            r.set("Frame", frame_);
            r.set_texels("environment", environment_, k_wide_format);
            r.set("opaque_ids", opaque_ids_);
            r.set("peeled_ids", peeled_ids_);
            r.set("color", color_);
            r.set("through", through_);
            r.set("share", share_);
            r.set("g_position", surfaces_.position);
            r.set("g_normal", surfaces_.normal);
            r.set("g_geometric", surfaces_.geometric);
            r.set("g_diffuse", surfaces_.diffuse);
            r.set("g_specular", surfaces_.specular);
            r.set("g_ids", surfaces_.ids);
            r.push(push);
            r.dispatch_over(static_cast<std::uint32_t>(size_.width), static_cast<std::uint32_t>(size_.height));
        });
}

// Adds all lights, a batch at a time where their shadows are asked for. Layers of what is lit can be more than a shader
// can be given at once: it then goes over the batch again for others, and adds to the colours the first time alone, so
// that these do not depend on it.
void RasterFrame::light(const RasterOptions& options, bool layers)
{
    const auto lights = static_cast<std::uint32_t>(described_->lights.size());
    const std::uint32_t batch = visibility_ ? std::max(1u, options.light_batch) : lights;
    const VkDeviceSize one = lit_pixels(size_) * sizeof(float), most = device_->limits().maxStorageBufferRange;
    const auto at_once = static_cast<std::uint32_t>(layers ? std::min<VkDeviceSize>(most / one, lights) : lights);
    for (std::uint32_t first = 0; first < lights; first += batch) {
        const std::uint32_t count = std::min(batch, lights - first);
        if (visibility_) visibility_->fill(commands_, surfaces_, first, count, lights_visible_);
        commands_.pass("lights")
            .reads(frame_, Use::storage_read)
            .reads(scene_.lights, Use::storage_read)
            .writes(color_)
            .writes(direct_)
            .reads(share_, Use::sampled)
            .reads(surfaces_.position, Use::sampled)
            .reads(surfaces_.normal, Use::sampled)
            .reads(surfaces_.geometric, Use::sampled)
            .reads(surfaces_.diffuse, Use::sampled)
            .reads(surfaces_.specular, Use::sampled)
            .reads(lights_visible_, Use::sampled)
            .writes(lit_)
            .compute([&](vk::Recorder& r) {
                r.bind(shade_);
                r.set("Frame", frame_);
                r.set("lights", scene_.lights);
                r.set("color", color_);
                r.set("direct", direct_);
                r.set("share", share_);
                r.set("g_position", surfaces_.position);
                r.set("g_normal", surfaces_.normal);
                r.set("g_geometric", surfaces_.geometric);
                r.set("g_diffuse", surfaces_.diffuse);
                r.set("g_specular", surfaces_.specular);
                r.set("visibility", lights_visible_);
                for (std::uint32_t lit = 0; lit < count; lit += at_once) {
                    const std::uint32_t bound = std::min(at_once, count - lit);
                    r.set("lit_layers", lit_, layers ? (first + lit) * one : 0, layers ? bound * one : lit_.bytes());
                    r.push(ShadePush{first, count, visibility_ ? 1u : 0u, lit == 0 ? 1u : 0u, layers ? 1u : 0u, lit,
                                     layers ? bound : 0, static_cast<std::uint32_t>(lit_pixels(size_))});
                    r.dispatch_over(static_cast<std::uint32_t>(size_.width), static_cast<std::uint32_t>(size_.height));
                }
            });
    }
}

// Adds the light of one bounce.
void RasterFrame::bounce(const scene::View& view, bool layers)
{
    if (!bounced_) return;
    bounced_->fill(commands_, surfaces_, view, irradiance_);
    vk::Pass pass = commands_.pass("bounced light");
    pass.reads(frame_, Use::storage_read).writes(color_).writes(indirect_);
    const std::pair<const char*, const vk::Image*> inputs[] = {
        {"share", &share_},
        {"g_position", &surfaces_.position},
        {"g_normal", &surfaces_.normal},
        {"g_geometric", &surfaces_.geometric},
        {"g_diffuse", &surfaces_.diffuse},
        {"g_specular", &surfaces_.specular},
        {"irradiance", &irradiance_},
    };
    for (const auto& [name, image] : inputs) pass.reads(*image, Use::sampled);
    pass.compute([&](vk::Recorder& r) {
        r.bind(bounce_);
        r.set("Frame", frame_);
        r.set("color", color_);
        r.set("indirect", indirect_);
        for (const auto& [name, image] : inputs) r.set(name, *image);
        r.push(BouncePush{layers ? 1u : 0u});
        r.dispatch_over(static_cast<std::uint32_t>(size_.width), static_cast<std::uint32_t>(size_.height));
    });
}

void RasterFrame::clear(const vk::Image& image, float value)
{
    if (vk::is_depth(image.format())) {
        commands_.pass("clear " + image.name()).depth({.image = &image, .clear = value}).render([](vk::Recorder&) {});
        return;
    }
    commands_.pass("clear " + image.name()).writes(image, Use::copy_target).copy([&](vk::Recorder& r) {
        r.clear(image, value);
    });
}

void RasterFrame::update(const scene::SceneState& state)
{
    scene_.update(commands_, state);
}

FrameCounters RasterFrame::render(const scene::SceneState& state, const scene::View& view, const RasterOptions& options,
                                  shading::FrameBuffers& out, const Progress& progress)
{
    const Size size = view.size;
    const std::size_t lights = described_->lights.size();
    fit(size, options, lights);
    if (view.orthographic && !std::isfinite(view.far)) {
        const Box3 bounds = described_->bounds(state.time());
        unlimited_far_ = view.near + std::max(1.0f, bounds.diagonal() + glm::length(bounds.centre() - view.eye));
    }
    send_frame(view);
    if (bounced_) bounced_->update(commands_, scene_, state);
    glm::vec4 planes[6];
    frustum_planes(view, planes);
    scene_.cull(commands_, planes);
    clear(color_, 0);
    clear(direct_, 0);
    if (bounced_) clear(indirect_, 0);
    if (options.layers)
        commands_.pass("forget lit").writes(lit_, Use::copy_target).copy([&](vk::Recorder& r) { r.fill(lit_, 0); });
    if (visibility_) visibility_->update(commands_, scene_, state, view);

    const bool peels = scene_.has_transparent();
    const int layers = peels ? options.transparent_layers + 1 : 1;
    const auto pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
    const auto resize = [&](ImageF& image, int channels) {
        if (image.width != size.width || image.height != size.height || image.channels != channels)
            image = ImageF(size.width, size.height, channels);
    };
    // Four floats a pixel to three.
    const auto store = [&](const vk::Buffer& from, ImageF& to, float scale, bool add) {
        const std::span<const float> wide = from.as<float>();
        for (std::size_t i = 0; i < pixels; ++i)
            for (std::size_t c = 0; c < 3; ++c)
                to.data[3 * i + c] = (add ? to.data[3 * i + c] : 0) + scale * wide[4 * i + c];
    };

    FrameCounters counters;
    std::uint64_t visibility_draws = 0;
    for (int sample = 0; sample < options.samples; ++sample) {
        const glm::vec2 offset = scene::sample_offset(sample, options.samples);
        const DrawPush push = draw_push(view, offset);
        draw_ids(push);
        if (peels) clear(peel_depth_[1], 1);
        const float weight = 1.0f / static_cast<float>(options.samples);
        std::vector<vk::Buffer> surfaces;
        std::optional<vk::Buffer> ids;
        for (int layer = 0; layer < layers; ++layer) {
            const bool peeled = layer + 1 < layers;
            if (peeled) peel(push, peel_depth_[(layer + 1) % 2], peel_depth_[layer % 2]);
            resolve({offset, weight, layer == 0 ? 1u : 0u, peeled ? 1u : 0u, layer + 1 == layers ? 1u : 0u});
            light(options, options.layers && layer == 0);
            bounce(view, options.layers && layer == 0);
            if (options.ids && sample == 0 && layer == 0) ids = commands_.read_back(surfaces_.ids);
            if (!options.layers || layer > 0) continue;
            for (const vk::Image* image : {&surfaces_.diffuse, &surfaces_.specular})
                surfaces.push_back(commands_.read_back(*image));
            if (sample == 0)
                for (const vk::Image* image : {&surfaces_.normal, &surfaces_.position})
                    surfaces.push_back(commands_.read_back(*image));
        }
        // One submit a sample: progress can be told, and a long frame is no single long submit.
        std::optional<vk::Buffer> color, direct, indirect, lit;
        const bool last = sample + 1 == options.samples;
        if (last) {
            color = commands_.read_back(color_);
            if (options.layers) direct = commands_.read_back(direct_), lit = commands_.read_back(lit_);
            if (options.layers && bounced_) indirect = commands_.read_back(indirect_);
        }
        const vk::Buffer drawn = commands_.read_back(scene_.counts_buffer);
        commands_.submit();
        counters.draws += drawn.as<std::uint32_t>()[0];
        if (ids) {
            *options.ids = IdImage(size.width, size.height, 2);
            std::copy_n(ids->as<std::uint32_t>().data(), options.ids->data.size(), options.ids->data.data());
        }

        if (options.layers) {
            resize(out.albedo, 3);
            store(surfaces[0], out.albedo, weight, sample > 0);
            store(surfaces[1], out.albedo, weight, true);
            if (sample == 0) {
                resize(out.normal, 3);
                resize(out.depth, 1);
                store(surfaces[2], out.normal, 1, false);
                for (std::size_t i = 0; i < pixels; ++i) out.depth.data[i] = surfaces[3].as<float>()[4 * i + 3];
            }
        }
        if (last) {
            resize(out.color, 3);
            store(*color, out.color, 1, false);
            if (options.layers) {
                resize(out.direct, 3);
                store(*direct, out.direct, 1, false);
                if (indirect) {
                    resize(out.indirect, 3);
                    store(*indirect, out.indirect, 1, false);
                }
                resize(out.shadow, static_cast<int>(lights));
                const std::span<const float> values = lit->as<float>();
                for (std::size_t l = 0; l < lights; ++l)
                    for (std::size_t i = 0; i < pixels; ++i)
                        out.shadow.data[i * lights + l] = values[l * lit_pixels(size) + i];
            }
        }
        if (progress && !progress({"drawing", static_cast<double>(sample + 1) / options.samples}))
            throw InterruptedError("interrupted");
    }
    if (bounced_) counters.indirect = bounced_->end_frame();
    if (visibility_) visibility_draws = visibility_->draws();
    counters.draws += visibility_draws;
    return counters;
}

}   // namespace gnomon::raster
