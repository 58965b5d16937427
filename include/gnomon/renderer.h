// SPDX-License-Identifier: Apache-2.0
#pragma once
// Renders frames of a scene.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "gnomon/arithmetic.h"
#include "gnomon/frame.h"
#include "gnomon/frame_input.h"
#include "gnomon/frame_report.h"
#include "gnomon/scene.h"
#include "gnomon/types.h"

namespace gnomon {

/// Diffuse bounces beyond which light is not followed one by one: all of them. The irradiance cache estimates what is
/// left; the reference ends paths by chance, without a bias.
inline constexpr int k_all_bounces = 1000;

/// RenderOptions::samples: one sample per pixel, and more where something ends within a pixel, such as a shadow or an
/// object. In rasterised frames, these are edges of opaque objects and textures; there, further samples take their
/// light from pixels around. Overlays, references and RenderOptions::as_printed have one sample per pixel instead.
inline constexpr int k_adaptive_samples = 0;

/// Path-traced indirect light: slow, unbiased, and with an estimate of its error. Direct light is computed as without
/// it, with the same camera rays, so `samples` still controls anti-aliasing.
struct ReferenceLightOptions {
    int spp = 1024;                // paths per pixel
    int bounces = k_all_bounces;   // diffuse bounces; 1: direct light and one bounce
    std::uint64_t seed = 0;
    friend bool operator==(const ReferenceLightOptions&, const ReferenceLightOptions&) = default;
};

/// How a frame is rendered: by ray tracing on the CPU, or by the rasteriser on a Vulkan device, which shows mirrors
/// without reflections and glass without refraction. The rasteriser also computes indirect light on the device. For
/// Indirect::visible, which lights the rasterised surfaces from the irradiance cache, RenderOptions::indirect_on
/// selects the device for cuts, visibility and sums.
enum class RenderMethod { trace, raster };

/// Shadows of the rasterised frame. `items` keeps one buffer for all receivers and redraws only what changed.
/// `coherent`, `depth` and `per_caster` make a texture for each receiver: only where something changed, all of them by
/// one draw each, and all of them from the casters before each. All give the same image, except where two objects are
/// exactly equally near to a light.
enum class ShadowTextures { off, per_caster, depth, coherent, items };

/// Options of a renderer. gnomon/ranges.h has the ranges of numbers.
struct RenderOptions {
    Size size{};                    // 0 x 0: the file's own resolution, else 1280 x 720
    std::string camera = "auto";    // a name, an index from 0, or auto: the first
    double turntable_seconds = 0;   // seconds in which the camera circles the scene; 0: off
    RenderMethod renderer = RenderMethod::trace;
    int max_depth = 10;                            // longest chain of reflections and refractions
    int samples = 1;                               // per pixel, or k_adaptive_samples
    PixelFilter filter = PixelFilter::automatic;   // the rasteriser has a wide one with adaptive samples only
    /// Motion blur: the angle by which a rotating shutter is open, in degrees; cinema has 180. It is open for this part
    /// of 360 of a frame's duration, around the frame's time, which is its middle. 0: frames show one moment. Not with
    /// references, overlays and ShadowCulling::paper; so for the aperture.
    double shutter = 0;
    /// Depth of field: the lens as its focal length divided by its diameter (2.8 is f/2.8), on a sensor 24 mm high, or
    /// its diameter in millimetres; the scene's unit is the metre, and the focal length of an orthographic camera is
    /// one. 0 and 0: everything is sharp. Not both.
    double f_number = 0;
    double aperture = 0;
    /// Distance of what is sharp, in metres along the view's axis; none: the median of what the middle of the image
    /// shows.
    std::optional<double> focus{};
    std::optional<double> exposure{};   // stops; none: automatic, from this frame only
    ToneMap tonemap = ToneMap::neutral;
    /// Mirrors and refracting bodies show the scene's own surroundings in any case.
    BackgroundKind background = BackgroundKind::environment;
    float background_color[3]{};   // of BackgroundKind::color, as shown: sRGB, 0 to 1, neither exposed nor tone-mapped
    ShadowCulling shadow_culling = ShadowCulling::certified;
    Indirect indirect = Indirect::visible;
    ShadowTextures shadow_textures = ShadowTextures::items;   // of the rasterised frame
    /// Angular diameter of directional lights, in degrees (the sun's is .53); 0: points.
    double sun_size = 0;
    int shadow_filter = 1;   // width of shadow edges in texels of the light view; 0: hard
    /// The published techniques by the letter of their papers. ShadowCulling::paper writes modes while the frame is
    /// traced, in scanline order and on one thread (docs/papers/shadow-culling.md). Of the rasterised frame: the colour
    /// of a receiver's texture decides alone (see FrameCounters::Shadow::looked_up_wrong), and every receiver goes
    /// through the light quad-tree by itself, one pass a level.
    bool as_printed = false;
    int bounces = k_all_bounces;   // diffuse bounces of Indirect::visible; the other methods have one
    std::optional<ReferenceLightOptions> reference{};   // instead of `indirect`
    int rsm_samples = 256;                              // Indirect::rsm
    int indirect_level = 5;          // Indirect::quadtree: finest level of refinement, 7 (coarse) to 1
    double depth_threshold = 0.05;   // Indirect::quadtree: largest depth difference within a cluster, as a fraction of
                                     // the light view's depth range
    double normal_threshold = 0.9;   // Indirect::quadtree: smallest cosine between normals within a cluster
    /// Indirect::quadtree: fraction of the thresholds around them within which a cluster and the four below it share
    /// the light, so that it does not change abruptly; 0: as published.
    double validity_margin = 0;
    /// Indirect::quadtree of traced frames: static and dynamic objects have light trees of their own, so that motion
    /// changes no static cluster's place, which would flicker; false: as published.
    bool separate_trees = false;
    /// Indirect::quadtree of traced frames: clusters are occluded, by rays from the receivers; false: as published.
    bool cluster_shadows = false;
    /// Indirect::rsm, quadtree: gather at every pixel. Otherwise, gather at 64 receivers along the longer side, and
    /// interpolate where the surfaces agree.
    bool indirect_at_every_pixel = false;
    int indirect_memory = 16;   // Indirect::visible: MB of irradiance cache; changes time, not images
    IndirectOn indirect_on = IndirectOn::automatic;
    Accelerator accelerator = Accelerator::embree;
    /// Of Accelerator::embree. The shadows and bounces of the rasterised frame that rays of the CPU decide follow it,
    /// too.
    Arithmetic arithmetic = Arithmetic::portable;
    int threads = 0;   // 0: all
    /// MB that the renderer may hold in ray tracing trees, caches and the image's layers; 0: no limit. Beyond it,
    /// render() throws MissingError, and the renderer stays usable. The scene itself does not count.
    int memory = 0;
    /// Also output the layers depth, normal, albedo, direct, indirect and shadow, and more for a reference.
    bool layers = false;
    /// Also output the layer id, or motion: one camera ray per pixel for both, in a pass of its own. Not with overlays
    /// other than Overlay::redrawn.
    bool ids = false;
    bool motion = false;
    bool report_changes = false;   // list the rectangles of pixels that changed (FrameReport::rectangles)
    /// Shown instead of the rendered scene. The image is then larger than `size` (see image_size) and has no other
    /// layers.
    Overlay overlay = Overlay::none;
    std::optional<int> overlay_light{};   // index from 0; none: all lights, one panel each
    /// Prepare for a window: shadows are remembered from the first frame on, results for later frames are proven by
    /// improve() alone instead of at the end of each frame, and pick() works with the rasteriser, too. Images are the
    /// same. Cannot be changed later.
    bool interactive = false;
    /// Where nothing has changed since the last traced frame, give its layers again and trace nothing; where view and
    /// options have not, keep what pixels show where nothing that changed can come before it. Frames are the same to the
    /// bit. Not with motion, a shutter or a lens. false: light each frame from what is remembered, for measurements.
    bool keep_image = true;
    friend bool operator==(const RenderOptions&, const RenderOptions&) = default;
};

/// Renders frames, and keeps what stays the same from frame to frame. A frame depends on the scene, the input and the
/// options alone: neither on the number of threads, nor on earlier frames. Exceptions: ShadowCulling::paper, whose
/// results depend on history; overlays, which show the cached state; a limit on indirect rays; and an object that was
/// promoted (see Mobility), which is rounded as one that moves from then on.
///
/// Threads: a renderer is used by one thread at a time; only cancel() may be called while it renders. Any number of
/// renderers may render at the same time in different threads, of the same scene or of different ones, because a Scene
/// is immutable. Each renders on RenderOptions::threads threads of its own.
///
/// A renderer that was moved from can only be assigned to or destroyed; any other call throws UsageError. A renderer
/// must not be moved, assigned to or destroyed while it renders.
class Renderer {
 public:
    /// @throws UsageError  an option is out of range
    explicit Renderer(RenderOptions options = {});
    ~Renderer();
    Renderer(Renderer&&) noexcept;
    Renderer& operator=(Renderer&&) noexcept;

