// SPDX-License-Identifier: Apache-2.0
#include "scene/sized_light.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "base/interruption.h"
#include "base/morton.h"

namespace gnomon::scene {

namespace {

constexpr int k_looks = 4;                        // a side of a cell, or of a face without cells, at which a texture is looked up
constexpr std::uint32_t k_most_joined = 1 << 14;  // triangles of a part, beyond which none are joined
constexpr float k_flat = 2e-6f;                   // joined triangles: largest distance from their plane, per diameter
constexpr float k_even = 1e-3f;                   // cells that differ by no more than this fraction count as one

std::uint32_t reversed_bits(std::uint32_t x)
{
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

// The second dimension of the (0, 2)-sequence: the matrix of binomial coefficients modulo 2.
std::uint32_t second_dimension(std::uint32_t i)
{
    std::uint32_t result = 0;
    for (std::uint32_t column = 1u << 31; i; i >>= 1, column ^= column >> 1)
        if (i & 1) result ^= column;
    return result;
}

float unit(std::uint32_t bits)
{
    return static_cast<float>(bits >> 8) * 0x1p-24f;
}

// The emission of one triangle's material along its surface.
class Emission {
 public:
    Emission(const Scene& scene, const Mesh& mesh, const Material& material)
        : scene_(scene), mesh_(mesh), material_(material)
    {
        const auto has = [&](const TextureUse& use) { return use.used() && !mesh.texcoords[use.texcoord].empty(); };
        textured_ = has(material.emissive_texture);
        const bool thins = material.alpha_mode != AlphaMode::opaque;
        alpha_textured_ = thins && has(material.base_color_texture);
        alpha_varies_ = thins && (alpha_textured_ || !mesh.colors.empty());
    }
    bool varies() const { return textured_ || alpha_varies_; }

    /// @param step  the width of the look-up, as a fraction of the triangle's edges
    glm::vec3 at(std::uint32_t triangle, float u, float v, float step) const
    {
        glm::vec3 radiance = material_.emissive;
        const glm::uvec3 index = mesh_.triangles[triangle];
        if (textured_) radiance *= glm::vec3(look_up(material_.emissive_texture, index, u, v, step));
        if (material_.alpha_mode == AlphaMode::opaque) return radiance;
        float alpha = material_.alpha;
        if (!mesh_.colors.empty())
            alpha *= (1 - u - v) * mesh_.colors[index[0]].w + u * mesh_.colors[index[1]].w + v * mesh_.colors[index[2]].w;
        if (alpha_textured_) alpha *= look_up(material_.base_color_texture, index, u, v, step).w;
        if (material_.alpha_mode == AlphaMode::blend) return radiance * std::clamp(alpha, 0.0f, 1.0f);
        return alpha >= material_.alpha_cutoff ? radiance : glm::vec3(0);
    }

 private:
    glm::vec4 look_up(const TextureUse& use, const glm::uvec3& index, float u, float v, float step) const
    {
        const auto& t = mesh_.texcoords[use.texcoord];
        const Texture& texture = scene_.textures[use.texture];
        const glm::vec2 here = use.apply((1 - u - v) * t[index[0]] + u * t[index[1]] + v * t[index[2]]);
        const glm::vec2 origin = use.apply(t[index[0]]);
        const float length = std::max(glm::length(use.apply(t[index[1]]) - origin),
                                      glm::length(use.apply(t[index[2]]) - origin));
        return texture.sample(here, length * step * static_cast<float>(std::max(texture.width(), texture.height())));
    }

    const Scene& scene_;
    const Mesh& mesh_;
    const Material& material_;
    bool textured_, alpha_textured_, alpha_varies_;
};

// The corners of a triangle in world space, counter-clockwise seen from the front.
struct Corners {
    glm::vec3 p[3];
    bool swapped = false;   // p[1] and p[2] are the mesh's third and second corner
};

// Barycentric coordinates (of p[1] and p[2]) of a point in the plane of a triangle.
glm::vec2 barycentric(const glm::vec3 (&p)[3], const glm::vec3& x)
{
    const glm::dvec3 a(p[1] - p[0]), b(p[2] - p[0]), c(x - p[0]);
    const double aa = glm::dot(a, a), ab = glm::dot(a, b), bb = glm::dot(b, b), ca = glm::dot(c, a), cb = glm::dot(c, b);
    const double determinant = aa * bb - ab * ab;
    if (!(determinant > 0)) return glm::vec2(0);
    return glm::vec2((bb * ca - ab * cb) / determinant, (aa * cb - ab * ca) / determinant);
}

// A face with what its emission is looked up by.
struct SourceFace {
    SizedFace face;
    Corners parts[2];
    const Emission* emission = nullptr;

    glm::vec3 radiance(float u, float v, float step) const
    {
        const glm::vec3 position = face.at(u, v);
        glm::vec2 at = barycentric(parts[0].p, position);
        int part = 0;
        if (face.corners == 4 && std::min({at.x, at.y, 1 - at.x - at.y}) < 0) {
            const glm::vec2 other = barycentric(parts[1].p, position);
            if (std::min({other.x, other.y, 1 - other.x - other.y}) > std::min({at.x, at.y, 1 - at.x - at.y}))
                at = other, part = 1;
        }
        at = glm::clamp(at, glm::vec2(0), glm::vec2(1));
        if (at.x + at.y > 1) at /= at.x + at.y;
        if (parts[part].swapped) std::swap(at.x, at.y);
        return emission->at(face.triangle[part], at.x, at.y, step);
    }
};

// The mean radiance over a rectangle of the unit square, weighted by area.
glm::vec3 mean_radiance(const SourceFace& source, const glm::vec2& low, const glm::vec2& high)
{
    glm::vec3 sum(0);
    float areas = 0;
    const float step = (high.x - low.x) / k_looks;
    for (int j = 0; j < k_looks; ++j)
        for (int i = 0; i < k_looks; ++i) {
            const glm::vec2 at = low + (high - low) * (glm::vec2(static_cast<float>(i), static_cast<float>(j)) + 0.5f) /
                                           static_cast<float>(k_looks);
            const float area = source.face.area_at(at.x, at.y);
            sum += area * source.radiance(at.x, at.y, step);
            areas += area;
        }
    return areas > 0 ? sum / areas : glm::vec3(0);
}

void make_triangle(SizedFace& face, const Corners& corners)
{
    face.corners = 3;
    face.corner = {corners.p[0], corners.p[1], corners.p[2], corners.p[2]};
    const glm::dvec3 cross = glm::cross(glm::dvec3(corners.p[1]) - glm::dvec3(corners.p[0]),
                                        glm::dvec3(corners.p[2]) - glm::dvec3(corners.p[0]));
    face.area = static_cast<float>(0.5 * glm::length(cross));
    face.normal = face.area > 0 ? glm::vec3(glm::normalize(cross)) : glm::vec3(0);
}

// Joins two triangles of which b's corner `apex` lies beyond a's edge `edge`.
// @return  false if they are not in one plane, or if the result would not be convex
bool join(const Corners& a, int edge, const Corners& b, int apex, SizedFace& face, bool& parallelogram)
{
    const std::array<glm::vec3, 4> q{a.p[edge], b.p[apex], a.p[(edge + 1) % 3], a.p[(edge + 2) % 3]};
    const glm::dvec3 normal_a = glm::cross(glm::dvec3(a.p[1] - a.p[0]), glm::dvec3(a.p[2] - a.p[0]));
    const double length = glm::length(normal_a);
    const double diameter = std::max(glm::length(q[2] - q[0]), glm::length(q[3] - q[1]));
    if (!(length > 0)) return false;
    const glm::dvec3 normal = normal_a / length;
    double largest = 0;
    for (const glm::vec3& p : q)
        for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(static_cast<double>(p[axis])));
    const double room = std::max(diameter, largest) * static_cast<double>(k_flat);
    if (std::abs(glm::dot(normal, glm::dvec3(q[1] - q[0]))) > room) return false;
    double area = 0;
    for (int i = 0; i < 4; ++i) {
        const glm::dvec3 in(q[static_cast<std::size_t>((i + 1) % 4)] - q[static_cast<std::size_t>(i)]),
            out(q[static_cast<std::size_t>((i + 2) % 4)] - q[static_cast<std::size_t>((i + 1) % 4)]);
        const double turn = glm::dot(normal, glm::cross(in, out));
        if (!(turn > 1e-4 * glm::length(in) * glm::length(out))) return false;
    }
    for (int i = 1; i < 3; ++i)
        area += 0.5 * glm::dot(normal, glm::cross(glm::dvec3(q[static_cast<std::size_t>(i)] - q[0]),
                                                  glm::dvec3(q[static_cast<std::size_t>(i + 1)] - q[0])));
    face.corner = q;
    face.corners = 4;
    face.normal = glm::vec3(normal);
    face.area = static_cast<float>(area);
    parallelogram = static_cast<double>(glm::length(q[0] + q[2] - q[1] - q[3])) <= 1e-4 * diameter;
    return true;
}

using Key = std::tuple<float, float, float>;

// Finds the faces of one part: pairs of triangles as quadrilaterals, parallelograms first, and what is left.
void collect_part(const Mesh& mesh, const MeshPart& part, const std::vector<glm::vec3>& positions,
                  const glm::mat4& to_world, const SizedFace& like, const Emission& emission,
                  std::vector<SourceFace>& faces)
{
    const bool mirrored = glm::determinant(glm::mat3(to_world)) < 0;
    std::vector<Corners> corners(part.triangle_count);
    std::vector<char> done(part.triangle_count, 0);
    for (std::uint32_t i = 0; i < part.triangle_count; ++i) {
        const glm::uvec3 index = mesh.triangles[part.first_triangle + i];
        Corners& c = corners[i];
        for (int k = 0; k < 3; ++k) c.p[k] = transform_point(to_world, positions[index[k]]);
        if (mirrored) std::swap(c.p[1], c.p[2]), c.swapped = true;
        const glm::vec3 cross = glm::cross(c.p[1] - c.p[0], c.p[2] - c.p[0]);
        done[i] = !(glm::dot(cross, cross) > 0) || !is_finite(cross);
    }
    if (part.triangle_count >= 2 && part.triangle_count <= k_most_joined) {
        // Look for the triangle that has an edge in the other direction.
        const auto key = [](const glm::vec3& p) { return Key{p.x, p.y, p.z}; };
        std::map<std::pair<Key, Key>, std::pair<std::uint32_t, int>> edges;
        for (std::uint32_t i = 0; i < part.triangle_count; ++i)
            for (int e = 0; e < 3 && !done[i]; ++e)
                edges.try_emplace({key(corners[i].p[e]), key(corners[i].p[(e + 1) % 3])}, i, e);
        for (const bool wants_parallelogram : {true, false})
            for (std::uint32_t i = 0; i < part.triangle_count; ++i)
                for (int e = 0; e < 3 && !done[i]; ++e) {
                    const auto at = edges.find({key(corners[i].p[(e + 1) % 3]), key(corners[i].p[e])});
                    if (at == edges.end()) continue;
                    const auto [j, edge] = at->second;
                    if (j == i || done[j]) continue;
                    SourceFace source{like, {corners[i], corners[j]}, &emission};
                    bool parallelogram = false;
                    if (!join(corners[i], e, corners[j], (edge + 2) % 3, source.face, parallelogram)) continue;
                    if (wants_parallelogram && !parallelogram) continue;
                    source.face.triangle[0] = part.first_triangle + i, source.face.triangle[1] = part.first_triangle + j;
                    done[i] = done[j] = 1;
                    faces.push_back(source);
                }
    }
    for (std::uint32_t i = 0; i < part.triangle_count; ++i) {
        if (done[i]) continue;
        SourceFace source{like, {corners[i], {}}, &emission};
        make_triangle(source.face, corners[i]);
        source.face.triangle[0] = part.first_triangle + i;
        if (source.face.area > 0) faces.push_back(source);
    }
}

float power(const SizedFace& face)
{
    return luminance(face.radiance) * face.area * (face.two_sided ? 2.0f : 1.0f);
}

glm::vec3 middle(const SizedFace& face)
{
    glm::vec3 sum(0);
    for (int i = 0; i < face.corners; ++i) sum += face.corner[static_cast<std::size_t>(i)];
    return sum / static_cast<float>(face.corners);
}

// A run of the faces, to become one light.
struct Cluster {
    std::size_t begin, end;
    float weight = 0;   // the larger, the sooner it is split
};

Cluster cluster_of(const std::vector<SourceFace>& faces, std::size_t begin, std::size_t end)
{
    Box3 box;
    float sum = 0;
    for (std::size_t i = begin; i < end; ++i) box.add(middle(faces[i].face)), sum += power(faces[i].face);
    return {begin, end, end - begin < 2 ? 0 : sum * box.diagonal()};
}

// Splits the longest axis of a cluster at the median of its faces' places.
std::size_t split(std::vector<SourceFace>& faces, const Cluster& cluster)
{
    Box3 box;
    for (std::size_t i = cluster.begin; i < cluster.end; ++i) box.add(middle(faces[i].face));
    const glm::vec3 size = box.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto from = faces.begin() + static_cast<std::ptrdiff_t>(cluster.begin),
               to = faces.begin() + static_cast<std::ptrdiff_t>(cluster.end);
    std::stable_sort(from, to, [&](const SourceFace& a, const SourceFace& b) {
        return middle(a.face)[axis] < middle(b.face)[axis];
    });
    return (cluster.begin + cluster.end) / 2;
}

// Groups the faces: one each, or clusters by place, static and dynamic ones apart.
std::vector<Cluster> group(std::vector<SourceFace>& faces, const SizedLightOptions& options)
{
    std::vector<Cluster> clusters;
    if (faces.size() <= static_cast<std::size_t>(options.most_lights)) {
        for (std::size_t i = 0; i < faces.size(); ++i) clusters.push_back({i, i + 1});
        return clusters;
    }
    const auto dynamic = std::stable_partition(faces.begin(), faces.end(),
                                               [](const SourceFace& s) { return !s.face.dynamic; });
    const auto still = static_cast<std::size_t>(dynamic - faces.begin());
    if (still > 0) clusters.push_back(cluster_of(faces, 0, still));
    if (still < faces.size()) clusters.push_back(cluster_of(faces, still, faces.size()));
    while (clusters.size() < static_cast<std::size_t>(options.most_clusters)) {
        const auto at = std::max_element(clusters.begin(), clusters.end(),
                                         [](const Cluster& a, const Cluster& b) { return a.weight < b.weight; });
        if (!(at->weight > 0)) break;
        const Cluster whole = *at;
        const std::size_t half = split(faces, whole);
        *at = cluster_of(faces, whole.begin, half);
        clusters.push_back(cluster_of(faces, half, whole.end));
    }
    return clusters;
}

// Finds the mean radiances of a face, over all of it and over the cells of its grid.
void find_radiance(SourceFace& source, int cells, std::vector<glm::vec3>& cell_radiance)
{
    cell_radiance.clear();
    if (!source.emission->varies()) {
        source.face.radiance = source.emission->at(source.face.triangle[0], 0, 0, 0);
        return;
    }
    glm::vec3 sum(0), low(k_infinity), high(0);
    float areas = 0;
    const float size = 1 / static_cast<float>(cells);
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            const glm::vec2 from(static_cast<float>(i) * size, static_cast<float>(j) * size);
            const glm::vec3 mean = mean_radiance(source, from, from + size);
            const float area = source.face.area_at(from.x + 0.5f * size, from.y + 0.5f * size);
            cell_radiance.push_back(mean);
            sum += area * mean, areas += area;
            low = glm::min(low, mean), high = glm::max(high, mean);
        }
    source.face.radiance = sum / areas;
    const glm::vec3 spread = high - low;
    if (std::max({spread.x, spread.y, spread.z}) <= k_even * std::max({high.x, high.y, high.z})) cell_radiance.clear();
}

void enclose(SizedLight& light)
{
    Box3 box;
    for (const SizedFace& face : light.faces)
        for (int i = 0; i < face.corners; ++i) box.add(face.corner[static_cast<std::size_t>(i)]);
    light.centre = box.centre();
    for (const SizedFace& face : light.faces)
        for (int i = 0; i < face.corners; ++i)
            light.radius = std::max(light.radius, glm::length(face.corner[static_cast<std::size_t>(i)] - light.centre));
}

// Places the points of the sequence on the faces, in proportion to their power.
void place(SizedLight& light, std::span<const SourceFace> sources, const std::vector<glm::vec2>& sequence)
{
    double all = 0;
    std::vector<double> sums;
    for (const SizedFace& face : light.faces) sums.push_back(all += static_cast<double>(power(face)));
    const float step = 1 / std::sqrt(static_cast<float>(sequence.size()));
    std::vector<std::pair<std::uint32_t, glm::vec2>> points;
    for (const glm::vec2& p : sequence) {
        const double wanted = static_cast<double>(p.x) * all;
        const auto f = std::min<std::size_t>(
            static_cast<std::size_t>(std::upper_bound(sums.begin(), sums.end(), wanted) - sums.begin()), sums.size() - 1);
        const double before = f == 0 ? 0 : sums[f - 1];
        const auto u = static_cast<float>((wanted - before) / (sums[f] - before));
        points.emplace_back(static_cast<std::uint32_t>(f),
                            light.faces.size() == 1 ? p : glm::vec2(std::clamp(u, 0.0f, 1.0f), p.y));
    }
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [f, p] : points) {
        const SizedFace& face = light.faces[f];
        const double share = static_cast<double>(power(face)) / all;
        SizedPlace at;
        at.position = face.at(p.x, p.y);
        at.face = f;
        at.radiance = light.cell_radiance.empty() ? face.radiance : sources[f].radiance(p.x, p.y, step);
        at.area = static_cast<float>(static_cast<double>(face.area_at(p.x, p.y)) /
                                     (share * static_cast<double>(sequence.size())));
        light.places.push_back(at);
    }
}

}   // namespace

