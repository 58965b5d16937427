// SPDX-License-Identifier: Apache-2.0
// glTF's extensions of materials: that each has its effect, of the right size, and that none gains energy.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/random.h"
#include "gltf_document.h"
#include "image_bytes.h"
#include "ray/light_through.h"
#include "ray/ray_scene.h"
#include "scene/file_surfaces.h"
#include "scene/material_layers.h"
#include "shading/layers.h"
#include "shading/sheen_shared.h"

namespace gnomon::shading {
namespace {

constexpr auto k_float_pi = static_cast<float>(k_pi);

// A quad in the plane z = 0, seen from above, with a material given as JSON.
class Quad {
 public:
    explicit Quad(const std::string& material, const std::string& extensions, const std::string& more = "")
    {
        write(more);
        const std::vector<float> corners = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
        const int p = document_.positions(corners), uv = document_.floats({0, 1, 1, 1, 1, 0, 0, 0}, "VEC2", 2);
        const int index = document_.accessor<std::uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 5123, 1);
        std::string used;
        for (std::size_t at = 0; at < extensions.size();) {
            const std::size_t end = std::min(extensions.find(' ', at), extensions.size());
            used += fmt::format("{}\"{}\"", used.empty() ? "" : ",", extensions.substr(at, end - at));
            at = end + 1;
        }
        const std::string images = more.empty() ? "" : R"("images":[{"uri":"t.png"}],"textures":[{"source":0}],)";
        auto scene = document_.load(
            images + "\"materials\":[{" + material + "}]," +
                test::one_mesh(fmt::format(
                    R"({{"attributes":{{"POSITION":{},"TEXCOORD_0":{}}},"indices":{},"material":0}})", p, uv, index)),
            fmt::format(R"("extensionsUsed":[{0}],"extensionsRequired":[{0}],)", used));
        EXPECT_TRUE(scene.warnings.empty()) << (scene.warnings.empty() ? "" : scene.warnings.front());
        scene_ = std::make_shared<const scene::Scene>(std::move(scene));
        state_ = std::make_unique<scene::SceneState>(scene_, 0);
        rays_ = std::make_unique<ray::RayScene>(*state_);
    }
    // The surface at a place of it, seen at an angle to its normal, from above or from below.
    SurfacePoint at(float angle = 0, bool from_below = false, const glm::vec2& place = {.1f, .2f}) const
    {
        const float side = from_below ? -1.0f : 1.0f;
        const glm::vec3 direction(std::sin(angle), 0, -side * std::cos(angle));
        const glm::vec3 origin = glm::vec3(place, 0) - 3.0f * direction;
        const ray::Hit hit = rays_->closest_single(origin, 0, direction, k_infinity, ray::Sides::both);
        SurfacePoint s;
        surface_at(*scene_, rays_->geometry(hit.object), hit.triangle, hit.u, hit.v, hit.t, direction, {}, s);
        return s;
    }
    const scene::Scene& scene() const { return *scene_; }
    const ray::RayScene& rays() const { return *rays_; }

