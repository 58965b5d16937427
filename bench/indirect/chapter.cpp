// SPDX-License-Identifier: Apache-2.0
// The chapter on Ki and Oh (2007): their Tables 1 to 3 and Figures 7 to 9 in the built-in Cornell box, with sparse
// receivers as in the paper and with receivers at all pixels, and Gnomon's default method there.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "api/scene_access.h"
#include "bench/indirect/printed.h"
#include "bench/indirect/quality.h"
#include "bench/indirect/report.h"
#include "bench/report/chapter.h"
#include "gnomon/scene.h"

namespace gnomon::bench {

namespace {

constexpr const char* k_scene = "builtin:cornell";
constexpr int k_headline_level = 6;

class IndirectChapter : public BenchChapter {
 public:
    explicit IndirectChapter(const BenchSettings& settings)
    {
        for (const bool full : {false, true}) {
            if (full && settings.quick) break;
            IndirectStudy study;
            study.scene = k_scene;
            IndirectBenchOptions& o = study.options;
            o.frames = {1, settings.quick ? 3 : 6};
            o.size = settings.size();
            o.threads = settings.threads;
            o.spp = settings.quick ? 256 : 4096;
            o.image_spp = settings.quick ? 64 : 512;
            o.judged = 2;
            o.images = true;
            IndirectSettings methods;
            methods.full = full;
            o.methods = indirect_methods_of_paper(methods);
            study.command = fmt::format(
                "gnomon bench indirect {} --frames {}-{} --size {}x{} --spp {} --judged {} --receivers {} --report out",
                k_scene, o.frames.first, o.frames.last, o.size.width, o.size.height, o.spp, o.judged,
                full ? "full" : "64");
            studies_.push_back(std::move(study));
        }
    }

    std::vector<BenchPart> parts() override
    {
        std::vector<BenchPart> parts;
        for (IndirectStudy& study : studies_) {
            const bool full = study.options.methods.front().settings.full;
            parts.push_back({fmt::format("indirect light: {}", full ? "receivers at every pixel" : "sparse receivers"),
                             full                  ? 100.
                             : studies_.size() > 1 ? 50.
                                                   : 6.,
                             [&study](const Progress& progress) {
                                 const Scene scene = load(study.scene);
                                 study.result = bench_indirect(api::scene_of(scene), study.options, progress);
                                 study.direct = direct_light(scene, study);
                             }});
        }
        return parts;
    }

    std::vector<ReportTable::Row> lead() const override
    {
        std::vector<ReportTable::Row> rows;
        for (const IndirectStudy& study : studies_) {
            const IndirectSettings settings = study.options.methods.front().settings;
            const auto& all = study.result.rows;
            const IndirectRow *tree = find_row(all, quadtree_name(k_headline_level), settings),
                              *visible = find_row(all, "visible", settings);
            const std::vector<Sampled> samples = sampled_rows(all, settings);
            if (!tree || !visible || samples.size() < 2 || !tree->nrmse_brute) continue;
            const SampledAt same = sampled_of_error(samples, *tree->nrmse_brute);
            const std::string of = settings.full ? "every pixel" : "64 receivers per side";
            rows.push_back(
                {{fmt::format("Indirect light, {}: speed-up over sampling of equal quality, buffers kept / not kept",
                              of),
                  fmt::format("{:.1f} / {:.1f}", k_printed_clusters_rates.kept / k_printed_same_quality.rates.kept,
                              k_printed_clusters_rates.not_kept / k_printed_same_quality.rates.not_kept),
                  fmt::format("{}{:.1f} / {:.1f}", same.beyond, same.at.kept / tree->cpu_ms_static,
                              same.at.not_kept / tree->cpu_ms_moving),
                  ""},
                 false});
            const auto error = [](const IndirectRow& r) {
                return fmt::format("{:.3f} in {:.1f} ms of CPU time", r.nrmse.value_or(0), r.cpu_ms_moving);
            };
            rows.push_back({{fmt::format("Indirect light, {}: error against a path-traced reference", of), "not given",
                             error(*tree), error(*visible)},
                            false});
        }
        return rows;
    }

    void write(ReportPage& page) const override
    {
        for (const IndirectStudy& study : studies_)
            if (!study.result.rows.empty()) add_indirect_section(page, study);
    }

    std::string name() const override { return "indirect"; }
    nlohmann::ordered_json json() const override
    {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const IndirectStudy& study : studies_) {
            if (study.result.rows.empty()) continue;
            list.push_back(indirect_json(study));
            list.back()["command"] = study.command;
        }
        return list;
    }

 private:
    std::vector<IndirectStudy> studies_;
};

}   // namespace

std::unique_ptr<BenchChapter> indirect_chapter(const BenchSettings& settings)
{
    return std::make_unique<IndirectChapter>(settings);
}

}   // namespace gnomon::bench
