// SPDX-License-Identifier: Apache-2.0
#include "bench/report/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/machine.h"
#include "bench/report/assets.h"
#include "gnomon/error.h"
#include "gnomon/version.h"
#include "io/file/atomic_file.h"
#include "io/image/image_file.h"
#include "ray/ray_scene.h"

namespace gnomon::bench {

namespace {
using Json = nlohmann::ordered_json;

std::string base64(const std::vector<std::uint8_t>& bytes)
{
    static constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t left = bytes.size() - i;
        const std::uint32_t three = std::uint32_t{bytes[i]} << 16 | (left > 1 ? std::uint32_t{bytes[i + 1]} << 8 : 0) |
                                    (left > 2 ? bytes[i + 2] : 0);
        text += letters[three >> 18];
        text += letters[three >> 12 & 63];
        text += left > 1 ? letters[three >> 6 & 63] : '=';
        text += left > 2 ? letters[three & 63] : '=';
    }
    return text;
}

// JSON for a script element, escaped so that nothing in it can end the element.
std::string script_json(const Json& json, int indent = -1)
{
    std::string safe;
    for (const char c : json.dump(indent, ' ', false, Json::error_handler_t::replace))
        c == '<' ? safe += "\\u003c" : safe += c;
    return safe;
}

std::string image_tag(const Image8& image, const std::string& kind, const std::string& name)
{
    return fmt::format("<img class=\"{}\" alt=\"{}\" src=\"data:image/png;base64,{}\">\n", kind, html_text(name),
                       base64(io::encode_png(image)));
}
}   // namespace

std::string html_text(std::string_view text)
{
    std::string safe;
    for (const char c : text) {
        switch (c) {
            case '&':
                safe += "&amp;";
                break;
            case '<':
                safe += "&lt;";
                break;
            case '>':
                safe += "&gt;";
                break;
            case '"':
                safe += "&quot;";
                break;
            default:
                safe += c;
        }
    }
    return safe;
}

std::string machine_line(int threads)
{
    return fmt::format("{}, {} of {} threads, packets of {}, gnomon {}", gnomon::processor_name(), threads,
                       processor_threads(), ray::RayScene::packet_width(), version());
}

ReportPage::ReportPage(std::string title, std::string machine) : title_(std::move(title)), machine_(std::move(machine))
{
}

ReportPage::~ReportPage() = default;
ReportPage::ReportPage(ReportPage&&) noexcept = default;

void ReportPage::section(const std::string& title, const std::string& command)
{
    if (!sections_.empty()) body_ += "</section>\n";
    sections_.push_back(title);
    command_ = command;
    body_ += fmt::format("<section id=\"section-{}\">\n<h2>{}</h2>\n", sections_.size(), html_text(title));
}

void ReportPage::text(const std::string& paragraph)
{
    body_ += fmt::format("<p>{}</p>\n", html_text(paragraph));
}

std::string ReportPage::figure(const std::string& kind, const std::string& content, const std::string& caption,
                               const std::string& command) const
{
    return fmt::format(
        "<figure class=\"{}\">\n{}<figcaption>{}\n<span class=\"origin\">{}<br><code>{}</code></span></figcaption>\n"
        "</figure>\n",
        kind, content, html_text(caption), html_text(machine_), html_text(command));
}

static std::string table_html(const ReportTable& table)
{
    std::string rows = "<table>\n<thead><tr>";
    for (const std::string& column : table.columns) rows += fmt::format("<th scope=\"col\">{}</th>", html_text(column));
    rows += "</tr></thead>\n<tbody>\n";
    for (const ReportTable::Row& row : table.rows) {
        GNOMON_CHECK_EQ(row.cells.size(), table.columns.size());
        rows += row.printed ? "<tr class=\"printed\">" : "<tr>";
        for (std::size_t i = 0; i < row.cells.size(); ++i) {
            const std::string cell = html_text(row.cells[i]);
            rows += i == 0 ? fmt::format("<th scope=\"row\">{}</th>", cell) : fmt::format("<td>{}</td>", cell);
        }
        rows += "</tr>\n";
    }
    return rows + "</tbody>\n</table>\n";
}

void ReportPage::notice(const std::string& title, const std::vector<std::string>& sentences)
{
    if (sentences.empty()) return;
    lead_ += fmt::format("<div class=\"notice\">\n<p>{}</p>\n<ul>\n", html_text(title));
    for (const std::string& sentence : sentences)
        lead_ += fmt::format("<li class=\"lacking\">{}</li>\n", html_text(sentence));
    lead_ += "</ul>\n</div>\n";
}

void ReportPage::lead(const ReportTable& table, const std::string& command)
{
    lead_ += figure("table", table_html(table), table.caption, command);
}

void ReportPage::table(const ReportTable& table)
{
    body_ += figure("table", table_html(table), table.caption, command_);
}

