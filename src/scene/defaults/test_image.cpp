// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/test_image.h"

#include <algorithm>
#include <array>
#include <functional>
#include <unordered_set>

#include "base/interruption.h"

namespace gnomon::scene {

namespace {

constexpr double k_looked_up = 64;       // pixels of a box around a triangle above which it is compared with others
constexpr float k_see_through = 0.02f;   // alpha below which a blended surface does not count

struct Surface {
    ObjectId object = none;
    std::uint32_t triangle = 0;
    bool seen = false, from_behind = false;
    glm::vec3 corner[3];   // world space
    glm::vec3 normal{0};
};

class Painter {
 public:
    Painter(TestImage& image, double half, double near) : image_(image), scale_(0.5 * image.side / half), near_(near) {}

    /// @param p  right, up, back of each corner
    void add(const glm::dvec3 (&p)[3], const Surface& surface)
    {
        // Clip at the near plane: at most four corners are left.
        glm::dvec3 kept[4];
        int count = 0;
        for (int i = 0; i < 3; ++i) {
            const glm::dvec3 &a = p[i], &b = p[(i + 1) % 3];
            const double da = -a.z - near_, db = -b.z - near_;
            if (da >= 0) kept[count++] = a;
            if ((da >= 0) != (db >= 0)) kept[count++] = a + (da / (da - db)) * (b - a);
        }
        for (int i = 2; i < count; ++i) fill({kept[0], kept[i - 1], kept[i]}, p, surface);
    }

 private:
    void fill(const std::array<glm::dvec3, 3>& p, const glm::dvec3 (&whole)[3], const Surface& surface)
    {
        const int side = image_.side;
        glm::dvec2 at[3];
        glm::dvec2 low(side), high(0);
        for (int i = 0; i < 3; ++i) {
            at[i] = 0.5 * side + scale_ * glm::dvec2(p[i].x, -p[i].y) / -p[i].z;
            low = glm::min(low, at[i]), high = glm::max(high, at[i]);
        }
        // A surface that lies exactly on one that was drawn changes no pixel. Small ones are drawn faster than found.
        if ((high.x - low.x) * (high.y - low.y) > k_looked_up && !drawn_.insert({p, surface.seen}).second) return;
        const double area = (at[1].x - at[0].x) * (at[2].y - at[0].y) - (at[1].y - at[0].y) * (at[2].x - at[0].x);
        if (area == 0 || !std::isfinite(area)) return;
        const auto first = [](double v) { return static_cast<int>(std::ceil(std::max(v, 0.0) - 0.5)); };
        const auto last = [&](double v) { return static_cast<int>(std::floor(std::min(v, side - 0.5) - 0.5)); };
        for (int y = first(low.y); y <= last(high.y); ++y)
            for (int x = first(low.x); x <= last(high.x); ++x) {
                const glm::dvec2 centre(x + 0.5, y + 0.5);
                double weight[3], reciprocal = 0;
                bool inside = true;
                for (int i = 0; i < 3; ++i) {
                    const glm::dvec2 &b = at[(i + 1) % 3], &c = at[(i + 2) % 3];
                    weight[i] = ((c.x - b.x) * (centre.y - b.y) - (c.y - b.y) * (centre.x - b.x)) / area;
                    inside = inside && weight[i] >= 0;
                    reciprocal -= weight[i] / p[i].z;
                }
                if (inside && reciprocal > 0)
                    put(image_.pixels[static_cast<std::size_t>(y) * side + x], 1 / reciprocal, centre, whole, surface);
            }
    }

    void put(TestPixel& pixel, double depth, const glm::dvec2& centre, const glm::dvec3 (&p)[3],
             const Surface& surface) const
    {
        const auto far = static_cast<float>(depth);
        pixel.first = std::min(pixel.first, far);
        if (!surface.seen || !(far < pixel.depth)) return;
        pixel.depth = far;
        pixel.object = surface.object, pixel.triangle = surface.triangle, pixel.from_behind = surface.from_behind;
        pixel.normal = surface.normal;
        // The point on the triangle, from its coordinates in the camera's space.
        const glm::dvec3 point((centre.x - 0.5 * image_.side) / scale_ * depth,
                               (0.5 * image_.side - centre.y) / scale_ * depth, -depth);
        const glm::dvec3 e1 = p[1] - p[0], e2 = p[2] - p[0], n = glm::cross(e1, e2), d = point - p[0];
        const double square = glm::dot(n, n);
        if (!(square > 0)) return;
        const auto u = static_cast<float>(std::clamp(glm::dot(glm::cross(d, e2), n) / square, 0.0, 1.0));
        const auto v = static_cast<float>(std::clamp(glm::dot(glm::cross(e1, d), n) / square, 0.0, 1.0));
        pixel.position = surface.corner[0] + u * (surface.corner[1] - surface.corner[0]) +
                         v * (surface.corner[2] - surface.corner[0]);
    }

