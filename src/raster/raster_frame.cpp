// SPDX-License-Identifier: Apache-2.0
#include "raster/raster_frame.h"

#include <algorithm>

#include "base/check.h"
#include "base/interruption.h"
#include "raster/raster_formats.h"
#include "raster/raster_view.h"
#include "scene/environment.h"

namespace gnomon::raster {

namespace {

void resize(ImageF& image, Size size, int channels)
{
    if (image.width != size.width || image.height != size.height || image.channels != channels)
        image = ImageF(size.width, size.height, channels);
}

// Stores scaled RGBA pixels as RGB, or adds them to the pixels there.
void store(const vk::Buffer& from, Size size, ImageF& to, float scale, bool add)
{
    resize(to, size, 3);
    const std::span<const float> wide = from.as<float>();
    for (std::size_t i = 0; i < to.data.size() / 3; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            to.data[3 * i + c] = (add ? to.data[3 * i + c] : 0) + scale * wide[4 * i + c];
}

}   // namespace

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

// Makes the images that the frame needs, unless those of the last frame fit.
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
        kept_key_.clear();
        opaque_ids_ = image("opaque ids", k_id_format, drawn);
        opaque_depth_ = image("opaque depth", k_depth_format, depth);
        surfaces_.position = image("position", k_wide_format, made);
        surfaces_.normal = image("normal", k_wide_format, made);
        surfaces_.geometric = image("geometric normal", k_wide_format, made);
        surfaces_.smooth = image("smooth normal", k_wide_format, made);
        surfaces_.diffuse = image("diffuse", k_wide_format, made);
        surfaces_.specular = image("specular", k_wide_format, made);
        surfaces_.ids = image("ids", k_id_format, made);
        color_ = image("colour", k_wide_format, made);
        through_ = image("through", k_wide_format, made);
        share_ = image("share", k_wide_format, made);
        size_ = size;
    }
    // An image that only some frames need is one pixel large in the others.
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
    fitting(own_, optional(keeps_surfaces(options), "own light", k_wide_format, made));
    fitting(surrounding_light_, optional(surroundings_ != nullptr, "light of surroundings", k_wide_format, made));
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

void RasterFrame::update(const scene::SceneState& state)
{
    scene_.update(commands_, state);
    scene_changed_ = scene_changed_ || state.changes().anything();
}

bool RasterFrame::keeps_surfaces(const RasterOptions& options) const
{
    return options.samples == 1 && !scene_.has_transparent();
}

// Finds out whether the G-buffer of the last frame is that of this one.
bool RasterFrame::find_kept(const scene::View& view, const RasterOptions& options, const shared::RasterFrame& constants)
{
    const shared::DrawPush push = draw_push(view, scene::sample_offset(0, options.samples), unlimited_far_);
    std::vector<std::byte> key;
    if (keeps_surfaces(options)) {
        const auto a = std::as_bytes(std::span(&constants, 1)), b = std::as_bytes(std::span(&push, 1));
        key.assign(a.begin(), a.end());
        key.insert(key.end(), b.begin(), b.end());
    }
    const bool kept = !key.empty() && key == kept_key_ && !scene_changed_;
    kept_key_ = std::move(key);
    scene_changed_ = false;
    return kept;
}

FrameCounters RasterFrame::render(const scene::SceneState& state, const scene::View& view, const RasterOptions& options,
                                  shading::FrameBuffers& out, const Progress& progress)
{
    Interruption interruption(progress);
    const InterruptionScope scope(progress ? &interruption : Interruption::current());
    begin_frame(state, view, options);
    FrameCounters counters;
    counters.kept_surfaces = surfaces_.kept;
    for (int sample = 0; sample < options.samples; ++sample) {
        const Drawn drawn = draw_sample(view, options, sample);
        if (!surfaces_.kept) counters.draws += drawn.counts.as<std::uint32_t>()[0];
        store_sample(drawn, options, sample, out);
        report_progress("drawing", static_cast<double>(sample + 1) / options.samples);
    }
    if (options.adaptive) refine_edges(view, options, out, counters);
    if (bounced_) counters.indirect = bounced_->end_frame();
    if (visibility_) visibility_->count(counters);
    if (sized_) counters.draws += sized_->draws();
    if (surroundings_) surroundings_->end_frame(counters);
    return counters;
}

// Brings the device up to this frame, and culls the view's draws.
void RasterFrame::begin_frame(const scene::SceneState& state, const scene::View& view, const RasterOptions& options)
{
    fit(view.size, options, described_->lights.size());
    if (view.orthographic && !std::isfinite(view.far)) {
        Box3 bounds = described_->bounds(state.time());
        const std::vector<scene::ObjectId>& dynamics = state.dynamic_objects();
        if (state.any_displaced() &&
            std::any_of(dynamics.begin(), dynamics.end(), [&](scene::ObjectId o) { return state.displaced(o); }))
            bounds.add(state.present_bounds().whole);
        unlimited_far_ = view.near + std::max(1.0f, bounds.diagonal() + glm::length(bounds.centre() - view.eye));
    }
    if (surroundings_) surroundings_->begin_frame(state, view);
    surrounding_visible_ = {};
    const shared::RasterFrame constants =
        frame_constants(*described_, view, !bounced_, !(bounced_ && bounced_->has_further_bounces()),
                        options.backdrop_apart, surroundings_.get());
    const vk::Upload upload = vk::upload_of(frame_, std::span<const shared::RasterFrame>(&constants, 1));
    commands_.upload("send view", {&upload, 1});
    if (bounced_) bounced_->update(commands_, scene_, state);
    glm::vec4 planes[6];
    frustum_planes(view, planes);
    scene_.cull(commands_, planes);
    surfaces_.kept = find_kept(view, options, constants);
    if (surfaces_.kept)
        copy(own_, color_);
    else
        clear(color_, 0);
    clear(direct_, 0);
    if (bounced_) clear(indirect_, 0);
    if (options.layers)
        commands_.pass("forget lit").writes(lit_, vk::Use::copy_target).copy([&](vk::Recorder& r) { r.fill(lit_, 0); });
    if (visibility_) visibility_->update(commands_, state, planes);
    if (sized_) sized_->update(commands_, state);
}

// Draws one sample of every pixel, layer by layer. One submit a sample: so progress can be reported, and a long frame
// is no single long submit.
RasterFrame::Drawn RasterFrame::draw_sample(const scene::View& view, const RasterOptions& options, int sample)
{
    const bool peels = scene_.has_transparent();
    const int layers = peels ? options.transparent_layers + 1 : 1;
    const glm::vec2 offset = scene::sample_offset(sample, options.samples);
    const shared::DrawPush push = draw_push(view, offset, unlimited_far_);
    const float weight = 1.0f / static_cast<float>(options.samples);
    Drawn drawn;
    if (!surfaces_.kept) draw_ids(push);
    if (peels) clear(peel_depth_[1], 1);
    for (int layer = 0; layer < layers; ++layer) {
        const bool peeled = layer + 1 < layers;
        if (peeled) peel(push, peel_depth_[(layer + 1) % 2], peel_depth_[layer % 2]);
        if (!surfaces_.kept) {
            resolve({offset, weight, layer == 0 ? 1u : 0u, peeled ? 1u : 0u, layer + 1 == layers ? 1u : 0u});
            if (!kept_key_.empty()) copy(color_, own_);
        }
        light(options, view, options.layers && layer == 0);
        bounce(view, options.layers && layer == 0);
        if (options.ids && sample == 0 && layer == 0) drawn.ids = commands_.read_back(surfaces_.ids);
        if (!options.layers || layer > 0) continue;
        drawn.diffuse = commands_.read_back(surfaces_.diffuse);
        drawn.specular = commands_.read_back(surfaces_.specular);
        if (sample > 0) continue;
        drawn.normal = commands_.read_back(surfaces_.normal);
        drawn.position = commands_.read_back(surfaces_.position);
    }
    if (sample + 1 == options.samples) {
        drawn.color = commands_.read_back(color_);
        if (options.layers) drawn.direct = commands_.read_back(direct_), drawn.lit = commands_.read_back(lit_);
        if (options.layers && bounced_) drawn.indirect = commands_.read_back(indirect_);
        if (visibility_) visibility_->end_frame(commands_);
    }
    drawn.counts = commands_.read_back(scene_.counts_buffer);
    commands_.submit();
    return drawn;
}

// Draws the surfaces at further places of the pixels, and makes the image of all samples.
void RasterFrame::refine_edges(const scene::View& view, const RasterOptions& options, shading::FrameBuffers& out,
                               FrameCounters& counters)
{
    GNOMON_CHECK(options.samples == 1);
    EdgeSamples edges(*described_, view, out, options.layers, scene_.has_transparent(), options.backdrop_apart,
                      *options.adaptive);
    for (int number = -1; number < scene::k_refined_samples; ++number) {
        const glm::vec2 offset = number < 0 ? glm::vec2(0.5f) : scene::refined_offset(number);
        clear(color_, 0);
        draw_ids(draw_push(view, offset, unlimited_far_));
        resolve({offset, 1, 1, 0, 1});
        const vk::Buffer position = commands_.read_back(surfaces_.position),
                         normal = commands_.read_back(surfaces_.normal),
                         diffuse = commands_.read_back(surfaces_.diffuse),
                         specular = commands_.read_back(surfaces_.specular), ids = commands_.read_back(surfaces_.ids),
                         own = commands_.read_back(color_);
        commands_.submit();
        const DrawnSurfaces drawn{position.as<float>(), normal.as<float>(),      diffuse.as<float>(),
                                  specular.as<float>(), ids.as<std::uint32_t>(), own.as<float>()};
        if (number < 0)
            edges.set_centres(drawn);
        else
            edges.add(number, drawn);
        report_progress("drawing", static_cast<double>(number + 2) / (scene::k_refined_samples + 1));
    }
    edges.resolve(out);
    counters.samples.pixels += edges.refined();
    counters.samples.taken += edges.refined() * std::uint64_t{scene::k_refined_samples};
    forget_surfaces();
}

// Copies to the host's images what a sample has read back.
void RasterFrame::store_sample(const Drawn& drawn, const RasterOptions& options, int sample, shading::FrameBuffers& out)
{
    if (drawn.ids) {
        *options.ids = IdImage(size_.width, size_.height, 2);
        std::copy_n(drawn.ids.as<std::uint32_t>().data(), options.ids->data.size(), options.ids->data.data());
    }
    if (drawn.diffuse) {
        const float weight = 1.0f / static_cast<float>(options.samples);
        store(drawn.diffuse, size_, out.albedo, weight, sample > 0);
        store(drawn.specular, size_, out.albedo, weight, true);
    }
    if (drawn.normal) {
        store(drawn.normal, size_, out.normal, 1, false);
        resize(out.depth, size_, 1);
        const std::span<const float> at = drawn.position.as<float>();
        for (std::size_t i = 0; i < out.depth.data.size(); ++i) out.depth.data[i] = at[4 * i + 3];
    }
    if (drawn.color) store(drawn.color, size_, out.color, 1, false);
    if (drawn.color && options.backdrop_apart) {
        resize(out.alpha, size_, 1);
        const std::span<const float> at = drawn.color.as<float>();
        for (std::size_t i = 0; i < out.alpha.data.size(); ++i)
            out.alpha.data[i] = 1 - std::clamp(at[4 * i + 3], 0.0f, 1.0f);
    }
    if (drawn.direct) store(drawn.direct, size_, out.direct, 1, false);
    if (drawn.indirect) store(drawn.indirect, size_, out.indirect, 1, false);
    if (drawn.lit) {
        const std::size_t lights = described_->lights.size();
        resize(out.shadow, size_, static_cast<int>(lights));
        const std::span<const float> values = drawn.lit.as<float>();
        const std::size_t pixels = out.color.data.size() / 3;
        for (std::size_t l = 0; l < lights; ++l)
            for (std::size_t i = 0; i < pixels; ++i)
                out.shadow.data[i * lights + l] = values[l * lit_pixels(size_) + i];
        for (std::size_t i = 0; i < surrounding_visible_.data.size(); ++i)
            out.shadow.data[i] += surrounding_visible_.data[i];
    }
}

}   // namespace gnomon::raster
