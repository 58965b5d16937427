// SPDX-License-Identifier: Apache-2.0
#pragma once
// Traces and shades the tiles of a frame, one after the other. One object a thread; its memory is reused.

#include <optional>

#include "base/stopwatch.h"
#include "shading/layers.h"
#include "shading/lobe_rays.h"
#include "trace/blur.h"
#include "trace/bounced_places.h"
#include "trace/environment_lighting.h"
#include "trace/indirect_light.h"
#include "trace/kept_tiles.h"
#include "trace/lobe_filter.h"
#include "trace/path_splits.h"
#include "trace/refinement.h"
#include "trace/shadow_tester.h"
#include "trace/sized_lighting.h"
#include "trace/smooth_horizon.h"
#include "trace/traced_frame.h"

namespace gnomon::trace {

/// The share of a surface's light that comes from what it mirrors, from which on it is a mirror.
inline constexpr float k_least_mirrored = 0.1f;

/// The lights with size of a frame, and how their visibility is found; null without them.
struct SizedTechnique {
    const scene::SizedLights* lights = nullptr;
    SizedVisibility* visibility = nullptr;
};

class TileTracer {
 public:
    /// @param environment  optional; with an image or suns
    /// @param indirect     optional
    /// @param lobes        optional: takes what lobe rays of primary hits bring, so that it can be filtered. Without,
    /// it
    ///                     is part of the colour
    /// @param centres      optional: takes what the pixels' first samples met
    /// @param places       optional: known places, whose bounced light further samples take. Not
    ///                     changed: see take_places()
    /// @param log          optional: takes all rays but shadow rays
    TileTracer(const FrameContext& frame, const TracedOptions& options, ShadowTester& shadows,
               const SizedTechnique& sized, EnvironmentTechnique* environment, IndirectLight* indirect,
               LobeImage* lobes, shading::CentreSamples* centres, const BouncedPlaces* places, TraceLog* log);

    /// @param sums      optional: takes the samples, which `out` then lacks but for the layers of the first one
    /// @param left_out  optional: the sums are without the samples of its touched pixels
    void trace(const Tile& tile, shading::FrameBuffers& out, image::SampleSums* sums = nullptr,
               const Blur* left_out = nullptr);
    /// The same for a tile of one sample a pixel that is kept, or to be kept.
    void trace(const Tile& tile, shading::FrameBuffers& out, std::size_t index, KeptTiles& kept);
    /// Adds the samples of a tile's selected pixels, which trace() began, to sums: those at the centres, and further
    /// ones.
    void refine(const Tile& tile, const Refinement& refinement, RefinedPixels& pixels);
    /// Adds those of the pixels that have one sample.
    void add_single(const Tile& tile, const Refinement& refinement, const RefinedPixels& pixels);
    /// Adds the samples of a tile's active pixels that belong to a time, which is that of the state.
    void blur(const Tile& tile, Blur& blur, int time);
    /// Rays other than those of the techniques.
    const FrameCounters& counters() const { return counters_; }
    /// Places that samples met since the last call, whose bounced light was computed.
    std::vector<BouncedPlace> take_places() { return std::exchange(new_places_, {}); }
    /// Milliseconds of this thread.
    const FrameTimes& times() const { return times_; }
    std::unique_ptr<ShadowTester::Worker> take_shadows() { return std::move(shadows_); }
    /// Only with lights with size.
    std::unique_ptr<SizedVisibility::Worker> take_sized() { return sized_->take_worker(); }
    /// Shadow rays to lights with size beside those of the worker.
    std::uint64_t few_rays() const { return sized_ ? sized_->few_rays() : 0; }
    /// Zeros without an environment.
    environment_light::VisibilityCounters environment_counters() const
    {
        return environment_ ? environment_->counters() : environment_light::VisibilityCounters{};
    }
    /// Null without indirect light.
    std::unique_ptr<IndirectLight::Worker> take_indirect() { return std::move(indirect_); }

 private:
    struct PathQueue {
        ray::RayQueue rays;
        std::vector<Path> paths;
        void clear() { rays.clear(), paths.clear(); }
        void push(const Path& path, const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar)
        {
            rays.push(origin, tnear, direction, tfar);
            paths.push_back(path);
        }
    };

    // A pixel with further samples.
    struct Refined {
        std::uint32_t pixel;    // of the tile
        int samples = 0;        // further ones
        bool several = false;   // the first few show a surface that its centre does not
        bool found = false;     // they show a surface that no pixel around has at its centre
    };

