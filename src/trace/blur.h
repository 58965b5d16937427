// SPDX-License-Identifier: Apache-2.0
#pragma once
// Motion blur and depth of field of the traced frame: samples of time and lens where something moves or is out of
// focus.
//
// 1. The frame is traced as without them, at the shutter's middle and by the lens's centre.
// 2. Pixels are touched if a moving object may be seen, may cast a shadow or may be mirrored in them, or if something
//    that is out of focus is seen there or may reach into them (Blur::select()). All others stay as they are, bit for
//    bit.
// 3. Touched pixels get 8, 16, 32, 64 or 128 samples. With a lens alone, these are rounds: pixels go on around which
//    samples still differ too much. Where the scene is posed, there are two rounds, because each
//    poses it anew: the first 8 samples tell how many each pixel takes in all (Blur::next_round()).
// 4. Each touched pixel becomes the mean of its samples, in linear light, so that what is blurred keeps its energy.
//
// Times are discrete: the scene is posed at up to 64 times of the shutter, in strata of equal length, one after the
// other, and each pose traces the samples that need it. The first 8 samples have the same times in all pixels, unless
// something moves so fast that it would be seen at 8 places with gaps between: then their times differ among 2, 4 or 8
// pixels that lie together. The later ones fill the other strata; pixels take turns in which half of a stratum they
// sample. Time and place
// in the pixel are the three dimensions of Sobol's sequence, and the place on the lens is a point of a (0, 2)-sequence;
// all but the times are scrambled differently in each pixel [Burley 2020].
//
// Direct and mirrored light is computed anew for each sample, at its time. Bounced light, which changes little while
// the shutter is open, is that of the shutter's middle, where the nearest pixels that show a sample's surface agree in
// it; elsewhere, as in mirror images, that of the nearest places on the object that other samples of the frame have met
// (bounced_places.h), where these agree. It is computed where neither does, and everywhere while a light or a material
// changes. With a lens alone, nothing moves: all light of a place is that of the frame without it, where the pixels
// that show the place agree in it. Of dim mirrored and refracted paths, some samples follow each. Pixels that no moving
// object may reach, as step 2 has it, keep all of their light.
//
// Each step reads what the step before made of the whole image, so that the result does not depend on threads. Memory:
// 30 bytes a pixel without layers, and 32 where the scene has rough metals; with a lens alone, 12 more, and 124 where
// these are seen.

#include <optional>
#include <span>
#include <vector>

#include "base/tasks.h"
#include "image/pixel_filter.h"
#include "scene/lens.h"
#include "scene/sized_light.h"
#include "shading/centre_samples.h"
#include "shading/frame_buffers.h"
#include "trace/lobe_filter.h"
#include "trace/point_batch.h"

namespace gnomon::trace {

struct TracedOptions;

/// Strata of the shutter's time at the most, and the first samples of a pixel, whose times all pixels share.
inline constexpr int k_most_blur_times = 64, k_first_blur_samples = 8;

/// What moves while the shutter is open.
struct BlurMotion {
    int times = 1;               // at which the scene is posed; 1, or a power of two from k_first_blur_samples on
    int phases = 1;              // 1, 2, 4 or 8: pixels have times of their own in so many ways; k_most_blur_times only
    bool everything = false;     // every pixel may change: the camera, a light or a material does
    bool relit = false;          // light changes by more than what moving objects hide and reflect
    std::vector<Box3> boxes{};   // of the objects that move, each over the whole time
    std::vector<scene::ObjectId> objects{};   // these
};

struct BlurOptions {
    scene::Lens lens{.radius = 0};
    int samples = 0;             // of each touched pixel; 0: in rounds
    bool random = false;         // for measurements: independent random samples, all of whose light is computed
    bool in_full = false;        // for measurements: all light of each sample is computed
    float error = 0.0125f;       // of a pixel, where 1 is a display's white, above which it takes more samples
    float whole_path = 0.125f;   // of a sample's light, below which some samples alone follow a path
    float blurred_from = 0.5f;   // diameter in pixels from which on what is out of focus counts
    float near = 0.5f;           // distance, in diagonals of its box, within which a moving object changes light
};

/// Where and when a sample is taken.
struct BlurSample {
    glm::vec2 offset{0.5f};   // in the pixel, 0 to 1
    glm::vec2 lens{0};        // in the unit disc
    int time = 0;             // number of the pose
};
/// What the few rays of a sample's lobe brought, as if they told how much the lobe reflects on average.
struct BlurredLobe {
    glm::vec3 light{0};
    float weight = 0;   // what all of the lobe would bring of radiance 1, the sum of three channels
    float counts = 0;   // as how many rays each of them counts (shading/lobe_rays.h)
};
/// The sample of that number of a pixel. The first 8, 16, 32, 64 and 128 are each well spread over time, lens and
/// pixel.
BlurSample blur_sample(const glm::ivec2& pixel, std::uint32_t number, const BlurMotion& motion, bool random);

/// A fraction, 0 to 1, that is well spread over a pixel's samples and independent of their times and places.
float blur_path_place(const glm::ivec2& pixel, std::uint32_t number, int depth);

class Blur {
 public:
    Blur(BlurMotion motion, const BlurOptions& options) : motion_(std::move(motion)), options_(options) {}