void ReportPage::chart(const Chart& chart, const std::string& caption)
{
    const int number = charts_++;
    body_ += figure(
        "chart",
        fmt::format("<div class=\"canvas\"><canvas id=\"chart-{0}\" role=\"img\" aria-label=\"{1}\"></canvas></div>\n"
                    "<script type=\"application/json\" class=\"chart-data\" data-canvas=\"chart-{0}\">{2}</script>\n",
                    number, html_text(chart.title), script_json(chart_js(chart))),
        caption, command_);
}

void ReportPage::comparison(const ImageComparison& images)
{
    GNOMON_CHECK(images.left.width == images.right.width && images.left.height == images.right.height);
    const int number = images_++;
    std::string content = fmt::format("<div class=\"compare\" id=\"compare-{}\" style=\"aspect-ratio: {} / {}\">\n",
                                      number, images.left.width, images.left.height);
    content += image_tag(images.right, "right", images.right_name);
    content += image_tag(images.left, "left", images.left_name);
    if (!images.difference.empty()) content += image_tag(images.difference, "difference", "Difference");
    content += fmt::format("<span class=\"tag tag-left\">{}</span><span class=\"tag tag-right\">{}</span>\n",
                           html_text(images.left_name), html_text(images.right_name));
    content += "<div class=\"handle\"></div>\n</div>\n<div class=\"controls\">";
    content += fmt::format(
        "<input type=\"range\" min=\"0\" max=\"100\" value=\"50\" step=\"0.5\" aria-label=\"{} against {}\">",
        html_text(images.left_name), html_text(images.right_name));
    if (!images.difference.empty())
        content += "<label><input type=\"checkbox\" class=\"show-difference\"> difference</label>";
    body_ += figure("images", content + "</div>\n", images.caption, command_);
}

void ReportPage::gallery(const std::vector<NamedImage>& images, const std::string& caption)
{
    std::string content = "<div class=\"row\">\n";
    for (const NamedImage& one : images)
        content +=
            fmt::format("<div>{}<span>{}</span></div>\n", image_tag(one.image, "small", one.name), html_text(one.name));
    body_ += figure(images.size() == 1 ? "gallery single" : "gallery", content + "</div>\n", caption, command_);
}

void ReportPage::attach(const std::string& name, const Json& document)
{
    const int number = attachments_++;
    body_ += fmt::format(
        "<p class=\"download\"><a id=\"download-{0}\" download=\"{1}\" href=\"#\">{1}</a></p>\n"
        "<script type=\"application/json\" class=\"attachment\" data-link=\"download-{0}\">\n{2}\n</script>\n",
        number, html_text(name), script_json(document, 1));
}

std::string ReportPage::html() const
{
    std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
    page += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
    // Give an empty icon, so that the browser requests none.
    page += "<link rel=\"icon\" href=\"data:,\">\n";
    page += fmt::format("<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n", html_text(title_), k_page_css);
    page += fmt::format("<h1>{}</h1>\n<p class=\"machine\">{}</p>\n", html_text(title_), html_text(machine_));
    page += lead_;
    if (sections_.size() > 1) {
        page += "<nav>\n<ol>\n";
        for (std::size_t i = 0; i < sections_.size(); ++i)
            page += fmt::format("<li><a href=\"#section-{}\">{}</a></li>\n", i + 1, html_text(sections_[i]));
        page += "</ol>\n</nav>\n";
    }
    page += body_;
    if (!sections_.empty()) page += "</section>\n";
    page += fmt::format("<script>\n{}</script>\n<script>\n{}</script>\n</body>\n</html>\n", k_chart_js, k_page_js);
    return page;
}

ReportFile::ReportFile(const std::filesystem::path& folder) : path_(folder / "index.html")
{
    // Create the missing folders; remove them again if anything fails.
    namespace fs = std::filesystem;
    std::error_code error;
    std::vector<fs::path> missing;
    for (fs::path at = fs::absolute(folder).lexically_normal(); !at.empty() && !fs::exists(at, error);
         at = at.parent_path())
        missing.push_back(at);
    const auto undo = [&] {
        std::for_each(made_.rbegin(), made_.rend(), [&](const fs::path& at) { fs::remove(at, error); });
    };
    std::reverse(missing.begin(), missing.end());
    for (const fs::path& at : missing) {
        if (fs::create_directory(at, error)) made_.push_back(at);
        if (!error) continue;
        const std::string why = error.message();
        undo();
        throw MissingError(fmt::format("cannot create the folder {}: {}", folder.string(), why));
    }
    try {
        file_ = std::make_unique<io::AtomicFile>(path_);
    } catch (...) {
        undo();
        throw;
    }
}

ReportFile::~ReportFile()
{
    const bool written = !file_;
    file_.reset();
    std::error_code ignored;
    // Remove only empty folders, because another program may have written to them.
    for (auto at = made_.rbegin(); !written && at != made_.rend(); ++at) std::filesystem::remove(*at, ignored);
}

void ReportFile::write(const ReportPage& page)
{
    file_->write(page.html());
    file_->commit();
    file_.reset();
}

}   // namespace gnomon::bench
