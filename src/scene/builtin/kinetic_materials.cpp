// SPDX-License-Identifier: Apache-2.0
#include "scene/builtin/kinetic.h"
#include "scene/builtin/patterns.h"

namespace gnomon::scene::kinetic {

namespace {

// Fraction of a clear sky that is seen from the middle of the yard; walls and trees hide the rest.
constexpr float k_sky_over_yard = 0.58f;

class Palette {
 public:
    explicit Palette(Scene& scene) : scene_(scene)
    {
        // The ramp that turns texture coordinate 1 into shade from the sky (shapes.h); clamped, since 1 is not 0.
        Sampler clamp;
        clamp.wrap_u = clamp.wrap_v = Wrap::clamp;
        clamp.mipmaps = false;
        ramp_ = texture("sky seen", ramp_pattern(k_sky_over_yard), clamp, false);
    }

    TextureId texture(const char* name, const Image8& image, Sampler sampler = {}, bool srgb = true)
    {
        scene_.textures.emplace_back(name, image, srgb, sampler);
        return static_cast<TextureId>(scene_.textures.size() - 1);
    }

    MaterialId add(const char* name, const glm::vec3& color, float roughness, float metallic = 0)
    {
        Material m;
        m.name = name;
        m.base_color = color;
        m.roughness = roughness;
        m.metallic = metallic;
        m.occlusion_texture.texture = ramp_;
        m.occlusion_texture.texcoord = 1;
        scene_.materials.push_back(m);
        return static_cast<MaterialId>(scene_.materials.size() - 1);
    }
    /// /// @param repeats  of the texture, per metre
    MaterialId textured(const char* name, TextureId image, float repeats, float roughness,
                        const glm::vec3& color = glm::vec3(1))
    {
        const MaterialId id = add(name, color, roughness);
        scene_.materials[id].base_color_texture.texture = image;
        scene_.materials[id].base_color_texture.scale = glm::vec2(repeats);
        return id;
    }
    MaterialId leaf(const char* name, const glm::vec3& color, float roughness = 0.5f)
    {
        const MaterialId id = add(name, color, roughness);
        scene_.materials[id].double_sided = true;
        return id;
    }
    MaterialId glass(const char* name, const glm::vec3& color)
    {
        const MaterialId id = add(name, color, 0);
        scene_.materials[id].transmission = 1;
        scene_.materials[id].ior = 1.5f;
        return id;
    }
    MaterialId unlit(const char* name, const glm::vec3& color)
    {
        const MaterialId id = add(name, color, 1);
        scene_.materials[id].model = ShadingModel::unlit;
        return id;
    }

