// SPDX-License-Identifier: Apache-2.0
#pragma once
// How much of each light with size the pixels of a rasterised frame see, by the remembered proofs of the traced frame
// (area_light/): for flat lights, of one polygon or several. The surfaces are read back, and the shares are sent to the
// device.
//
// Shares are exact where parts of surfaces are proven lit or dark, and as fine as the traced frame's in penumbrae.
//
// Cost: what is read back and sent, for every layer of surfaces; the proofs of parts that are seen for the first time;
// per pixel and light what the part costs (area_light/area_shadows.h).

#include "area_light/cell_places.h"
#include "base/tasks.h"
#include "raster/gbuffer.h"
#include "scene/sized_light.h"
#include "shading/between_horizons.h"

namespace gnomon::raster {

class ProvenShares {
 public:
    /// The ray scene must follow the state before every follow(). Both outlive this.
    ProvenShares(const ray::RayScene& rays, Tasks& tasks) : rays_(rays), tasks_(tasks) {}

    /// Follows one advance() of the state, after the lights did.
    void follow(const scene::SceneState& state, const scene::SizedLights& lights);
    /// Whether a light's shares are found; else it is a cluster.
    bool knows(std::size_t light) const { return light < planar_.size() && planar_[light] != k_cluster; }

    /// Reads the surfaces of a layer back. Submits.
    void read(vk::Commands& commands, const GBuffer& surfaces, const scene::View& view);
    /// Finds the shares of lights at all pixels that were read: of the irradiance, and of what a glossy lobe reflects.
    /// @return  light by light, pixel by pixel; 0 for lights that are not known
    std::span<const glm::vec2> find(std::size_t first, std::size_t count, std::span<const scene::SizedLight> lights);

    std::size_t bytes() const { return visibility_ ? visibility_->bytes() : 0; }

 private:
    static constexpr std::uint32_t k_cluster = 0xffffffffu;
    // The points of one tile.
    struct Tile {
        std::vector<visibility::ShadowPoint> points;
        std::vector<std::uint32_t> pixels;
    };
    // Of one thread.
    struct Scratch {
        area_light::AreaVisibility::Scratch visibility;
        area_light::AreaVisibility::Answers answers;
        std::vector<std::uint32_t> asked;
        std::vector<std::uint8_t> seen;
        shading::SeenBetween between;
    };
    void make_points(std::size_t tile, const scene::View& view);
    void find_in_tile(const Tile& tile, std::size_t number, const scene::SizedLight& light, Scratch& own,
                      glm::vec2* shares) const;
    shading::SurfacePoint surface_of(const Tile& tile, std::uint32_t point) const;
    bool has_lobe(const shading::SurfacePoint& s, std::uint32_t pixel) const;
    glm::vec2 share_of(const Tile& tile, std::uint32_t point, std::size_t number, const scene::SizedLight& light,
                       std::size_t k, Scratch& own) const;
    glm::vec2 share_between(const Tile& tile, std::uint32_t point, const shading::SurfacePoint& s,
                            const scene::SizedLight& light, Scratch& own) const;

    const ray::RayScene& rays_;
    Tasks& tasks_;
    std::unique_ptr<area_light::AreaVisibility> visibility_;
    const scene::SizedLights* lights_ = nullptr;
    std::uint32_t version_ = 0;                    // of the lights
    std::vector<std::uint32_t> planar_;            // by light: index among the planar ones, or k_cluster
    std::vector<area_light::CellPlaces> places_;   // by planar light
    // Of the layer that was read:
    vk::Buffer positions_, normals_, geometric_, smooth_, speculars_, diffuse_, ids_;
    int width_ = 0, height_ = 0;
    glm::vec3 eye_{0}, forward_{0};
    bool orthographic_ = false;
    std::vector<Tile> tiles_;
    std::vector<Scratch> scratch_;
    std::vector<glm::vec2> shares_;
};

}   // namespace gnomon::raster