 private:
    // A texture of 2 x 1 texels: RGBA of both.
    void write(const std::string& more)
    {
        if (more.empty()) return;
        std::vector<std::uint8_t> row;
        for (std::size_t i = 0; i + 1 < more.size(); i += 2)
            row.push_back(static_cast<std::uint8_t>(std::stoi(more.substr(i, 2), nullptr, 16)));
        const auto png = test::png_bytes({2, 1, 8, PNG_COLOR_TYPE_RGBA}, {row});
        std::ofstream(document_.folder() / "t.png", std::ios::binary)
            .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    }
    test::Document document_;
    std::shared_ptr<const scene::Scene> scene_;
    std::unique_ptr<scene::SceneState> state_;
    std::unique_ptr<ray::RayScene> rays_;
};

std::string extension(const std::string& name, const std::string& values, const std::string& base = "")
{
    return fmt::format(R"("pbrMetallicRoughness":{{{}}},"extensions":{{"{}":{{{}}}}})", base, name, values);
}

// What the surface reflects to the viewer of light from everywhere, and what it lets through.
double albedo(const SurfacePoint& s)
{
    Random random(3);
    constexpr int n = 100'000;
    glm::dvec3 sum(0);
    for (int i = 0; i < n; ++i) {
        const float z = random.uniform(), a = random.uniform(0, 2 * k_float_pi), r = std::sqrt(1 - z * z);
        sum += glm::dvec3(reflect_light(s, {r * std::cos(a), r * std::sin(a), z}, glm::vec3(1)));
    }
    const Continuation next = continue_from(s);
    const glm::dvec3 all = sum / double{n} * (2 * k_pi) + glm::dvec3(next.refracted_weight + next.straight_weight);
    return std::max({all.x, all.y, all.z});
}

TEST(MaterialLayers, SpecularScalesTheReflectanceAtNormalIncidence)
{
    const std::string base = R"("roughnessFactor":0,"metallicFactor":0)";
    const Quad quad(
        extension("KHR_materials_specular", R"("specularFactor":0.5,"specularColorFactor":[1,0.5,2])", base),
        "KHR_materials_specular");
    const glm::vec3 seen = continue_from(quad.at()).reflected_weight;
    EXPECT_NEAR(seen.x, .04f * .5f, 1e-5f);
    EXPECT_NEAR(seen.y, .04f * .25f, 1e-5f);
    EXPECT_NEAR(seen.z, .04f, 1e-5f);
    // At grazing angles it is the factor, whatever the colour.
    const glm::vec3 grazing = continue_from(quad.at(1.5697f)).reflected_weight;
    EXPECT_NEAR(grazing.x, .5f, .01f);
    EXPECT_NEAR(grazing.z, .5f, .01f);
    // A metal has none of it.
    const Quad metal(extension("KHR_materials_specular", R"("specularFactor":0.5)",
                               R"("roughnessFactor":0,"baseColorFactor":[0.8,0.6,0.4,1])"),
                     "KHR_materials_specular");
    EXPECT_NEAR(continue_from(metal.at()).reflected_weight.y, .6f, 1e-5f);
}

TEST(MaterialLayers, TexturesOfSpecularAreReadFromTheirChannels)
{
    // Alpha is 51/255 in the left texel and 255/255 in the right one; red 188 is a linear 0.5.
    const Quad quad(
        extension("KHR_materials_specular", R"("specularTexture":{"index":0},"specularColorTexture":{"index":0})",
                  R"("roughnessFactor":0,"metallicFactor":0)"),
        "KHR_materials_specular", "bcffff33bcffffff");
    EXPECT_NEAR(continue_from(quad.at(0, false, {-.5f, 0})).reflected_weight.y, .04f * .2f, 1e-4f);
    EXPECT_NEAR(continue_from(quad.at(0, false, {.5f, 0})).reflected_weight.y, .04f, 1e-4f);
    EXPECT_NEAR(continue_from(quad.at(0, false, {.5f, 0})).reflected_weight.x, .04f * .5f, 2e-4f);
    // A transform of the texture moves its right texel to the left.
    const Quad moved(
        extension("KHR_materials_specular",
                  R"("specularTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.5,0]}}})",
                  R"("roughnessFactor":0,"metallicFactor":0)"),
        "KHR_materials_specular KHR_texture_transform", "bcffff33bcffffff");
    EXPECT_NEAR(continue_from(moved.at(0, false, {-.5f, 0})).reflected_weight.y, .04f, 1e-4f);
}

TEST(MaterialExtensions, UnlitShowsItsColourWhateverTheLight)
{
    const Quad quad(extension("KHR_materials_unlit", "", R"("baseColorFactor":[0.25,0.5,0.75,1])"),
                    "KHR_materials_unlit");
    const SurfacePoint s = quad.at(0.5f);
    EXPECT_EQ(s.model, scene::ShadingModel::unlit);
    EXPECT_EQ(s.emissive, glm::vec3(0.25f, 0.5f, 0.75f));
    EXPECT_EQ(continue_from(s).reflected_weight, glm::vec3(0));
}

TEST(MaterialExtensions, EmissiveStrengthMultipliesTheEmission)
{
    const Quad quad(
        R"("emissiveFactor":[1,0.5,0.25],)" + extension("KHR_materials_emissive_strength", R"("emissiveStrength":8)"),
        "KHR_materials_emissive_strength");
    EXPECT_EQ(quad.at().emissive, glm::vec3(8, 4, 2));
}

