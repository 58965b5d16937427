// SPDX-License-Identifier: Apache-2.0
// Places that triangles with holes hide: by the map of a texture against the texture itself, for each kind of wrapping
// and filtering, and a share of them that is known.

#include "area_light/holed_places.h"

#include <gtest/gtest.h>

#include <bit>

#include "base/random.h"

namespace gnomon::area_light {
namespace {

constexpr glm::vec3 k_point(0);
constexpr float k_cutoff = 0.5f;

LightPlaces square_light()
{
    LightPolygon light;
    light.corner = {glm::vec3(-1, 4, -1), glm::vec3(1, 4, -1), glm::vec3(1, 4, 1), glm::vec3(-1, 4, 1)};
    light.corners = 4;
    light.normal = {0, -1, 0};
    return LightPlaces(light);
}

std::shared_ptr<const scene::Texture> texture_of(const Image8& image, scene::Sampler sampler)
{
    return std::make_shared<const scene::Texture>("holes", image, true, sampler);
}

Image8 random_image(int width, int height, Random& random)
{
    Image8 image(width, height, 4);
    for (std::uint8_t& value : image.data) value = static_cast<std::uint8_t>(random.below(256));
    return image;
}

std::vector<scene::Sampler> samplers()
{
    std::vector<scene::Sampler> all;
    for (const scene::Wrap u : {scene::Wrap::repeat, scene::Wrap::mirror, scene::Wrap::clamp})
        for (const scene::Wrap v : {scene::Wrap::repeat, scene::Wrap::mirror, scene::Wrap::clamp})
            for (const scene::Filter filter : {scene::Filter::linear, scene::Filter::nearest})
                all.push_back({u, v, filter, filter, false});
    return all;
}

// What hides the whole light from the point, and more.
struct Triangle {
    glm::vec3 corner[3] = {{-9, 2, -9}, {9, 2.5f, -9}, {0, 1.5f, 12}};
    glm::vec2 texcoord[3];
};

PlaceMask everything()
{
    PlaceMask mask;
    mask.fill(~std::uint64_t{0});
    return mask;
}

TEST(HoledPlaces, AreThoseOfTheWholeTexture)
{
    const LightPlaces places = square_light();
    Random random(1);
    int different = 0, blocked = 0, all = 0;
    for (const scene::Sampler& sampler : samplers())
        for (int repeat = 0; repeat < 8; ++repeat) {
            const auto texture = texture_of(random_image(3 + repeat, 17 - repeat, random), sampler);
            const float alpha = repeat % 2 ? 1.0f : 0.8f;
            const HoleMap map(texture, alpha, k_cutoff);
            Triangle triangle;
            for (glm::vec2& uv : triangle.texcoord) uv = 6.0f * glm::vec2(random.uniform(), random.uniform()) - 3.0f;
            const glm::vec2 *uv = triangle.texcoord, along_u = uv[1] - uv[0], along_v = uv[2] - uv[0];
            PlaceMask by_map{}, by_texture{};
            add_blocked_past_holes(k_point, triangle.corner, triangle.texcoord, map, places, everything(), by_map);
            add_blocked_past_holes(
                k_point, triangle.corner,
                [&](float u, float v) { return alpha * texture->alpha(uv[0] + u * along_u + v * along_v) < k_cutoff; },
                places, everything(), by_texture);
            for (std::size_t row = 0; row < by_map.size(); ++row) {
                const std::uint64_t apart = by_map[row] ^ by_texture[row];
                different += std::popcount(apart);
            }
            blocked += count_places(by_map), all += places.count();
        }
    // Coordinates of both are rounded differently, which may show where a place lies on the border of a hole.
    EXPECT_LE(different, all / 10000);
    EXPECT_GT(blocked, all / 4);
    EXPECT_LT(blocked, 3 * all / 4);
}

TEST(HoledPlaces, MapsAreSureWhereTheySaySo)
{
    Random random(2);
    int count[3] = {};
    for (const scene::Sampler& sampler : samplers()) {
        Image8 image = random_image(5, 4, random);
        // Few alphas, so that some squares are all of one kind.
        for (std::size_t i = 3; i < image.data.size(); i += 4) image.data[i] = image.data[i] < 64 ? 0 : 200;
        const auto texture = texture_of(image, sampler);
        const HoleMap map(texture, 1, k_cutoff);
        const float half = sampler.magnify == scene::Filter::linear ? 0.5f : 0.0f;
        for (int y = -1; y < map.rows() - 1; ++y)
            for (int x = -1; x < map.columns() - 1; ++x) {
                const auto kind = map.kinds()[(y + 1) * map.columns() + x + 1];
                ++count[kind];
                for (int k = 0; k < 20 && kind != HoleMap::mixed; ++k) {
                    const glm::vec2 uv((static_cast<float>(x) + half + random.uniform()) / 5.0f,
                                       (static_cast<float>(y) + half + random.uniform()) / 4.0f);
                    EXPECT_EQ(map.is_hole(uv), kind == HoleMap::hole) << x << ' ' << y;
                }
            }
    }
    for (const int of_kind : count) EXPECT_GT(of_kind, 50);
}

// Stripes of holes over half of the texture: half of the light is hidden, however fine they are.
TEST(HoledPlaces, HideTheShareThatIsSolid)
{
    const LightPlaces places = square_light();
    Image8 image(8, 1, 4);
    for (int x = 0; x < 8; ++x) image.pixel(x, 0)[3] = x < 4 ? 255 : 0;
    const HoleMap map(texture_of(image, {}), 1, k_cutoff);
    Triangle triangle;
    // Half-way to the light and parallel to it, so that the light's projection is from -1/2 to 1/2.
    for (glm::vec3& p : triangle.corner) p.y = 2;
    for (const int stripes : {2, 3, 7}) {
        for (int c = 0; c < 3; ++c)
            triangle.texcoord[c] = {triangle.corner[c].x * static_cast<float>(stripes), triangle.corner[c].z};
        PlaceMask blocked{};
        add_blocked_past_holes(k_point, triangle.corner, triangle.texcoord, map, places, everything(), blocked);
        EXPECT_NEAR(static_cast<double>(count_places(blocked)) / places.count(), 0.5, 0.002) << stripes;
    }
}

TEST(HoledPlaces, LeaveOutWhatIsBlockedAlready)
{
    const LightPlaces places = square_light();
    Random random(3);
    const auto texture = texture_of(random_image(4, 4, random), {});
    const HoleMap map(texture, 1, k_cutoff);
    Triangle triangle;
    triangle.texcoord[1] = {4, 0}, triangle.texcoord[2] = {0, 4};
    PlaceMask none{}, blocked = everything();
    EXPECT_FALSE(
        add_blocked_past_holes(k_point, triangle.corner, triangle.texcoord, map, places, everything(), blocked));
    PlaceMask untouched{};
    EXPECT_FALSE(add_blocked_past_holes(k_point, triangle.corner, triangle.texcoord, map, places, none, untouched));
    EXPECT_EQ(count_places(untouched), 0);
}

}   // namespace
}   // namespace gnomon::area_light
