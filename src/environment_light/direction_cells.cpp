// SPDX-License-Identifier: Apache-2.0
#include "environment_light/direction_cells.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <unordered_map>

#include "base/check.h"
#include "base/morton.h"
#include "base/sobol.h"
#include "environment_light/spherical_triangles.h"
#include "scene/direction_grid.h"

namespace gnomon::environment_light {

namespace {

constexpr int k_sample_rows = 512;            // of the grid of samples over an image; twice as many columns
constexpr int k_finest_rows = 1024;           // larger images are averaged down to less than twice as many
constexpr int k_quadrature_levels = 4;        // of the samples in a cell that is divided further
constexpr std::uint32_t k_least_group = 64;   // leaves of a cell of the least level
// Averages blocks of texels of an image that is finer than cells need, row by row with equal weights: within a block,
// rows have nearly the same solid angle.
ImageF reduced(const ImageF& image)
{
    const int factor = image.height / k_finest_rows;
    const int columns = image.width / factor, rows = image.height / factor;
    ImageF result(columns, rows, 3);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            // Blocks divide the image evenly, so that no texel is left out.
            const auto begin = [](int i, int of, int size) {
                return static_cast<int>(static_cast<std::int64_t>(i) * size / of);
            };
            const int x0 = begin(x, columns, image.width), x1 = begin(x + 1, columns, image.width);
            const int y0 = begin(y, rows, image.height), y1 = begin(y + 1, rows, image.height);
            glm::dvec3 sum(0);
            for (int j = y0; j < y1; ++j)
                for (int i = x0; i < x1; ++i) {
                    const float* p = image.pixel(i, j);
                    sum += glm::dvec3(p[0], p[1], p[2]);
                }
            sum /= static_cast<double>((x1 - x0) * (y1 - y0));
            float* to = result.pixel(x, y);
            for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(sum[c]);
        }
    return result;
}

// What a cell brings.
struct Light {
    glm::dvec3 flux{0};
    glm::dvec3 weighted{0};   // directions, by luminance times solid angle
    double luminance = 0;     // times solid angle
    void add(const glm::dvec3& part, const glm::dvec3& direction)
    {
        flux += part;
        const double light = gnomon::luminance(part);
        luminance += light, weighted += light * direction;
    }
};

}   // namespace

struct DirectionCells::Builder {
    DirectionCells& out;
    const scene::Environment& environment;
    const CellOptions& options;
    std::vector<Light> lights;   // by node
    double total = 0;

    Corners corners_of(std::uint32_t node) const
    {
        const DirectionNode& n = out.nodes_[node];
        return {n.corner[0], n.corner[1], n.corner[2]};
    }
    void set(std::uint32_t node, const Corners& corners, std::uint64_t place)
    {
        DirectionNode& n = out.nodes_[node];
        std::copy(corners.begin(), corners.end(), n.corner.begin());
        n.place = place;
    }
    void divide(std::uint32_t node)
    {
        const auto first = static_cast<std::uint32_t>(out.nodes_.size());
        const std::uint64_t place = out.nodes_[node].place;
        const Corners corners = corners_of(node);
        const auto put = [&](const auto& parts) {
            const auto count = static_cast<std::uint32_t>(parts.size());
            out.nodes_.resize(first + count);
            out.nodes_[node].children = first, out.nodes_[node].count = count;
            for (std::uint32_t q = 0; q < count; ++q) set(first + q, parts[q], 16 * place + q);
        };
        if (node < out.roots_)
            put(ninths(corners));
        else
            put(quarters(corners));
    }

