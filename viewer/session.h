// SPDX-License-Identifier: Apache-2.0
#pragma once
// Loads scenes and renders frames for the viewer in the background: one thread loads scenes, another renders the latest
// requested frame. The window's thread posts requests and takes images, and never waits for either.
//
// A request describes a frame completely: time, camera, options, user overrides. A request that is replaced before its
// rendering began is never rendered. A newer request interrupts frames that only refine what is shown.

#include <atomic>
#include <condition_variable>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/image.h"
#include "base/math.h"
#include "gnomon/renderer.h"
#include "viewer/outline.h"

namespace gnomon::viewer {

/// A user override: a node that is held where it was taken, or moved, turned and scaled from there. Its track is
/// ignored.
struct UserOverride {
    NodeId node;
    Transform taken;       // where it was taken: to its parent's space (Picked::transform)
    glm::vec3 offset{0};   // from there, in its parent's space
    glm::quat turn{1, 0, 0, 0};
    float factor = 1;     // of its size
    glm::vec3 pivot{0};   // around which it turns and grows, before it is moved; in its parent's space
    /// To its parent's space.
    Transform transform() const;
    friend bool operator==(const UserOverride&, const UserOverride&) = default;
};

struct ViewRequest {
    /// The scene that orbit, overrides and pick refer to; they are ignored once another scene is loaded.
    std::shared_ptr<const Scene> scene;
    double time = 0;
    std::optional<Camera> orbit;   // the interactive camera; none: the scene's
    std::string camera = "auto";   // then, as on the command line; the frame fails if the scene has no such camera
    double turn = 0;               // radians around the scene, of the scene's camera
    Size size{640, 360};
    RenderOptions options;                 // size, camera, turntable, threads and layers of it are not read
    std::vector<UserOverride> overrides;   // the frame fails if the scene does not have a node
    std::optional<glm::vec2>
        pick;             // fractions of the view's width and height from the top left: find the object there
    bool whole = false;   // all indirect light in the first image, however long that takes
    /// A newer request ends its rendering, because it only shows the last image more sharply. Ignored with a pick, for
    /// a whole frame, and where the renderer would forget much.
    bool interruptible = false;
    /// Limit of the first image's rays of indirect light, if it is less than the session's.
    std::optional<std::uint64_t> rays;
    /// The first image follows few reflections in a row: one of more pixels replaces it where nothing moves.
    bool coarse = false;
    /// Until the scene's bounced light is prepared, which may take seconds, images come without it, and the one with it
    /// follows the last of them. A newer request interrupts the preparation, which then begins again.
    bool early = false;
    /// The first image is a preview (FrameInput::preview), as one that comes without bounced light is in any case.
    bool preview = false;
    /// More than the view and its time changed: an image of the request before is not waited for, unless that one is
    /// urgent as well.
    bool urgent = false;
    /// Options of a last image, once nothing is missing in the one with `options`: with all indirect light, and
    /// interrupted by any newer request. For what takes long and is not needed in motion, such as blur.
    std::optional<RenderOptions> at_rest;
    int enlarge = 1;   // how many times as wide its images are, with sharp edges between surfaces (viewer/enlarge.h)
    // Of the session itself.
    std::uint64_t number = 0;   // given by ask()
    bool finishing = false;     // for the image with the options at rest
};

/// Milliseconds by stage.
struct ViewTimes {
    enum Stage { scene, direct, indirect, rest, k_stages };
    static const char* name(int stage);
    double ms[k_stages] = {};   // a rasterised frame is `rest` as a whole
    double light_maps = 0;      // of `indirect`: what any number of pixels takes
    double fixed = 0;           // in all, what any number of pixels takes
    double total() const;
};

struct Picked {
    InstanceId instance;   // an id without a part: nothing is there
    NodeId node;           // that moves it
    Transform transform;   // of that node to its parent's space, in this image
    Transform world;       // of that node to the world, in this image
    std::string name;
    std::string mobility;   // "stands still", "moves", "deforms"
    glm::vec3 position{0};
    glm::vec3 pivot{0};   // around which it turns and grows, in the space of that node
};

struct ViewImage {
    std::shared_ptr<const Scene> scene;
    Frame frame;    // without layers, unless the request was for a whole frame
    Image8 image;   // the frame in sRGB, or enlarged
    /// By pixel: 1 divided by the depth of what it shows along the camera's axis, 0 without any. Of enlarged images,
    /// and of sharper ones of the same view that follow them; empty for others.
    std::vector<float> nearness;
    Camera camera;                         // with which it was rendered
    std::optional<Camera> orbit;           // its request's
    double time = 0;                       // its request's
    std::vector<UserOverride> overrides;   // its request's
    Box3 bounds;                           // of the scene
    ViewTimes times;
    bool early = false;             // bounced light is being prepared
    std::uint64_t number = 0;       // counts up
    std::uint64_t request = 0;      // its request: the number that ask() returned
    std::optional<Picked> picked;   // result of the last `pick` in this scene
    /// Of what the frame shows of the picked object, in pixels of the frame without legends; not with overlays that
    /// replace the image.
    std::vector<OutlineEdge> outline;
    std::size_t remembered_bytes = 0;
};

/// Progress and errors.
struct LoadState {
    bool loading = false;
    std::string file;   // being loaded, or loaded last
    std::string stage;
    double done = 0;
    std::string error;            // of the last load; empty if it succeeded
    std::string frame_error;      // of the last frame
    std::uint64_t failed = 0;     // its request; 0: the last frame did not fail
    std::exception_ptr trouble;   // the last error
    std::uint64_t loads = 0;      // that succeeded
    std::string preparing;        // what takes long, and how far it is; empty: nothing
};

/// A scene as its file gives it, and what options make of it.
struct SceneRecipe {
    std::string what;   // file or builtin:NAME
    double fps = 0;     // 0: its own
    std::optional<int> lights;
    std::vector<std::string> light_specs;
    std::string environment;
    bool strict = false;                 // refuses files with errors that could be repaired
    int memory = LoadOptions{}.memory;   // MB that the file may ask for
    std::optional<bool> ground;
    std::string animation, variant;   // as LoadOptions has them
    friend bool operator==(const SceneRecipe&, const SceneRecipe&) = default;
};

class ViewSession {
 public:
    /// About 50 ms on two cores.
    static constexpr std::uint64_t k_rays_a_frame = 1u << 18;
    static constexpr int k_coarse_depth = 3;   // reflections and refractions in a row in coarse images, at most
    /// @param rays_a_frame  limit of an image's rays of indirect light; the missing light comes with the next image
    /// @param changed       called from threads of the session when it has news: an image, a scene, an error, progress
    explicit ViewSession(int threads, std::uint64_t rays_a_frame = k_rays_a_frame, std::function<void()> changed = {});
    ~ViewSession();

