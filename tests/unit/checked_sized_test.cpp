// SPDX-License-Identifier: Apache-2.0
// The overlay of shadow states shows what is remembered of lights with size, and counts wrong answers.

#include <gtest/gtest.h>

#include "api/scene_access.h"
#include "frame/state_overlay.h"
#include "gnomon/gnomon.h"
#include "scene/view.h"
#include "trace/checked_shadows.h"
#include "trace/checked_sized.h"
#include "trace/proven_visibility.h"
#include "trace/traced_frame.h"

namespace gnomon {
namespace {

using trace::StateMark;

const std::vector<Vec3> k_square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
const std::vector<std::uint32_t> k_down{0, 1, 2, 0, 2, 3}, k_up{0, 2, 1, 0, 3, 2};

// A board between a square light and a floor.
Scene board_under_a_square()
{
    SceneBuilder builder;
    const MaterialId emitter = builder.material({.base_color = {0, 0, 0}, .emissive = {4, 4, 4}}),
                     white = builder.material({.base_color = {0.7f, 0.7f, 0.7f}, .double_sided = true});
    const MeshId down = builder.mesh({.positions = k_square, .indices = k_down}),
                 up = builder.mesh({.positions = k_square, .indices = k_up});
    builder.instance(down, emitter, Transform::translation(0, 2, 0), {.name = "panel"});
    builder.instance(up, white, Transform::scaling(8, 1, 8));
    builder.instance(up, white, Transform::translation(0.2, 0.3, 0.1) * Transform::scaling(1.6, 1, 1.2));
    Camera camera;
    camera.transform = Transform::look_at({0.5f, 2, 4}, {0, 0.2f, 0});
    camera.vertical_fov = 0.8;
    builder.camera(camera);
    return builder.finish();
}

TEST(CheckedSized, MarksOfSeveralLightsAreJoined)
{
    EXPECT_EQ(trace::joined(StateMark::away, StateMark::none), StateMark::none);
    EXPECT_EQ(trace::joined(StateMark::full, StateMark::away), StateMark::full);
    EXPECT_EQ(trace::joined(StateMark::full, StateMark::full), StateMark::full);
    EXPECT_EQ(trace::joined(StateMark::full, StateMark::none), StateMark::penumbra);
    EXPECT_EQ(trace::joined(StateMark::penumbra, StateMark::partial), StateMark::partial);
    EXPECT_EQ(trace::joined(StateMark::moving, StateMark::partial), StateMark::moving);
}

TEST(CheckedSized, OverlayHasAPanelOfTheEmissiveObjectWithLitDarkAndPenumbra)
{
    const Scene scene = board_under_a_square();
    RenderOptions options;
    options.size = {96, 72};
    options.overlay = Overlay::shadow_states;
    const Frame frame = Renderer(options).render(scene, 1);
    EXPECT_EQ(frame.size, image_size(scene, options));
    EXPECT_EQ(frame.size, frame::overlay_size({96, 72}, 1, {false, true})) << "no panel of lights that approximate it";
    EXPECT_EQ(frame.counters.shadow.rays_wrong, 0u);
    // Panels are shaded by the angle to the viewer: compare hues, as ratios of channels.
    const std::vector<std::uint8_t> bytes = frame.to_srgb8();
    const frame::PanelPlace at = frame::panel_place({96, 72}, 1, 0);
    std::size_t found[trace::k_state_marks] = {};
    for (int y = 0; y < 72; ++y)
        for (int x = 0; x < 96; ++x) {
            const std::uint8_t* shown =
                &bytes[3 * (static_cast<std::size_t>(at.top + y) * static_cast<std::size_t>(frame.size.width) +
                            static_cast<std::size_t>(at.left + x))];
            for (int mark = 0; mark < trace::k_state_marks; ++mark)
                for (int shade = 0; shade < 256; ++shade) {
                    const frame::Rgb8 color = frame::cell_color({static_cast<StateMark>(mark), false, false, false},
                                                                static_cast<std::uint8_t>(shade));
                    if (color == frame::Rgb8{shown[0], shown[1], shown[2]}) {
                        ++found[mark];
                        break;
                    }
                }
        }
    EXPECT_GT(found[static_cast<int>(StateMark::none)], 200u);
    EXPECT_GT(found[static_cast<int>(StateMark::full)], 20u);
    EXPECT_GT(found[static_cast<int>(StateMark::penumbra)], 200u);
}

TEST(CheckedSized, MoreEmissiveObjectsThanPanelsShareOne)
{
    SceneBuilder builder;
    const MaterialId emitter = builder.material({.base_color = {0, 0, 0}, .emissive = {4, 4, 4}});
    const MeshId down = builder.mesh({.positions = k_square, .indices = k_down});
    for (std::size_t i = 0; i <= frame::SizedPanels::k_most_sized; ++i)
        builder.instance(down, emitter, Transform::translation(2.0 * static_cast<double>(i), 2, 0));
    const frame::SizedPanels panels = frame::sized_panels(*api::scene_of(builder.finish()));
    ASSERT_EQ(panels.titles.size(), 1u);
    EXPECT_EQ(panels.titles[0], "all 17 lights with size");
    for (const int panel : panels.of_object) EXPECT_EQ(panel, 0);
}

// Says that all of every light is visible everywhere, or none of it.
class Liar final : public trace::SizedVisibility {
 public:
    explicit Liar(bool lit) : lit_(lit) {}
    void begin_frame(const trace::FrameContext&, const scene::SizedLights&) override {}
    class Work final : public Worker {
     public:
        explicit Work(bool lit) : lit_(lit) {}
        void find_visible(const trace::PointBatch&, std::uint32_t, std::span<const std::uint32_t> points,
                          trace::SizedVisible& result) override
        {
            result.reset(points.size());
            for (std::size_t k = 0; k < points.size(); ++k) {
                if (lit_) result.answer[k] = trace::SizedVisible::Answer::lit;
                result.state[k] = lit_ ? StateMark::none : StateMark::full;
            }
        }