    // Divides all of the sphere to the least level.
    void make_even()
    {
        const auto faces = icosahedron();
        out.roots_ = faces.size();
        out.nodes_.resize(faces.size());
        for (std::uint32_t f = 0; f < faces.size(); ++f) set(f, faces[f], 32 + f);
        std::size_t begin = 0;
        for (int level = 0; level < options.least_level; ++level) {
            const std::size_t end = out.nodes_.size();
            for (; begin < end; ++begin) divide(static_cast<std::uint32_t>(begin));
        }
    }
    std::uint32_t leaf_at(const glm::dvec3& d) const
    {
        std::uint32_t node = 0;
        double most = -2;
        for (std::uint32_t f = 0; f < out.roots_; ++f) {
            const double at = glm::dot(d, out.nodes_[f].corner[0] + out.nodes_[f].corner[1] + out.nodes_[f].corner[2]);
            if (at > most) most = at, node = f;
        }
        while (out.nodes_[node].children != 0) {
            const std::uint32_t first = out.nodes_[node].children;
            if (out.nodes_[node].count == 9) {
                std::uint32_t part = 0;
                while (part < 8 && !contains(corners_of(first + part), d)) ++part;
                node = first + part;
                continue;
            }
            // The middle quarter has what no corner has.
            const Corners inner = corners_of(first + 3);
            std::uint32_t q = 3;
            if (glm::dot(d, glm::cross(inner[2], inner[0])) < 0)
                q = 0;
            else if (glm::dot(d, glm::cross(inner[0], inner[1])) < 0)
                q = 1;
            else if (glm::dot(d, glm::cross(inner[1], inner[2])) < 0)
                q = 2;
            node = first + q;
        }
        return node;
    }

    // The normals of the edges of a cell, for many directions: contains().
    struct Edges {
        glm::dvec3 normal[3];
        explicit Edges(const Corners& c)
            : normal{glm::cross(c[0], c[1]), glm::cross(c[1], c[2]), glm::cross(c[2], c[0])}
        {
        }
        bool contain(const glm::dvec3& d) const
        {
            return glm::dot(d, normal[0]) >= 0 && glm::dot(d, normal[1]) >= 0 && glm::dot(d, normal[2]) >= 0;
        }
    };

    // Sums samples of the image over the leaves. What a cell has too little or too much of solid angle, because samples
    // have cells of their own, is made up for at its darkest sample: an even sky is then exact, and so is a sun.
    void integrate()
    {
        const ImageF& image = environment.image();
        int rows = image.height, columns = image.width;
        if (rows < k_sample_rows || columns < 2 * k_sample_rows) {
            rows *= (k_sample_rows + rows - 1) / rows;
            columns *= (2 * k_sample_rows + columns - 1) / columns;
        }
        struct Sum {
            double angle = 0, darkest = 1e300;
            glm::dvec3 dark{0};
        };
        std::vector<Sum> sums(out.nodes_.size());
        lights.assign(out.nodes_.size(), {});
        std::uint32_t leaf = 0;
        const bool whole = rows == image.height && columns == image.width;
        const scene::DirectionGrid directions(columns, rows);
        std::optional<Edges> edges;   // of the leaf
        for (int y = 0; y < rows; ++y) {
            const double above = std::cos(y * k_pi / rows), below = std::cos((y + 1) * k_pi / rows);
            const double angle = 2 * k_pi / columns * (above - below);
            const float v = std::acos(std::clamp(directions.at(0, y).y, -1.0f, 1.0f)) / static_cast<float>(k_pi);
            for (int x = 0; x < columns; ++x) {
                const glm::vec3 direction = directions.at(x, y);
                const glm::dvec3 d(direction);
                const float* p = whole ? image.pixel(x, y) : nullptr;
                const glm::dvec3 radiance =
                    whole ? glm::dvec3(p[0], p[1], p[2])
                          : glm::dvec3(scene::radiance_at(image, directions.longitude(x, y, direction), v));
                if (!edges || !edges->contain(d)) leaf = leaf_at(d), edges.emplace(corners_of(leaf));
                lights[leaf].add(angle * radiance, d);
                Sum& sum = sums[leaf];
                sum.angle += angle;
                if (const double light = luminance(radiance); light < sum.darkest)
                    sum.darkest = light, sum.dark = radiance;
            }
        }
        for (std::uint32_t n = 0; n < out.nodes_.size(); ++n) {
            if (out.nodes_[n].children != 0) continue;
            const Corners corners = corners_of(n);
            const double missing = solid_angle(corners) - sums[n].angle;
            if (sums[n].darkest < 1e300) lights[n].add(missing * sums[n].dark, centroid(corners));
            total += lights[n].luminance;
        }
    }
    // The mean direction of a cell of even radiance.
    static glm::dvec3 centroid(const Corners& c)
    {
        // The integral of the direction over a spherical polygon is half the sum of its edges' arcs times normals.
        glm::dvec3 sum(0);
        for (std::size_t e = 0; e < 3; ++e) {
            const glm::dvec3 n = glm::cross(c[e], c[(e + 1) % 3]);
            const double length = glm::length(n);
            if (length > 0) sum += std::atan2(length, glm::dot(c[e], c[(e + 1) % 3])) / length * n;
        }
        sum *= 0.5;
        const double angle = solid_angle(c);
        return glm::dot(sum, middle(c)) > 0 ? sum / angle : -sum / angle;
    }

