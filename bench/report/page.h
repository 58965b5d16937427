// SPDX-License-Identifier: Apache-2.0
#pragma once
// A page of measured results in one file: sections of text, tables, charts and compared images, with the machine and
// the exact command under every figure, and the numbers attached. It needs nothing but a browser: script, style,
// images and data are in it.
//
// The page is made in memory and written in one go: it is whole or not there.

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/image.h"
#include "bench/report/chart.h"

namespace gnomon::io {
class AtomicFile;
}

namespace gnomon::bench {

struct ReportTable {
    struct Row {
        std::vector<std::string> cells;   // as many as columns; the first is the row's head
        bool printed = false;             // values from a paper, not ours: set apart
    };
    std::string caption;
    std::vector<std::string> columns;
    std::vector<Row> rows;
};

/// Two images of one size under a slider, and where they differ.
struct ImageComparison {
    std::string caption;
    std::string left_name, right_name;
    Image8 left, right;
    Image8 difference;   // may be empty
};

struct NamedImage {
    std::string name;
    Image8 image;
};

class ReportPage {
 public:
    /// @param machine  what everything was measured on, in a line
    ReportPage(std::string title, std::string machine);
    ~ReportPage();
    ReportPage(ReportPage&&) noexcept;

    /// Stands above all sections, whenever it is called. @param command  what measured it
    void lead(const ReportTable& table, const std::string& command);
    /// What follows was measured by this command. A page of several sections lists them above the first.
    void section(const std::string& title, const std::string& command);
    void text(const std::string& paragraph);
    void table(const ReportTable& table);
    void chart(const Chart& chart, const std::string& caption);
    void comparison(const ImageComparison& images);
    /// Small images side by side.
    void gallery(const std::vector<NamedImage>& images, const std::string& caption);
    /// Data to download. @param name  of the file it becomes
    void attach(const std::string& name, const nlohmann::ordered_json& document);

    std::string html() const;

 private:
    std::string figure(const std::string& kind, const std::string& content, const std::string& caption,
                       const std::string& command) const;

    std::string title_, machine_, command_, lead_, body_;
    std::vector<std::string> sections_;
    int charts_ = 0, images_ = 0, attachments_ = 0;
};

/// `folder`/index.html, made sure of before the work and written after it.
class ReportFile {
 public:
    /// Makes the folder, if need be.
    /// @throws MissingError  the folder cannot be made or written
    explicit ReportFile(const std::filesystem::path& folder);
    /// Without write(), removes what it made.
    ~ReportFile();

    /// @throws MissingError
    void write(const ReportPage& page);
    const std::filesystem::path& path() const { return path_; }

 private:
    std::vector<std::filesystem::path> made_;   // folders, outermost first
    std::filesystem::path path_;
    std::unique_ptr<io::AtomicFile> file_;
};

/// Processor, packet width and version, in a line. @param threads  that the bench used
std::string machine_line(int threads);

/// Text as HTML shows it.
std::string html_text(std::string_view text);

}   // namespace gnomon::bench