TEST(MaterialExtensions, TheIndexOfRefractionSetsTheReflectance)
{
    for (const float ior : {1.0f, 1.33f, 1.5f, 2.4f}) {
        const Quad quad(extension("KHR_materials_ior", fmt::format(R"("ior":{})", ior),
                                  R"("roughnessFactor":0,"metallicFactor":0)"),
                        "KHR_materials_ior");
        const float root = (ior - 1) / (ior + 1);
        EXPECT_NEAR(continue_from(quad.at()).reflected_weight.y, root * root, 1e-5f) << ior;
    }
}

TEST(MaterialExtensions, TextureTransformsScaleTurnAndMove)
{
    // Left texel: linear .0, right texel: 1. Coordinates of the quad: u from left to right, v from top to bottom.
    const auto red = [](const std::string& transform, const glm::vec2& place) {
        const Quad quad(fmt::format(R"("pbrMetallicRoughness":{{"metallicFactor":0,"baseColorTexture":{{"index":0,)"
                                    R"("extensions":{{"KHR_texture_transform":{{{}}}}}}}}})",
                                    transform),
                        "KHR_texture_transform", "000000ffffffffff");
        return quad.at(0, false, place).diffuse.x;
    };
    EXPECT_NEAR(red("", {-.5f, .3f}), 0, 1e-5f);
    EXPECT_NEAR(red("", {.5f, .3f}), 1, 1e-5f);
    // Twice as many: a quarter of the quad is a texel.
    EXPECT_NEAR(red(R"("scale":[2,1])", {-.25f, .3f}), 1, 1e-5f);
    EXPECT_NEAR(red(R"("scale":[2,1])", {.25f, .3f}), 0, 1e-5f);
    EXPECT_NEAR(red(R"("offset":[0.5,0])", {-.5f, .3f}), 1, 1e-5f);
    // A quarter turn: u is v, of the quad's top and bottom.
    const std::string turned = R"("rotation":1.5707963)";
    EXPECT_NEAR(red(turned, {-.5f, .5f}), red(turned, {.5f, .5f}), 1e-5f);
    EXPECT_NEAR(std::abs(red(turned, {0, .5f}) - red(turned, {0, -.5f})), 1, 1e-5f);
}

TEST(MaterialLayers, ClearcoatAddsItsHighlightAndTakesThatFromTheBase)
{
    const float roughness = .5f, coat = .75f, n_h = 1;
    const Quad quad(extension("KHR_materials_clearcoat",
                              fmt::format(R"("clearcoatFactor":{},"clearcoatRoughnessFactor":{})", coat, roughness),
                              R"("baseColorFactor":[0.5,0.5,0.5,1],"metallicFactor":0)"),
                    "KHR_materials_clearcoat");
    const Quad bare(
        extension("KHR_materials_ior", R"("ior":1.5)", R"("baseColorFactor":[0.5,0.5,0.5,1],"metallicFactor":0)"),
        "KHR_materials_ior");
    const glm::vec3 above(0, 0, 1);
    // At normal incidence: D = 1 / (pi a^2), V = 1/4, F = 0.04.
    const float alpha = roughness * roughness;
    const float lobe = n_h / (k_float_pi * alpha * alpha) / 4;
    const float expected = coat * .04f * lobe + (1 - coat * .04f) * reflect_light(bare.at(), above, glm::vec3(1)).x;
    EXPECT_NEAR(reflect_light(quad.at(), above, glm::vec3(1)).x, expected, 1e-4f);
    // A smooth coat mirrors beside the rough base.
    const Quad smooth(
        extension("KHR_materials_clearcoat", R"("clearcoatFactor":1)", R"("roughnessFactor":1,"metallicFactor":0)"),
        "KHR_materials_clearcoat");
    EXPECT_NEAR(continue_from(smooth.at()).reflected_weight.x, .04f, 1e-5f);
    EXPECT_GT(continue_from(smooth.at(1.5f)).reflected_weight.x, .6f);
}

