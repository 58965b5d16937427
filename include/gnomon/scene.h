// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scenes from files or made in code.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "gnomon/error.h"
#include "gnomon/types.h"

namespace gnomon {

namespace scene {
class Scene;
}

/// What a scene holds. 'Dynamic' means: may move or deform at some time in the clip.
struct SceneInfo {
    std::string name;
    std::uint64_t triangles = 0, triangles_dynamic = 0;   // instanced
    std::uint64_t objects = 0, objects_dynamic = 0;       // instances of meshes
    std::uint64_t meshes = 0, materials = 0, textures = 0;
    std::vector<std::string> lights, cameras;   // names; empty strings for unnamed ones
    int frames = 1;
    double fps = 24;
    double start = 0, end = 0;                 // seconds
    float bounds_low[3]{}, bounds_high[3]{};   // at the start
    Size resolution{};                         // the file's own; 0 x 0: none
    std::vector<std::string> warnings;
};

/// A scene: cheap to copy (copies share it), never changed after loading.
class Scene {
 public:
    explicit Scene(std::shared_ptr<const scene::Scene> inside);
    // Moving copies, too: a scene that was moved from is still one.
    Scene(const Scene&) = default;
    Scene& operator=(const Scene&) = default;

    /// Frames of the whole clip, counted from 1; at least 1.
    int frame_count() const;
    /// Time of a frame in seconds.
    double time_of(int frame) const;
    /// Video rate in frames a second.
    double fps() const;
    SceneInfo info() const;

    /// The same scene sampled at another rate (glTF), or shown at it (AFF, which numbers its own frames).
    /// @throws UsageError  a rate that is none, or at which the clip has more than 10^9 frames
    Scene at_rate(double fps) const;
    /// A scene without animation as a clip of that length: for a turntable. Others stay as they are.
    Scene lasting(double seconds) const;
    /// Keeps the first `count` lights in file order.
    Scene with_lights(int count) const;
    /// Replaces all lights. Each spec is "spot X Y Z DX DY DZ HALF_ANGLE_DEG R G B" or "point X Y Z R G B", in candela.
    /// @throws UsageError  for a spec that is not of that form
    Scene with_light_specs(const std::vector<std::string>& specs) const;

    /// Lit by an image of the surroundings as well: OpenEXR, Radiance HDR, PNG or JPEG, longitude by latitude, its
    /// upper edge towards +Y, its centre towards -Z, its right quarter towards +X. It replaces the background and the
    /// default sky and sun; the file's own lights stay.
    /// @param lights  directional lights that stand for it, a power of two from 1 to 1024
    /// @throws InputError for a file that is missing or wrong; UsageError for a number of lights that is not of that
    ///         form
    Scene with_environment(const std::filesystem::path& file, int lights = 16) const;

    const std::shared_ptr<const scene::Scene>& inside() const { return impl_; }

 private:
    std::shared_ptr<const scene::Scene> impl_;
};

struct LoadOptions {
    Progress progress;   // optional
    int threads = 0;     // 0: all
};

/// Loads a scene: a file by its extension (.aff, ...), or "builtin:NAME".
/// @throws InputError    for a file that is missing or wrong: names file, place and fault
/// @throws UsageError    for an unknown extension or built-in scene
/// @throws InterruptedError
Scene load(const std::string& what, const LoadOptions& options = {});

}   // namespace gnomon
