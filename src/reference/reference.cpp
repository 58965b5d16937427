// SPDX-License-Identifier: Apache-2.0
#include "reference/reference.h"

#include <atomic>

#include "base/check.h"
#include "base/interruption.h"

namespace gnomon::reference {

namespace {
constexpr std::size_t k_paths_of_task = 4096;   // paths of one task, about
}   // namespace

IrradiancePoint irradiance_point(const shading::SurfacePoint& s, const glm::vec3& smooth_origin, std::uint64_t key)
{
    return {s.position, s.geometric_normal, s.normal, s.offset, key, s.smooth_normal, smooth_origin};
}

IrradiancePoint irradiance_point(const scene::Scene& scene, const ray::RayScene& rays, scene::ObjectId object,
                                 std::uint32_t triangle, float u, float v, const glm::vec3& to_viewer,
                                 std::uint64_t key)
{
    shading::SurfacePoint surface;
    shading::surface_at(scene, rays.geometry(object), triangle, u, v, 0, -to_viewer, {}, surface);
    return irradiance_point(surface, shading::smooth_origin(rays.geometry(object), triangle, u, v, surface), key);
}

ReferenceLight::ReferenceLight(const scene::SceneState& state, const ray::RayScene& rays,
                               const ReferenceOptions& options)
    : state_(state), rays_(rays), options_(options), background_(state.scene().background)
{
    GNOMON_CHECK(options.samples >= 1 && options.bounces >= 0);
    const scene::Scene& scene = state.scene();
    for (const scene::Material& material : scene.materials)
        transparent_ = transparent_ || material.surface_class() == scene::SurfaceClass::transparent;
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const scene::Light& light = scene.lights[l];
        const auto id = static_cast<scene::LightId>(l);
        if (state.light(id).visible && light.color != glm::vec3(0) && uses(light)) lights_.push_back(id);
    }
    choice_ = std::make_unique<LightChoice>(state, lights_);
    if (options.shining) {
        emitters_ = std::make_unique<EmitterSampler>(state, rays);
        if (emitters_->empty()) emitters_.reset();
    }
    if (options.bounces > 0 && !transparent_ && !rays.thins_light()) {
        emission_ = std::make_unique<LightEmission>(state, rays, lights_);
        if (emission_->empty()) emission_.reset();
    }
    if (!options.surroundings) return;

    background_.sun_radiance = glm::vec3(0);
    using Kind = scene::Background::Kind;
    background_shines_ = background_.kind != Kind::color || background_.color != glm::vec3(0);
    if (background_.kind == Kind::image) {
        environment_ = std::make_unique<EnvironmentSampler>(*background_.environment);
        if (environment_->empty()) environment_.reset(), background_shines_ = false;
    }
}

std::vector<IrradianceEstimate> reference_irradiance(const scene::SceneState& state, const ray::RayScene& rays,
                                                     std::span<const IrradiancePoint> points,
                                                     const ReferenceOptions& options, Tasks& tasks,
                                                     ReferenceCounters* counters, const Progress& progress)
{
    Interruption interruption(progress);
    const InterruptionScope scope(progress ? &interruption : Interruption::current());
    const ReferenceLight light(state, rays, options);
    std::vector<IrradianceEstimate> result(points.size());
    std::vector<std::unique_ptr<ReferencePaths>> workers(static_cast<std::size_t>(tasks.threads()));
    const std::size_t block = 1 + (k_paths_of_task - 1) / static_cast<std::size_t>(options.samples);
    const std::size_t blocks = (points.size() + block - 1) / block;

    std::atomic<std::size_t> done = 0;
    tasks.for_each(blocks, [&](std::size_t index, int worker) {
        auto& paths = workers[static_cast<std::size_t>(worker)];
        if (!paths) paths = std::make_unique<ReferencePaths>(light);
        std::vector<ReferencePaths::Request> requests;
        const std::size_t begin = index * block, end = std::min(points.size(), begin + block);
        for (std::size_t i = begin; i < end; ++i) requests.push_back({points[i], options.samples});
        paths->estimate(requests, result.data() + begin);
        report_progress("reference", static_cast<double>(++done) / static_cast<double>(blocks));
    });
    for (const auto& paths : workers)
        if (counters && paths) counters->paths += paths->counters().paths, counters->rays += paths->counters().rays;
    return result;
}

}   // namespace gnomon::reference
