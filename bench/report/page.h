// SPDX-License-Identifier: Apache-2.0
#pragma once
// Builds a page of measured results as one HTML file: sections of text, tables, charts and image comparisons, with the
// machine and the exact command below every figure, and the data attached. Scripts, style, images and data are embedded
// in the file.
//
// The page is built in memory and written atomically, so the file is complete or absent.

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
        std::vector<std::string> cells;   // one per column; the first is the row's header
        bool printed = false;             // values printed in a paper; shown in another colour
    };
    std::string caption;
    std::vector<std::string> columns;
    std::vector<Row> rows;
};

/// Two images of the same size with a slider, and an image of their difference.
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
    /// @param machine  one line that describes the machine
    ReportPage(std::string title, std::string machine);
    ~ReportPage();
    ReportPage(ReportPage&&) noexcept;

    /// Adds a list above all sections, such as what the page lacks. Nothing if it is empty.
    void notice(const std::string& title, const std::vector<std::string>& sentences);
    /// Adds a table above all sections. @param command  the command that measured it
    void lead(const ReportTable& table, const std::string& command);
    /// Begins a section, measured by `command`. A page of several sections begins with a list of them.
    void section(const std::string& title, const std::string& command);
    void text(const std::string& paragraph);
    void table(const ReportTable& table);
    void chart(const Chart& chart, const std::string& caption);
    void comparison(const ImageComparison& images);
    /// Adds small images side by side, or a single image over the width of the page.
    void gallery(const std::vector<NamedImage>& images, const std::string& caption);
    /// Adds data to download. @param name  the file name offered
    void attach(const std::string& name, const nlohmann::ordered_json& document);

    std::string html() const;

 private:
    std::string figure(const std::string& kind, const std::string& content, const std::string& caption,
                       const std::string& command) const;

    std::string title_, machine_, command_, lead_, body_;
    std::vector<std::string> sections_;
    int charts_ = 0, images_ = 0, attachments_ = 0;
};

/// The file `folder`/index.html, opened before the measurement and written after it.
class ReportFile {
 public:
    /// Creates the folder if necessary.
    /// @throws MissingError  the folder cannot be created or written
    explicit ReportFile(const std::filesystem::path& folder);
    /// Removes the folders that it created, unless write() was called.
    ~ReportFile();

    /// @throws MissingError
    void write(const ReportPage& page);
    const std::filesystem::path& path() const { return path_; }

 private:
    std::vector<std::filesystem::path> made_;   // folders created, outermost first
    std::filesystem::path path_;
    std::unique_ptr<io::AtomicFile> file_;
};

/// One line with processor, packet width and version. @param threads  number used by the bench
std::string machine_line(int threads);

/// Escapes text for HTML.
std::string html_text(std::string_view text);

}   // namespace gnomon::bench