    /// Starts to load a scene. The one before stays until this one is loaded, or for good if loading fails.
    void load(const SceneRecipe& recipe);
    LoadState load_state() const;
    /// The scene that requests refer to; null: none yet.
    std::shared_ptr<const Scene> scene() const;

    /// Requests a frame. Replaces a request whose rendering has not begun. Interrupts one that is interruptible, any
    /// that is not urgent if this one is, and the refining of the one before; no image of theirs follows.
    /// @return its number, from 1
    std::uint64_t ask(ViewRequest request);
    /// A request waits for its first image.
    bool busy() const;
    /// A new request would not wait for the one before to get its first image.
    bool interruptible() const;
    /// The last request has an image, and gets refined ones until it is complete, and its last one.
    bool refining() const;
    /// The newest image, if there is one newer than that number.
    std::shared_ptr<const ViewImage> image(std::uint64_t newer_than) const;

 private:
    void load_loop(const std::stop_token& stop);
    void render_loop(const std::stop_token& stop);
    std::shared_ptr<ViewImage> render(const std::shared_ptr<const Scene>& scene, const ViewRequest& request,
                                      bool refines);
    bool asked_soon(const std::stop_token& stop);
    bool publish(std::shared_ptr<ViewImage> image, ViewRequest& request, bool refines);
    bool finishes(ViewRequest& request);
    void hand_over_overrides(const Scene& scene, const ViewRequest& request, FrameInput& input);
    Picked pick(const Scene& scene, const Frame& frame, const glm::vec2& place);
    std::optional<Picked> picked_before(const std::shared_ptr<const Scene>& scene) const;
    std::vector<float> nearness_before(const ViewImage& image) const;
    void fail(std::uint64_t request, const std::string& message);
    void note_preparing(const std::string& stage);
    void tell() const;

    int threads_;
    std::uint64_t rays_a_frame_;
    std::function<void()> changed_;
    mutable std::mutex mutex_;
    std::condition_variable_any to_load_, to_render_;
    std::optional<SceneRecipe> wanted_;
    std::optional<ViewRequest> request_;
    std::atomic<std::uint64_t> asked_ = 0;    // number of the last request; written under the mutex
    std::atomic<std::uint64_t> urgent_ = 0;   // number of the last urgent one; written under the mutex
    bool rendering_ = false, refining_ = false, interruptible_ = false;
    LoadState state_;
    std::shared_ptr<const Scene> scene_;
    std::shared_ptr<const ViewImage> image_;
    std::atomic<bool> leaving_ = false;
    // Of the render thread alone.
    Renderer renderer_;
    std::shared_ptr<const Scene> rendered_;   // the renderer's scene
    struct Prepared {                         // what a frame with bounced light was rendered with
        std::shared_ptr<const Scene> scene;
        Indirect method = Indirect::off;
        int bounces = 0;
        friend bool operator==(const Prepared&, const Prepared&) = default;
    };
    Prepared prepared_;
    int refined_ = 0;            // images that refined the last request
    std::vector<NodeId> held_;   // nodes whose transforms the renderer was given
    // The last file read, so that other lights or rates do not read it again.
    std::string loaded_file_;
    LoadOptions loaded_options_;   // strict, animation and variant
    std::filesystem::file_time_type loaded_time_{};
    std::optional<Scene> loaded_;
    std::jthread load_thread_, render_thread_;   // last: they use all of the above
};

}   // namespace gnomon::viewer
