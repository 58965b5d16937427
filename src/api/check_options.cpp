// SPDX-License-Identifier: Apache-2.0
#include "api/check_options.h"

#include <fmt/format.h>

#include <string>

#include "gnomon/error.h"

namespace gnomon {

namespace {

// Whole numbers in full, not as 1.67772e+07.
std::string text_of(double end)
{
    const auto whole = static_cast<long long>(end);
    return static_cast<double>(whole) == end ? fmt::format("{}", whole) : fmt::format("{}", end);
}

void check_size(const Size& size)
{
    if (size.width == 0 && size.height == 0) return;   // the file's own
    if (!ranges::image_side.contains(size.width) || !ranges::image_side.contains(size.height))
        throw UsageError(fmt::format("size {}x{} is out of range: {} to {} a side", size.width, size.height,
                                     ranges::image_side.low, ranges::image_side.high));
    if (static_cast<std::int64_t>(size.width) * size.height > ranges::k_max_pixels)
        throw UsageError(fmt::format("size {}x{} has more than {} million pixels", size.width, size.height,
                                     ranges::k_max_pixels / 1'000'000));
}

// Rejects values that an enum does not have, as casts and memory that was never written can give.
template <class Enum>
void check_known(std::string_view what, Enum value, Enum last)
{
    const auto number = static_cast<int>(value);
    if (number < 0 || number > static_cast<int>(last))
        throw UsageError(fmt::format("{} is {}, which its type does not have", what, number));
}

void check_lens_and_shutter(const RenderOptions& o)
{
    check_range("the shutter is", o.shutter, ranges::shutter, " degrees");
    if (o.f_number != 0) check_range("the f-number is", o.f_number, ranges::f_number);
    if (o.aperture != 0) check_range("the aperture is", o.aperture, ranges::aperture, " mm");
    if (o.f_number != 0 && o.aperture != 0)
        throw UsageError("the aperture is given twice: as an f-number and in millimetres");
    const bool has_lens = o.f_number != 0 || o.aperture != 0;
    if (o.focus) check_range("the focus is", *o.focus, ranges::focus, " m");
    if (o.focus && !has_lens) throw UsageError("a focus needs an aperture: without one, everything is sharp");
    if (o.shutter == 0 && !has_lens) return;
    const char* const what = has_lens ? "depth of field" : "motion blur";
    if (o.reference) throw UsageError(fmt::format("{} needs a frame without a reference", what));
    if (o.overlay != Overlay::none) throw UsageError(fmt::format("{} needs a frame without an overlay", what));
    if (o.shadow_culling == ShadowCulling::paper)
        throw UsageError(fmt::format("{} is not there with the shadow culling of the paper", what));
}

}   // namespace

void check_range(std::string_view what, double value, const Range& range, std::string_view unit)
{
    if (!range.contains(value))
        throw UsageError(
            fmt::format("{} out of range: {} to {}{}", what, text_of(range.low), text_of(range.high), unit));
}

void check_options(const RenderOptions& o)
{
    check_size(o.size);
    check_known("the renderer", o.renderer, RenderMethod::raster);
    check_known("the tone mapping", o.tonemap, ToneMap::aces);
    check_known("the shadow culling", o.shadow_culling, ShadowCulling::certified);
    check_known("the indirect light", o.indirect, Indirect::visible);
    check_known("the device of indirect light", o.indirect_on, IndirectOn::vulkan);
    check_known("the shadow textures", o.shadow_textures, ShadowTextures::items);
    check_known("the accelerator", o.accelerator, Accelerator::kdtree);
    check_known("the arithmetic", o.arithmetic, Arithmetic::native);
    check_known("the overlay", o.overlay, Overlay::clusters);
    check_range("max depth is", o.max_depth, ranges::max_depth);
    if (o.samples != k_adaptive_samples) check_range("samples are", o.samples, ranges::samples);
    check_known("the pixel filter", o.filter, PixelFilter::blackman_harris);
    if (o.renderer == RenderMethod::raster && o.samples != k_adaptive_samples && o.filter != PixelFilter::automatic &&
        o.filter != PixelFilter::box)
        throw UsageError(
            "a filter wider than the pixel needs traced frames or adaptive samples: not with the rasteriser and "
            "a fixed number");
    check_lens_and_shutter(o);
    if (o.reference) {
        check_range("spp is", o.reference->spp, ranges::spp);
        check_range("bounces are", o.reference->bounces, ranges::reference_bounces);
    }
    check_range("bounces are", o.bounces, ranges::bounces);
    check_range("memory of indirect light is", o.indirect_memory, ranges::indirect_memory, " MB");
    check_range("RSM samples are", o.rsm_samples, ranges::rsm_samples);
    check_range("indirect level is", o.indirect_level, ranges::indirect_level);
    check_range("depth threshold is", o.depth_threshold, ranges::depth_threshold);
    check_range("normal threshold is", o.normal_threshold, ranges::normal_threshold);
    check_range("validity margin is", o.validity_margin, ranges::validity_margin);
    check_range("sun size is", o.sun_size, ranges::sun_size, " degrees");
    if (o.exposure) check_range("exposure is", *o.exposure, ranges::exposure, " stops");
    if (o.turntable_seconds != 0)
        check_range("time of a turntable is", o.turntable_seconds, ranges::turntable_seconds, " seconds");
    check_range("limit of memory is", o.memory, ranges::memory, " MB");
    check_range("threads are", o.threads, ranges::threads);
    check_range("shadow filter is", o.shadow_filter, ranges::shadow_filter);
    if (o.renderer == RenderMethod::raster && (o.overlay == Overlay::shadow_states || o.overlay == Overlay::clusters))
        throw UsageError(
            "an overlay of shadow states or clusters shows the traced frame's inside: not with the rasteriser");
    if (o.renderer == RenderMethod::raster && o.reference)
        throw UsageError("the reference is traced: not with the rasteriser");
    check_known("the background", o.background, BackgroundKind::color);
    for (const float channel : o.background_color)
        if (!(channel >= 0 && channel <= 1)) throw UsageError("the background's colour is out of range: 0 to 1");
    if (o.background != BackgroundKind::environment && o.overlay != Overlay::none)
        throw UsageError("another background than the environment needs a frame without an overlay");
    if (o.cluster_shadows && (o.renderer == RenderMethod::raster || o.indirect != Indirect::quadtree))
        throw UsageError("shadows of clusters are traced: they need the traced frame, with indirect light by quadtree");
    if (o.separate_trees && (o.renderer == RenderMethod::raster || o.indirect != Indirect::quadtree))
        throw UsageError(
            "separate trees are those of a traced light map: they need the traced frame, with indirect light by "
            "quadtree");
    if (o.overlay == Overlay::redrawn &&
        (o.renderer == RenderMethod::trace || o.shadow_textures == ShadowTextures::off))
        throw UsageError("an overlay of what was redrawn shows light views: it needs the rasteriser, with shadows");
    if (o.overlay == Overlay::shadow_states && o.shadow_culling == ShadowCulling::off)
        throw UsageError("an overlay of shadow states shows a memory: not with shadow culling off");
    if (o.overlay == Overlay::clusters && (o.indirect != Indirect::quadtree || o.reference))
        throw UsageError(
            "an overlay of clusters shows what the light quad-tree chose: it needs indirect light by quadtree");
}

}   // namespace gnomon