TEST(MaterialLayers, ClearcoatHasNormalsOfItsOwn)
{
    // Red 255, green and blue 128: the normal points along u.
    const Quad quad(
        extension("KHR_materials_clearcoat", R"("clearcoatFactor":1,"clearcoatNormalTexture":{"index":0,"scale":0.5})"),
        "KHR_materials_clearcoat", "ff80ffffff80ffff");
    const SurfacePoint s = quad.at();
    EXPECT_NEAR(s.normal.z, 1, 1e-4f);
    EXPECT_NEAR(s.layers.coat_normal.x / s.layers.coat_normal.z, .5f, .01f);
}

TEST(MaterialLayers, SheenTakesWhatItReflects)
{
    const Quad quad(extension("KHR_materials_sheen", R"("sheenColorFactor":[0.5,0.25,0],"sheenRoughnessFactor":0.5)",
                              R"("baseColorFactor":[0,0,0,1],"metallicFactor":1)"),
                    "KHR_materials_sheen");
    for (const float angle : {0.0f, .8f, 1.4f}) {
        const SurfacePoint s = quad.at(angle);
        Random random(5);
        constexpr int n = 200'000;
        glm::dvec3 sum(0);
        for (int i = 0; i < n; ++i) {
            const float z = random.uniform(), a = random.uniform(0, 2 * k_float_pi), r = std::sqrt(1 - z * z);
            sum += glm::dvec3(reflect_layers(s, {r * std::cos(a), r * std::sin(a), z}));
        }
        sum *= 2 * k_pi / n;
        EXPECT_NEAR(sum.x, .5 * s.layers.sheen_albedo, .02 * s.layers.sheen_albedo + 1e-3) << angle;
        EXPECT_NEAR(sum.y / sum.x, .5, 1e-3) << angle;
        EXPECT_NEAR(s.coverage, 1 - .5f * s.layers.sheen_albedo, 1e-5f) << angle;
    }
    EXPECT_GT(quad.at(1.4f).layers.sheen_albedo, 2 * quad.at(0).layers.sheen_albedo);
}

TEST(MaterialLayers, ShadersKnowTheAlbedoOfSheen)
{
    constexpr float albedos[] = {GNOMON_SHEEN_ALBEDOS};
    static_assert(std::size(albedos) == GNOMON_SHEEN_ROWS * GNOMON_SHEEN_COLUMNS);
    for (int r = 0; r < GNOMON_SHEEN_ROWS; ++r)
        for (int c = 0; c < GNOMON_SHEEN_COLUMNS; ++c)
            EXPECT_NEAR(albedos[r * GNOMON_SHEEN_COLUMNS + c],
                        sheen_albedo(static_cast<float>(c) / (GNOMON_SHEEN_COLUMNS - 1),
                                     .1f + .9f * static_cast<float>(r) / (GNOMON_SHEEN_ROWS - 1)),
                        2e-4f);
}

TEST(MaterialLayers, AnisotropyWidensTheHighlightAlongTheGrain)
{
    const auto material = [](float rotation) {
        return extension("KHR_materials_anisotropy",
                         fmt::format(R"("anisotropyStrength":0.8,"anisotropyRotation":{})", rotation),
                         R"("roughnessFactor":0.4)");
    };
    const Quad quad(material(0), "KHR_materials_anisotropy");
    const SurfacePoint s = quad.at();
    const glm::vec3 along = glm::normalize(glm::vec3(.8f, 0, 1)), across = glm::normalize(glm::vec3(0, .8f, 1));
    // By the distribution's closed form, at the half vectors; visibility is nearly the same.
    const float alpha = .16f, wide = glm::mix(alpha, 1.0f, .64f);
    const auto distribution = [](const glm::vec3& h, float x, float y) {
        const float q = h.x * h.x / (x * x) + h.y * h.y / (y * y) + h.z * h.z;
        return 1 / (k_float_pi * x * y * q * q);
    };
    const glm::vec3 h = glm::normalize(along + glm::vec3(0, 0, 1)), g = glm::normalize(across + glm::vec3(0, 0, 1));
    const float ratio = distribution(h, wide, alpha) / distribution(g, wide, alpha);
    const float seen = reflect_light(s, along, glm::vec3(1)).x / reflect_light(s, across, glm::vec3(1)).x;
    EXPECT_GT(seen, 5);
    EXPECT_NEAR(seen / ratio, 1, .35f);
    // Turned by a quarter, it is the other way round.
    const Quad turned(material(k_float_pi / 2), "KHR_materials_anisotropy");
    EXPECT_NEAR(reflect_light(turned.at(), across, glm::vec3(1)).x, reflect_light(s, along, glm::vec3(1)).x, 1e-3f);
}