    void sample(const Corners& c, int levels, Light& light) const
    {
        if (levels > 0) {
            for (const Corners& quarter : quarters(c)) sample(quarter, levels - 1, light);
            return;
        }
        const glm::dvec3 d = middle(c);
        light.add(solid_angle(c) * glm::dvec3(environment.radiance(glm::vec3(d))), d);
    }

    // Divides cells that bring too much, level by level.
    void refine()
    {
        std::vector<std::uint32_t> bright;
        std::size_t leaves = 0;
        for (std::uint32_t n = 0; n < out.nodes_.size(); ++n)
            if (out.nodes_[n].children == 0) bright.push_back(n), ++leaves;
        for (int level = options.least_level; level < options.most_levels && !bright.empty(); ++level) {
            std::vector<std::uint32_t> next;
            for (const std::uint32_t n : bright) {
                if (!(lights[n].luminance > options.largest_share * total) || leaves + 3 > options.most_cells) continue;
                divide(n);
                leaves += 3;
                lights.resize(out.nodes_.size());
                const std::uint32_t first = out.nodes_[n].children;
                double sum = 0;
                for (std::uint32_t q = 0; q < 4; ++q) {
                    sample(corners_of(first + q), k_quadrature_levels, lights[first + q]);
                    sum += lights[first + q].luminance;
                }
                // The samples say what share each quarter has.
                for (std::uint32_t q = 0; q < 4; ++q) {
                    Light& light = lights[first + q];
                    const double scale = sum > 0 ? lights[n].luminance / sum : 0;
                    light.flux *= scale, light.weighted *= scale, light.luminance *= scale;
                    if (sum > 0) continue;
                    light = lights[n];
                    light.flux *= 0.25, light.weighted *= 0.25, light.luminance *= 0.25;
                }
                for (std::uint32_t q = 0; q < 4; ++q) next.push_back(first + q);
            }
            bright = std::move(next);
        }
    }
};

DirectionCells::DirectionCells(const scene::Environment& environment, const CellOptions& options)
{
    std::optional<scene::Environment> coarser;
    if (environment.image().height >= 2 * k_finest_rows) coarser.emplace(reduced(environment.image()));
    Builder builder{*this, coarser ? *coarser : environment, options, {}, 0};
    builder.make_even();
    builder.integrate();
    builder.refine();
    for (std::uint32_t r = 0; r < roots_; ++r) number_leaves(r);
    add_cones();
    for (std::size_t leaf = 0; leaf < nodes_of_.size(); ++leaf) {
        const std::uint32_t n = nodes_of_[leaf];
        const Corners corners = builder.corners_of(n);
        const Light& light = builder.lights[n];
        means_.emplace_back(light.luminance > 0 ? light.weighted / light.luminance : Builder::centroid(corners));
        fluxes_.emplace_back(light.flux);
        angles_.push_back(static_cast<float>(solid_angle(corners)));
        total_ += fluxes_.back();
        // The place depends on the cell alone, so that it is the same for every image.
        const auto index = static_cast<double>(nodes_[n].place % 4093);
        directions_.emplace_back(jittered_in(corners, index));
    }
    // Cells of the least level that were divided into many.
    followers_.assign(words(), 0);
    std::uint32_t level_begin = 0, level_end = static_cast<std::uint32_t>(roots_);
    std::uint32_t families_begin = 0;
    for (int level = 0; level < options.least_level; ++level) {
        families_begin = level_begin;
        const std::uint32_t next = level_end;
        const std::uint32_t last = nodes_[level_end - 1].children + nodes_[level_end - 1].count;
        level_begin = next, level_end = last;
    }
    stable_numbers_.resize(nodes_of_.size());
    std::vector<std::uint32_t> of_level;   // in the order of the tree
    for (std::uint32_t n = level_begin; n < level_end; ++n) of_level.push_back(n);
    std::ranges::sort(of_level, {}, [&](std::uint32_t n) { return nodes_[n].first_leaf; });
    for (std::uint32_t number = 0; number < of_level.size(); ++number) {
        const DirectionNode& node = nodes_[of_level[number]];
        for (std::uint32_t l = 0; l < node.leaves; ++l) stable_numbers_[node.first_leaf + l] = number + l;
    }
    for (std::uint32_t n = level_begin; n < level_end && options.groups; ++n)
        if (nodes_[n].leaves >= k_least_group) add_group(nodes_[n].first_leaf, nodes_[n].leaves);
    family_followers_.assign(words(), 0);
    if (options.groups) add_families(families_begin, level_begin);
}

