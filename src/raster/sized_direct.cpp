// SPDX-License-Identifier: Apache-2.0
#include "raster/sized_direct.h"

#include <algorithm>

#include "raster/raster_formats.h"
#include "raster/raster_shared.h"
#include "raster/sized_shared.h"
#include "shading/glossy.h"
#include "shading/transformed_cosines.h"

namespace gnomon::raster {

namespace {

using shared::LobeFit;
using shared::SizedFaceRecord;
using shared::SizedLightRecord;
using shared::SizedPlaceRecord;

constexpr std::uint32_t k_compute_code[] =
#include "raster/sized.comp.inc"
    ;
constexpr std::uint32_t k_closer_code[] =
#include "raster/sized_closer.comp.inc"
    ;
constexpr std::uint32_t k_sum_code[] =
#include "raster/sized_sum.comp.inc"
    ;

// Places of one-sided faces lie this far in front of them, as a fraction of the light's radius, so that their own face
// is behind them.
constexpr float k_lift = 1e-4f;

constexpr std::uint32_t k_batch = 4;   // lights whose shares are sent at once

scene::SizedLightOptions place_options(const SizedDirectOptions& options)
{
    scene::SizedLightOptions result;
    result.places = options.places;
    result.places_in_all = options.places_in_all;
    result.least_places = options.least_places;
    return result;
}

SizedPlaceRecord record_of(const scene::SizedPlace& place, std::uint32_t first_face)
{
    return {place.position, first_face + place.face, place.radiance, place.area};
}

// Sends values to a buffer, which is made anew if they do not fit. There is always room for one.
template <class T>
void send_all(const std::shared_ptr<vk::Device>& device, vk::Commands& commands, const char* name, vk::Buffer& buffer,
              const std::vector<T>& values)
{
    const std::size_t bytes = std::max<std::size_t>(values.size(), 1) * sizeof(T);
    if (!buffer || buffer.bytes() < bytes) buffer = vk::Buffer(device, name, bytes);
    if (values.empty()) return;
    const vk::Upload upload = vk::upload_of(buffer, std::span<const T>(values));
    commands.upload(name, {&upload, 1});
}

}   // namespace

struct SizedDirect::Views {
    light_views::LightViews views;
    light_views::CasterGeometry casters;
    light_views::GpuLightViews buffers;
    shadow_textures::LookupRecords records;

