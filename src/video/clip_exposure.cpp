// SPDX-License-Identifier: Apache-2.0
#include "video/clip_exposure.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "image/tone_map.h"

namespace gnomon::video {

namespace {
// The options of the small frames: what the clip shows, without what single pixels or earlier frames decide.
RenderOptions small_options(const Scene& scene, const RenderOptions& options)
{
    RenderOptions small = options;
    small.overlay = Overlay::none;
    small.overlay_light.reset();
    const Size size = image_size(scene, small);
    const double scale = std::min(1.0, k_exposure_side / static_cast<double>(std::max(size.width, size.height)));
    const auto side = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(pixels * scale))); };
    small.size = {side(size.width), side(size.height)};
    small.samples = 1;
    small.filter = PixelFilter::automatic;
    small.exposure = 0;
    small.background = BackgroundKind::environment;   // in front of another one, a scene is exposed alike
    small.reference.reset();
    small.as_printed = false;
    if (small.shadow_culling == ShadowCulling::paper) small.shadow_culling = ShadowCulling::certified;
    small.layers = small.ids = small.motion = small.report_changes = false;
    return small;
}

// Restores a renderer's options.
class OptionsScope {
 public:
    OptionsScope(Renderer& renderer, RenderOptions during) : renderer_(renderer), before_(renderer.options())
    {
        renderer_.set_options(std::move(during));
    }
    ~OptionsScope() { renderer_.set_options(std::move(before_)); }
    OptionsScope(const OptionsScope&) = delete;
    OptionsScope& operator=(const OptionsScope&) = delete;

 private:
    Renderer& renderer_;
    RenderOptions before_;
};
}   // namespace

std::vector<int> exposure_frames(int frame_count)
{
    std::vector<int> frames;
    const int count = std::min(frame_count, k_exposure_frames);
    for (int i = 0; i < count; ++i)
        frames.push_back(1 + static_cast<int>((std::int64_t{2} * i + 1) * frame_count / (2 * count)));
    return frames;
}

double clip_exposure(const Scene& scene, Renderer& renderer, const Progress& progress)
{
    const RenderOptions& options = renderer.options();
    RenderOptions small = small_options(scene, options);
    // Frames whose pixels depend on earlier ones must not see the small frames.
    const bool keeps_history = options.shadow_culling == ShadowCulling::paper || options.overlay != Overlay::none;
    std::optional<Renderer> apart;
    if (keeps_history) apart.emplace(small);
    Renderer& used = apart ? *apart : renderer;
    const OptionsScope scope(used, std::move(small));

    // Gather the pixels of all small frames.
    std::vector<float> pixels;
    const std::vector<int> frames = exposure_frames(scene.frame_count());
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const auto step = [&](const ProgressStep& s) {
            const double done = (static_cast<double>(i) + s.done) / static_cast<double>(frames.size());
            return !progress || progress({"exposure", done});
        };
        const Frame frame = used.render(scene, frames[i], step);
        const std::span<const float> values = frame.layers.front().values();
        pixels.insert(pixels.end(), values.begin(), values.end());
    }
    return image::auto_exposure(pixels);
}

}   // namespace gnomon::video
