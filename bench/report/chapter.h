// SPDX-License-Identifier: Apache-2.0
#pragma once
// bench all: one chapter a paper, and one for the whole frame. A chapter measures part by part, then writes its
// sections.
//
// A bench that is new here brings a class that derives from BenchChapter, and a line in subcommand_bench_all.cpp.

#include <nlohmann/json_fwd.hpp>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/report/page.h"
#include "gnomon/types.h"

namespace gnomon::bench {

/// Scenes of the papers where they are, else what stands in for them.
struct BenchScenes {
    std::string kitchen, robots;   // empty: not there
    std::string stand_in;          // a built-in scene; used where the ones above are not there
};

/// Looks below the folder that GNOMON_SCENES names, else ../shared/scenes.
BenchScenes find_bench_scenes();

struct BenchSettings {
    bool quick = false;    // smaller images, fewer frames: a look, not a measurement
    int threads = 1;       // the most of a machine that is used
    std::string command;   // the whole command line
    BenchScenes scenes;
    Size size() const { return quick ? Size{256, 256} : Size{512, 512}; }
};

struct BenchPart {
    std::string name;
    double weight = 1;   // of the whole time
    /// @throws InterruptedError; MissingError if the machine lacks what it needs: the page then says so instead
    std::function<void(const Progress&)> measure;
};

class BenchChapter {
 public:
    virtual ~BenchChapter() = default;
    /// In the order in which they are called. They refer to this chapter.
    virtual std::vector<BenchPart> parts() = 0;
    /// Rows of the table at the head of the page: what, printed, as published here, Gnomon's own.
    virtual std::vector<ReportTable::Row> lead() const = 0;
    virtual void write(ReportPage& page) const = 0;
    /// Its key in the document, and all that was measured.
    virtual std::string name() const = 0;
    virtual nlohmann::ordered_json json() const = 0;
};

std::unique_ptr<BenchChapter> culling_chapter(const BenchSettings& settings);
std::unique_ptr<BenchChapter> shadow_textures_chapter(const BenchSettings& settings);
std::unique_ptr<BenchChapter> indirect_chapter(const BenchSettings& settings);
std::unique_ptr<BenchChapter> frame_chapter(const BenchSettings& settings);

}   // namespace gnomon::bench