    struct Drawn {
        std::array<glm::dvec3, 3> p;
        bool seen = false;
        bool operator==(const Drawn&) const = default;
    };
    struct HashOfDrawn {
        std::size_t operator()(const Drawn& drawn) const
        {
            std::size_t hash = drawn.seen;
            for (const glm::dvec3& corner : drawn.p)
                for (int c = 0; c < 3; ++c) hash = hash * 0x9e3779b97f4a7c15u ^ std::hash<double>()(corner[c]) >> 7;
            return hash;
        }
    };

    TestImage& image_;
    double scale_, near_;
    std::unordered_set<Drawn, HashOfDrawn> drawn_;
};

}   // namespace

float TestImage::shown() const
{
    const auto count = std::count_if(pixels.begin(), pixels.end(), [](const TestPixel& p) { return p.object != none; });
    return pixels.empty() ? 0 : static_cast<float>(count) / static_cast<float>(pixels.size());
}

float TestImage::shown_of_all() const
{
    int all = 0, seen = 0;
    for (const TestPixel& p : pixels) all += p.first < k_infinity, seen += p.object != none && p.depth == p.first;
    return all > 0 ? static_cast<float>(seen) / static_cast<float>(all) : 1;
}

TestImage draw_test_image(const SceneState& state, const glm::dvec3& eye, const glm::dmat3& axes,
                          const TestImageOptions& options)
{
    TestImage image;
    image.side = options.side;
    image.pixels.resize(static_cast<std::size_t>(options.side) * static_cast<std::size_t>(options.side));
    Painter painter(image, std::tan(options.vertical_fov / 2), options.near);
    const glm::dmat3 to_camera = glm::transpose(axes);
    const Scene& scene = state.scene();
    for (ObjectId id = 0; id < scene.objects.size(); ++id) {
        interruption_point();
        if (!state.object_visible(id)) continue;
        const Object& object = scene.objects[id];
        const Mesh& mesh = scene.meshes[object.mesh];
        const std::vector<glm::vec3>& positions = object.deforming ? state.deformed(id).positions : mesh.positions;
        const glm::mat4 world = state.object_matrix(id);
        const bool mirrored = glm::determinant(glm::mat3(world)) < 0;
        std::vector<glm::vec3> at(positions.size());
        std::vector<glm::dvec3> from_camera(positions.size());
        for (std::size_t v = 0; v < positions.size(); ++v) {
            at[v] = transform_point(world, positions[v]);
            from_camera[v] = to_camera * (glm::dvec3(at[v]) - eye);
        }
        for (const MeshPart& part : mesh.parts) {
            const Material& material = scene.materials[part.material];
            if (material.alpha_mode == AlphaMode::blend && material.alpha < k_see_through) continue;
            if (!options.glass && material.surface_class() == SurfaceClass::transparent) continue;
            for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
                const glm::uvec3& index = mesh.triangles[t];
                const glm::dvec3 p[3] = {from_camera[index[0]], from_camera[index[1]], from_camera[index[2]]};
                const glm::dvec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
                const double length = glm::length(cross);
                if (!(length > 0) || !std::isfinite(length)) continue;
                const bool faces = (glm::dot(cross, p[0]) < 0) != mirrored;
                Surface surface;
                surface.object = id, surface.triangle = t;
                surface.seen = faces || !material.one_sided();
                surface.from_behind = !faces;
                surface.normal = glm::vec3(axes * (cross / (glm::dot(cross, p[0]) < 0 ? length : -length)));
                for (int c = 0; c < 3; ++c) surface.corner[c] = at[index[c]];
                painter.add(p, surface);
            }
        }
    }
    return image;
}

}   // namespace gnomon::scene
