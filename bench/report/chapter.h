// SPDX-License-Identifier: Apache-2.0
#pragma once
// The chapters of bench all: one per paper and one for the whole frame. A chapter measures in several parts, then
// writes its sections of the page.
//
// To add a chapter, derive a class from BenchChapter and add it in subcommand_bench_all.cpp.

#include <nlohmann/json_fwd.hpp>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/report/page.h"
#include "gnomon/types.h"

namespace gnomon::bench {

/// The scenes of the papers, where available, and a substitute for them.
struct BenchScenes {
    std::string kitchen, robots;   // files; empty if not found
    std::string stand_in;          // a built-in scene, used where those above are not found
    std::string buddha, sponza;    // of the light quad-tree; their figures are left out where they are not found
    std::string folder;            // that was searched
};

/// Searches a folder: `folder`, or if it is empty the one given by GNOMON_SCENES, by default ../shared/scenes.
BenchScenes find_bench_scenes(const std::string& folder = {});

/// What a page lacks because a scene was not found: a sentence for each.
std::vector<std::string> missing_scenes(const BenchScenes& scenes);

struct BenchSettings {
    bool quick = false;    // smaller images and fewer frames, for a first impression
    int threads = 1;       // largest number of threads used
    std::string command;   // the whole command line
    BenchScenes scenes;
    Size size() const { return quick ? Size{256, 256} : Size{512, 512}; }
};

struct BenchPart {
    std::string name;
    double weight = 1;   // expected time, relative to the other parts
    /// @throws InterruptedError; MissingError if the machine lacks something, which the page then reports
    std::function<void(const Progress&)> measure;
};

class BenchChapter {
 public:
    virtual ~BenchChapter() = default;
    /// The parts in the order in which they are measured. They hold references to this chapter.
    virtual std::vector<BenchPart> parts() = 0;
    /// Rows of the table at the top of the page: the quantity, its value printed in the paper, measured here with the
    /// published method, and with Gnomon's method.
    virtual std::vector<ReportTable::Row> lead() const = 0;
    /// What the chapter leaves out that the paper has, although the scenes are there: a sentence for each.
    virtual std::vector<std::string> left_out() const { return {}; }
    virtual void write(ReportPage& page) const = 0;
    /// The chapter's key in the JSON document, and everything measured.
    virtual std::string name() const = 0;
    virtual nlohmann::ordered_json json() const = 0;
};

std::unique_ptr<BenchChapter> culling_chapter(const BenchSettings& settings);
std::unique_ptr<BenchChapter> shadow_textures_chapter(const BenchSettings& settings);
std::unique_ptr<BenchChapter> indirect_chapter(const BenchSettings& settings);
std::unique_ptr<BenchChapter> frame_chapter(const BenchSettings& settings);

}   // namespace gnomon::bench
