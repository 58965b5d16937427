// SPDX-License-Identifier: Apache-2.0
#include "frame/state_overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "image/bitmap_font.h"
#include "scene/emission.h"

namespace gnomon::frame {

namespace {
constexpr std::uint8_t k_paper_tone = 24, k_ink = 210;   // grey levels of the border and of its text
constexpr int k_small_image = 900;                       // pixels of width; narrower images get small letters
constexpr int k_gap = 4;

// Colours that do not need red and green to be distinguished [Okabe and Ito 2008].
constexpr Rgb8 k_colors[trace::k_state_marks] = {
    {12, 12, 14},      // background
    {58, 58, 62},      // away
    {0, 158, 115},     // moving
    {168, 168, 168},   // unknown
    {240, 228, 66},    // none
    {0, 114, 178},     // full
    {213, 94, 0},      // partial
    {86, 180, 233},    // penumbra
};
constexpr Rgb8 k_untrusted_grey{112, 112, 112};
constexpr float k_untrusted_weight = 0.6f;   // weight of the grey that is mixed in

struct Entry {
    Rgb8 color;
    std::string text;
};

int line_height(int dot)
{
    return dot * (image::k_glyph_height + 4);
}

int columns_of(std::size_t panels)
{
    return std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(panels)))));
}

int rows_of(std::size_t panels)
{
    const int columns = columns_of(panels);
    return (static_cast<int>(panels) + columns - 1) / columns;
}

int cell_width(Size panel)
{
    return panel.width + k_gap;
}

int inner_width(Size panel, std::size_t panels)
{
    return columns_of(panels) * cell_width(panel) - k_gap;
}

// Returns the size in pixels of one dot of the letters.
int dot_of(Size panel, std::size_t panels)
{
    return inner_width(panel, panels) < k_small_image ? 1 : 2;
}

int cell_height(Size panel, std::size_t panels)
{
    return panel.height + line_height(dot_of(panel, panels)) + k_gap;
}

Rgb8 mix(const Rgb8& a, const Rgb8& b, float share_of_b)
{
    Rgb8 result;
    for (std::size_t c = 0; c < 3; ++c)
        result[c] = static_cast<std::uint8_t>(
            std::lround(static_cast<float>(a[c]) * (1 - share_of_b) + static_cast<float>(b[c]) * share_of_b));
    return result;
}

// Counts of cells by mark, with and without trust, and of wrong ones, over all panels.
struct Sums {
    std::size_t trusted[trace::k_state_marks] = {}, untrusted[trace::k_state_marks] = {}, wrong = 0, wrong_behind = 0;
    std::size_t asked = 0;   // cells where the light could reach the surface
};

Sums sums_of(const trace::StateMap& map)
{
    Sums sums;
    for (const std::uint8_t byte : map.cells) {
        const trace::StateCell cell = trace::StateCell::of(byte);
        ++(cell.untrusted ? sums.untrusted : sums.trusted)[static_cast<std::size_t>(cell.mark)];
        sums.asked += cell.mark != trace::StateMark::background && cell.mark != trace::StateMark::away;
        sums.wrong += cell.wrong;
        sums.wrong_behind += cell.wrong_behind && !cell.wrong;
    }
    return sums;
}

// Pads every number to the same width, so that the legend of a video does not move.
std::vector<Entry> legend_of(const Sums& sums, const OverlayKind& kind)
{
    const bool paper = kind.paper;
    const auto share = [&](std::size_t count) {
        return sums.asked == 0 ? 0.0 : 100.0 * static_cast<double>(count) / static_cast<double>(sums.asked);
    };
    std::vector<Entry> entries;
    const auto add = [&](trace::StateMark mark, const char* name) {
        const auto m = static_cast<std::size_t>(mark);
        entries.push_back({k_colors[m], fmt::format("{:3.0f}% {}", share(sums.trusted[m]), name)});
    };
    add(trace::StateMark::none,
        paper ? "NON_SHADOW: only dynamic objects are asked" : "NONE: only dynamic objects are asked");
    add(trace::StateMark::full, paper ? "FULL_SHADOW: no ray" : "FULL: no ray");
    add(trace::StateMark::partial, paper ? "PARTIAL_SHADOW: traced" : "PARTIAL: traced");
    if (kind.sized) add(trace::StateMark::penumbra, "PENUMBRA: remembered triangles are asked");
    add(trace::StateMark::unknown, paper ? "INIT: traced" : "UNKNOWN: traced");
    if (paper) {
        std::size_t all = 0;
        for (const std::size_t count : sums.untrusted) all += count;
        const Rgb8 example = cell_color({trace::StateMark::none, true, false, false}, 255);
        entries.push_back({example, fmt::format("{:3.0f}% pale: not seen whole, traced", share(all))});
    }
    add(trace::StateMark::moving, "moving: traced");
    entries.push_back({k_colors[static_cast<std::size_t>(trace::StateMark::away)], "light behind or dark"});
    entries.push_back({k_wrong_color, fmt::format("wrong: {:<6}", sums.wrong)});
    entries.push_back({k_wrong_behind_color, fmt::format("wrong in mirrors, glass: {:<6}", sums.wrong_behind)});
    return entries;
}

// Lays out entries from left to right, in as many lines as they need.
struct Line {
    std::vector<std::size_t> entries;
};
int swatch(int dot)
{
    return dot * (image::k_glyph_height + 2);
}
int entry_width(const Entry& entry, int dot)
{
    return swatch(dot) + 4 * dot + image::text_width(entry.text, dot) + 12 * dot;
}
std::vector<Line> lines_of(const std::vector<Entry>& entries, int width, int dot)
{
    std::vector<Line> lines(1);
    int used = 0;
    for (std::size_t e = 0; e < entries.size(); ++e) {
        const int needed = entry_width(entries[e], dot);
        if (used > 0 && used + needed > width) {
            lines.emplace_back();
            used = 0;
        }
        lines.back().entries.push_back(e);
        used += needed;
    }
    return lines;
}
}   // namespace