    void begin_tile(const Tile& tile);
    void clear_sums(std::size_t count);
    // Of TileTracer::trace().
    std::size_t number_of(const Tile& tile) const;
    void add_samples(int sample, image::SampleSums& sums, const Blur* left_out);
    void values_of(std::size_t at, float* values) const;
    // Of TileTracer::refine() (tile_refiner.cpp).
    void find_refined(const RefinedPixels& pixels);
    bool finds_surface(const Refined& refined, const float* values, const shading::CentreSample& met) const;
    void single_values(std::span<const ImageF* const> layers, const glm::ivec2& pixel);
    void shade_samples(std::span<const FurtherSample> samples);
    void take_samples(const Refinement& refinement, std::span<const std::uint32_t> refined, int first, int end);
    bool take_light(const TilePoint& point, scene::ObjectId object, std::uint32_t triangle);
    bool take_agreed(const FurtherSample& sample, std::uint32_t to, shading::CentreSample& own);
    struct TextureLight;
    void add_texture(const glm::ivec2& at, const Refinement& refinement);
    void find_texture_light(const glm::ivec2& at, TextureLight& light);
    void light_texture(const TextureLight& light, const glm::vec2& offset, const shading::CentreSample& sample);
    void scale_light(float* values, const glm::vec3& by) const;
    void texture_sample(const shading::TriangleReflectance& triangle, const glm::ivec2& at, const glm::vec2& offset,
                        shading::CentreSample& sample) const;
    // What pixels around a sample know of its bounced light: none shows its surface, or they disagree, or it has
    // theirs.
    enum class Bounced { unknown, disagrees, taken };
    Bounced take_bounced(const TilePoint& point);
    Bounced take_bounced(const TilePoint& point, const glm::vec2& offset, const shading::CentreSample& own,
                         const shading::CentreSamples& centres, const shading::RefineOptions& options,
                         const ImageF* color);
    bool take_nearest(const TilePoint& point, shading::CentreSample& own, bool agreed);
    void add_share(std::uint32_t to, shading::CentreSample& own, const shading::CentreSample& of, float weight,
                   const float* values);
    // Light of first samples that is interpolated between pixels (tile_lattice.cpp).
    struct Around;
    struct LatticePixel {
        glm::vec3 diffuse{0}, specular{0}, normal{0};
        float roughness = 0;
        float coverage = 0, coat = 0, coat_roughness = 0;
        glm::vec3 coat_normal{0};
        float image_by_lobe = 0, hidden = 1;
        glm::vec3 open{0};
        int step = 0;   // of the widest lattice that it is on; 0: it shows no surface
    };
    bool interpolates(int sample) const;
    void shade_lattice(int sample, Stopwatch& watch);
    void note_points();
    void move_chosen(std::size_t first);
    bool find_around(const TilePoint& point, int step, Around& around) const;
    bool is_alike(const Around& around) const;
    bool take_light_around(TilePoint& point, int step);
    bool take_mirrored_around(const TilePoint& point, int step);
    void follow_lattice(int sample, Stopwatch& watch);
    // Of places whose bounced light samples share (tile_places.cpp).
    std::optional<BouncedPlace> bounced_place(const TilePoint& point, const shadow_culling::ShadowPoint& at,
                                              bool primary) const;
    bool take_place(TilePoint& point, const shadow_culling::ShadowPoint& at, bool primary) const;
    void note_place(const TilePoint& point, const shadow_culling::ShadowPoint& at, bool primary,
                    const glm::vec3& irradiance);
    // Of TileTracer::blur() (tile_blur.cpp).
    Bounced take_still_bounced(const TilePoint& point, scene::ObjectId object, std::uint32_t triangle);
    void shade_blurred(std::span<const FurtherSample> samples, const Blur& blur);
    void note_blurred_lobe(const TilePoint& point, float counts);
    bool take_still_light(const TilePoint& point, scene::ObjectId object, std::uint32_t triangle);
    bool lens_turns_little(const shading::SurfacePoint& s) const;
    bool take_still_lobe(const TilePoint& point, const shadow_culling::ShadowPoint& at);
    bool take_lobe(const TilePoint& point, const shadow_culling::ShadowPoint& at);
    shading::CentreSample centre_sample(const shading::SurfacePoint& s, scene::ObjectId object,
                                        std::uint32_t triangle) const;
    glm::ivec2 pixel_of_image(std::uint32_t pixel) const
    {
        return tile_.pixel_of_image(pixels_.empty() ? pixel : pixels_[pixel]);
    }
    void clear_points();
    PointBatch batch(bool primary, int sample) const;
    bool shades_further() const { return refinement_ || blur_; }
    /// Whether rays of lobes are kept for the filter: not those of further samples, which are not filtered.
    bool keeps_lobe_rays() const { return lobes_ && !shades_further(); }
    // Whether a path is the first ray of a primary hit's lobe.
    bool is_kept_lobe_ray(const Path& path) const { return bounce_ == 0 && path.lobe.light != 0 && keeps_lobe_rays(); }
    void queue_primary(int sample);
    void queue_camera_ray(std::uint32_t pixel, const glm::vec2& at);
    void shade_sample(int sample, Stopwatch& watch);
    void shade_first_hits(int sample, Stopwatch& watch);
    void shade_rest(int sample, Stopwatch& watch);
    void follow_hits(int sample, Stopwatch& watch);
    // Of the trace() of a tile that is kept (kept_shading.cpp).
    void keep_first_hits(KeptTile& kept) const;
    void shade_kept(KeptTile& kept, KeptTiles& tiles, Stopwatch& watch);
    void take_kept_points(const KeptTile& kept);
    void gather_kept(KeptTile& kept, KeptTiles& tiles);
    void add_kept_bounced(const KeptTile& kept);
    void note_kept_place(const KeptPoint& from, const glm::vec3& irradiance);
    void note_mirrored(std::span<const glm::vec3> without);
    void trace_queue(const PathQueue& queue);
    void shade_hits(const PathQueue& queue, bool primary, int sample, bool last_depth);
    void sort_hits(std::size_t count);
    glm::vec3 seen_of_background(const PathEnd& end, const glm::vec3& direction, bool apart = false) const;
    struct MirroredRay {
        glm::vec3 weight{0};
        float own = 0;   // part of it that shows emission and background
    };
    MirroredRay mirrored_ray(const TilePoint& point) const;
    glm::vec3 below_lobe(const TilePoint& point) const;
    bool stands_for_lobe(const TilePoint& point) const;
    glm::vec3 open_irradiance(const shading::SurfacePoint& s) const;
    glm::vec3 show_behind(TilePoint& point, const glm::vec3& direction) const;
    // Adds what a point sends to the viewer, to the colour or to what lies behind.
    void add_light(const TilePoint& point, const glm::vec3& radiance)
    {
        if (point.behind)
            backdrop_[point.pixel] += radiance;
        else
            add_color(point.pixel, point.lobe, radiance);
    }
    void add_highlight(const TilePoint& point, const glm::vec3& by_lobe)
    {
        if (!highlights_.empty()) highlights_[point.pixel] += point.throughput * by_lobe;
    }
    void add_lights(const PointBatch& batch, Stopwatch& watch);
    void add_suns(const PointBatch& batch, Stopwatch& watch);
    void add_image(const PointBatch& batch, std::size_t first, std::size_t end, Stopwatch& watch);
    void add_sized_lights(const PointBatch& batch, std::size_t first, Stopwatch& watch);
    void add_soft_light(bool primary, int sample, std::size_t first, std::size_t end, Stopwatch& watch);
    glm::vec3 reflect_bounced(const TilePoint& point, const glm::vec3& indirect, const glm::vec3& surroundings) const;
    void add_indirect(const PointBatch& batch);
    void add_gathered(const PointBatch& batch);
    PathSplits split(const TilePoint& point, glm::vec3& reflected, glm::vec3& refracted) const;
    bool goes_on(Path& path) const;
    void queue_continuations(bool primary);
    void queue_lobe(const TilePoint& point, std::uint32_t first, const glm::uvec2& flip, std::size_t rays,
                    const LobePath& path, float share, float* found, LobePixel* kept);
    void queue_nested_lobe(const TilePoint& point);
    void follow_paths(int sample, Stopwatch& watch);
    void keep_lobes(int sample);
    int rays_of_each(int samples) const;
    std::uint32_t number_of_lobe_rays(const glm::ivec2& pixel, std::uint32_t most);
    void trace_lobes(int sample, Stopwatch& watch);
    void add_color(std::uint32_t pixel, const LobePath& lobe, const glm::vec3& radiance);
    void store_lobes();
    void queue_layered(const TilePoint& point, const glm::vec3& lift);
    /// Of the light from lit_ to one light, what surfaces between them let through, in passes_.
    void find_passing(const scene::Light& light, const scene::LightState& at);
    void store(shading::FrameBuffers& out) const;