DirectionCells::DirectionCells(const glm::vec3& to_light, double diameter, const glm::vec3& irradiance,
                               const CellOptions& options)
{
    GNOMON_CHECK(diameter > 0 && diameter < k_pi / 2);
    // A (0, 2)-net of the square, mapped to the disc [Shirley and Chiu 1997]: one place in every cell of a grid.
    const int side = 1 << options.disc_level;
    const auto count = static_cast<std::uint32_t>(side) * static_cast<std::uint32_t>(side);
    std::vector<glm::dvec2> place(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const double a = (reversed_bits(i) + 0.5) / 4294967296.0, b = (second_dimension(i) + 0.5) / 4294967296.0;
        const auto x = static_cast<std::uint32_t>(a * side), y = static_cast<std::uint32_t>(b * side);
        const double s = 2 * a - 1, t = 2 * b - 1;
        glm::dvec2 p(0);
        if (std::abs(s) > std::abs(t))
            p = s * glm::dvec2(std::cos(k_pi / 4 * t / s), std::sin(k_pi / 4 * t / s));
        else if (t != 0)
            p = t * glm::dvec2(std::sin(k_pi / 4 * s / t), std::cos(k_pi / 4 * s / t));
        place[morton_code(x, y)] = p;
    }
    glm::vec3 across, up;
    make_basis(to_light, across, up);
    const double reach = std::tan(diameter / 2);
    const auto direction = [&](const glm::dvec2& p) {
        return glm::normalize(glm::dvec3(to_light) + reach * p.x * glm::dvec3(across) + reach * p.y * glm::dvec3(up));
    };

    // A complete tree of quarters; each node has the rectangle around its places.
    roots_ = 1;
    nodes_.resize(1);
    nodes_[0].leaves = count;
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
        glm::dvec2 low(2), high(-2);
        const std::uint32_t first_leaf = nodes_[n].first_leaf, leaves = nodes_[n].leaves;
        for (std::uint32_t i = first_leaf; i < first_leaf + leaves; ++i)
            low = glm::min(low, place[i]), high = glm::max(high, place[i]);
        const glm::dvec2 room(1e-3);
        low -= room, high += room;
        nodes_[n].corner = {direction(low), direction({high.x, low.y}), direction(high), direction({low.x, high.y})};
        nodes_[n].corners = 4;
        nodes_[n].place = n;
        if (leaves == 1) continue;
        nodes_[n].children = static_cast<std::uint32_t>(nodes_.size()), nodes_[n].count = 4;
        for (std::uint32_t q = 0; q < 4; ++q) {
            DirectionNode& child = nodes_.emplace_back();
            child.first_leaf = first_leaf + q * leaves / 4, child.leaves = leaves / 4;
        }
    }
    nodes_of_.resize(count), stable_numbers_.resize(count);
    std::iota(stable_numbers_.begin(), stable_numbers_.end(), 0u);
    for (std::uint32_t n = 0; n < nodes_.size(); ++n)
        if (nodes_[n].children == 0) nodes_of_[nodes_[n].first_leaf] = n;
    const auto angle = static_cast<float>(2 * k_pi * (1 - std::cos(diameter / 2)) / count);
    for (std::uint32_t i = 0; i < count; ++i) {
        directions_.emplace_back(direction(place[i]));
        means_.push_back(directions_.back());
        fluxes_.push_back(irradiance / static_cast<float>(count));
        angles_.push_back(angle);
    }
    total_ = irradiance;
    add_cones();
    if (options.groups) add_group(0, count);
    family_followers_.assign(words(), 0);
}

