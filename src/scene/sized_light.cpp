// SPDX-License-Identifier: Apache-2.0
#include "scene/sized_light.h"

#include <algorithm>

#include "base/interruption.h"
#include "base/morton.h"
#include "base/sobol.h"
#include "scene/flat_figures.h"

namespace gnomon::scene {

namespace {

constexpr float k_even = 1e-3f;   // cells that differ by no more than this fraction count as one

float unit(std::uint32_t bits)
{
    return static_cast<float>(bits >> 8) * 0x1p-24f;
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
    float weight = 0;                  // the larger, the sooner it is split
    SizedFace outline{.corners = 0};   // of a flat figure
};

Cluster cluster_of(const std::vector<SourceFace>& faces, std::size_t begin, std::size_t end)
{
    Box3 box;
    float sum = 0;
    for (std::size_t i = begin; i < end; ++i) box.add(middle(faces[i].face)), sum += power(faces[i].face);
    return {begin, end, end - begin < 2 ? 0 : sum * box.diagonal(), {.corners = 0}};
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

// Orders faces so that those of a flat figure are side by side.
std::vector<Cluster> figures_of(std::vector<SourceFace>& faces)
{
    std::vector<Cluster> clusters;
    std::vector<SourceFace> ordered;
    for (const FlatFigure& figure : flat_figures(faces)) {
        clusters.push_back({ordered.size(), ordered.size() + figure.faces.size(), 0, figure.outline});
        for (const std::size_t f : figure.faces) ordered.push_back(faces[f]);
    }
    faces = std::move(ordered);
    return clusters;
}

// Groups faces by place; static and dynamic ones, and those of each cone, are apart.
std::vector<Cluster> group(std::vector<SourceFace>& faces, const SizedLightOptions& options)
{
    std::vector<Cluster> clusters;
    const auto same_kind = [](const SizedFace& a, const SizedFace& b) {
        return a.dynamic == b.dynamic && a.cone == b.cone;
    };
    for (std::size_t first = 0; first < faces.size();) {
        const auto from = faces.begin() + static_cast<std::ptrdiff_t>(first);
        const SizedFace kind = from->face;
        const auto end = static_cast<std::size_t>(
            std::stable_partition(from, faces.end(), [&](const SourceFace& s) { return same_kind(s.face, kind); }) -
            faces.begin());
        clusters.push_back(cluster_of(faces, first, end));
        first = end;
    }
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

// Orders objects by their faces' places and radiances. Their numbers differ between a scene that was edited and one
// made at once, and sums of many lights must not.
void order_by_place(std::vector<SourceFace>& faces)
{
    std::vector<std::pair<std::size_t, std::size_t>> objects;   // from, to
    for (std::size_t f = 0; f < faces.size(); ++f)
        if (f == 0 || faces[f].face.object != faces[f - 1].face.object)
            objects.emplace_back(f, f + 1);
        else
            objects.back().second = f + 1;
    if (objects.size() < 2) return;
    const auto key = [](const SizedFace& face) {
        std::array<float, 15> values;
        std::size_t k = 0;
        for (const glm::vec3& corner : face.corner)
            for (int axis = 0; axis < 3; ++axis) values[k++] = corner[axis];
        for (int axis = 0; axis < 3; ++axis) values[k++] = face.radiance[axis];
        return values;
    };
    std::stable_sort(objects.begin(), objects.end(), [&](const auto& a, const auto& b) {
        for (std::size_t i = a.first, j = b.first; i < a.second && j < b.second; ++i, ++j)
            if (const auto x = key(faces[i].face), y = key(faces[j].face); x != y) return x < y;
        return a.second - a.first < b.second - b.first;
    });
    std::vector<SourceFace> ordered;
    ordered.reserve(faces.size());
    for (const auto& [from, to] : objects)
        for (std::size_t f = from; f < to; ++f) ordered.push_back(std::move(faces[f]));
    faces = std::move(ordered);
}

// Finds the mean radiances of a face with a texture, over all of it and over the cells of its grid.
void find_radiance(SourceFace& source, int cells, std::vector<glm::vec3>& cell_radiance)
{
    cell_radiance.clear();
    glm::vec3 sum(0), low(k_infinity), high(0);
    float areas = 0;
    const float size = 1 / static_cast<float>(cells);
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            const glm::vec2 from(static_cast<float>(i) * size, static_cast<float>(j) * size);
            const glm::vec3 mean = source.mean_radiance(from, from + size);
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
            static_cast<std::size_t>(std::upper_bound(sums.begin(), sums.end(), wanted) - sums.begin()),
            sums.size() - 1);
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

std::vector<glm::vec2> sequence_in_morton_order(int count)
{
    std::vector<glm::uvec2> points;
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i)
        points.emplace_back(reversed_bits(i), second_dimension(i));
    std::sort(points.begin(), points.end(),
              [](const glm::uvec2& a, const glm::uvec2& b) { return morton_code(a.x, a.y) < morton_code(b.x, b.y); });
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
            like.cone = emission_cone(material, -glm::vec3(state.object_matrix(o)[2]));
            counts_.triangles += part.triangle_count;
            collect_faces(mesh, part, object.deforming ? state.deformed(o).positions : mesh.positions,
                          state.object_matrix(o), like, *emissions.back(), faces);
        }
    }