    /// Renders a frame of the scene's clip. Values that were handed over before stay in force.
    /// @param frame     1 to scene.frame_count()
    /// @param progress  see Progress; while it runs, this renderer can only be cancelled
    /// @throws UsageError    the frame or camera does not exist; this renderer is rendering already, in another thread
    ///         or around the progress callback that calls it
    /// @throws MissingError  RenderMethod::raster without a suitable Vulkan device or enough memory, or the device was
    ///         lost; RenderOptions::memory is too little
    /// @throws InterruptedError  cancel() was called, or progress returned false. The next frame is as if the
    ///         interrupted one had not been asked for.
    /// @throws what progress throws, with the same effect
    Frame render(const Scene& scene, int frame, const Progress& progress = {});
    /// Takes over what a host changed, and renders a frame. Values of parts that a scene has in common with the one
    /// before stay in force. What is remembered stays if nothing but instances that may move or deform was added or
    /// removed, or values of lights, materials and cameras were edited; otherwise, another scene begins anew.
    /// Cost of the update: what is handed over with another value, and what that moves; with another scene, a
    /// comparison of both as well.
    /// @throws UsageError  an id is not of this scene; a number is not finite; lengths disagree: then nothing is taken
    ///         over. Also as above
    Frame render(const Scene& scene, const FrameInput& input, const Progress& progress = {});

