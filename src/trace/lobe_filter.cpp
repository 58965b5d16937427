// SPDX-License-Identifier: Apache-2.0
#include "trace/lobe_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"
#include "base/interruption.h"
#include "shading/lobe_rays.h"

namespace gnomon::trace {

namespace {

constexpr int k_half = shading::k_lobe_interleave / 2;

constexpr float k_apart = 1000;   // a difference of lobes that have nothing in common
const LobePixel k_no_lobe;

// The first and the last column, and row, of the window have the same patterns: each counts half.
float part_at(int offset)
{
    return offset == -k_half || offset == k_half ? 0.5f : 1.0f;
}

// The square of how much two lobes differ, in widths.
float difference(const LobePixel& a, const LobePixel& b, const LobeFilterOptions& options)
{
    const glm::vec3 apart = b.position - a.position, turn = b.axis - a.axis;
    const float square = apart.x * apart.x + apart.y * apart.y + apart.z * apart.z;
    const float footprint = std::max(a.footprint, b.footprint);
    if (!(b.width > 0) || !(square < options.near * options.near * (footprint * footprint))) return k_apart;
    const float width = std::min(a.width, b.width), wider = std::max(a.width, b.width) - width;
    return (turn.x * turn.x + turn.y * turn.y + turn.z * turn.z + wider * wider) / (width * width);
}

// How far a neighbour's rays could be the pixel's own, 0 to 1, by the square of the difference.
struct Likeness {
    float unlike, slope;
    explicit Likeness(const LobeFilterOptions& o)
        : unlike(o.unlike * o.unlike), slope(1 / (o.unlike * o.unlike - o.alike * o.alike))
    {
    }
    float operator()(float difference) const
    {
        const float t = std::min(std::max((unlike - difference) * slope, 0.0f), 1.0f);
        return t * t * (3 - 2 * t);
    }
};

// A row of pixels, and their neighbours in one direction.
struct Neighbours {
    const float *px, *py, *pz, *ax, *ay, *az, *width, *footprint;
    const float *other_px, *other_py, *other_pz, *other_ax, *other_ay, *other_az, *other_width, *other_footprint;
    const float* other_rays;
};

// As difference() and Likeness, for a row. Without branches, so that compilers use vectors.
void find_shares(const Neighbours& n, int first, int end, float near, const Likeness& likeness, float edge,
                 float* __restrict share)
{
    for (int x = first; x < end; ++x) {
        const float dx = n.other_px[x] - n.px[x], dy = n.other_py[x] - n.py[x], dz = n.other_pz[x] - n.pz[x];
        const float tx = n.other_ax[x] - n.ax[x], ty = n.other_ay[x] - n.ay[x], tz = n.other_az[x] - n.az[x];
        const float square = dx * dx + dy * dy + dz * dz, turn = tx * tx + ty * ty + tz * tz;
        const float a = n.footprint[x], b = n.other_footprint[x], footprint = a < b ? b : a;
        const float w = n.width[x], v = n.other_width[x], width = v < w ? v : w, wider = (v < w ? w : v) - width;
        const float rays = n.other_rays[x], close = square < near * (footprint * footprint) ? rays : 0.0f;
        const float apart = (turn + wider * wider) / (width * width);
        float t = (likeness.unlike - apart) * likeness.slope;
        t = t > 0 ? t : 0.0f;   // nor where a width is 0
        t = t < 1 ? t : 1.0f;
        share[x] = t * t * (3 - 2 * t) * close * edge;
    }
}

void add_products(const float* __restrict share, const float* __restrict of, int first, int end, float* __restrict sum)
{
    for (int x = first; x < end; ++x) sum[x] += share[x] * of[x];
}

}   // namespace

LobeImage::LobeImage(Size size, int side)
    : size_(size),
      side_(side),
      columns_((size.width + side - 1) / side),
      tiles_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>((size.height + side - 1) / side)),
      spread_(tiles_.size())
{
}