    // Find the flat figures among them, of those that have one radiance.
    for (SourceFace& source : faces)
        if (!source.emission->varies()) source.face.radiance = source.emission->at(source.face.triangle[0], 0, 0, 0);
    std::erase_if(faces, [](const SourceFace& s) { return !s.emission->varies() && !(power(s.face) > 0); });
    order_by_place(faces);
    std::vector<Cluster> clusters = figures_of(faces);
    const bool few = clusters.size() <= static_cast<std::size_t>(options_.most_lights);

    // Find the radiance of the others, and group the faces if there are too many figures.
    const int cells = few ? options_.cells : 1;
    std::vector<std::vector<glm::vec3>> cell_radiance(few ? faces.size() : 0);
    std::vector<glm::vec3> none_of_it;
    for (std::size_t f = 0; f < faces.size(); ++f)
        if (faces[f].emission->varies()) find_radiance(faces[f], cells, few ? cell_radiance[f] : none_of_it);
    if (!few) {
        std::erase_if(faces, [](const SourceFace& source) { return !(power(source.face) > 0); });
        clusters = group(faces, options_);
    }
    counts_.polygons = faces.size();

    // Make the lights.
    int places = options_.places;
    while (places > options_.least_places && static_cast<int>(clusters.size()) * places > options_.places_in_all)
        places /= 2;
    const std::vector<glm::vec2> sequence = sequence_in_morton_order(places);
    for (const Cluster& cluster : clusters) {
        const std::span<const SourceFace> sources(faces.data() + cluster.begin, cluster.end - cluster.begin);
        SizedLight light;
        for (const SourceFace& source : sources) light.faces.push_back(source.face);
        light.outline = cluster.outline;
        if (sources.size() == 1) {
            light.outline = light.faces[0];
            if (!(power(light.faces[0]) > 0)) continue;
            if (few) light.cell_radiance = cell_radiance[cluster.begin];
            light.cells = light.cell_radiance.empty() ? 1 : cells;
        }
        light.dynamic = light.faces[0].dynamic;
        light.cone = light.faces[0].cone;
        light.tree = make_face_tree(light.faces);
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
        bytes += sizeof(SizedLight) + light.faces.size() * sizeof(SizedFace) +
                 light.tree.nodes.size() * sizeof(FaceNode) + light.tree.order.size() * sizeof(std::uint32_t) +
                 light.places.size() * sizeof(SizedPlace) + light.cell_radiance.size() * sizeof(glm::vec3);
    return bytes;
}

}   // namespace gnomon::scene
