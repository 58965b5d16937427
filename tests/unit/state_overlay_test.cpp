// SPDX-License-Identifier: Apache-2.0
// The overlay of shadow states: panel layout, colours, and the image that a renderer returns.
#include <gtest/gtest.h>

#include "frame/state_overlay.h"
#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

using frame::cell_color;
using frame::Rgb8;
using trace::StateCell;
using trace::StateMark;

int difference(const Rgb8& a, const Rgb8& b)
{
    int sum = 0;
    for (std::size_t c = 0; c < 3; ++c) sum += std::abs(int{a[c]} - int{b[c]});
    return sum;
}

trace::StateMap map_of(Size size, int lights)
{
    trace::StateMap map;
    for (int l = 0; l < lights; ++l) map.lights.push_back(l);
    map.start(size);
    for (std::size_t i = 0; i < map.cells.size(); ++i) map.cells[i] = static_cast<std::uint8_t>(i % 7);
    std::fill(map.shade.begin(), map.shade.end(), std::uint8_t{255});
    return map;
}

TEST(StateOverlay, MarksHaveDistinctColours)
{
    std::vector<Rgb8> colors{frame::k_wrong_color, frame::k_wrong_behind_color};
    for (int m = 0; m < trace::k_state_marks; ++m) colors.push_back(cell_color({static_cast<StateMark>(m)}, 255));
    for (std::size_t a = 0; a < colors.size(); ++a)
        for (std::size_t b = 0; b < a; ++b) EXPECT_GT(difference(colors[a], colors[b]), 60) << a << " and " << b;
}

TEST(StateOverlay, WrongOverridesAllOtherMarks)
{
    for (int byte = 0; byte < 64; ++byte) {
        const StateCell cell = StateCell::of(static_cast<std::uint8_t>(byte));
        if (static_cast<int>(cell.mark) >= trace::k_state_marks) continue;
        const Rgb8 color = cell_color(cell, 40);
        EXPECT_EQ(color == frame::k_wrong_color, (byte & StateCell::k_wrong) != 0);
        EXPECT_EQ(color == frame::k_wrong_behind_color, (byte & 48) == 32);
    }
    EXPECT_NE(cell_color({StateMark::none, true, false, false}, 255), cell_color({StateMark::none}, 255));
}

// Three bits encode eight marks, and all are in use.
TEST(StateOverlay, InvalidMarkIsAnInternalError)
{
    static_assert(trace::k_state_marks == StateCell::k_mark + 1);
    EXPECT_THROW(frame::state_color(static_cast<StateMark>(trace::k_state_marks)), InternalError);
}

TEST(StateOverlay, PanelsDoNotOverlap)
{
    for (const Size size : {Size{1, 1}, Size{8, 3}, Size{65, 49}, Size{410, 20}})
        for (const int lights : {1, 2, 3, 6, 16})
            for (const bool paper : {false, true}) {
                const trace::StateMap map = map_of(size, lights);
                const std::vector<std::string> titles(static_cast<std::size_t>(lights), "a title that is rather long");
                const Image8 image = frame::paint_states(map, titles, {paper, lights == 3});
                const Size whole = frame::overlay_size(size, static_cast<std::size_t>(lights), {paper, lights == 3});
                EXPECT_EQ((Size{image.width, image.height}), whole);
                EXPECT_EQ(whole.width % 2 + whole.height % 2, 0) << "videos need even sizes";
                for (std::size_t p = 0; p < map.lights.size(); ++p) {
                    const frame::PanelPlace at = frame::panel_place(size, map.lights.size(), p);
                    ASSERT_LE(at.left + size.width, image.width);
                    ASSERT_LE(at.top + size.height, image.height);
                    for (int y = 0; y < size.height; ++y)
                        for (int x = 0; x < size.width; ++x) {
                            const std::uint8_t* shown = image.pixel(at.left + x, at.top + y);
                            const Rgb8 color{shown[0], shown[1], shown[2]};
                            ASSERT_EQ(color, cell_color(map.cell(p, x, y), 255));
                        }
                }
            }
}

TEST(StateOverlay, RendererReturnsItWithTheReportedSize)
{
    const Scene scene = load("builtin:kinetic");
    for (const std::optional<int> light : {std::optional<int>(), std::optional<int>(2)}) {
        RenderOptions options;
        options.size = {60, 40};
        options.overlay = Overlay::shadow_states;
        options.overlay_light = light;
        options.layers = true;
        Renderer renderer(options);
        renderer.render(scene, 1);
        const Frame image = renderer.render(scene, 2);
        EXPECT_EQ(image.size, image_size(scene, options));
        EXPECT_EQ(image.size, frame::overlay_size({60, 40}, light ? 1 : scene.info().lights.size(), {}));
        EXPECT_EQ(image.layers.size(), 1u);
        // The colours are exactly those that were drawn.
        const std::vector<std::uint8_t> bytes = image.to_srgb8();
        const Rgb8 legend = frame::state_color(StateMark::none);
        const auto found = std::search(bytes.begin(), bytes.end(), legend.begin(), legend.end());
        EXPECT_NE(found, bytes.end());
    }
}

TEST(StateOverlay, RefusesUnsupportedOptions)
{
    RenderOptions options;
    options.size = {60, 40};
    options.overlay = Overlay::shadow_states;
    options.shadow_culling = ShadowCulling::off;
    EXPECT_THROW(Renderer{options}, UsageError);
    options.shadow_culling = ShadowCulling::certified;
    const Scene scene = load("builtin:kinetic");
    EXPECT_THROW(Renderer{options}.render(scene.with_lights(0), 1), UsageError);
    options.overlay_light = static_cast<int>(scene.info().lights.size());
    EXPECT_THROW(Renderer{options}.render(scene, 1), UsageError);
    options.overlay_light.reset();
    options.size = {16000, 15000};
    EXPECT_THROW(image_size(scene, options), UsageError);
}

}   // namespace
}   // namespace gnomon
