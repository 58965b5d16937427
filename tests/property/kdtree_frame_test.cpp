// SPDX-License-Identifier: Apache-2.0
// Complete frames on the counting kd-tree: the images of Embree up to edges, counts that do not depend on threads, and
// the savings of culling.
#include <gtest/gtest.h>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

struct Clip {
    std::vector<std::vector<float>> color;
    std::vector<FrameCounters> counters;
};

Clip render(const Scene& scene, Accelerator accelerator, ShadowCulling culling, int threads,
            Indirect indirect = Indirect::visible)
{
    RenderOptions options;
    options.size = {96, 72};
    options.threads = threads;
    options.accelerator = accelerator;
    options.shadow_culling = culling;
    options.indirect = indirect;
    options.keep_image = false;   // the work of whole frames is counted
    options.bounces = 1;          // further ones carry what one ray sees at an edge through the whole scene
    Renderer renderer(options);
    Clip clip;
    for (int frame = 5; frame < 9; ++frame) {
        const Frame image = renderer.render(scene, frame);
        clip.color.push_back(image.layers[0].copy());
        clip.counters.push_back(image.counters);
    }
    return clip;
}

std::size_t pixels_different(const std::vector<float>& a, const std::vector<float>& b, float tolerance)
{
    std::size_t different = 0;
    for (std::size_t i = 0; i < a.size(); i += 3)
        for (std::size_t c = 0; c < 3; ++c)
            if (std::abs(a[i + c] - b[i + c]) > tolerance * (std::abs(a[i + c]) + 0.1f)) {
                ++different;
                break;
            }
    return different;
}

TEST(KdTreeFrame, EqualsTheEmbreeImageUpToEdges)
{
    for (const char* name : {"builtin:cornell", "builtin:kinetic"}) {
        SCOPED_TRACE(name);
        const Scene scene = load(name);
        const Clip embree = render(scene, Accelerator::embree, ShadowCulling::off, 1);
        const Clip kdtree = render(scene, Accelerator::kdtree, ShadowCulling::off, 1);
        const Clip direct_embree = render(scene, Accelerator::embree, ShadowCulling::off, 1, Indirect::off);
        const Clip direct_kdtree = render(scene, Accelerator::kdtree, ShadowCulling::off, 1, Indirect::off);
        for (std::size_t f = 0; f < embree.color.size(); ++f) {
            EXPECT_LE(pixels_different(direct_embree.color[f], direct_kdtree.color[f], 1e-3f), 96u * 72 / 200) << f;
            // A ray that hits an edge on one tree and misses it on the other affects all values interpolated from it.
            EXPECT_LE(pixels_different(embree.color[f], kdtree.color[f], 2e-2f), 96u * 72 / 200) << f;
            EXPECT_FALSE(embree.counters[f].kdtree.has_value());
            ASSERT_TRUE(kdtree.counters[f].kdtree.has_value());
            const FrameCounters& counters = kdtree.counters[f];
            EXPECT_GT(counters.kdtree->primary.nodes, counters.primary_rays);
            EXPECT_GT(counters.kdtree->primary.tests, 0u);
            EXPECT_GT(counters.kdtree->shadow.nodes, counters.shadow.rays);
            EXPECT_GE(counters.kdtree->reflection.nodes, counters.reflection_rays);
            EXPECT_GE(counters.kdtree->refraction.nodes, counters.refraction_rays);
            EXPECT_GT(counters.kdtree->indirect.nodes, counters.indirect.rays)
                << "including the rays that find its points";
        }
    }
}

TEST(KdTreeFrame, CountsAreSameForAnyThreadCountAndFallWithCulling)
{
    const Scene scene = load("builtin:cornell");
    const Clip off = render(scene, Accelerator::kdtree, ShadowCulling::off, 1);
    for (const ShadowCulling culling : {ShadowCulling::off, ShadowCulling::paper, ShadowCulling::certified}) {
        const Clip one = render(scene, Accelerator::kdtree, culling, 1);
        const Clip three = render(scene, Accelerator::kdtree, culling, 3);
        EXPECT_EQ(one.color, three.color);
        for (std::size_t f = 0; f < one.counters.size(); ++f) {
            EXPECT_EQ(one.counters[f].kdtree, three.counters[f].kdtree);
        }
        const FrameCounters::KdTree &last = *one.counters.back().kdtree, &all = *off.counters.back().kdtree;
        if (culling == ShadowCulling::off) {
            EXPECT_EQ(last, all);
        } else {
            EXPECT_LT(last.shadow.nodes, all.shadow.nodes);
            EXPECT_EQ(last.primary, all.primary);
        }
        if (culling == ShadowCulling::certified) {
            EXPECT_EQ(one.color, off.color) << "exact on this tree as well";
            EXPECT_LT(last.shadow.nodes, all.shadow.nodes / 2);
        }
    }
}

}   // namespace
}   // namespace gnomon
