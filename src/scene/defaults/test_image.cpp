// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/test_image.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "base/interruption.h"

namespace gnomon::scene {

namespace {

constexpr double k_looked_up = 64;       // pixels of a box around a triangle above which it is compared with others
constexpr double k_far = 1e6;            // pixels: of corners that lie farther away, crossings are not precise
constexpr float k_see_through = 0.02f;   // alpha below which a blended surface does not count

struct Surface {
    ObjectId object = none;
    std::uint32_t triangle = 0;
    bool seen = false, from_behind = false;
    glm::vec3 corner[3];    // world space
    glm::dvec3 normal{0};   // in the camera's space
};

class Painter {
 public:
    Painter(TestImage& image, const glm::dmat3& axes, double half, double near)
        : image_(image),
          axes_(axes),
          scale_(0.5 * image.side / half),
          near_(near),
          shown_(image.pixels.size()),
          runs_((static_cast<std::size_t>(image.side) + k_run - 1) / k_run),
          farthest_(runs_ * static_cast<std::size_t>(image.side), k_infinity)
    {
    }

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

    /// Computes the positions at the pixels. Call once, after add().
    void finish()
    {
        for (std::size_t at = 0; at < shown_.size(); ++at)
            if (image_.pixels[at].object != none) place(at);
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
        // A surface that lies exactly on one that was drawn changes no pixel. Small ones are drawn faster than found,
        // and those that are hidden need not be found.
        bool looked_up = (high.x - low.x) * (high.y - low.y) <= k_looked_up;
        const double area = (at[1].x - at[0].x) * (at[2].y - at[0].y) - (at[1].y - at[0].y) * (at[2].x - at[0].x);
        if (area == 0 || !std::isfinite(area)) return;
        const auto first = [](double v) { return static_cast<int>(std::ceil(std::max(v, 0.0) - 0.5)); };
        const auto last = [&](double v) { return static_cast<int>(std::floor(std::min(v, side - 0.5) - 0.5)); };
        // A row meets the triangle between the crossings of its sides, one pixel more or less.
        const int left = first(low.x), right = last(high.x);
        const bool is_near = std::max({-low.x, -low.y, high.x, high.y}) < k_far;
        const Plane plane(p, at, area, std::max({-low.x, -low.y, high.x, high.y, static_cast<double>(side)}));
        for (int y = first(low.y); y <= last(high.y); ++y) {
            double from = left, to = right;
            for (int i = 0; i < 3; ++i) {
                const glm::dvec2 &b = at[(i + 1) % 3], &c = at[(i + 2) % 3];
                const double rise = c.y - b.y;
                const double crossing = b.x + (c.x - b.x) * (y + 0.5 - b.y) / rise - 0.5;
                if (!is_near || !std::isfinite(crossing)) continue;
                ((rise > 0) == (area > 0) ? to : from) =
                    (rise > 0) == (area > 0) ? std::min(to, crossing + 1) : std::max(from, crossing - 1);
            }
            const int end = static_cast<int>(to);
            for (int x = static_cast<int>(from); x <= end; ++x) {
                const glm::dvec2 centre(x + 0.5, y + 0.5);
                if (is_near && x % k_run == 0 && x + k_run - 1 <= end && is_run_hidden(x, y, plane)) {
                    x += k_run - 1;
                    continue;
                }
                const std::size_t pixel = static_cast<std::size_t>(y) * side + x;
                if (is_near && is_hidden(pixel, plane.most_at(centre), surface.seen)) continue;
                double twice[3];   // the areas of three triangles with the centre as a corner
                bool inside = true;
                for (int i = 0; i < 3; ++i) {
                    const glm::dvec2 &b = at[(i + 1) % 3], &c = at[(i + 2) % 3];
                    twice[i] = (c.x - b.x) * (centre.y - b.y) - (c.y - b.y) * (centre.x - b.x);
                    inside = inside & (area > 0 ? twice[i] >= 0 : twice[i] <= 0);
                }
                if (!inside) continue;
                double reciprocal = 0;
                for (int i = 0; i < 3; ++i) reciprocal -= twice[i] / area / p[i].z;
                if (!(reciprocal > 0)) continue;
                if (!looked_up && !drawn_.insert({p, surface.seen, surface.object})) return;
                looked_up = true;
                put(pixel, 1 / reciprocal, whole, surface);
            }
        }
    }