// The reflectance of a thin film at one wavelength by Airy's sum, at normal incidence.
double airy(double thin_film, double base, double nanometres, double wavelength)
{
    const double a = (1 - thin_film) / (1 + thin_film), b = (thin_film - base) / (thin_film + base);
    const double phase = 4 * k_pi * thin_film * nanometres / wavelength;
    return (a * a + b * b + 2 * a * b * std::cos(phase)) / (1 + a * a * b * b + 2 * a * b * std::cos(phase));
}

TEST(MaterialLayers, ThinFilmsReflectAsAiryPrescribes)
{
    const glm::vec3 f0(.5f);
    const double root = std::sqrt(.5), base = (1 + root) / (1 - root), thin_film = 1.4;
    // No thin film: the base. A thick thin film: the mean over wavelengths, without interference.
    const glm::vec3 none = thin_film_reflectance(f0, 1, 1.4f, 0);
    EXPECT_NEAR(none.x, .5f, 5e-3f);
    const glm::vec3 thick = thin_film_reflectance(f0, 1, 1.4f, 60'000);
    double mean = 0;
    for (int i = 0; i < 10'000; ++i) mean += airy(thin_film, base, 60'000, 400 + .03 * i) / 10'000;
    EXPECT_NEAR(thick.y, mean, .01);
    // Thin films, at the wavelengths where the eye's green and red are most sensitive.
    for (const double nanometres : {80.0, 100.0, 150.0, 200.0}) {
        double green = 0;
        for (int i = -20; i <= 20; ++i) green += airy(thin_film, base, nanometres, 545 + 1.5 * i) / 41;
        EXPECT_NEAR(thin_film_reflectance(f0, 1, 1.4f, static_cast<float>(nanometres)).y, green, .12) << nanometres;
    }
}

TEST(MaterialLayers, IridescenceColoursTheReflection)
{
    const auto material = [](int nanometres) {
        return extension(
            "KHR_materials_iridescence",
            fmt::format(R"("iridescenceFactor":1,"iridescenceIor":1.4,"iridescenceThicknessMaximum":{})", nanometres),
            R"("roughnessFactor":0,"baseColorFactor":[0.5,0.5,0.5,1])");
    };
    for (const int nanometres : {150, 350}) {
        const Quad quad(material(nanometres), "KHR_materials_iridescence");
        const glm::vec3 seen = continue_from(quad.at()).reflected_weight;
        const glm::vec3 thin_film = thin_film_reflectance(glm::vec3(.5f), 1, 1.4f, static_cast<float>(nanometres));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], thin_film[c], 1e-3f) << nanometres;
        EXPECT_GT(std::max({seen.x, seen.y, seen.z}) / std::min({seen.x, seen.y, seen.z}), 1.2f) << nanometres;
    }
}

TEST(MaterialLayers, ThinWallsDoNotBendLight)
{
    const Quad quad(extension("KHR_materials_transmission", R"("transmissionFactor":1)",
                              R"("roughnessFactor":0,"metallicFactor":0,"baseColorFactor":[1,0.5,0.25,1])"),
                    "KHR_materials_transmission");
    for (const bool below : {false, true}) {
        const SurfacePoint s = quad.at(.7f, below);
        const Continuation next = continue_from(s);
        EXPECT_NEAR(glm::length(next.refracted + s.to_viewer), 0, 1e-5f);
        const float passes = 1 - fresnel_dielectric(std::cos(.7f), 1.5f);
        EXPECT_NEAR(next.refracted_weight.x, passes, 1e-4f);
        EXPECT_NEAR(next.refracted_weight.z, .25f * passes, 1e-4f);
    }
}