// Makes a group of leaves. Its rim are those bright ones that lie furthest from its middle, one for each of some
// directions around it.
void DirectionCells::add_group(std::uint32_t first, std::uint32_t leaves)
{
    constexpr int k_rim = 32;
    constexpr std::uint32_t k_within = 12;   // one of so many
    constexpr float k_bright = 0.25f;        // of the brightest leaf's flux
    followers_.resize(words(), 0);
    float most = 0;
    glm::vec3 middle(0);
    for (std::uint32_t i = first; i < first + leaves; ++i) {
        const float light = luminance(fluxes_[i]);
        most = std::max(most, light), middle += light * directions_[i];
    }
    if (!(most > 0)) return;
    glm::vec3 across, up;
    make_basis(glm::normalize(middle), across, up);
    LeafGroup group{first, leaves, {}};
    std::vector<char> is_scout(leaves, 0);
    for (std::uint32_t i = k_within / 2; i < leaves; i += k_within) is_scout[i] = 1;
    for (int k = 0; k < k_rim; ++k) {
        const auto turn = static_cast<float>(2 * k_pi * k / k_rim);
        const glm::vec3 out = std::cos(turn) * across + std::sin(turn) * up;
        std::uint32_t furthest = 0;
        float reach = -k_infinity;
        for (std::uint32_t i = 0; i < leaves; ++i) {
            if (luminance(fluxes_[first + i]) < k_bright * most) continue;
            const float at = glm::dot(out, directions_[first + i]);
            if (at > reach) reach = at, furthest = i;
        }
        is_scout[furthest] = 1;
    }
    for (std::uint32_t i = 0; i < leaves; ++i) {
        if (is_scout[i])
            group.scouts.push_back(first + i);
        else
            followers_[(first + i) / 64] |= std::uint64_t{1} << ((first + i) % 64);
    }
    groups_.push_back(std::move(group));
}

// Makes a family of each of these nodes.
void DirectionCells::add_families(std::uint32_t begin, std::uint32_t end)
{
    constexpr double k_same = 1e-12;   // squared distance of corners
    family_of_.resize(leaves());
    stand_ins_.assign(words(), 0);
    stand_in_of_.resize(leaves());
    for (std::uint32_t n = begin; n < end; ++n) {
        const DirectionNode& node = nodes_[n];
        CellFamily family{node.first_leaf, node.leaves, node.first_leaf, {}, {}};
        const auto off = [&](std::uint32_t leaf) { return glm::dot(node.axis, directions_[leaf]); };
        for (std::uint32_t leaf = node.first_leaf; leaf < node.first_leaf + node.leaves; ++leaf) {
            if (off(leaf) > off(family.scout)) family.scout = leaf;
            family_of_[leaf] = static_cast<std::uint16_t>(families_.size());
        }
        std::size_t found = 0;
        for (std::uint32_t m = begin; m < end && found < family.neighbours.size(); ++m) {
            int shared = 0;
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t b = 0; b < 3; ++b) {
                    const glm::dvec3 way = node.corner[a] - nodes_[m].corner[b];
                    shared += glm::dot(way, way) < k_same;
                }
            if (shared == 2) family.neighbours[found++] = m - begin;
        }
        GNOMON_CHECK(found == family.neighbours.size());
        const bool divided_once = family.leaves == node.count;
        if (divided_once) {
            family.scouts.push_back(family.scout);
            add_followers(node, family.scout);
        } else {
            add_scouts(node, family);
            // The one next to the middle.
            if (!family.scouts.empty()) family.scout = *std::ranges::max_element(family.scouts, {}, off);
        }
        // The first leaves of a group may be decided before others are.
        followers_[family.scout / 64] &= ~(std::uint64_t{1} << (family.scout % 64));
        add_stand_ins(node, family.scout, divided_once);
        families_.push_back(std::move(family));
    }
    add_few_stand_ins();
}

