// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "bench/shadow_textures/report.h"
#include "options/enum_names.h"

namespace gnomon::bench {

nlohmann::ordered_json shadow_textures_json(const ShadowTexturesBenchOptions& options,
                                            const ShadowTexturesBenchResult& result)
{
    nlohmann::ordered_json rows = nlohmann::ordered_json::array(), exponents = nlohmann::ordered_json::object();
    for (const ShadowTexturesRow& row : result.rows)
        rows.push_back({{"objects", row.objects},
                        {"dynamic_percent", row.dynamic_percent},
                        {"movers", row.dynamic_objects},
                        {"method", name_of(row)},
                        {"shadow_ms", row.shadow_ms},
                        {"buffers_ms", row.buffers_ms},
                        {"textures_ms", row.textures_ms},
                        {"shadow_cpu_ms", row.shadow_cpu_ms},
                        {"frame_ms", row.frame_ms},
                        {"draws", row.draws},
                        {"copies", row.copies},
                        {"textures_updated", row.textures_updated},
                        {"touched", row.touched},
                        {"draws_of_all_between", row.draws_of_all_between},
                        {"printed_wrong_percent", row.printed_wrong_percent},
                        {"identical_to_full", row.identical_to_full}});
    for (const auto& [method, exponent] : result.exponents) exponents[std::string(options::name_of(method))] = exponent;
    return {{"device", result.device},
            {"clock", result.clock},
            {"as_printed", options.as_printed},
            {"vertices", options.vertices},
            {"size", {options.size.width, options.size.height}},
            {"view_size", options.view_size},
            {"frames", options.frames},
            {"rows", std::move(rows)},
            {"exponents", std::move(exponents)}};
}

}   // namespace gnomon::bench