TEST(MaterialLayers, TransmissionIsWhereItsTextureSays)
{
    const Quad quad(extension("KHR_materials_transmission",
                              R"("transmissionFactor":1,"transmissionTexture":{"index":0})", R"("metallicFactor":0)"),
                    "KHR_materials_transmission", "00ffffffffffffff");
    EXPECT_EQ(quad.at(0, false, {-.5f, 0}).transmitted, glm::vec3(0));
    EXPECT_EQ(quad.at(0, false, {-.5f, 0}).diffuse, glm::vec3(1));
    EXPECT_EQ(quad.at(0, false, {.5f, 0}).transmitted, glm::vec3(1));
    EXPECT_EQ(quad.at(0, false, {.5f, 0}).diffuse, glm::vec3(0));
    // Shadows follow it.
    ray::RayQueue queue;
    queue.push({-.5f, 0, -1}, 0, {0, 0, 1}, k_infinity);
    queue.push({.5f, 0, -1}, 0, {0, 0, 1}, k_infinity);
    glm::vec3 passes[2];
    quad.rays().let_through(queue, 0, 2, passes);
    EXPECT_EQ(passes[0], glm::vec3(0));
    EXPECT_EQ(passes[1], glm::vec3(1));
}

TEST(MaterialLayers, BodiesRefractAndAbsorbByBeersLaw)
{
    const Quad quad(
        R"("pbrMetallicRoughness":{"roughnessFactor":0,"metallicFactor":0},"extensions":{)"
        R"("KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_volume":{"thicknessFactor":1,)"
        R"("attenuationDistance":2,"attenuationColor":[0.25,0.5,1]}})",
        "KHR_materials_transmission KHR_materials_volume");
    const SurfacePoint above = quad.at(.7f), inside = quad.at(.3f, true);
    EXPECT_NEAR(glm::length(glm::vec2(continue_from(above).refracted)), std::sin(.7f) / 1.5f, 1e-4f);   // Snell
    EXPECT_EQ(attenuation(above, 2), glm::vec3(1));   // the ray comes from outside
    EXPECT_NEAR(attenuation(inside, 2).x, .25f, 1e-5f);
    EXPECT_NEAR(attenuation(inside, 4).y, .25f, 1e-5f);
    EXPECT_NEAR(attenuation(inside, 1).x, .5f, 1e-5f);
    EXPECT_EQ(attenuation(inside, 100).z, 1);
}

TEST(MaterialLayers, RoughTransmissionSpreadsWithoutChance)
{
    const Quad quad(extension("KHR_materials_transmission", R"("transmissionFactor":1)",
                              R"("roughnessFactor":0.5,"metallicFactor":0)"),
                    "KHR_materials_transmission");
    const SurfacePoint s = quad.at(.4f);
    std::vector<TransmittedRay> rays, again;
    find_transmitted(s, continue_from(s), false, rays);
    find_transmitted(s, continue_from(s), false, again);
    ASSERT_GT(rays.size(), 8u);
    glm::vec3 sum(0), mean(0);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(rays[i].direction, again[i].direction);
        EXPECT_LT(glm::dot(rays[i].direction, s.geometric_normal), 0);
        sum += rays[i].part, mean += rays[i].part * rays[i].direction;
    }
    EXPECT_NEAR(sum.x, 1, 1e-5f);
    // They lie around the straight direction, at an angle that the roughness gives.
    EXPECT_GT(glm::dot(glm::normalize(mean), -s.to_viewer), .97f);
    EXPECT_LT(glm::length(mean), .97f);
    // A path that was split continues as one.
    find_transmitted(s, continue_from(s), true, rays);
    ASSERT_EQ(rays.size(), 1u);
}

TEST(MaterialLayers, DispersionBendsBlueMoreThanRed)
{
    const Quad quad(
        R"("pbrMetallicRoughness":{"roughnessFactor":0,"metallicFactor":0},"extensions":{)"
        R"("KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_volume":{"thicknessFactor":1},)"
        R"("KHR_materials_dispersion":{"dispersion":1}})",
        "KHR_materials_transmission KHR_materials_volume KHR_materials_dispersion");
    const SurfacePoint s = quad.at(.8f);
    std::vector<TransmittedRay> rays;
    find_transmitted(s, continue_from(s), false, rays);
    ASSERT_EQ(rays.size(), 3u);
    glm::vec3 sum(0);
    for (int c = 0; c < 3; ++c) {
        // Snell's law with the index of the channel: an Abbe number of 20 spreads them by (ior - 1) / 20.
        const float ior = 1.5f + .0125f * static_cast<float>(c - 1);
        EXPECT_NEAR(rays[static_cast<std::size_t>(c)].direction.x, std::sin(.8f) / ior, 1e-4f) << c;
        sum += rays[static_cast<std::size_t>(c)].part;
    }
    EXPECT_EQ(sum, glm::vec3(1));
}

