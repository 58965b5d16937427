// SPDX-License-Identifier: Apache-2.0
#pragma once
// Renders frames of a scene, and keeps what the next frame can use again: the scene's state, the ray scene, the caches
// of shadows and indirect light, and the rasteriser.
//
// This is the only place that makes techniques from options, and that replaces them when options change. A cache is
// kept as long as the options still need it and it would be made in the same way; otherwise it is discarded, because a
// cache that does not follow every frame misses changes.
//
// A frame is two calls: advance() moves scene, ray scene and caches to a time; render() makes the image of a view.
//
// Invariant: the image depends on the scene, the time, the options and the host's values alone, not on earlier frames.
// Exceptions: ShadowCulling::paper, overlays that show a cache, and a limit on indirect rays.
// Cost: that of the techniques; advance() itself compares a few options.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/memory_limit.h"
#include "base/tasks.h"
#include "frame/frame_environment.h"
#include "frame/frame_memory.h"
#include "frame/host_values.h"
#include "frame/rasterizer.h"
#include "frame/shown_bounds.h"
#include "frame/shutter.h"
#include "gnomon/renderer.h"
#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"
#include "scene/sized_light.h"
#include "scene/view.h"
#include "shading/frame_buffers.h"
#include "shadow_culling/certified/certified_culling.h"
#include "shadow_culling/nah2009/paper_culling.h"
#include "trace/frame_scratch.h"
#include "trace/proven_visibility.h"
#include "trace/state_map.h"
#include "trace/trace_log.h"
#include "trace/traced_frame.h"

namespace gnomon::frame {

/// How an engine is used.
struct EngineSettings {
    int threads = 0;   // 0: all
    /// Cull shadows from a scene's first frame on. Otherwise from the second, since a single image gains nothing.
    bool culls_first_frame = false;
    /// Certificates are made by make_certificates() alone, not at the end of each frame.
    bool defers_certificates = false;
    /// There is a ray scene for rasterised frames too: hit_at() and bounds() will be called.
    bool always_has_rays = false;
    bool redrawn_stays = false;   // RasterSettings::redrawn_stays
};

/// The image that options come to for a scene.
enum class Shown : std::uint8_t { light, shadow_states, clusters, redrawn };

/// Milliseconds of advance().
struct AdvanceTimes {
    double scene = 0;    // state and, for a new scene, ray scene
    double caches = 0;   // update of the ray scene; what the options need was made
    bool anew = false;   // the scene or the accelerator is another one, and nothing was kept
};

struct RenderRequest {
    std::vector<int> overlay_lights{};      // of Shown::shadow_states: the lights of its panels
    std::uint64_t indirect_ray_limit = 0;   // IrradianceCache::limit_rays(); 0: none
    bool preview = false;                   // FrameInput::preview
    /// From move_previous(): the frame before, for the layer of motion. None: nothing moved.
    std::optional<scene::View> previous_view{};
    std::optional<Shutter> shutter{};   // of RenderOptions::shutter and aperture; none: neither
    bool random_blur = false;           // for measurements: BlurOptions::random
    bool blur_in_full = false;          // likewise: BlurOptions::in_full
    // For measurements, with no technique that keeps a cache.
    Tasks* tasks = nullptr;           // these threads instead of the engine's
    trace::TraceLog* log = nullptr;   // takes the frame's rays; needs a single thread
};

/// What a view's ray meets first.
struct PickedPoint {
    scene::ObjectId object = scene::none;   // none: nothing; the rest is then undefined
    scene::MaterialId material = scene::none;
    std::uint32_t triangle = 0;   // of the object's mesh
    glm::vec3 position{0};
    glm::vec3 normal{0};   // shading normal, unit, on the viewer's side
    float depth = 0;       // along the view's axis
};

/// What a frame changed against the one before.
struct EngineReport {
    /// This frame is the first of its scene, or follows one that failed: the list of rectangles is the whole image, and
    /// the other lists are empty.
    bool everything = true;
    std::vector<scene::ObjectId> objects;       // moved, deformed, appeared or vanished; ascending
    std::vector<scene::LightId> lights;         // position, direction, visibility or values differ; ascending
    std::vector<scene::MaterialId> materials;   // values differ; ascending
    /// Disjoint rectangles that contain all pixels whose linear colour differs in bits. Only with
    /// RenderOptions::report_changes; otherwise empty.
    std::vector<PixelRectangle> rectangles;
};

class FrameEngine {
 public:
    explicit FrameEngine(const EngineSettings& settings = {});
    ~FrameEngine();
    FrameEngine(const FrameEngine&) = delete;
    FrameEngine& operator=(const FrameEngine&) = delete;