glm::vec3 SizedFace::at(float u, float v) const
{
    if (corners == 3) {
        const float root = std::sqrt(u);
        return corner[0] + root * ((corner[1] - corner[0]) + v * (corner[2] - corner[1]));
    }
    return (1 - u) * (1 - v) * corner[0] + u * (1 - v) * corner[1] + u * v * corner[2] + (1 - u) * v * corner[3];
}

float SizedFace::area_at(float u, float v) const
{
    if (corners == 3) return area;
    const glm::vec3 along_u = (1 - v) * (corner[1] - corner[0]) + v * (corner[2] - corner[3]);
    const glm::vec3 along_v = (1 - u) * (corner[3] - corner[0]) + u * (corner[2] - corner[1]);
    return glm::length(glm::cross(along_u, along_v));
}

bool may_emit(const Material& material)
{
    return material.emissive != glm::vec3(0) && material.model == ShadingModel::metallic_roughness;
}

bool emits_light(const Scene& scene)
{
    for (const Object& object : scene.objects) {
        if (object.removed) continue;
        const Mesh& mesh = scene.meshes[object.mesh];
        for (const MeshPart& part : mesh.parts) {
            const Material& material = scene.materials[part.material];
            if (!may_emit(material)) continue;
            const Emission emission(scene, mesh, material);
            std::vector<SourceFace> faces;
            collect_part(mesh, part, mesh.positions, glm::mat4(1), {}, emission, faces);
            std::vector<glm::vec3> cells;
            for (SourceFace& source : faces) {
                find_radiance(source, 1, cells);
                if (source.face.radiance != glm::vec3(0)) return true;
            }
        }
    }
    return false;
}