    /// Other options for the frames that follow. What they do not bear on stays remembered.
    /// @throws UsageError  an option is out of range, or `interactive` differs
    void set_options(RenderOptions options);
    /// What the last frame shows at a pixel's centre, as the layer "id" has it. Costs about a thousand rays.
    /// @param x, y  in the rendered view, from its top left corner, from 0. Overlays surround the view with titles, see
    ///         Frame::view_left and view_size; of shadow states, every panel shows it.
    /// @throws UsageError  outside the view; no frame was rendered yet, or the last one failed
    Pick pick(int x, int y);
    /// What the last frame changed.
    /// @throws UsageError  no frame was rendered yet, or the last one failed
    FrameReport report() const;

    /// Makes the render in progress, and only that, stop and throw InterruptedError: typically within 10 ms while it
    /// traces, and within 100 ms while it builds. Without a render in progress, and where one is about to end, it has
    /// no effect. May be called from any thread, and from a progress callback.
    void cancel();

    /// The options in force.
    const RenderOptions& options() const;

    // Of the last frame. All throw UsageError before the first, and for parts that its scene does not have.

    /// A node's transform to its parent's space in the last frame.
    Transform transform(const NodeId& node) const;
    /// A node's transform to the world in the last frame.
    Transform world_transform(const NodeId& node) const;
    /// Whether a node and all nodes above it were shown in the last frame.
    bool visible(const NodeId& node) const;
    /// The camera of the last frame, with its transform to the world.
    Camera camera() const;
    /// The bounds of the objects that were visible in the last frame, in world space.
    Box bounds() const;

    /// Uses time without work: proves results for later frames until all are proven or `go_on` returns false.
    void improve(const std::function<bool()>& go_on);

    /// Name of the Vulkan device that rendered the last frame; empty if none did.
    std::string device() const;
    /// Bytes of remembered results, textures and geometry aside.
    std::size_t remembered_bytes() const;

    /// Forgets the scene, the values that were handed over and everything remembered.
    void forget();

 private:
    struct Impl;
    Impl& impl() const;
    Impl& idle() const;
    std::unique_ptr<Impl> impl_;
};

/// Checks options as the constructor of Renderer does, without making one.
/// @throws UsageError  an option is out of range, or options exclude each other
void check_options(const RenderOptions& options);

/// The size at which a scene is rendered if none is given.
Size default_size(const Scene& scene, const std::string& camera = "auto");

/// The size of the images that a renderer with these options makes, overlays included.
/// @throws UsageError  no such camera or light; an overlay of a scene without lights, or one that is too large
Size image_size(const Scene& scene, const RenderOptions& options);

}   // namespace gnomon