 private:
    Scene& scene_;
    TextureId ramp_ = none;
};

}   // namespace

Materials add_materials(Scene& scene)
{
    Palette palette(scene);
    const TextureId stone =
        palette.texture("limestone", stone_pattern(512, {0.72f, 0.64f, 0.52f}, {0.56f, 0.48f, 0.37f}, 0.45f, 11));
    const TextureId flag =
        palette.texture("flagstone", stone_pattern(512, {0.52f, 0.45f, 0.37f}, {0.36f, 0.31f, 0.26f}, 0.35f, 23));
    const TextureId wall = palette.texture("plaster", plaster_pattern(384, {0.80f, 0.57f, 0.36f}, 37));
    const TextureId marble = palette.texture("marble", marble_pattern(256, 41));
    const TextureId clay =
        palette.texture("terracotta", stone_pattern(256, {0.58f, 0.24f, 0.12f}, {0.42f, 0.16f, 0.08f}, 0.15f, 53));
    Sampler once;
    once.wrap_u = once.wrap_v = Wrap::clamp;
    const TextureId dial = palette.texture("dial", dial_pattern(640), once);

    Materials m{};
    m.limestone = palette.textured("limestone", stone, 0.55f, 0.85f);
    m.paving = palette.textured("paving", flag, 0.6f, 0.6f);
    m.plaster = palette.textured("plaster", wall, 0.28f, 0.95f);
    m.marble = palette.textured("marble", marble, 0.7f, 0.35f);
    m.dial = palette.textured("dial", dial, 1, 0.45f);
    m.terracotta = palette.textured("terracotta", clay, 1.1f, 0.75f);
    m.roof = palette.textured("roof tiles", clay, 0.9f, 0.8f, {1.0f, 0.92f, 0.85f});
    scene.materials[m.roof].double_sided = true;
    m.iron = palette.add("iron", {0.05f, 0.05f, 0.055f}, 0.5f);
    m.bronze = palette.add("bronze", {0.62f, 0.37f, 0.16f}, 0.32f, 1);
    m.gold = palette.add("gold", {1.0f, 0.73f, 0.30f}, 0.18f, 1);
    m.mirror = palette.add("mirror", {0.93f, 0.94f, 0.95f}, 0, 1);
    m.water = palette.add("water", {0.50f, 0.57f, 0.60f}, 0, 1);
    m.pool_floor = palette.add("pool tiles", {0.06f, 0.16f, 0.20f}, 0.4f);
    m.glass = palette.glass("glass", {0.97f, 0.99f, 0.98f});
    m.amber_glass = palette.glass("amber glass", {1.0f, 0.62f, 0.18f});
    m.blue_glass = palette.glass("blue glass", {0.35f, 0.65f, 1.0f});
    m.red = palette.add("red paint", {0.72f, 0.045f, 0.03f}, 0.35f);
    m.black = palette.add("black paint", {0.03f, 0.03f, 0.035f}, 0.35f);
    m.yellow = palette.add("yellow paint", {0.90f, 0.56f, 0.04f}, 0.35f);
    m.blue = palette.add("blue paint", {0.04f, 0.14f, 0.50f}, 0.35f);
    m.white = palette.add("white paint", {0.82f, 0.80f, 0.76f}, 0.35f);
    m.bark = palette.add("bark", {0.20f, 0.14f, 0.09f}, 0.95f);
    m.soil = palette.add("soil", {0.07f, 0.05f, 0.035f}, 1);
    m.ivy = palette.leaf("ivy", {0.10f, 0.24f, 0.055f});
    m.orange_leaf = palette.leaf("orange leaf", {0.10f, 0.27f, 0.05f}, 0.38f);
    m.box_leaf = palette.leaf("box leaf", {0.13f, 0.29f, 0.07f});
    m.cypress = palette.leaf("cypress", {0.055f, 0.13f, 0.05f}, 0.7f);
    m.olive = palette.leaf("olive leaf", {0.20f, 0.25f, 0.14f}, 0.55f);
    m.lily = palette.leaf("lily pad", {0.12f, 0.24f, 0.06f}, 0.35f);
    m.blossom = palette.leaf("blossom", {0.62f, 0.05f, 0.30f}, 0.6f);
    m.orange = palette.add("orange", {0.95f, 0.36f, 0.03f}, 0.4f);
    // The light of a flame is a point light within it; the flame itself shows its colour.
    m.flame = palette.unlit("flame", {14.0f, 8.0f, 3.2f});
    m.grass = palette.add("meadow", {0.20f, 0.22f, 0.08f}, 1);
    m.hill_near = palette.unlit("near hills", {0.26f, 0.32f, 0.33f});
    m.hill_far = palette.unlit("far hills", {0.42f, 0.50f, 0.58f});
    return m;
}

float open_sky(const glm::vec3& p, const glm::vec3& n)
{
    const auto fade = [](float low, float high, float x) {
        const float t = glm::clamp((x - low) / (high - low), 0.0f, 1.0f);
        return t * t * (3 - 2 * t);
    };
    float seen = 1;
    // Under a roof, sky light comes in through the arches and decreases with the distance from them.
    const float behind_back = k_back_z - p.z, behind_right = p.x - k_right_x;
    const float behind = glm::max(behind_back, behind_right);
    if (behind > -0.3f && p.y < k_eaves) {
        const float depth = fade(-0.3f, k_arcade_depth, behind);
        const float height = fade(k_springing - 0.6f, k_eaves, p.y);
        seen *= glm::mix(1.0f, 0.30f - 0.13f * height, depth);
    } else if (behind <= -0.3f && p.y < k_eaves) {
        // Before the arcade, its wall hides a part of the sky.
        seen *= 1 - 0.22f * (1 - fade(0.0f, 3.0f, -behind)) * (1 - p.y / k_eaves);
    }
    // Darken surfaces that face down, and contacts with the ground.
    if (n.y < 0) seen *= 1 + 0.35f * n.y;
    if (n.y < 0.6f) seen *= 0.72f + 0.28f * fade(0.0f, 0.5f, p.y);
    return seen;
}

}   // namespace gnomon::scene::kinetic
