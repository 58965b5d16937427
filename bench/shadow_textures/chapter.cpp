// SPDX-License-Identifier: Apache-2.0
// The chapter on Oh and Shin (2004): their Figures 7 and 8, and a few dynamic objects among a growing number of static
// ones.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/report/chapter.h"
#include "bench/shadow_textures/report.h"
#include "options/enum_names.h"

namespace gnomon::bench {

namespace {

constexpr double k_shown_percent = 10;   // of dynamic objects, for which the paper prints a number

struct Experiment {
    std::string name;
    ShadowTexturesBenchOptions options;
    double weight = 1;
    ShadowTexturesBenchResult result{};
    std::string command() const
    {
        std::string command = "gnomon bench shadow-textures --objects";
        for (const int objects : options.objects) command += fmt::format(" {}", objects);
        if (options.dynamic_objects) {
            command += fmt::format(" --movers {}", *options.dynamic_objects);
        } else {
            command += " --dynamic";
            for (const double percent : options.dynamic) command += fmt::format(" {}", percent);
        }
        command += fmt::format(" --vertices {} --size {}x{} --frames {} --method", options.vertices, options.size.width,
                               options.size.height, options.frames);
        for (const ShadowTextures method : options.methods) command += fmt::format(" {}", options::name_of(method));
        return command;
    }
};

class ShadowTexturesChapter : public BenchChapter {
 public:
    explicit ShadowTexturesChapter(const BenchSettings& settings)
    {
        using enum ShadowTextures;
        const bool quick = settings.quick;
        // A quick run has fewer vertices, because a software driver draws only a few million triangles per second.
        ShadowTexturesBenchOptions growth;
        growth.objects = quick ? std::vector<int>{25, 50, 100} : std::vector<int>{25, 50, 100, 200, 300};
        if (quick) growth.vertices = 200;
        growth.frames = 1;
        growth.images = true;
        growth.size = settings.size();
        growth.methods = {per_caster, depth, coherent, items};
        experiments_.push_back({"shadow textures: Figure 7", growth, quick ? 6. : 60.});

        ShadowTexturesBenchOptions percents;
        percents.objects = {quick ? 100 : 300};
        percents.dynamic = quick ? std::vector<double>{0, 10, 100} : std::vector<double>{0, 10, 25, 50, 75, 100};
        percents.vertices = quick ? 500 : 2037;
        percents.frames = 3;
        percents.size = settings.size();
        experiments_.push_back({"shadow textures: Figure 8", percents, quick ? 8. : 70.});

        ShadowTexturesBenchOptions crowd;
        crowd.objects = quick ? std::vector<int>{110, 1010} : std::vector<int>{110, 1010, 10010, 100010};
        crowd.dynamic_objects = 10;
        crowd.frames = quick ? 5 : 15;
        crowd.size = {16, 16};   // of the image, which is not measured here
        crowd.methods = {coherent, items};
        experiments_.push_back({"shadow textures: a crowd", crowd, quick ? 3. : 50.});
    }

    std::vector<BenchPart> parts() override
    {
        std::vector<BenchPart> parts;
        for (Experiment& e : experiments_)
            parts.push_back({e.name, e.weight, [&e](const Progress& progress) {
                                 e.result = bench_shadow_textures(e.options, progress);
                             }});
        return parts;
    }

    std::vector<ReportTable::Row> lead() const override
    {
        std::vector<ReportTable::Row> rows;
        const Experiment& growth = experiments_[0];
        if (growth.result.exponents.size() == growth.options.methods.size())
            rows.push_back({{"Shadow textures: growth of the shadow pass, as a power of the number of objects",
                             "2 per caster, 1 with one depth buffer",
                             fmt::format("{:.2f} per caster with extents, {:.2f} with one depth buffer",
                                         growth.result.exponents[0].second, growth.result.exponents[1].second),
                             ""},
                            false});
        const ShadowTexturesRow *depth = at_shown_percent(ShadowTextures::depth),
                                *coherent = at_shown_percent(ShadowTextures::coherent),
                                *items = at_shown_percent(ShadowTextures::items);
        if (!depth || !coherent || !items) return rows;
        const auto saved = [&](const ShadowTexturesRow* row) {
            return fmt::format("{:.1f} %", 100 * (1 - row->frame_ms / depth->frame_ms));
        };
        const auto times = [&](const ShadowTexturesRow* row) {
            return fmt::format("{:.1f} x", depth->shadow_ms / row->shadow_ms);
        };
        rows.push_back({{"Shadow textures, 10 % dynamic objects: time of the whole frame saved by coherence", "23.4 %",
                         saved(coherent), saved(items)},
                        false});
        rows.push_back({{"Shadow textures, 10 % dynamic objects: speed-up of the shadow pass by coherence", "not given",
                         times(coherent), times(items)},
                        false});
        return rows;
    }

    void write(ReportPage& page) const override
    {
        for (const Experiment& e : experiments_)
            if (!e.result.rows.empty())
                add_shadow_textures_section(page, e.command(), e.options, e.result,
                                            shadow_textures_json(e.options, e.result));
    }

    std::string name() const override { return "shadow_textures"; }
    nlohmann::ordered_json json() const override
    {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const Experiment& e : experiments_) {
            if (e.result.rows.empty()) continue;
            list.push_back(shadow_textures_json(e.options, e.result));
            list.back()["command"] = e.command();
        }
        return list;
    }

 private:
    const ShadowTexturesRow* at_shown_percent(ShadowTextures method) const
    {
        for (const ShadowTexturesRow& row : experiments_[1].result.rows)
            if (row.method == method && row.dynamic_percent == k_shown_percent) return &row;
        return nullptr;
    }

    std::vector<Experiment> experiments_;
};

}   // namespace

std::unique_ptr<BenchChapter> shadow_textures_chapter(const BenchSettings& settings)
{
    return std::make_unique<ShadowTexturesChapter>(settings);
}

}   // namespace gnomon::bench
