// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>

#include "base/interruption.h"
#include "scene/file_surfaces.h"
#include "scene/value_tracks.h"

namespace gnomon::scene {

namespace {

// Counts the texels of a texture's finest level that are not opaque, within rectangles.
class Holes {
 public:
    explicit Holes(const Texture& texture)
        : width_(texture.width()), height_(texture.height()), sampler_(texture.sampler())
    {
        const Image8& level = texture.levels().front();
        any_ = texture.has_alpha();
        if (!any_) return;
        const auto row = static_cast<std::size_t>(width_) + 1;
        sums_.assign(row * (static_cast<std::size_t>(height_) + 1), 0);
        for (int y = 0; y < height_; ++y) {
            std::uint32_t sum = 0;
            for (int x = 0; x < width_; ++x) {
                sum += level.pixel(x, y)[3] != 255;
                sums_[row * static_cast<std::size_t>(y + 1) + static_cast<std::size_t>(x + 1)] =
                    sums_[row * static_cast<std::size_t>(y) + static_cast<std::size_t>(x + 1)] + sum;
            }
        }
        any_ = sums_.back() > 0;
    }
    bool any() const { return any_; }
    // Whether a filter may read such a texel between two corners of a box of coordinates.
    bool between(const glm::vec2& low, const glm::vec2& high) const
    {
        if (!any_) return false;
        const auto [x0, x1] = texels(low.x, high.x, width_, sampler_.wrap_u);
        const auto [y0, y1] = texels(low.y, high.y, height_, sampler_.wrap_v);
        // A range that crosses the border is two.
        for (const auto& [left, right] : pieces(x0, x1, width_))
            for (const auto& [top, bottom] : pieces(y0, y1, height_))
                if (count(left, top, right, bottom) > 0) return true;
        return false;
    }

 private:
    using Range = std::pair<int, int>;   // first, past the last
    static Range texels(float low, float high, int size, Wrap wrap)
    {
        const double a = std::floor(static_cast<double>(low) * size - 0.5),
                     b = std::ceil(static_cast<double>(high) * size + 0.5);
        if (!(b - a < size) || !(std::abs(a) < 1e9)) return {0, size};
        if (wrap == Wrap::clamp) {
            const int first = std::clamp(static_cast<int>(a), 0, size - 1);
            return {first, std::max(first, std::clamp(static_cast<int>(b), 0, size - 1)) + 1};
        }
        if (wrap == Wrap::mirror && (a < 0 || b >= size)) return {0, size};
        const double period = std::floor(a / size) * size;
        return {static_cast<int>(a - period), static_cast<int>(b - period) + 1};
    }
    static std::vector<Range> pieces(int first, int past, int size)
    {
        if (past <= size) return {{first, past}};
        return {{first, size}, {0, std::min(past - size, size)}};
    }
    std::uint32_t count(int left, int top, int right, int bottom) const
    {
        const auto at = [&](int x, int y) {
            return sums_[(static_cast<std::size_t>(width_) + 1) * static_cast<std::size_t>(y) +
                         static_cast<std::size_t>(x)];
        };
        return at(right, bottom) - at(left, bottom) - at(right, top) + at(left, top);
    }

    int width_, height_;
    Sampler sampler_;
    bool any_ = false;
    std::vector<std::uint32_t> sums_;   // of texels above and to the left
};

}   // namespace

void find_solid_blends(Scene& scene, const std::vector<bool>& keep)
{
    std::map<TextureId, Holes> holes;
    std::map<MaterialId, MaterialId> opaque;
    const auto opaque_copy = [&](MaterialId id) {
        const auto [known, fresh] = opaque.try_emplace(id, static_cast<MaterialId>(scene.materials.size()));
        if (fresh) {
            Material copy = scene.materials[id];
            copy.alpha_mode = AlphaMode::opaque;
            scene.materials.push_back(std::move(copy));
        }
        return known->second;
    };
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        const Mesh& mesh = scene.meshes[m];
        // Mark the triangles of this mesh that are opaque.
        std::vector<bool> solid;
        for (const MeshPart& part : mesh.parts) {
            const Material& material = scene.materials[part.material];
            if (material.alpha_mode != AlphaMode::blend || material.alpha < 1) continue;
            if (material.track && material.track->alpha_changes) continue;
            if (part.material < keep.size() && keep[part.material]) continue;
            interruption_point();
            const TextureUse& use = material.base_color_texture;
            const bool textured = use.used() && !mesh.texcoords[use.texcoord].empty();
            const Holes* of_texture = nullptr;
            if (textured) of_texture = &holes.try_emplace(use.texture, scene.textures[use.texture]).first->second;
            for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
                const glm::uvec3 index = mesh.triangles[t];
                if (!mesh.colors.empty() &&
                    std::min({mesh.colors[index[0]].w, mesh.colors[index[1]].w, mesh.colors[index[2]].w}) < 1)
                    continue;
                if (of_texture && of_texture->any()) {
                    const auto& at = mesh.texcoords[use.texcoord];
                    const glm::vec2 a = use.apply(at[index[0]]), b = use.apply(at[index[1]]),
                                    c = use.apply(at[index[2]]);
                    if (of_texture->between(glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c)))) continue;
                }
                if (solid.empty()) solid.resize(mesh.triangles.size());
                solid[t] = true;
            }
        }
        if (solid.empty()) continue;

        // Divide the parts, opaque triangles first.
        std::vector<MeshPart> parts;
        std::vector<glm::uvec3> triangles;
        triangles.reserve(mesh.triangles.size());
        for (const MeshPart& part : mesh.parts)
            for (const bool wanted : {true, false}) {
                MeshPart piece = part;
                piece.first_triangle = static_cast<std::uint32_t>(triangles.size());
                for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
                    if (solid[t] == wanted) triangles.push_back(mesh.triangles[t]);
                piece.triangle_count = static_cast<std::uint32_t>(triangles.size()) - piece.first_triangle;
                if (wanted && piece.triangle_count > 0) piece.material = opaque_copy(part.material);
                if (piece.triangle_count > 0) parts.push_back(piece);
            }
        Mesh& edited = scene.meshes.edit(m);
        edited.parts = std::move(parts);
        edited.triangles = std::move(triangles);
    }
}

}   // namespace gnomon::scene