    // A bound of the reciprocal of a triangle's depth, by pixel: it rises evenly over the image.
    class Plane {
     public:
        /// @param extent  no coordinate in the image exceeds it
        Plane(const std::array<glm::dvec3, 3>& p, const glm::dvec2 (&at)[3], double area, double extent)
        {
            constexpr double k_rounding = 4e-13;   // of the products of coordinates below, many times over
            double nearest = k_infinity;
            for (int i = 0; i < 3; ++i) {
                const glm::dvec2 &b = at[(i + 1) % 3], &c = at[(i + 2) % 3];
                rise_ += glm::dvec2(c.y - b.y, b.x - c.x) / (area * p[i].z);
                nearest = std::min(nearest, -p[i].z);
            }
            from_ = at[0];
            most_ = -1 / p[0].z + k_rounding * (extent * extent / std::abs(area) + 1) / nearest;
        }
        double most_at(const glm::dvec2& centre) const { return most_ + glm::dot(rise_, centre - from_); }

     private:
        glm::dvec2 rise_{0}, from_{0};
        double most_ = 0;
    };

    // Whether put() has no effect, because what was drawn is nearer.
    bool is_hidden(std::size_t at, double most_reciprocal, bool seen) const
    {
        const TestPixel& pixel = image_.pixels[at];
        const float drawn = seen ? std::max(pixel.first, pixel.depth) : pixel.first;
        return most_reciprocal * static_cast<double>(drawn) < k_nearer;
    }
    // The same for all of k_run pixels of a row, from x on.
    bool is_run_hidden(int x, int y, const Plane& plane) const
    {
        const double most = std::max(plane.most_at({x + 0.5, y + 0.5}), plane.most_at({x + k_run - 0.5, y + 0.5}));
        return most * static_cast<double>(farthest_[run_of(x, y)]) < k_nearer;
    }
    std::size_t run_of(int x, int y) const
    {
        return static_cast<std::size_t>(y) * runs_ + static_cast<std::size_t>(x / k_run);
    }
    // Notes how far what was drawn is at the farthest in the run of a pixel.
    void measure_run(std::size_t at)
    {
        const auto side = static_cast<std::size_t>(image_.side);
        const std::size_t y = at / side, first = at % side / k_run * k_run;
        float farthest = 0;
        for (std::size_t x = first; x < std::min(first + k_run, side); ++x) {
            const TestPixel& pixel = image_.pixels[y * side + x];
            farthest = std::max({farthest, pixel.first, pixel.depth});
        }
        farthest_[y * runs_ + first / k_run] = farthest;
    }

    // Of equally near surfaces, that of the first object is shown.
    void put(std::size_t at, double depth, const glm::dvec3 (&p)[3], const Surface& surface)
    {
        TestPixel& pixel = image_.pixels[at];
        const auto far = static_cast<float>(depth);
        pixel.first = std::min(pixel.first, far);
        show(pixel, at, far, depth, p, surface);
        measure_run(at);
    }
    void show(TestPixel& pixel, std::size_t at, float far, double depth, const glm::dvec3 (&p)[3],
              const Surface& surface)
    {
        if (!surface.seen || !(far < pixel.depth || (far == pixel.depth && surface.object < pixel.object))) return;
        pixel.depth = far;
        pixel.object = surface.object, pixel.triangle = surface.triangle, pixel.from_behind = surface.from_behind;
        pixel.normal = glm::vec3(axes_ * surface.normal);
        Shown& shown = shown_[at];
        shown.depth = depth;
        for (int i = 0; i < 3; ++i) shown.p[i] = p[i], shown.corner[i] = surface.corner[i];
    }

    // The point of a triangle that a pixel shows, from its coordinates in the camera's space.
    void place(std::size_t at)
    {
        const auto side = static_cast<std::size_t>(image_.side);
        const std::size_t row = at / side;
        const glm::dvec2 centre(static_cast<double>(at % side) + 0.5, static_cast<double>(row) + 0.5);
        const auto& [p, corner, depth] = shown_[at];
        const glm::dvec3 point((centre.x - 0.5 * image_.side) / scale_ * depth,
                               (0.5 * image_.side - centre.y) / scale_ * depth, -depth);
        const glm::dvec3 e1 = p[1] - p[0], e2 = p[2] - p[0], n = glm::cross(e1, e2), d = point - p[0];
        const double square = glm::dot(n, n);
        if (!(square > 0)) return;
        const auto u = static_cast<float>(std::clamp(glm::dot(glm::cross(d, e2), n) / square, 0.0, 1.0));
        const auto v = static_cast<float>(std::clamp(glm::dot(glm::cross(e1, d), n) / square, 0.0, 1.0));
        image_.pixels[at].position = corner[0] + u * (corner[1] - corner[0]) + v * (corner[2] - corner[0]);
    }