    Views(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
          const light_views::ViewedLights& viewed, const light_views::LightViewsOptions& options)
        : views(state, viewed, options), casters(device, state), buffers(device, views), records(device, views)
    {
    }
};

SizedDirect::SizedDirect(const std::shared_ptr<vk::Device>& device, const scene::SceneState&,
                         const SizedDirectOptions& options)
    : device_(device), options_(options), places_(place_options(options))
{
}

SizedDirect::~SizedDirect() = default;

const light_views::LightViews* SizedDirect::views() const
{
    return views_ ? &views_->views : nullptr;
}

std::uint64_t SizedDirect::draws() const
{
    return views_ ? views_->views.counts().draws : 0;
}

// Makes the places that have views, and finds which of them moved.
void SizedDirect::find_places(const scene::SceneState& state)
{
    std::vector<scene::Light> kinds;
    std::vector<scene::LightState> states;
    first_place_.clear();
    for (std::size_t l = 0; l < places_.lights().size(); ++l) {
        const scene::SizedLight& light = places_.lights()[l];
        first_place_.push_back(static_cast<std::uint32_t>(states.size()));
        if (proofs_ && proofs_->knows(l)) continue;
        const auto add = [&](const glm::vec3& position, const scene::SizedFace& face) {
            scene::Light kind;
            kind.type = face.two_sided ? scene::LightType::point : scene::LightType::spot;
            kind.outer_angle = static_cast<float>(k_pi / 2);
            kinds.push_back(kind);
            const float lift = face.two_sided ? 0 : k_lift * light.radius;
            states.push_back({position + lift * face.normal, face.normal, true});
        };
        if (options_.method == SizedDirectOptions::Method::percentage_closer) {
            glm::vec3 middle(0);
            const scene::SizedFace& face = light.faces.front();
            for (int k = 0; k < face.corners; ++k)
                middle += face.corner[static_cast<std::size_t>(k)] / static_cast<float>(face.corners);
            add(middle, face);
            continue;
        }
        if (options_.method == SizedDirectOptions::Method::unshadowed) continue;
        for (const scene::SizedPlace& place : light.places) add(place.position, light.faces[place.face]);
    }
    first_place_.push_back(static_cast<std::uint32_t>(states.size()));

    // Find what moved. With other lights, all views are made anew.
    moved_before_.swap(moved_);
    moved_.clear(), started_.clear();
    const bool same = std::equal(kinds.begin(), kinds.end(), kinds_.begin(), kinds_.end(),
                                 [](const scene::Light& a, const scene::Light& b) { return a.type == b.type; });
    if (!same) views_.reset();
    for (scene::LightId p = 0; same && p < states.size(); ++p) {
        if (states[p] == states_[p]) continue;
        moved_.push_back(p);
        if (!std::binary_search(moved_before_.begin(), moved_before_.end(), p)) started_.push_back(p);
    }
    kinds_ = std::move(kinds), states_ = std::move(states);
    if (views_ || places_.empty()) return;
    light_views::LightViewsOptions options;
    options.projection.half_cubes = true;
    options.atlas = options_.atlas;
    views_ = std::make_unique<Views>(device_, state, light_views::ViewedLights{kinds_, states_, {}, {}}, options);
}

// Sends the lights, their faces and places.
void SizedDirect::send(vk::Commands& commands)
{
    std::vector<SizedLightRecord> records;
    std::vector<SizedFaceRecord> faces;
    std::vector<SizedPlaceRecord> places, view_places;
    std::vector<glm::vec3> cells;
    for (std::size_t l = 0; l < lights_.lights().size(); ++l) {
        const scene::SizedLight &light = lights_.lights()[l], &with_views = places_.lights()[l];
        SizedLightRecord r{};
        r.centre = light.centre, r.radius = light.radius;
        r.first_face = static_cast<std::uint32_t>(faces.size());
        r.face_count = static_cast<std::uint32_t>(light.faces.size());
        r.first_place = static_cast<std::uint32_t>(places.size());
        r.place_count = static_cast<std::uint32_t>(light.places.size());
        r.first_view = first_place_[l];
        r.view_count = first_place_[l + 1] - first_place_[l];
        r.first_cell = static_cast<std::uint32_t>(cells.size());
        r.cells = light.cell_radiance.empty() ? 0 : static_cast<std::uint32_t>(light.cells);
        r.cone_axis = light.cone.axis;
        r.cos_outer = light.cone.limits() ? light.cone.cosines.outer : GNOMON_NO_CONE;
        r.cos_inner = light.cone.cosines.inner;
        for (const scene::SizedFace& f : light.faces) {
            SizedFaceRecord face{};
            std::copy(f.corner.begin(), f.corner.end(), face.corner);
            face.corners = static_cast<std::uint32_t>(f.corners);
            face.normal = f.normal, face.radiance = f.radiance;
            face.two_sided = f.two_sided ? 1 : 0;
            faces.push_back(face);
        }
        for (const scene::SizedPlace& p : light.places) places.push_back(record_of(p, r.first_face));
        // Faces of a light are in the same order in both.
        r.proven = proofs_ && proofs_->knows(l) ? 1 : 0;
        if (options_.method == SizedDirectOptions::Method::views && r.proven == 0)
            for (const scene::SizedPlace& p : with_views.places) view_places.push_back(record_of(p, r.first_face));
        cells.insert(cells.end(), light.cell_radiance.begin(), light.cell_radiance.end());
        records.push_back(r);
    }
    send_all(device_, commands, "lights with size", light_records_, records);
    send_all(device_, commands, "faces of lights", faces_, faces);
    send_all(device_, commands, "places of lights", place_records_, places);
    send_all(device_, commands, "viewing places of lights", view_places_, view_places);
    send_all(device_, commands, "cells of lights", cells_, cells);
    if (fits_) return;
    std::vector<LobeFit> fits;
    for (const shading::TransformedCosineFit& f : shading::transformed_cosine_fits())
        fits.push_back({f.a, f.b, f.c, f.tilt, f.scale});
    send_all(device_, commands, "fits of lobes", fits_, fits);
    const std::span<const glm::vec2> albedos = shading::glossy_albedo_table();
    send_all(device_, commands, "albedos of lobes", albedos_, std::vector<glm::vec2>(albedos.begin(), albedos.end()));
}

void SizedDirect::update(vk::Commands& commands, const scene::SceneState& state)
{
    lights_.update(state);
    places_.update(state);
    if (proofs_) proofs_->follow(state, lights_);
    const bool other_lights = lights_.version() != sent_version_;
    if (other_lights) find_places(state);
    if (!other_lights && !moved_.empty()) {
        // What moved in the last frame rests now.
        moved_.clear(), moved_before_.clear(), started_.clear();
    }
    if (lights_.empty()) {
        sent_version_ = lights_.version();
        views_.reset();
        kinds_.clear(), states_.clear();
        return;
    }
    if (other_lights) {
        send(commands);
        sent_version_ = lights_.version();
        changed_ = true;
    }
    Views& v = *views_;
    v.views.update(state, {kinds_, states_, moved_, started_});
    v.casters.update(commands, state);
    v.buffers.record(commands, v.views, v.casters);
    v.records.update(commands, v.views);
    changed_ = changed_ || v.views.counts().views_changed > 0;
}

void SizedDirect::make_pipelines()
{
    const bool closer = options_.method == SizedDirectOptions::Method::percentage_closer;
    vk::ComputeDesc desc;
    desc.name = "lights with size";
    desc.code = {"raster/sized.comp", k_compute_code};
    if (closer) desc.code = {"raster/sized_closer.comp", k_closer_code};
    desc.blocks = vk::all_blocks(
        vk::shared_push<shared::SizedPush>(), shadow_textures::look_up_blocks(),
        std::vector{vk::shared_block<shared::RasterFrame>("Frame"), vk::shared_block<SizedLightRecord>("SizedLights"),
                    vk::shared_block<SizedFaceRecord>("SizedFaces"), vk::shared_block<SizedPlaceRecord>("SizedPlaces"),
                    vk::shared_block<SizedPlaceRecord>("ViewPlaces"), vk::shared_block<LobeFit>("LobeFits")});
    if (!closer) desc.blocks.push_back(vk::shared_block<shadow_textures::shared::TexturePlace>("Places"));
    compute_ = vk::Pipeline(device_, desc);
    sum_ = vk::Pipeline(device_, vk::ComputeDesc{.name = "add lights with size",
                                                 .code = {"raster/sized_sum.comp", k_sum_code},
                                                 .blocks = {vk::shared_push<shared::SizedSumPush>()}});
}

// Computes the image: in batches if shares are sent, else at once.
void SizedDirect::compute(vk::Commands& commands, const SizedSurfaces& layer)
{
    const auto lights = static_cast<std::uint32_t>(lights_.lights().size());
    if (!shares_) shares_ = vk::Buffer(device_, "visible shares", sizeof(glm::vec2));
    if (!proofs_) return compute_batch(commands, layer, 0, lights);
    proofs_->read(commands, layer.surfaces, layer.view);
    for (std::uint32_t first = 0; first < lights; first += k_batch) {
        const std::uint32_t count = std::min(k_batch, lights - first);
        const std::span<const glm::vec2> shares = proofs_->find(first, count, lights_.lights());
        if (shares_.bytes() < shares.size_bytes()) shares_ = vk::Buffer(device_, "visible shares", shares.size_bytes());
        const vk::Upload upload = vk::upload_of(shares_, shares);
        commands.upload("visible shares", {&upload, 1});
        compute_batch(commands, layer, first, count);
    }
}

void SizedDirect::compute_batch(vk::Commands& commands, const SizedSurfaces& layer, std::uint32_t first,
                                std::uint32_t count)
{
    const GBuffer& g = layer.surfaces;
    const Views& v = *views_;
    const std::pair<const char*, const vk::Buffer*> buffers[] = {
        {"Frame", &layer.frame},          {"SizedLights", &light_records_}, {"SizedFaces", &faces_},
        {"SizedPlaces", &place_records_}, {"SizedCells", &cells_},          {"LobeFits", &fits_},
        {"LobeAlbedos", &albedos_},       {"ViewPlaces", &view_places_},    {"Shares", &shares_}};
    const std::pair<const char*, const vk::Image*> images[] = {
        {"share", &layer.share},     {"g_position", &g.position},
        {"g_normal", &g.normal},     {"g_geometric", &g.geometric},
        {"g_smooth", &g.smooth},     {"g_diffuse", &g.diffuse},
        {"g_specular", &g.specular}, {"g_ids", &g.ids}};
    vk::Pass pass = commands.pass("lights with size");
    v.records.declare(pass, v.buffers, nullptr);
    for (const auto& [name, buffer] : buffers) pass.reads(*buffer, vk::Use::storage_read);
    for (const auto& [name, image] : images) pass.reads(*image, vk::Use::sampled);
    pass.writes(image_).compute([&](vk::Recorder& r) {
        r.bind(compute_);
        for (const auto& [name, buffer] : buffers) r.set(name, *buffer);
        for (const auto& [name, image] : images) r.set(name, *image);
        if (options_.method == SizedDirectOptions::Method::percentage_closer) {
            r.set("light_depth", v.buffers.depth(), v.buffers.sampler());
            v.records.bind_views(r);
        } else {
            v.records.bind(r, v.buffers, nullptr);
        }
        r.set("sized", image_);
        const glm::uvec2 size(g.position.width(), g.position.height());
        shared::SizedPush push{};
        push.look_up = shadow_textures::LookupRecords::constants(size, v.views, nullptr, options_.look_up);
        push.first_light = first, push.lights = count;
        push.continued = first > 0 ? 1 : 0;
        push.unshadowed = options_.method == SizedDirectOptions::Method::unshadowed ? 1 : 0;
        push.far = options_.polygon.far;
        push.least_roughness = options_.polygon.least_roughness;
        r.push(push);
        r.dispatch_over(size.x, size.y);
    });
}

void SizedDirect::add(vk::Commands& commands, const SizedSurfaces& layer, const vk::Image& color,
                      const vk::Image& direct, bool layers)
{
    if (empty()) return;
    const std::uint32_t width = color.width(), height = color.height();
    if (!compute_) make_pipelines();
    const bool fits = image_ && image_.width() == width && image_.height() == height;
    if (!fits)
        image_ = vk::Image(device_, {.name = "light with size",
                                     .width = width,
                                     .height = height,
                                     .format = k_wide_format,
                                     .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT});
    if (fits && layer.surfaces.kept && !changed_)
        ++kept_;
    else
        compute(commands, layer);
    changed_ = false;
    commands.pass("add lights with size")
        .uses(sum_)
        .binds("sized", image_)
        .binds("color", color)
        .binds("direct", direct)
        .compute([&](vk::Recorder& r) {
            r.push(shared::SizedSumPush{layers ? 1u : 0u});
            r.dispatch_over(width, height);
        });
}

}   // namespace gnomon::raster
