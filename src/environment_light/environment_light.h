// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light of an environment image at points of a frame, with the visibility of its directions: the full distribution
// of the image, not a few suns; exact where nothing occludes it, and without noise. And the visible shares of
// directional lights that have a size, as discs of directions.
//
// It follows the scene state, and keeps what is known: while an image stays, its cells and tables; while static
// triangles stay, what is proven of them. Another image, such as the same one turned, keeps the proofs of all cells
// that both have, and what rays found in their directions.
//
// An irradiance at a point is a function of the point, the normal, the image and the scene alone.
//
// Cost: see cell_light.h, cell_visibility.h and cell_proofs.h. A new image: some 30 ms.

#include <memory>

#include "base/tasks.h"
#include "environment_light/cell_light.h"
#include "environment_light/cell_visibility.h"
#include "environment_light/mirrored_cells.h"

namespace gnomon::environment_light {

struct EnvironmentOptions {
    CellOptions cells;
    CellLightOptions light;
    ProofOptions proofs;
    double sun_diameter = 0;   // angular, of directional lights, in radians; 0: they are points, and none is a sun here
    bool image = true;         // false: suns alone
};

/// A directional light with a size.
struct Sun {
    scene::LightId light = 0;
    DirectionCells cells;
    std::unique_ptr<CellVisibility> visibility;
};

class EnvironmentLight {
 public:
    explicit EnvironmentLight(const EnvironmentOptions& options = {});
    ~EnvironmentLight();

    /// Follows one advance() of the state, after the ray scene did. The state must be the one of the call before, or
    /// one that continues it.
    /// @param tasks  optional: what is made at first is made side by side
    void follow(const scene::SceneState& state, const ray::RayScene& rays, Tasks* tasks = nullptr);
    /// Whether the scene has no environment image, or a black one; nothing else may then be called but follow().
    bool empty() const { return !image_; }
    /// Increases whenever memory of points (PointMemory) must be forgotten: that of the image, and that of suns. While
    /// another image follows, it stays; what points did not ask for in the frame after it is void.
    std::uint32_t version() const { return version_; }
    std::uint32_t suns_version() const { return suns_version_; }
    /// Whether there are visible dynamic objects, which may hide anything in any frame.
    bool anything_moves() const { return surroundings_ && !surroundings_->dynamic_boxes().empty(); }
    const std::vector<std::unique_ptr<Sun>>& suns() const { return suns_; }
    const EnvironmentOptions& options() const { return options_; }
    /// The share of a sun's light that a surface with this normal gets from its visible directions.
    static float visible_share(const Sun& sun, const glm::vec3& normal, std::span<const std::uint64_t> seen);

    const CellLight& light() const;
    const CellVisibility& visibility() const;
    /// For points of smooth meshes. Thread-safe.
    const MirroredCells& mirrored() const;

    /// The irradiance at one point of a surface. Thread-safe for different scratch and memory.
    /// @param point   ray origin and geometric normal; of a static object, with its triangle: what is proven of it then
    ///                saves rays
    /// @param normal  unit, shading; on the side of the geometric normal
    /// @param memory  of static points; null: nothing is remembered
    glm::vec3 irradiance(CellVisibility::Scratch& scratch, const visibility::ShadowPoint& point,
                         const glm::vec3& normal, PointMemory* memory = nullptr) const;
    std::size_t bytes() const;

 private:
    struct Image;
    std::shared_ptr<const scene::Environment> lighting_image(const scene::SceneState& state) const;
    void follow_image(const std::shared_ptr<const scene::Environment>& lights, std::unique_ptr<Image> made, bool anew);
    void follow_suns(const scene::SceneState& state, bool anew);

    EnvironmentOptions options_;
    std::unique_ptr<Surroundings> surroundings_;
    std::unique_ptr<Image> image_;
    std::unique_ptr<Image> before_;   // the image of the frame before, if it was another one: points remember its cells
    std::vector<std::unique_ptr<Sun>> suns_;
    std::uint32_t version_ = 0, suns_version_ = 0;
};

}   // namespace gnomon::environment_light