    const BlurMotion& motion() const { return motion_; }
    const BlurOptions& options() const { return options_; }

    /// Finds the touched pixels.
    /// @param centres  of the frame at the shutter's middle; so for the other arguments
    /// @param sized    null: the scene's lights alone light it
    void select(const shading::CentreSamples& centres, const scene::SceneState& state, const scene::View& view,
                const scene::SizedLights* sized, Tasks& tasks);
    BlurSample sample(const glm::ivec2& pixel, std::uint32_t number) const
    {
        return blur_sample(pixel, number, motion_, options_.random);
    }
    int time(const glm::ivec2& pixel, std::uint32_t number) const;
    int channels() const { return sums_.channels; }
    float exposure() const { return exposure_; }
    /// Keeps the light of the frame, unless the scene moves.
    /// @param layers  in the order of averaged_layers(), of one sample a pixel
    void keep_light(std::span<const ImageF* const> layers);
    /// What was kept; empty: nothing.
    std::span<const ImageF* const> still_layers() const { return still_layers_; }
    /// What lobes reflect as seen through the lens's centre; null where the scene moves, as that may move with it.
    const LobeImage* lobes() const { return still_lobes_ ? &*still_lobes_ : nullptr; }
    /// Whether samples take light from the frame at the shutter's middle.
    bool shares() const { return !options_.random && !options_.in_full && !motion_.relit; }
    bool any() const { return any_; }
    bool touched(int x, int y) const { return any_ && *rounds_.pixel(x, y) > 0; }

    /// Keeps the sums of the samples of the other pixels, until finish().
    /// @param centre  weights of a sample at a pixel's centre
    /// @param share   that all samples of a pixel have in the sums
    void keep(image::SampleSums&& sums, const image::SampleWeights& centre, int share, int tile);
    /// @param channels  values of each sample, in the order of averaged_layers()
    /// @param lobes     of the frame; none: add_lobe() is not called
    void begin(Size size, int channels, float exposure, std::optional<LobeImage> lobes);

    /// Selects the pixels that take the next samples.
    /// @return  false: there are none
    bool next_round(Tasks& tasks);
    /// Of a pixel.
    std::uint32_t most_samples() const { return totals_.back(); }
    /// How much of all rounds is done.
    /// @param times  of this round that are done
    double progress(double times) const;
    /// Whether some sample of the round may have this time.
    bool uses(int time) const { return used_[static_cast<std::size_t>(time)]; }
    bool active(int x, int y) const { return *active_.pixel(x, y) != 0; }
    bool any_active(const Tile& tile) const;
    std::uint32_t first_sample() const { return first_; }
    /// Of an active pixel.
    std::uint32_t end_sample(int x, int y) const { return totals_[*rounds_.pixel(x, y) - std::size_t{2}]; }
    /// Adds a sample of an active pixel. Tasks may do so at once for different pixels.
    void add(int x, int y, const float* values);
    /// Adds what lobes brought of the sample that was added last. The samples of a pixel know better together how much
    /// lobes reflect: in the mean, each counts as its rays do.
    void add_lobe(int x, int y, const BlurredLobe& lobe);

    /// Writes the touched pixels, and with kept sums all of them.
    void finish(const std::vector<ImageF*>& layers, Tasks& tasks) const;
    std::uint64_t touched_pixels() const;

 private:
    void touch_moving(const shading::CentreSamples& centres, const scene::View& view, Tasks& tasks);
    void touch_lit(const shading::CentreSamples& centres, const scene::SceneState& state,
                   const scene::SizedLights* sized, Tasks& tasks);
    void touch_unsharp(const shading::CentreSamples& centres, const scene::View& view, Tasks& tasks);
    void widen(Tasks& tasks);
    void use_times();
    // What the samples of some pixels show: sums over the pixels.
    struct Spread {
        glm::vec3 mean{0}, variance{0};
        int pixels = 0;
    };
    void add_spread(int x, int y, Spread& to) const;
    float error_at(int x, int y, std::uint32_t samples) const;
    int most_rounds() const;
    std::size_t next_total(int x, int y) const;
    void mean_of(int x, int y, std::span<float> mean) const;

    BlurMotion motion_;
    BlurOptions options_;
    Size size_{};
    bool any_ = false;
    int round_ = -1;
    std::vector<std::uint32_t> totals_;   // samples that a pixel may have
    std::uint32_t first_ = 0, end_ = 0;   // samples of the round; the last of some pixels only
    std::vector<char> used_;              // by time
    float exposure_ = 1;
    Image8 rounds_;    // 0: not touched; 1: no samples yet; else 2 and the number of its total
    Image8 active_;    // of the round
    ImageF sums_;      // of samples
    ImageF squares_;   // of their colours
    ImageF lobes_;     // of their lobes: light, counted light, weight, counted weight; empty: there are none
    std::vector<ImageF> still_;
    std::vector<const ImageF*> still_layers_;   // these
    std::optional<LobeImage> still_lobes_;
    std::optional<image::SampleSums> others_;
    image::SampleWeights centre_;
    float share_ = 1;
    int tile_ = 32;
};

}   // namespace gnomon::trace