    struct Shown {
        glm::dvec3 p[3];       // in the camera's space
        glm::vec3 corner[3];   // world space
        double depth = 0;
    };
    struct Drawn {
        std::array<glm::dvec3, 3> p;
        bool seen = false;
        ObjectId object = none;   // the first that was drawn
        bool is_like(const Drawn& other) const { return p == other.p && seen == other.seen; }
    };
    // A set of them: indices in a list, by hash, with linear probing. One of an earlier object takes the place of
    // another.
    class DrawnSet {
     public:
        bool insert(const Drawn& drawn)
        {
            if (2 * (list_.size() + 1) > slots_.size()) grow();
            const std::uint64_t hash = hash_of(drawn);
            for (std::size_t slot = hash & (slots_.size() - 1);; slot = (slot + 1) & (slots_.size() - 1)) {
                if (slots_[slot] == none) {
                    slots_[slot] = static_cast<std::uint32_t>(list_.size());
                    list_.emplace_back(hash, drawn);
                    return true;
                }
                auto& [other_hash, other] = list_[slots_[slot]];
                if (other_hash != hash || !other.is_like(drawn)) continue;
                if (other.object <= drawn.object) return false;
                other.object = drawn.object;
                return true;
            }
        }

     private:
        static std::uint64_t hash_of(const Drawn& drawn)
        {
            std::uint64_t hash = drawn.seen;
            for (const glm::dvec3& corner : drawn.p)
                for (int c = 0; c < 3; ++c) {
                    hash = (hash ^ std::bit_cast<std::uint64_t>(corner[c] + 0.0)) * 0x9e3779b97f4a7c15u;   // -0 is 0
                    hash ^= hash >> 29;
                }
            return hash;
        }
        void grow()
        {
            slots_.assign(std::max<std::size_t>(2 * slots_.size(), 1024), none);
            for (std::size_t i = 0; i < list_.size(); ++i) {
                std::size_t slot = list_[i].first & (slots_.size() - 1);
                while (slots_[slot] != none) slot = (slot + 1) & (slots_.size() - 1);
                slots_[slot] = static_cast<std::uint32_t>(i);
            }
        }
        std::vector<std::pair<std::uint64_t, Drawn>> list_;
        std::vector<std::uint32_t> slots_;
    };

    static constexpr int k_run = 8;   // pixels of a row that are found hidden together
    static constexpr double k_nearer = 1 - 1e-6;

    TestImage& image_;
    const glm::dmat3& axes_;
    double scale_, near_;
    std::vector<Shown> shown_;   // by pixel with an object
    std::size_t runs_;           // of a row
    std::vector<float> farthest_;
    DrawnSet drawn_;
};

const std::vector<glm::vec3>& positions_of(const SceneState& state, ObjectId id)
{
    const Object& object = state.scene().objects[id];
    return object.deforming ? state.deformed(id).positions : state.scene().meshes[object.mesh].positions;
}

// The visible objects, the nearest first, as far as their first vertices say: what is drawn hides most of what follows.
std::vector<ObjectId> from_front(const SceneState& state, const glm::dmat3& to_camera, const glm::dvec3& eye)
{
    std::vector<std::pair<double, ObjectId>> order;
    for (ObjectId id = 0; id < state.scene().objects.size(); ++id) {
        if (!state.object_visible(id)) continue;
        const std::vector<glm::vec3>& positions = positions_of(state, id);
        if (positions.empty()) continue;
        const glm::dvec3 first(transform_point(state.object_matrix(id), positions.front()));
        const double depth = -(to_camera * (first - eye)).z;
        order.emplace_back(std::isfinite(depth) ? depth : 0.0, id);
    }
    std::sort(order.begin(), order.end());
    std::vector<ObjectId> result;
    for (const auto& [depth, id] : order) result.push_back(id);
    return result;
}

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
    Painter painter(image, axes, std::tan(options.vertical_fov / 2), options.near);
    const glm::dmat3 to_camera = glm::transpose(axes);
    const Scene& scene = state.scene();
    std::vector<glm::vec3> at;
    std::vector<glm::dvec3> from_camera;
    for (const ObjectId id : from_front(state, to_camera, eye)) {
        interruption_point();
        const Object& object = scene.objects[id];
        const Mesh& mesh = scene.meshes[object.mesh];
        const std::vector<glm::vec3>& positions = positions_of(state, id);
        const glm::mat4 world = state.object_matrix(id);
        const bool mirrored = glm::determinant(glm::mat3(world)) < 0;
        at.resize(positions.size());
        from_camera.resize(positions.size());
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
                surface.normal = cross / (glm::dot(cross, p[0]) < 0 ? length : -length);
                for (int c = 0; c < 3; ++c) surface.corner[c] = at[index[c]];
                painter.add(p, surface);
            }
        }
    }
    painter.finish();
    return image;
}

}   // namespace gnomon::scene
