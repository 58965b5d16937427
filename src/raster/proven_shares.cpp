// SPDX-License-Identifier: Apache-2.0
#include "raster/proven_shares.h"

#include <algorithm>

#include "gpu_scene/gpu_scene_shared.h"
#include "raster/shadow_point.h"
#include "ray/smooth_surface.h"
#include "scene/view.h"
#include "shading/glossy.h"
#include "shading/lobe_shared.h"
#include "shading/polygon_light.h"

namespace gnomon::raster {

namespace {

using area_light::AreaVisibility;

constexpr int k_tile = 32;   // pixels a side, whose points are handed over together

int tiles_across(int pixels)
{
    return (pixels + k_tile - 1) / k_tile;
}

float mean_of(const glm::vec3& share, const glm::vec3& radiance)
{
    const float whole = luminance(radiance);
    return whole > 0 ? luminance(share * radiance) / whole : 0;
}

}   // namespace

void ProvenShares::follow(const scene::SceneState& state, const scene::SizedLights& lights)
{
    const bool first = !visibility_;
    if (first) visibility_ = std::make_unique<AreaVisibility>(state, rays_);
    std::vector<area_light::AreaLight> planar;
    planar_.assign(lights.lights().size(), k_cluster);
    for (std::size_t l = 0; l < lights.lights().size(); ++l) {
        if (!lights.lights()[l].is_flat()) continue;
        planar_[l] = static_cast<std::uint32_t>(planar.size());
        planar.push_back(area_light::area_light_of(lights.lights()[l]));
    }
    visibility_->follow(state, rays_, planar);
    if (!first && lights_ == &lights && version_ == lights.version()) return;
    lights_ = &lights, version_ = lights.version();
    places_.clear();
    for (std::size_t l = 0; l < lights.lights().size(); ++l)
        if (planar_[l] != k_cluster) places_.emplace_back(*visibility_, planar_[l], lights.lights()[l]);
}

// Makes the points of one tile as the traced frame does.
void ProvenShares::make_points(std::size_t number, const scene::View& view)
{
    Tile& tile = tiles_[number];
    tile.points.clear(), tile.pixels.clear();
    const std::span<const glm::vec4> positions = positions_.as<glm::vec4>(), geometric = geometric_.as<glm::vec4>(),
                                     diffuse = diffuse_.as<glm::vec4>();
    const std::span<const glm::uvec2> ids = ids_.as<glm::uvec2>();
    const int columns = tiles_across(view.size.width), x0 = static_cast<int>(number) % columns * k_tile,
              y0 = static_cast<int>(number) / columns * k_tile;
    for (int y = y0; y < std::min(y0 + k_tile, height_); ++y)
        for (int x = x0; x < std::min(x0 + k_tile, width_); ++x) {
            const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
            if (ids[i].x == 0 || static_cast<std::uint32_t>(diffuse[i].w) == GNOMON_MODEL_UNLIT) continue;
            tile.points.push_back(shadow_point_of(rays_, ids[i], glm::vec3(positions[i]), glm::vec3(geometric[i])));
            tile.pixels.push_back(static_cast<std::uint32_t>(i));
        }
}

void ProvenShares::read(vk::Commands& commands, const GBuffer& surfaces, const scene::View& view)
{
    positions_ = commands.read_back(surfaces.position), normals_ = commands.read_back(surfaces.normal);
    geometric_ = commands.read_back(surfaces.geometric), smooth_ = commands.read_back(surfaces.smooth),
    speculars_ = commands.read_back(surfaces.specular);
    diffuse_ = commands.read_back(surfaces.diffuse), ids_ = commands.read_back(surfaces.ids);
    commands.submit();
    width_ = view.size.width, height_ = view.size.height;
    eye_ = view.eye, forward_ = view.forward, orthographic_ = view.orthographic;
    tiles_.resize(static_cast<std::size_t>(tiles_across(width_)) * static_cast<std::size_t>(tiles_across(height_)));
    scratch_.resize(static_cast<std::size_t>(tasks_.threads()));
    tasks_.for_each(tiles_.size(), [&](std::size_t t, int) { make_points(t, view); });
}

std::span<const glm::vec2> ProvenShares::find(std::size_t first, std::size_t count,
                                              std::span<const scene::SizedLight> lights)
{
    const auto pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    shares_.assign(count * pixels, glm::vec2(0));
    tasks_.for_each(tiles_.size(), [&](std::size_t t, int worker) {
        for (std::size_t l = first; l < first + count; ++l)
            if (knows(l) && !tiles_[t].points.empty())
                find_in_tile(tiles_[t], planar_[l], lights[l], scratch_[static_cast<std::size_t>(worker)],
                             &shares_[(l - first) * pixels]);
    });
    return shares_;
}

void ProvenShares::find_in_tile(const Tile& tile, std::size_t number, const scene::SizedLight& light, Scratch& own,
                                glm::vec2* shares) const
{
    // Ask for the points that face the light, and that it faces.
    const scene::SizedFace& face = light.outline;
    own.asked.clear();
    for (std::uint32_t p = 0; p < tile.points.size(); ++p) {
        const visibility::ShadowPoint& point = tile.points[p];
        if (!face.two_sided && !(glm::dot(face.normal, point.origin - face.corner[0]) > 0)) continue;
        if (glm::vec3(smooth_.as<glm::vec4>()[tile.pixels[p]]) != point.normal) {
            const shading::SurfacePoint s = surface_of(tile, p);
            if (shading::is_partly_between(s, light)) {
                shares[tile.pixels[p]] = share_between(tile, p, s, light, own);
                continue;
            }
        }
        const auto above = [&](const glm::vec3& corner) { return glm::dot(point.normal, corner - point.origin) > 0; };
        if (std::any_of(face.corner.begin(), face.corner.begin() + face.corners, above)) own.asked.push_back(p);
    }
    if (own.asked.empty()) return;
    visibility_->find(own.visibility, tile.points, own.asked, number, own.answers);
    for (std::size_t k = 0; k < own.asked.size(); ++k) {
        glm::vec2 share(0);
        if (own.answers.answer[k] == AreaVisibility::Answer::lit) share = glm::vec2(1);
        if (own.answers.answer[k] == AreaVisibility::Answer::partial)
            share = share_of(tile, own.asked[k], number, light, k, own);
        shares[tile.pixels[own.asked[k]]] = share;
    }
}

shading::SurfacePoint ProvenShares::surface_of(const Tile& tile, std::uint32_t p) const
{
    const std::uint32_t pixel = tile.pixels[p];
    const glm::vec4 normal = normals_.as<glm::vec4>()[pixel];
    shading::SurfacePoint s;
    s.position = glm::vec3(positions_.as<glm::vec4>()[pixel]);
    s.geometric_normal = tile.points[p].normal, s.normal = glm::vec3(normal);
    s.smooth_normal = glm::vec3(smooth_.as<glm::vec4>()[pixel]);
    s.to_viewer = orthographic_ ? -forward_ : glm::normalize(eye_ - s.position);
    s.roughness = std::max(normal.w, GNOMON_LOBE_LEAST_ROUGHNESS);
    s.specular = glm::vec3(speculars_.as<glm::vec4>()[pixel]);
    return s;
}

bool ProvenShares::has_lobe(const shading::SurfacePoint& s, std::uint32_t pixel) const
{
    const bool metallic_roughness =
        static_cast<std::uint32_t>(diffuse_.as<glm::vec4>()[pixel].w) == GNOMON_MODEL_METALLIC_ROUGHNESS;
    return metallic_roughness && speculars_.as<glm::vec4>()[pixel].w == 0 && shading::has_glossy_lobe(s);
}

// The shares of a point to which a part of a light is behind its triangle, but not behind the smooth surface.
glm::vec2 ProvenShares::share_between(const Tile& tile, std::uint32_t p, const shading::SurfacePoint& s,
                                      const scene::SizedLight& light, Scratch& own) const
{
    const visibility::ShadowPoint& point = tile.points[p];
    const glm::vec3 lift =
        ray::smooth_lift(rays_.geometry(point.object), point.triangle, point.u, point.v, point.normal);
    own.between.find(rays_, s, point.origin, point.origin + lift, light);
    const bool lobe = has_lobe(s, tile.pixels[p]);
    const shading::VisibleShare share =
        shading::visible_share(s, light, own.between.places(), own.between.seen(), shading::SeenBetween::k_whole, lobe);
    const glm::vec3& radiance = light.faces.front().radiance;
    return {mean_of(share.irradiance, radiance), lobe ? mean_of(share.lobe, radiance) : 0.0f};
}

// The shares of a point that sees a part of a light.
glm::vec2 ProvenShares::share_of(const Tile& tile, std::uint32_t p, std::size_t number, const scene::SizedLight& light,
                                 std::size_t k, Scratch& own) const
{
    const visibility::ShadowPoint& point = tile.points[p];
    const std::uint32_t pixel = tile.pixels[p];
    const area_light::VisibleCells& cells = own.answers.cells[own.answers.at[k]];
    const std::size_t side = own.answers.back[k] ? 1 : 0;
    const area_light::LightCells& of_side = visibility_->cells(number, side == 1);
    const area_light::CellPlaces& places = places_[number];
    const shading::SurfacePoint s = surface_of(tile, p);
    const bool lobe = has_lobe(s, pixel);
    if (places.one_radiance && !lobe) return glm::vec2(of_side.share(point.origin, s.normal, point.normal, cells));
    own.seen.resize(places.of[side].size());
    places.fill_seen(side, of_side, cells, own.seen.data());
    const shading::VisibleShare share =
        shading::visible_share(s, light, places.of[side], own.seen, area_light::CellPlaces::k_whole, lobe);
    const glm::vec3& radiance = light.faces.front().radiance;
    return {mean_of(share.irradiance, radiance), lobe ? mean_of(share.lobe, radiance) : 0.0f};
}

}   // namespace gnomon::raster
