// SPDX-License-Identifier: Apache-2.0
// The samples of a frame at other times of its shutter and places of its lens.
#include "base/interruption.h"
#include "frame/frame_engine.h"
#include "image/pixel_filter.h"

namespace gnomon::frame {

namespace {

constexpr int k_raster_poses = 32;   // images that make a blurred rasterised one

void add(FrameCounters& to, const FrameCounters& more)
{
    to.primary_rays += more.primary_rays;
    to.reflection_rays += more.reflection_rays;
    to.refraction_rays += more.refraction_rays;
    to.samples.pixels += more.samples.pixels;
    to.samples.taken += more.samples.taken;
    to.samples.shaded += more.samples.shaded;
    to.shadow.rays += more.shadow.rays;
    to.shadow.rays_skipped += more.shadow.rays_skipped;
    to.shadow.rays_dynamic_only += more.shadow.rays_dynamic_only;
    to.indirect.rays += more.indirect.rays;
    to.draws += more.draws;
}

}   // namespace

// Whether the plan's image is one that motion and lens blur.
bool FrameEngine::can_blur() const
{
    return plan_.shown == Shown::light && !plan_.reference && !plan_.nah &&
           (options_.shutter > 0 || options_.f_number > 0 || options_.aperture > 0);
}

// Moves the state to a fraction of the shutter's opening, whole, because what missed a time could not follow to the
// next. The techniques follow with the next image.
void FrameEngine::pose(const Shutter& shutter, double fraction)
{
    const InterruptionScope whole(nullptr);
    if (shutter.host) shutter.host->apply_pose(*state_, fraction);
    state_->advance(fraction == Shutter::k_middle ? shutter.middle : shutter.at(fraction));
    posed_ = true;
    if (rays_) rays_->update(*state_);
    follow_emission();
    if (raster_) raster_->update(*state_);
}

// Takes the samples of touched pixels, round by round and time by time, and returns to the shutter's middle.
void FrameEngine::blur_traced(trace::Blur& blur, const Shutter& shutter, const trace::TracedOptions& options,
                              const trace::Techniques& techniques, Tasks& tasks, FrameCounters& counters)
{
    const int times = blur.motion().times;
    counters.samples.pixels += blur.touched_pixels();
    while (blur.next_round(tasks)) {
        for (int k = 0; k < times; ++k) {
            if (!blur.uses(k)) continue;
            report_progress("blurring", blur.progress(k));
            scene::View view = view_;
            if (times > 1) {
                const double fraction = Shutter::fraction(k, times);
                pose(shutter, fraction);
                view = shutter.view_at(*state_, fraction);
            }
            add(counters,
                trace::trace_blurred(*state_, *rays_, view, options, tasks, buffers_->times, techniques, blur, k));
        }
    }
    if (posed_) {
        pose(shutter, Shutter::k_middle);
        add(counters, trace::trace_blurred(*state_, *rays_, view_, options, tasks, buffers_->times, techniques, blur,
                                           std::nullopt));
    }
    trace::finish_blur(blur, options, tasks, *buffers_);
}

// Renders whole images at times of the shutter, through places of the lens, and averages them.
FrameCounters FrameEngine::blur_raster(const scene::View& view, const Shutter& shutter)
{
    if (!rays_) make_rays();
    const SeenPlaces places = see_places(*rays_, view);
    const scene::Lens lens = find_lens(view, options_, places);
    const trace::BlurMotion motion = find_motion(*state_, view, shutter, places);
    if (motion.times == 1 && lens.sharp()) return render_raster(view);

    // The layers whose values are averaged.
    const auto layers = [&]() {
        std::vector<ImageF*> result{&buffers_->color};
        if (options_.background != BackgroundKind::environment) result.push_back(&buffers_->alpha);
        if (options_.layers)
            result.insert(result.end(), {&buffers_->direct, &buffers_->indirect, &buffers_->albedo, &buffers_->shadow});
        return result;
    };
    std::vector<std::vector<double>> sums;
    FrameCounters counters;
    records_whole_ = true;
    for (int k = 0; k < k_raster_poses; ++k) {
        report_progress("drawing", static_cast<double>(k) / k_raster_poses);
        const InterruptionScope whole(nullptr);
        scene::View posed = view;
        if (motion.times > 1) {
            const double fraction = Shutter::fraction(k, k_raster_poses);
            pose(shutter, fraction);
            posed = shutter.view_at(*state_, fraction);
        }
        const trace::BlurSample sample = trace::blur_sample({0, 0}, static_cast<std::uint32_t>(k), {}, false);
        if (!lens.sharp()) posed = scene::through_lens(posed, lens, sample.lens);
        // With adaptive samples, the images are of different places of the pixel's filter, so that all edges are clean.
        if (options_.samples == k_adaptive_samples) {
            const PixelFilter filter = image::chosen_filter(options_.filter, true);
            const glm::vec2 place = 2.0f * glm::vec2(image::filter_place(filter, sample.offset.x),
                                                     image::filter_place(filter, sample.offset.y));
            posed.shift += glm::vec2(place.x / static_cast<float>(view.size.width),
                                     -place.y / static_cast<float>(view.size.height));
        }
        add(counters, render_raster(posed, true));
        const std::vector<ImageF*> now = layers();
        sums.resize(now.size());
        for (std::size_t l = 0; l < now.size(); ++l) {
            sums[l].resize(now[l]->data.size(), 0.0);
            for (std::size_t i = 0; i < sums[l].size(); ++i) sums[l][i] += static_cast<double>(now[l]->data[i]);
        }
    }
    // What is not averaged is that of the shutter's middle.
    const InterruptionScope whole(nullptr);
    if (posed_) pose(shutter, Shutter::k_middle);
    add(counters, render_raster(view, true));
    const std::vector<ImageF*> last = layers();
    for (std::size_t l = 0; l < last.size(); ++l)
        for (std::size_t i = 0; i < sums[l].size(); ++i)
            last[l]->data[i] = static_cast<float>(sums[l][i] / k_raster_poses);
    return counters;
}

}   // namespace gnomon::frame