     private:
        bool lit_;
    };
    std::unique_ptr<Worker> make_worker() override { return std::make_unique<Work>(lit_); }
    FrameCounters::Shadow end_frame(std::span<const std::unique_ptr<Worker>>, Tasks&) override { return {}; }

 private:
    bool lit_;
};

TEST(CheckedSized, CountsProvenAnswersThatRaysContradict)
{
    const Scene scene = board_under_a_square();
    const scene::SceneState state(api::scene_of(scene), 0);
    const ray::RayScene rays(state);
    scene::SizedLights lights;
    lights.update(state);
    const scene::View view = scene::make_view(state, 0, {48, 36});
    Tasks tasks(1);
    const auto wrong = [&](trace::SizedVisibility& tested) {
        trace::StateMap map;
        map.lights = {static_cast<int>(state.scene().lights.size())};
        trace::EveryShadowRay every_ray;
        trace::CheckedShadows shadows(every_ray, map);
        trace::CheckedSized checked(tested, map, std::vector<int>(lights.lights().size(), 0));
        trace::Techniques techniques;
        techniques.shadows = &shadows;
        techniques.sized = &lights;
        techniques.sized_visibility = &checked;
        trace::TracedOptions options;
        shading::FrameBuffers out;
        const FrameCounters counters = trace::trace_frame(state, rays, view, options, tasks, out, techniques);
        std::size_t marked = 0;
        for (const std::uint8_t cell : map.cells) marked += trace::StateCell::of(cell).wrong;
        EXPECT_EQ(marked > 0, *counters.shadow.rays_wrong > 0);
        return *counters.shadow.rays_wrong;
    };
    Liar lit(true), dark(false);
    EXPECT_GT(wrong(lit), 50u);
    EXPECT_GT(wrong(dark), 50u);
    trace::ProvenVisibility proven;
    EXPECT_EQ(wrong(proven), 0u);
}

}   // namespace
}   // namespace gnomon