    const scene::SceneState& state_;
    const scene::Scene& scene_;
    const ray::RayScene& rays_;
    const scene::View& view_;
    const TracedOptions& options_;
    const IndirectLight* indirect_light_;   // null: ambient light stands in for it
    std::unique_ptr<ShadowTester::Worker> shadows_;
    std::optional<SizedLighting> sized_;   // none: the lights that approximate emissive surfaces light instead
    std::optional<EnvironmentLighting> environment_;   // none: lights are points, those that approximate an image, too
    glm::vec3 open_image_{0};                          // irradiance of the image on a level surface, of estimates
    bool sees_image_ = false;                          // it has an image
    std::unique_ptr<IndirectLight::Worker> indirect_;
    bool is_estimate_;   // the indirect light has errors
    TraceLog* log_;
    FrameCounters counters_;
    FrameTimes times_;

    Tile tile_;
    PathQueue primary_, reflected_, refracted_, next_reflected_, next_refracted_;
    int bounce_ = 0;   // of the paths that are followed
    ray::Hits hits_;
    bool hides_surfaces_ = false;             // see hidden_surfaces.h
    std::vector<std::uint64_t> order_;        // of hits_, see sort_hits()
    std::vector<std::uint32_t> first_hits_;   // by object, while hits are ordered; none: not hit
    // By point. Apart, because every light reads all of the last two.
    std::vector<TilePoint> points_;
    std::vector<shadow_culling::ShadowPoint> shadow_points_;
    std::vector<glm::vec3> normals_;
    SmoothHorizon horizon_;
    std::vector<std::uint32_t> lit_;   // points that the present light reaches
    bool thins_light_ = false;         // surfaces let a part of light through
    std::vector<glm::vec3> passes_;    // by lit point, with such surfaces
    ray::RayQueue passing_;
    std::vector<shading::TransmittedRay> transmitted_;
    IndirectResult arrives_;