Rgb8 state_color(trace::StateMark mark)
{
    GNOMON_CHECK_LT(static_cast<int>(mark), trace::k_state_marks);   // a byte has room for one more
    return k_colors[static_cast<std::size_t>(mark)];
}

Rgb8 cell_color(const trace::StateCell& cell, std::uint8_t shade)
{
    if (cell.wrong) return k_wrong_color;
    if (cell.wrong_behind) return k_wrong_behind_color;
    Rgb8 color = state_color(cell.mark);
    if (cell.mark == trace::StateMark::background) return color;
    if (cell.untrusted) color = mix(color, k_untrusted_grey, k_untrusted_weight);
    constexpr float k_grazing = 0.55f;   // of a colour where the surface is seen edge-on
    return mix({0, 0, 0}, color, k_grazing + (1 - k_grazing) * static_cast<float>(shade) / 255.0f);
}

SizedPanels sized_panels(const scene::Scene& scene)
{
    SizedPanels panels;
    panels.of_object.assign(scene.objects.size(), -1);
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) {
        const std::vector<scene::MeshPart>& parts = scene.meshes[scene.objects[o].mesh].parts;
        const auto emits = [&](const scene::MeshPart& part) { return may_emit(scene.materials[part.material]); };
        if (scene.objects[o].removed || std::none_of(parts.begin(), parts.end(), emits)) continue;
        panels.of_object[o] = static_cast<int>(panels.titles.size());
        const std::string& name = scene.nodes[scene.objects[o].node].name;
        panels.titles.push_back(
            fmt::format("light with size {}{}{}", panels.titles.size(), name.empty() ? "" : ": ", name));
    }
    if (panels.titles.size() <= SizedPanels::k_most_sized) return panels;
    for (int& panel : panels.of_object) panel = std::min(panel, 0);
    panels.titles = {fmt::format("all {} lights with size", panels.titles.size())};
    return panels;
}

std::vector<int> panels_of(const trace::StateMap& map, const scene::SizedLights& lights, const scene::Scene& scene)
{
    const SizedPanels panels = sized_panels(scene);
    std::vector<int> result;
    for (const scene::SizedLight& light : lights.lights()) {
        const int wanted = panels.of_object[light.faces.front().object];
        const auto at = std::find(map.lights.begin(), map.lights.end(), static_cast<int>(scene.lights.size()) + wanted);
        result.push_back(wanted < 0 || at == map.lights.end() ? -1 : static_cast<int>(at - map.lights.begin()));
    }
    return result;
}

Size overlay_size(Size panel, std::size_t panels, const OverlayKind& kind)
{
    const int dot = dot_of(panel, panels);
    const auto lines = lines_of(legend_of({}, kind), inner_width(panel, panels), dot);
    const int width = inner_width(panel, panels) + 2 * k_gap;
    const int height = k_gap + rows_of(panels) * cell_height(panel, panels) +
                       static_cast<int>(lines.size()) * line_height(dot) + k_gap;
    return {(width + 1) / 2 * 2, (height + 1) / 2 * 2};
}

PanelPlace panel_place(Size panel, std::size_t panels, std::size_t index)
{
    const int columns = columns_of(panels), i = static_cast<int>(index);
    return {k_gap + i % columns * cell_width(panel),
            k_gap + i / columns * cell_height(panel, panels) + line_height(dot_of(panel, panels))};
}

Image8 paint_states(const trace::StateMap& map, const std::vector<std::string>& titles, const OverlayKind& kind)
{
    GNOMON_CHECK_EQ(titles.size(), map.lights.size());
    const std::size_t panels = map.lights.size();
    const int dot = dot_of(map.size, panels);
    const Size size = overlay_size(map.size, panels, kind);
    Image8 image(size.width, size.height, 3);
    std::fill(image.data.begin(), image.data.end(), k_paper_tone);

    // Paint the panels, each below its title.
    for (std::size_t i = 0; i < panels; ++i) {
        const PanelPlace at = panel_place(map.size, panels, i);
        image::draw_text(image, titles[i], at.left, at.top - line_height(dot) + dot, map.size.width, dot, k_ink);
        for (int y = 0; y < map.size.height; ++y)
            for (int x = 0; x < map.size.width; ++x) {
                const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(map.size.width) +
                                          static_cast<std::size_t>(x);
                const Rgb8 color = cell_color(map.cell(i, x, y), map.shade[pixel]);
                std::copy(color.begin(), color.end(), image.pixel(at.left + x, at.top + y));
            }
    }

    // Paint the legend, laid out as it was measured.
    const std::vector<Entry> entries = legend_of(sums_of(map), kind), measured = legend_of({}, kind);
    const int width = inner_width(map.size, panels);
    int top = k_gap + rows_of(panels) * cell_height(map.size, panels);
    for (const Line& line : lines_of(measured, width, dot)) {
        int left = k_gap;
        for (const std::size_t e : line.entries) {
            const int side = std::min(swatch(dot), size.width - left);
            for (int y = 0; y < swatch(dot); ++y)
                for (int x = 0; x < side; ++x)
                    std::copy(entries[e].color.begin(), entries[e].color.end(), image.pixel(left + x, top + y));
            const int text = left + swatch(dot) + 4 * dot;
            image::draw_text(image, entries[e].text, text, top + dot, size.width - text, dot, k_ink);
            left += entry_width(measured[e], dot);
        }
        top += line_height(dot);
    }
    return image;
}

}   // namespace gnomon::frame