LobePixel& LobeImage::at(int x, int y)
{
    auto& tile = tiles_[tile_of(x, y)];
    if (!tile) tile = std::make_unique<LobePixel[]>(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
    return tile[in_tile(x, y)];
}

const LobePixel& LobeImage::at(int x, int y) const
{
    const auto& tile = tiles_[tile_of(x, y)];
    return tile ? tile[in_tile(x, y)] : k_no_lobe;
}

std::array<glm::vec3, 9>& LobeImage::spread(int x, int y)
{
    auto& tile = spread_[tile_of(x, y)];
    if (!tile) {
        tile = std::make_unique<Spread[]>(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
        std::fill_n(tile.get(), side_ * side_, Spread{});
    }
    return tile[in_tile(x, y)];
}

glm::vec3 LobeImage::filtered(int x, int y, const LobeFilterOptions& options) const
{
    const LobePixel& own = at(x, y);
    if (own.weight == glm::vec3(0)) return glm::vec3(0);
    if (!(own.width > 0)) return own.light;
    const Likeness likeness(options);
    glm::vec3 light(0), weight(0);
    for (int dy = -k_half; dy <= k_half; ++dy)
        for (int dx = -k_half; dx <= k_half; ++dx) {
            const int nx = x + dx, ny = y + dy;
            if (nx < 0 || ny < 0 || nx >= size_.width || ny >= size_.height) continue;
            const LobePixel& other = at(nx, ny);
            if (!(other.width > 0)) continue;
            const float edge = part_at(dx) * part_at(dy);
            const float share = likeness(difference(own, other, options)) * other.rays * edge;
            light += share * other.light, weight += share * other.weight;
        }
    glm::vec3 result(0);
    for (int c = 0; c < 3; ++c) result[c] = weight[c] > 0 ? own.weight[c] * (light[c] / weight[c]) : own.light[c];
    return result;
}

float LobeImage::rays_wanted(int x, int y, int left, int top, int width, int height,
                             const LobeFilterOptions& options) const
{
    // Of each ring of neighbours, ask four.
    const Likeness likeness(options);
    const LobePixel& own = at(x, y);
    float alike = 1, step = k_apart;
    for (int ring = 1; ring <= k_half; ++ring) {
        int asked = 0;
        float sum = 0;
        for (int k = 0; k < 4; ++k) {
            // Along the axes and the diagonals, in turn.
            const int dx = ring % 2 == 1 ? (k % 2 == 0 ? ring * (1 - k) : 0) : ring * (k % 2 == 0 ? 1 : -1);
            const int dy = ring % 2 == 1 ? (k % 2 == 1 ? ring * (2 - k) : 0) : ring * (k < 2 ? 1 : -1);
            const int nx = x + dx, ny = y + dy;
            if (nx < left || ny < top || nx >= left + width || ny >= top + height) continue;
            const float apart = difference(own, at(nx, ny), options);
            if (ring == 1) step = std::min(step, apart);
            sum += likeness(apart), ++asked;
        }
        const float pixels = ring == k_half ? 4 * k_half - 1 : 8 * ring;   // those of the last ring count half
        if (asked > 0) alike += pixels * sum / static_cast<float>(asked);
    }
    // Where neighbours are far apart, a narrow lobe shows little within one pixel.
    const float few = step < k_apart
                          ? std::max(options.rays_across / std::max(std::sqrt(step), 1e-3f), options.own_rays)
                          : options.rays;
    return std::min(std::max(options.rays / alike, options.least_rays), few);
}

// A tile and the pixels around it that count for its own, by component.
struct LobeImage::Window {
    int stride = 0, height = 0;
    enum Of { px, py, pz, ax, ay, az, width, footprint, rays, lr, lg, lb, wr, wg, wb, k_values };
    std::vector<float> values[k_values];
    std::vector<float> share, light[3], weight[3];   // of a row of the tile

    float* row(Of of, int y) { return values[of].data() + static_cast<std::size_t>(y * stride); }
    void resize(int side)
    {
        stride = height = side + 2 * k_half;
        for (auto& list : values) list.assign(static_cast<std::size_t>(stride * height), 0);
        share.resize(static_cast<std::size_t>(side));
        for (auto* lists : {light, weight})
            for (int c = 0; c < 3; ++c) lists[c].resize(static_cast<std::size_t>(side));
    }
    void take(int x, int y, const LobePixel& p, const glm::vec3& found)
    {
        const float all[k_values]{p.position.x, p.position.y, p.position.z, p.axis.x,   p.axis.y,
                                  p.axis.z,     p.width,      p.footprint,  p.rays,     found.x,
                                  found.y,      found.z,      p.weight.x,   p.weight.y, p.weight.z};
        for (int k = 0; k < k_values; ++k) values[k][static_cast<std::size_t>(y * stride + x)] = all[k];
    }
};

// Filters the pixels of a tile, a row at a time for each neighbour: the same sums as filtered(), in the same order.
void LobeImage::filter_tile(int left, int top, glm::vec3 LobePixel::*from, glm::vec3 LobePixel::*to, Window& window,
                            const LobeFilterOptions& options)
{
    window.resize(side_);
    for (int y = 0; y < window.height; ++y)
        for (int x = 0; x < window.stride; ++x) {
            const int nx = left + x - k_half, ny = top + y - k_half;
            if (nx < 0 || ny < 0 || nx >= size_.width || ny >= size_.height || !tiles_[tile_of(nx, ny)]) continue;
            const LobePixel& pixel = tiles_[tile_of(nx, ny)][in_tile(nx, ny)];
            if (pixel.width > 0) window.take(x, y, pixel, pixel.*from);
        }
    const float near = options.near * options.near;
    const Likeness likeness(options);
    using Of = Window::Of;
    for (int y = 0; y < side_ && top + y < size_.height; ++y) {
        // Find the part of the row that has lobes.
        LobePixel* const pixels = tiles_[tile_of(left, top)].get() + y * side_;
        int first = side_, end = 0;
        for (int x = 0; x < side_; ++x)
            if (pixels[x].weight != glm::vec3(0)) first = std::min(first, x), end = x + 1;
        if (first >= end) continue;
        for (auto* sums : {window.light, window.weight})
            for (int c = 0; c < 3; ++c) std::fill(sums[c].begin(), sums[c].end(), 0.0f);
        const auto own = [&](Of of) { return window.row(of, y + k_half) + k_half; };
        for (int dy = -k_half; dy <= k_half; ++dy)
            for (int dx = -k_half; dx <= k_half; ++dx) {
                const auto other = [&](Of of) { return window.row(of, y + k_half + dy) + k_half + dx; };
                const float edge = part_at(dx) * part_at(dy);
                const Neighbours n{own(Of::px),    own(Of::py),   own(Of::pz),      own(Of::ax),
                                   own(Of::ay),    own(Of::az),   own(Of::width),   own(Of::footprint),
                                   other(Of::px),  other(Of::py), other(Of::pz),    other(Of::ax),
                                   other(Of::ay),  other(Of::az), other(Of::width), other(Of::footprint),
                                   other(Of::rays)};
                float* const share = window.share.data();
                find_shares(n, first, end, near, likeness, edge, share);
                const Of light[3]{Of::lr, Of::lg, Of::lb}, weight[3]{Of::wr, Of::wg, Of::wb};
                for (int c = 0; c < 3; ++c) {
                    add_products(share, other(light[c]), first, end, window.light[c].data());
                    add_products(share, other(weight[c]), first, end, window.weight[c].data());
                }
            }
        for (int x = first; x < end; ++x) {
            LobePixel& pixel = pixels[x];
            if (pixel.weight == glm::vec3(0)) continue;
            for (int c = 0; c < 3; ++c) {
                const auto at = static_cast<std::size_t>(x);
                const float light = window.light[c][at], weight = window.weight[c][at];
                (pixel.*to)[c] = pixel.width > 0 && weight > 0 ? pixel.weight[c] * (light / weight) : (pixel.*from)[c];
            }
        }
    }
}

template <class Done>
void LobeImage::filter(Tasks& tasks, const LobeFilterOptions& options, const Done& done)
{
    std::vector<std::size_t> there;
    for (std::size_t t = 0; t < tiles_.size(); ++t)
        if (tiles_[t]) there.push_back(t);
    std::vector<Window> windows(static_cast<std::size_t>(tasks.threads()));
    const auto for_each_tile = [&](const auto& body) {
        tasks.for_each(there.size(), [&](std::size_t i, int worker) {
            interruption_point();
            const int tile = static_cast<int>(there[i]);
            body(tile % columns_ * side_, tile / columns_ * side_, windows[static_cast<std::size_t>(worker)]);
        });
    };
    for_each_tile([&](int left, int top, Window& window) {
        filter_tile(left, top, &LobePixel::light, &LobePixel::once, window, options);
    });
    for_each_tile([&](int left, int top, Window& window) {
        filter_tile(left, top, &LobePixel::once, &LobePixel::filtered, window, options);
        for (int y = top; y < std::min(top + side_, size_.height); ++y)
            for (int x = left; x < std::min(left + side_, size_.width); ++x) done(x, y);
    });
}

void LobeImage::add_to(ImageF& color, float scale, Tasks& tasks, const LobeFilterOptions& options)
{
    GNOMON_CHECK(color.width == size_.width && color.height == size_.height);
    filter(tasks, options, [&](int x, int y) {
        const glm::vec3 light = scale * std::as_const(*this).at(x, y).filtered;
        float* const to = color.pixel(x, y);
        for (int c = 0; c < 3; ++c) to[c] += light[c];
    });
}

void LobeImage::add_to(image::SampleSums& sums, Tasks& tasks, const LobeFilterOptions& options)
{
    filter(tasks, options, [&](int x, int y) {
        const LobePixel& pixel = std::as_const(*this).at(x, y);
        const std::size_t tile = tile_of(x, y);
        if (pixel.weight == glm::vec3(0) || !spread_[tile]) return;
        // All samples of the pixel have the filtered light, each times its own weight.
        glm::vec3 radiance(0);
        for (int c = 0; c < 3; ++c)
            if (pixel.weight[c] > 0) radiance[c] = pixel.filtered[c] / pixel.weight[c];
        Spread light = spread_[tile][in_tile(x, y)];
        for (glm::vec3& to : light) to *= radiance;
        sums.add_light(tile, x % side_, y % side_, light);
    });
}

}   // namespace gnomon::trace