    glm::vec3 open_sky_{0};             // irradiance of a surface that faces up, by a sky without its sun
    std::vector<glm::vec3> backdrop_;   // how much is seen of what lies behind, by pixel of the tile
    std::vector<glm::vec3> color_, direct_, indirect_color_, albedo_, normal_;   // by pixel of the tile
    std::vector<glm::vec3> variance_, first_irradiance_, first_variance_;        // of an estimate
    std::vector<float> depth_, shadow_;

    // Adaptive samples.
    shading::CentreSamples* const centres_;
    const BouncedPlaces* const places_;
    std::vector<BouncedPlace> new_places_;     // since take_places()
    const Refinement* refinement_ = nullptr;   // while further samples are shaded
    const Blur* blur_ = nullptr;               // likewise, of those of times and lens
    std::span<const FurtherSample> samples_;   // these
    std::vector<std::uint32_t> pixels_;        // theirs
    std::vector<Refined> refined_;
    std::vector<FurtherSample> wanted_;
    std::vector<float> values_;                  // by refined pixel and further sample
    std::vector<shading::CentreSample> met_;     // by sample of the list
    std::vector<shading::CentreSample> known_;   // by refined pixel and sample of the first few
    std::vector<float> single_values_;           // of one pixel

    // Interpolated light, by pixel of the tile.
    std::vector<LatticePixel> lattice_;
    std::vector<glm::vec3> sharp_, sharp_direct_, sharp_indirect_;   // what every pixel has computed
    std::vector<glm::vec3> highlights_;   // of the soft light, what lobes reflect directly; empty: is not asked for
    std::vector<TilePoint> followed_;     // points whose continuations are followed
    std::vector<char> chosen_;            // of the points from one on

    // First hits of a tile that is kept. The points have the values of their last use but for those that are set.
    std::vector<TilePoint> kept_points_;
    std::vector<shadow_culling::ShadowPoint> kept_shadow_points_;
    std::vector<glm::vec3> kept_normals_;
    std::vector<char> kept_whole_;   // by point: it had all values
    TilePoint kept_plain_;           // one that reflects diffusely

    // Lobes of primary hits.
    int rays_of_lobe_ = 0;   // for each sample; 0: rough surfaces reflect by mirror rays
    LobeImage* const lobes_;
    std::vector<TilePoint> lobe_points_;    // of the sample
    bool spreads_lobes_ = false;            // a pixel filter spreads their light
    std::vector<glm::vec3> lobe_weights_;   // then: of the sample, by pixel of the tile
    std::vector<shading::LobeRay> lobe_rays_;
    // By ray that is kept, by further sample, or by batch of rays and pixel of the tile; empty: no point had a lobe.
    std::vector<glm::vec3> lobe_light_;
    std::vector<std::uint32_t> kept_pixels_;   // by ray that is kept: its pixel of the tile
    std::vector<LobeRay> kept_rays_;
    std::vector<int> lobe_samples_;            // by pixel of the tile: how many have such rays
    std::vector<BlurredLobe> blurred_lobes_;   // by sample of time and lens; empty: none had a lobe
};

}   // namespace gnomon::trace