    /// Moves to a time of a scene. Another scene discards everything, unless it differs from the last one as
    /// scene::continuation() allows, and `host` is given; so does another accelerator.
    /// @param options  size, camera, turntable, threads, exposure and tone mapping are not read
    /// @param host     values of the same scene; their changes are taken over, or all of them for another scene
    /// @throws MissingError      RenderMethod::raster without a suitable Vulkan device or memory; the limit on memory
    ///         is exceeded
    /// @throws InterruptedError  the current work was interrupted (base/interruption.h)
    AdvanceTimes advance(const std::shared_ptr<const scene::Scene>& scene, double time, const RenderOptions& options,
                         const HostValues* host = nullptr);
    /// The scene of the last advance(). Its objects may have other numbers than those of state().
    const std::shared_ptr<const scene::Scene>& scene() const { return scene_; }
    /// Objects of the ray scene that the last advance() placed or refitted.
    std::uint64_t touched_instances() const { return rays_ ? rays_->statistics().touched : 0; }
    /// The scene's state; none before the first advance().
    const scene::SceneState* state() const { return state_.get(); }
    /// @param threads  0: all
    void use_threads(int threads);

    /// @param turn  radians around the scene's centre at the clip's start; none: the camera as it is
    scene::View make_view(scene::CameraId camera, Size size, std::optional<double> turn = {});

    /// The same in another state of the scene.
    scene::View view_in(const scene::SceneState& state, scene::CameraId camera, Size size, std::optional<double> turn);
    /// Moves a second state of the scene, which only the layer of motion uses, to the frame before, for
    /// RenderRequest::previous_view. Call after advance(), if its options ask for motion.
    /// @param host  values with those of the frame before; none: the scene's own
    const scene::SceneState& move_previous(double time, const HostValues* host = nullptr);

    /// Renders a view, once after each advance(). The image lies in buffers() where shown() is light or redrawn, else
    /// paint_overlay() makes it.
    /// @param progress  in place of the current Interruption (base/interruption.h)
    /// @throws InterruptedError  the work was interrupted; the next frame begins without the caches that took notes
    /// @throws MissingError      too little memory, or the device was lost; everything is discarded
    FrameCounters render(const scene::View& view, const RenderRequest& request = {}, const Progress& progress = {});

    // Of the last frame.
    /// Its stages; others fill `scene` and `image`.
    const FrameTimes& times() const { return times_; }
    Shown shown() const { return plan_.shown; }
    shading::FrameBuffers& buffers() { return *buffers_; }
    /// The same, to be kept: its memory is not used again as long as there is a pointer to it.
    std::shared_ptr<const shading::FrameBuffers> shared_buffers() const { return buffers_; }
    /// Valid until the next advance().
    const EngineReport& report() const { return report_; }
    /// A frame was rendered, and nothing has failed or advanced since.
    bool has_frame() const { return has_frame_; }
    const scene::View& view() const { return view_; }
    /// The layer of indirect light was filled, with layers.
    bool has_indirect() const { return plan_.reference || plan_.cache || plan_.map || plan_.raster_indirect; }
    bool is_reference() const { return plan_.reference; }
    /// No point of the irradiance cache is missing because of a limit on rays.
    bool complete() const;
    /// Shown::shadow_states and clusters, in screen colours.
    /// @param titles  of shadow states, by panel
    Image8 paint_overlay(const std::vector<std::string>& titles);
    /// Shown::redrawn: paints over the colour in buffers(), which becomes what is shown, within 0 to 1.
    void paint_redrawn(double exposure);
    /// The Vulkan device; empty for traced frames.
    std::string device() const;
    std::size_t cached_bytes() const;
    /// Bytes of the ray scene, the caches and the image's buffers: what RenderOptions::memory limits.
    std::size_t held_bytes() const;

    /// Makes certificates from what the last frames' shadow rays saw, until all are made or `go_on` returns false.
    void make_certificates(const std::function<bool()>& go_on);
    /// What a view shows at a pixel's centre, as the layer of ids has it. Builds a ray scene if there is none.
    /// @param pixel  within the view's image, from 0
    PickedPoint hit_at(const scene::View& view, const glm::ivec2& pixel);
    /// The ray scene. There is one unless all frames of the scene were rasterised without the irradiance cache.
    const ray::RayScene& rays() const { return *rays_; }
    /// Bounds of everything visible that the library did not add by itself.
    Box3 bounds();

