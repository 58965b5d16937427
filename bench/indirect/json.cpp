// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "base/machine.h"
#include "bench/indirect/report.h"

namespace gnomon::bench {

namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json maybe(const std::optional<T>& value)
{
    return value ? Json(*value) : Json(nullptr);
}

Json row_json(const IndirectRow& r)
{
    return {{"method", r.method},
            {"title", r.title},
            {"on", r.vulkan ? "vulkan" : "cpu"},
            {"depth_threshold", r.settings.depth_threshold},
            {"normal_threshold", r.settings.normal_threshold},
            {"validity_margin", r.settings.margin},
            {"receivers", r.settings.full ? "full" : "64"},
            {"clusters", r.work.clusters},
            {"ms_cold", r.ms_cold},
            {"ms_static", r.ms_static},
            {"ms_not_kept", r.ms_not_kept},
            {"ms_moving", r.ms_moving},
            {"ms_repair", r.ms_repair},
            {"ms_rebuild", r.ms_rebuild},
            {"ms_moving_median", r.ms_moving_median},
            {"ms_moving_worst", r.ms_moving_worst},
            {"cpu_ms_cold", r.cpu_ms_cold},
            {"cpu_ms_static", r.cpu_ms_static},
            {"cpu_ms_not_kept", r.cpu_ms_not_kept},
            {"cpu_ms_moving", r.cpu_ms_moving},
            {"cpu_ms_repair", r.cpu_ms_repair},
            {"cpu_ms_rebuild", r.cpu_ms_rebuild},
            {"dirty_pixels", r.work.dirty_pixels},
            {"dirty_nodes", r.work.dirty_nodes},
            {"nrmse", maybe(r.nrmse)},
            {"nrmse_by_frame", r.nrmse_by_frame},
            {"local_means",
             {{"blocks", r.local_means.blocks},
              {"off", r.local_means.off},
              {"surely_off", r.local_means.surely_off},
              {"least", r.local_means.least},
              {"greatest", r.local_means.greatest}}},
            {"nrmse_brute", maybe(r.nrmse_brute)},
            {"energy_ratio", maybe(r.energy_ratio)},
            {"flicker", maybe(r.flicker)},
            {"flicker_floor", maybe(r.flicker_floor)},
            {"view_change_mean", r.view_change ? Json(r.view_change->mean) : Json(nullptr)},
            {"view_change_largest", r.view_change ? Json(r.view_change->largest) : Json(nullptr)},
            {"rays", r.work.rays},
            {"rays_cold", r.rays_cold},
            {"rays_left_out", r.work.rays_left_out},
            {"bytes", r.work.bytes}};
}

}   // namespace

Json indirect_json(const IndirectStudy& study)
{
    const IndirectBenchOptions& options = study.options;
    const IndirectBenchResult& result = study.result;
    Json rows = Json::array();
    for (const IndirectRow& row : result.rows) rows.push_back(row_json(row));
    Json document = {{"device", study.device.empty() ? gnomon::processor_name() : study.device},
                     {"processor", gnomon::processor_name()},
                     {"threads", options.threads > 0 ? options.threads : gnomon::processor_threads()},
                     {"scene", study.scene},
                     {"width", options.size.width},
                     {"height", options.size.height},
                     {"frames", {options.frames.first, options.frames.last}},
                     {"judged_frames", result.judged},
                     {"spp", options.spp},
                     {"points", result.points},
                     {"mean_irradiance", result.mean_irradiance},
                     {"reference_noise", result.mean_irradiance > 0 ? Json(result.reference_noise) : Json(nullptr)},
                     {"rows", std::move(rows)}};
    for (const DeviceFramesResult& of : study.device_frames) {
        Json frames = Json::array();
        for (const DeviceFramesRow& r : of.rows)
            frames.push_back({{"method", r.method},
                              {"depth_threshold", r.depth_threshold},
                              {"normal_threshold", r.normal_threshold},
                              {"clusters", r.lights},
                              {"ms_kept", r.ms_kept},
                              {"ms_not_kept", r.ms_not_kept},
                              {"kept", r.kept},
                              {"made", r.made},
                              {"different_from_quadtree", r.different_from_quadtree}});
        document["device_frames"].push_back({{"device", of.device},
                                             {"clock", of.clock},
                                             {"receivers", of.full ? "full" : "64"},
                                             {"rows", std::move(frames)}});
    }
    if (study.large)
        document["large_gather"] = {{"width", study.large->size.width},
                                    {"height", study.large->size.height},
                                    {"clusters", study.large->clusters},
                                    {"ms", study.large->ms}};
    return document;
}

}   // namespace gnomon::bench