TEST(MaterialLayers, NoneGainsEnergy)
{
    const std::string white = R"("baseColorFactor":[1,1,1,1],"metallicFactor":0,"roughnessFactor":)";
    const std::pair<const char*, const char*> cases[] = {
        {"KHR_materials_specular", R"("specularColorFactor":[20,20,20])"},
        {"KHR_materials_clearcoat", R"("clearcoatFactor":1,"clearcoatRoughnessFactor":0.5)"},
        {"KHR_materials_sheen", R"("sheenColorFactor":[1,1,1],"sheenRoughnessFactor":0.3)"},
        {"KHR_materials_sheen", R"("sheenColorFactor":[1,1,1],"sheenRoughnessFactor":1)"},
        {"KHR_materials_anisotropy", R"("anisotropyStrength":1)"},
        {"KHR_materials_iridescence", R"("iridescenceFactor":1,"iridescenceThicknessMaximum":300)"},
        {"KHR_materials_transmission", R"("transmissionFactor":0.7)"}};
    for (const auto& [name, values] : cases)
        for (const float roughness : {.4f, 1.0f})
            for (const float angle : {0.0f, .7f, 1.3f}) {
                const Quad quad(extension(name, values, white + fmt::format("{}", roughness)), name);
                const Quad bare(extension("KHR_materials_ior", "", white + fmt::format("{}", roughness)),
                                "KHR_materials_ior");
                const double all = albedo(quad.at(angle));
                // The base's diffuse and specular parts alone add up to a little more than 1 at grazing angles.
                EXPECT_LT(all, std::max(1.0, albedo(bare.at(angle))) + .03) << name << ' ' << roughness << ' ' << angle;
                EXPECT_GT(all, .4) << name << ' ' << roughness << ' ' << angle;
            }
}

TEST(MaterialLayers, MaterialsWithoutThemHaveNoBlock)
{
    const Quad plain(extension("KHR_materials_ior", R"("ior":1.4)"), "KHR_materials_ior");
    EXPECT_EQ(plain.scene().materials.at(0).layers, nullptr);
    const Quad empty(extension("KHR_materials_specular", R"("specularFactor":1)"), "KHR_materials_specular");
    EXPECT_EQ(empty.scene().materials.at(0).layers, nullptr);
    EXPECT_FALSE(empty.at().layered);
}

TEST(ThinningSurfaces, LetThroughWhatAlphaAndColourLeave)
{
    const Quad blend(R"("alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.25]})",
                     "KHR_materials_unlit");
    const Quad sheet(extension("KHR_materials_transmission", R"("transmissionFactor":1)",
                               R"("metallicFactor":0,"baseColorFactor":[1,0.5,0.25,1])"),
                     "KHR_materials_transmission");
    for (const auto& [quad, expected] :
         {std::pair(&blend, glm::vec3(.75f)), std::pair(&sheet, glm::vec3(1, .5f, .25f))}) {
        EXPECT_TRUE(quad->rays().thins_light());
        ray::RayQueue queue;
        for (int i = 0; i < 40; ++i) queue.push({-.9f + .045f * static_cast<float>(i), .1f, 1}, 0, {0, 0, -2}, 1);
        queue.push({2, 0, 1}, 0, {0, 0, -2}, 1);          // beside it
        queue.push({0.1f, .3f, 1}, 0, {0, 0, -2}, .4f);   // ends before it
        std::vector<glm::vec3> passes(queue.size());
        quad->rays().let_through(queue, 0, queue.size(), passes.data());
        for (std::size_t i = 0; i < 40; ++i) ASSERT_EQ(passes[i], expected) << i;
        EXPECT_EQ(passes[40], glm::vec3(1));
        EXPECT_EQ(passes[41], glm::vec3(1));
        std::uint8_t occluded[64];
        quad->rays().occluded(queue, 0, queue.size(), occluded);
        EXPECT_EQ(occluded[5], 0);
    }
}