    /// Discards the scene and all caches.
    void forget();

    Tasks& tasks() { return tasks_; }

 private:
    // What makes an image, but for the scene's state.
    struct Made {
        std::shared_ptr<const scene::Scene> scene;
        RenderOptions options;
        scene::View view;
    };
    // The techniques that options come to for a scene.
    struct Plan {
        Shown shown = Shown::light;
        bool raster = false, raster_indirect = false;
        bool certified = false, nah = false;                  // shadow culling of the traced frame
        bool cache = false, map = false, reference = false;   // its indirect light
    };
    Plan plan_for(const RenderOptions& options) const;
    bool continue_with(const std::shared_ptr<const scene::Scene>& scene);
    bool adds_much() const;
    void make_rays();
    void follow_emission();
    void trace_centres(const RenderRequest& request);
    void make_report(const shading::FrameBuffers* before);
    void discard_caches();
    void discard_light();       // what follows in frames
    void discard_followers();   // what follows in advance()
    void fit_caches(const RenderOptions& options);
    void fit_rasterizer(const RenderOptions& options);
    bool is_made(const scene::View& view, const RenderRequest& request) const;
    bool is_same(const Made& earlier, const scene::View& view) const;
    FrameCounters render_raster(const scene::View& view, bool whole = false);
    bool uses_environment() const;
    void list_changes();
    void pose(const Shutter& shutter, double fraction);
    bool can_blur() const;
    void blur_traced(trace::Blur& blur, const Shutter& shutter, const trace::TracedOptions& options,
                     const trace::Techniques& techniques, Tasks& tasks, FrameCounters& counters);
    FrameCounters blur_raster(const scene::View& view, const Shutter& shutter);
    FrameCounters render_traced(const scene::View& view, const RenderRequest& request);
    void check_memory(std::string_view what) const;
    void keep_tiles(trace::TracedOptions& traced);
    void count_kdtree(FrameCounters& counters) const;

    EngineSettings settings_;
    Tasks tasks_;
    std::shared_ptr<const scene::Scene> scene_;   // of all that follows
    Accelerator accelerator_ = Accelerator::embree;
    Arithmetic arithmetic_ = Arithmetic::portable;
    std::unique_ptr<scene::SceneState> state_;
    std::unique_ptr<ray::RayScene> rays_;
    bool first_frame_ = true;      // of the scene
    bool advanced_ = false;        // and not rendered since
    bool advanced_still_ = true;   // the last advance changed nothing
    RenderOptions options_;        // of the last advance()
    MemoryLimit limit_;            // likewise
    Plan plan_;                    // likewise
    std::optional<glm::vec3> turn_centre_;
    ShownBounds shown_bounds_;

    scene::SizedLights sized_;                          // of traced frames; follows every advance()
    std::unique_ptr<trace::ProvenVisibility> proven_;   // of the lights with size; saw the last advance()
    FrameEnvironment environment_;                      // of environment images and suns
    std::unique_ptr<shadow_culling::CertifiedCulling> certified_;
    std::unique_ptr<shadow_culling::PaperCulling> nah_;
    std::unique_ptr<irradiance_cache::IrradianceCache> cache_;
    std::unique_ptr<light_quadtree::MapLight> map_;
    std::unique_ptr<Rasterizer> raster_;
    RenderOptions cache_options_, map_options_, raster_options_;   // that these were made with
    const ray::RayScene* raster_rays_ = nullptr;                   // that the rasterizer was made with

    FrameMemory memory_;
    std::shared_ptr<shading::FrameBuffers> buffers_ = memory_.take();
    trace::FrameScratch scratch_;
    trace::StateMap states_;
    scene::View view_;             // of the last frame
    bool has_frame_ = false;       // see has_frame()
    bool follows_frame_ = false;   // the last advance() started from a complete frame
    bool records_whole_ = false;   // the rasteriser is not interrupted within an image
    bool posed_ = false;           // the last frame moved through its shutter's times
    bool has_image_ = false;       // the last frame's image lies in buffers_ as it was rendered
    std::optional<Made> made_;     // what made the image in buffers_, if a frame of the same may have it again
    std::optional<Made> traced_;   // the last frame, if the tiles that it left in scratch_ may be kept
    bool continues_ = false;       // this frame is of the same scene, options and view
    FrameTimes times_;
    EngineReport report_;                               // of the last frame
    std::unique_ptr<scene::SceneState> state_before_;   // see move_previous()
    bool before_lags_ = false;                          // it has values of an earlier scene
};

}   // namespace gnomon::frame