// Makes all leaves of a node followers but one.
void DirectionCells::add_followers(const DirectionNode& node, std::uint32_t scout)
{
    for (std::uint32_t leaf = node.first_leaf; leaf < node.first_leaf + node.leaves; ++leaf)
        if (leaf != scout) family_followers_[leaf / 64] |= std::uint64_t{1} << (leaf % 64);
}

// The leaf of a node whose direction is next to the node's middle.
std::uint32_t DirectionCells::middle_of(const DirectionNode& node) const
{
    std::uint32_t middle = node.first_leaf;
    for (std::uint32_t leaf = middle; leaf < node.first_leaf + node.leaves; ++leaf)
        if (glm::dot(node.axis, directions_[leaf]) > glm::dot(node.axis, directions_[middle])) middle = leaf;
    return middle;
}

// Adds the scouts of a family that was divided further: of four leaves of one cell, the one in the middle, and every
// other leaf. Those of groups have scouts of their own.
void DirectionCells::add_scouts(const DirectionNode& node, CellFamily& family)
{
    for (std::uint32_t q = 0; q < node.count; ++q) {
        const DirectionNode& child = nodes_[node.children + q];
        if (child.leaves >= k_least_group) continue;
        if (child.leaves > 1 && child.leaves != child.count) {
            add_scouts(child, family);
            continue;
        }
        family.scouts.push_back(middle_of(child));
        add_followers(child, family.scouts.back());
    }
}

void DirectionCells::add_around(std::size_t leaf, std::span<std::uint64_t> mask) const
{
    if (families_.empty()) {
        std::ranges::fill(mask, ~std::uint64_t{0});
        return;
    }
    const auto add = [&](const CellFamily& family) {
        for (std::size_t l = family.first; l < family.first + family.leaves; ++l)
            mask[l / 64] |= std::uint64_t{1} << (l % 64);
    };
    const CellFamily& own = families_[family_of_[leaf]];
    add(own);
    for (const std::uint32_t n : own.neighbours) add(families_[n]);
}

void DirectionCells::number_leaves(std::uint32_t node)
{
    nodes_[node].first_leaf = static_cast<std::uint32_t>(nodes_of_.size());
    if (nodes_[node].children == 0)
        nodes_of_.push_back(node);
    else
        for (std::uint32_t q = 0; q < nodes_[node].count; ++q) number_leaves(nodes_[node].children + q);
    nodes_[node].leaves = static_cast<std::uint32_t>(nodes_of_.size()) - nodes_[node].first_leaf;
}

void DirectionCells::add_cones()
{
    for (DirectionNode& node : nodes_) {
        glm::dvec3 sum(0);
        for (int c = 0; c < node.corners; ++c) sum += node.corner[static_cast<std::size_t>(c)];
        const glm::dvec3 axis = glm::normalize(sum);
        double least = 1;
        for (int c = 0; c < node.corners; ++c)
            least = std::min(least, glm::dot(axis, node.corner[static_cast<std::size_t>(c)]));
        node.axis = glm::vec3(axis);
        node.cosine = static_cast<float>(least) - 1e-6f;
    }
}

std::vector<std::int32_t> DirectionCells::same_leaves(const DirectionCells& other) const
{
    std::unordered_map<std::uint64_t, std::int32_t> there;
    for (std::size_t leaf = 0; leaf < other.leaves(); ++leaf)
        there.emplace(other.nodes_[other.nodes_of_[leaf]].place, static_cast<std::int32_t>(leaf));
    std::vector<std::int32_t> same(leaves(), -1);
    for (std::size_t leaf = 0; leaf < leaves(); ++leaf)
        if (const auto at = there.find(nodes_[nodes_of_[leaf]].place); at != there.end()) same[leaf] = at->second;
    return same;
}

bool DirectionCells::same_directions(const DirectionCells& other) const
{
    return directions_ == other.directions_;
}

std::size_t DirectionCells::bytes() const
{
    return nodes_.size() * sizeof(DirectionNode) + families_.size() * sizeof(CellFamily) +
           (stood_for_.size() + few_stood_for_.size()) * sizeof(StoodFor) +
           leaves() * (3 * sizeof(glm::vec3) + sizeof(float) + sizeof(std::uint32_t) + sizeof(std::uint16_t));
}

}   // namespace gnomon::environment_light