TEST(ThinningSurfaces, OpaqueTrianglesOfBlendAreOpaque)
{
    // The left texel is clear, the right one opaque; the left half of the quad reads the left one.
    const Quad mixed(R"("alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorTexture":{"index":0}})",
                     "KHR_materials_unlit", "ffffff00ffffffff");
    EXPECT_EQ(mixed.scene().meshes[0].parts.size(), 1u);   // both triangles read both
    EXPECT_EQ(mixed.scene().materials[mixed.scene().meshes[0].parts[0].material].alpha_mode, scene::AlphaMode::blend);
    const Quad solid(R"("alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorTexture":{"index":0}})",
                     "KHR_materials_unlit", "ffffffffffffffff");
    const auto& part = solid.scene().meshes[0].parts.at(0);
    EXPECT_EQ(solid.scene().materials[part.material].alpha_mode, scene::AlphaMode::opaque);
    EXPECT_FALSE(solid.rays().thins_light() && scene::thins_light(solid.scene().materials[part.material]));

    // One triangle on each side of the texture.
    scene::Scene scene;
    Image8 image(4, 1, 4);
    for (int x = 0; x < 4; ++x)
        for (int c = 0; c < 4; ++c) image.pixel(x, 0)[c] = c < 3 || x >= 2 ? 255 : 100;
    scene.textures.emplace_back("t", image, true, scene::Sampler{scene::Wrap::clamp, scene::Wrap::clamp});
    scene::Material material;
    material.alpha_mode = scene::AlphaMode::blend;
    material.base_color_texture.texture = 0;
    scene.materials.push_back(material);
    scene::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {3, 0, 0}, {2, 1, 0}};
    mesh.texcoords[0] = {{0, 0}, {.3f, 0}, {0, 1}, {.8f, 0}, {1, 0}, {.9f, 1}};
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    mesh.parts = {{0, 0, 2}};
    scene.meshes.push_back(mesh);
    scene::find_solid_blends(scene);
    ASSERT_EQ(scene.meshes[0].parts.size(), 2u);
    EXPECT_EQ(scene.meshes[0].triangles[0], glm::uvec3(3, 4, 5));
    EXPECT_EQ(scene.materials[scene.meshes[0].parts[0].material].alpha_mode, scene::AlphaMode::opaque);
    EXPECT_EQ(scene.materials[scene.meshes[0].parts[1].material].alpha_mode, scene::AlphaMode::blend);
}

// A cube around the origin, outwards or inwards.
scene::Mesh cube(float half, bool inwards, scene::MaterialId material)
{
    scene::Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.positions.push_back(half * glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    if (inwards)
        for (glm::uvec3& t : mesh.triangles) std::swap(t.x, t.y);
    mesh.parts = {{material, 0, 12}};
    return mesh;
}

// @param outer  half the side of the shell, around a cube of 1
std::size_t outlines(float outer, bool inwards, bool double_sided)
{
    scene::Scene scene;
    scene.materials.resize(2);
    scene.materials[1].double_sided = double_sided;
    scene.meshes.push_back(cube(1, false, 0));
    scene.meshes.push_back(cube(outer, inwards, 1));
    for (const scene::MeshId mesh : {0u, 1u}) scene.nodes[scene.add_node("", scene::none)].mesh = mesh;
    const std::size_t found = scene::find_outlines(scene);
    scene.finish();
    const scene::Material& material = scene.materials[scene.meshes[1].parts[0].material];
    EXPECT_EQ(material.outline, found > 0);
    if (found > 0) {
        EXPECT_TRUE(material.one_sided());
        EXPECT_EQ(material.surface_class(), scene::SurfaceClass::transparent);
        EXPECT_FALSE(scene::thins_light(material));
    }
    return found;
}

TEST(Outlines, AreInvertedHullsAroundABodyAndNothingElse)
{
    EXPECT_EQ(outlines(1.04f, true, false), 1u);
    EXPECT_EQ(outlines(1.04f, false, false), 0u);   // looks outwards
    EXPECT_EQ(outlines(1.04f, true, true), 0u);     // seen from both sides
    EXPECT_EQ(outlines(1.5f, true, false), 0u);     // a room around the body
}

}   // namespace
}   // namespace gnomon::shading
