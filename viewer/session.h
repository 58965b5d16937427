// SPDX-License-Identifier: Apache-2.0
#pragma once
// Loads scenes and renders frames for the viewer in the background: one thread loads scenes, another renders the latest
// requested frame. The window's thread posts requests and takes images, and never waits for either.
//
// A request describes a frame completely: time, view, options, user overrides. A request that is replaced before its
// rendering began is never rendered. Frames come from a frame::FrameEngine, so they are those of gnomon::Renderer.

#include <atomic>
#include <condition_variable>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/image.h"
#include "gnomon/renderer.h"
#include "scene/scene.h"
#include "scene/view.h"

namespace gnomon::frame {
class FrameEngine;
}

namespace gnomon::viewer {

/// A user override: a node that is held where it is, or moved from there.
struct HandMoved {
    scene::NodeId node = scene::none;
    bool frozen = false;   // held where it is now
    glm::vec3 offset{0};   // from where it was taken, in its parent's space
    friend bool operator==(const HandMoved&, const HandMoved&) = default;
};

struct ViewRequest {
    std::shared_ptr<const Scene>
        scene;   // that eye, hands and pick refer to; they are ignored once another scene is loaded
    double time = 0;
    std::optional<scene::View> eye;   // none: the scene's camera
    std::string camera = "auto";      // then, as on the command line; the frame fails if the scene has no such camera
    double turn = 0;                  // radians around the scene, of the scene's camera
    Size size{640, 360};
    RenderOptions options;   // size, camera, turntable and threads of it are not read
    std::vector<HandMoved> hands;
    std::optional<glm::vec2> pick;   // pixels from the top left corner: find the object there
    bool whole = false;              // all indirect light in the first image, however long that takes
    std::uint64_t number = 0;        // given by ask()
};

/// Milliseconds by stage.
struct ViewTimes {
    static constexpr int k_stages = 4;
    static const char* name(int stage);
    double ms[k_stages] = {};   // scene, trees, light, image
    double total() const;
};

struct Picked {
    scene::ObjectId object = scene::none;
    scene::NodeId node = scene::none;
    std::string name;
    std::string mobility;   // "static", "moves rigidly", "deforms"
    glm::vec3 position{0};
};

struct ViewImage {
    std::shared_ptr<const Scene> scene;
    Image8 image;           // sRGB
    scene::View eye;        // as rendered
    glm::ivec2 corner{0};   // of the view in the image: overlays have titles and legends around it
    Box3 bounds;            // of the scene
    double time = 0;
    bool complete = true;   // all of its indirect light is there; else the next image has more of it
    ViewTimes times;
    FrameCounters counters;
    std::uint64_t number = 0;       // counts up
    std::uint64_t request = 0;      // its request: the number that ask() returned
    std::optional<Picked> picked;   // result of the last `pick`; object none: nothing there
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
};

/// A scene as its file gives it, and what options make of it.
struct SceneRecipe {
    std::string what;   // file or builtin:NAME
    double fps = 0;     // 0: its own
    std::optional<int> lights;
    std::vector<std::string> light_specs;
    std::string environment;
    friend bool operator==(const SceneRecipe&, const SceneRecipe&) = default;
};

class ViewSession {
 public:
    /// About 50 ms on two cores.
    static constexpr std::uint64_t k_rays_a_frame = 1u << 18;
    /// @param rays_a_frame  limit of an image's rays of indirect light; the missing light comes with the next image
    explicit ViewSession(int threads, std::uint64_t rays_a_frame = k_rays_a_frame);
    ~ViewSession();

    /// Starts to load a scene. The one before stays until this one is loaded, or for good if loading fails.
    void load(const SceneRecipe& recipe);
    LoadState load_state() const;
    /// The scene that requests refer to; null: none yet.
    std::shared_ptr<const Scene> scene() const;

    /// Requests a frame. Replaces a request whose rendering has not begun, and ends the refining of the one before.
    /// @return its number, from 1
    std::uint64_t ask(ViewRequest request);
    /// A request waits for its first image.
    bool busy() const;
    /// The last request has an image, and gets refined ones until it is complete.
    bool refining() const;
    /// The newest image, if there is one newer than that number.
    std::shared_ptr<const ViewImage> image(std::uint64_t newer_than) const;

 private:
    void load_loop(const std::stop_token& stop);
    void render_loop(const std::stop_token& stop);
    std::shared_ptr<ViewImage> render(const std::shared_ptr<const Scene>& scene, const ViewRequest& request);
    void fail(std::uint64_t request, const std::string& message);

    int threads_;
    std::uint64_t rays_a_frame_;
    mutable std::mutex mutex_;
    std::condition_variable_any to_load_, to_render_;
    std::optional<SceneRecipe> wanted_;
    std::optional<ViewRequest> request_;
    std::uint64_t asked_ = 0;
    bool rendering_ = false, refining_ = false;
    LoadState state_;
    std::shared_ptr<const Scene> scene_;
    std::shared_ptr<const ViewImage> image_;
    std::atomic<bool> leaving_ = false;
    std::unique_ptr<frame::FrameEngine> engine_;   // of the render thread alone
    // The last file read, so that other lights or rates do not read it again.
    std::string loaded_file_;
    std::filesystem::file_time_type loaded_time_{};
    std::optional<Scene> loaded_;
    std::jthread loader_, renderer_;   // last: they use all of the above
};

}   // namespace gnomon::viewer