std::vector<glm::vec2> sequence_in_morton_order(int count)
{
    std::vector<glm::uvec2> points;
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i)
        points.emplace_back(reversed_bits(i), second_dimension(i));
    std::sort(points.begin(), points.end(), [](const glm::uvec2& a, const glm::uvec2& b) {
        return morton_code(a.x, a.y) < morton_code(b.x, b.y);
    });
    // Centre the points in the elementary intervals, of which each has one.
    const float half = 0.5f / static_cast<float>(count);
    std::vector<glm::vec2> result;
    for (const glm::uvec2& p : points) result.emplace_back(unit(p.x) + half, unit(p.y) + half);
    return result;
}

bool SizedLights::must_follow(const SceneState& state) const
{
    if (&state != state_) return true;
    const FrameChanges& changes = state.changes();
    if (!changes.materials_changed.empty() || !changes.added.empty() || !changes.removed.empty() ||
        !changes.promoted.empty())
        return true;
    if (!any_emissive_) return false;
    return std::any_of(changes.changed.begin(), changes.changed.end(), [&](ObjectId o) { return emissive_[o] != 0; });
}

void SizedLights::update(const SceneState& state)
{
    if (!must_follow(state)) return;
    const bool had = !lights_.empty();
    state_ = nullptr;   // until all is made
    make(state);
    state_ = &state;
    if (had || !lights_.empty()) ++version_;
}

void SizedLights::forget()
{
    state_ = nullptr;
    if (!lights_.empty()) ++version_;
    lights_.clear();
    counts_ = {};
}

void SizedLights::make(const SceneState& state)
{
    const Scene& scene = state.scene();
    lights_.clear();
    counts_ = {};
    any_emissive_ = std::any_of(scene.materials.begin(), scene.materials.end(), may_emit);
    if (!any_emissive_) return;

    // Collect the faces of visible objects.
    emissive_.assign(scene.objects.size(), 0);
    std::vector<std::unique_ptr<Emission>> emissions;
    std::vector<SourceFace> faces;
    for (ObjectId o = 0; o < scene.objects.size(); ++o) {
        const Object& object = scene.objects[o];
        if (object.removed) continue;
        const Mesh& mesh = scene.meshes[object.mesh];
        for (const MeshPart& part : mesh.parts) {
            const Material& material = scene.materials[part.material];
            if (!may_emit(material)) continue;
            emissive_[o] = 1;
            if (!state.object_there(o)) continue;
            interruption_point();
            emissions.push_back(std::make_unique<Emission>(scene, mesh, material));
            SizedFace like;
            like.object = o;
            like.two_sided = !material.one_sided();
            like.dynamic = state.is_dynamic(o);
            counts_.triangles += part.triangle_count;
            collect_part(mesh, part, object.deforming ? state.deformed(o).positions : mesh.positions,
                         state.object_matrix(o), like, *emissions.back(), faces);
        }
    }

    // Find their radiance, and drop those that have none.
    const int cells = faces.size() <= static_cast<std::size_t>(options_.most_lights) ? options_.cells : 1;
    std::vector<std::vector<glm::vec3>> cell_radiance(cells > 1 ? faces.size() : 0);
    std::vector<glm::vec3> none_of_it;
    for (std::size_t f = 0; f < faces.size(); ++f)
        find_radiance(faces[f], cells, cells > 1 ? cell_radiance[f] : none_of_it);
    if (cells == 1)
        std::erase_if(faces, [](const SourceFace& source) { return !(power(source.face) > 0); });
    counts_.polygons = faces.size();

    // Make the lights.
    const std::vector<Cluster> clusters = group(faces, options_);
    int places = options_.places;
    while (places > options_.least_places && static_cast<int>(clusters.size()) * places > options_.places_in_all)
        places /= 2;
    const std::vector<glm::vec2> sequence = sequence_in_morton_order(places);
    for (const Cluster& cluster : clusters) {
        const std::span<const SourceFace> sources(faces.data() + cluster.begin, cluster.end - cluster.begin);
        SizedLight light;
        for (const SourceFace& source : sources) light.faces.push_back(source.face);
        if (sources.size() == 1) {
            if (!(power(light.faces[0]) > 0)) continue;
            if (cells > 1) light.cell_radiance = cell_radiance[cluster.begin];
            light.cells = light.cell_radiance.empty() ? 1 : cells;
        }
        light.dynamic = light.faces[0].dynamic;
        enclose(light);
        place(light, sources, sequence);
        lights_.push_back(std::move(light));
    }
    counts_.lights = lights_.size();
}

std::size_t SizedLights::bytes() const
{
    std::size_t bytes = emissive_.size();
    for (const SizedLight& light : lights_)
        bytes += sizeof(SizedLight) + light.faces.size() * sizeof(SizedFace) + light.places.size() * sizeof(SizedPlace) +
                 light.cell_radiance.size() * sizeof(glm::vec3);
    return bytes;
}

}   // namespace gnomon::scene
