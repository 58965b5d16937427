// SPDX-License-Identifier: Apache-2.0
#include "trace/kept_tiles.h"

#include <array>
#include <cmath>

#include "scene/light_reach.h"

namespace gnomon::trace {

namespace {

// The camera rays of a tile lie between four planes, one pixel outside of it.
class TilePyramid {
 public:
    TilePyramid(const Tile& tile, const scene::View& view)
    {
        const auto x0 = static_cast<float>(tile.x - 1), x1 = static_cast<float>(tile.x + tile.width + 1);
        const auto y0 = static_cast<float>(tile.y - 1), y1 = static_cast<float>(tile.y + tile.height + 1);
        const std::array<glm::vec2, 4> corners{glm::vec2(x0, y0), {x1, y0}, {x1, y1}, {x0, y1}};
        std::array<glm::vec3, 4> origins, directions;
        float near, far;
        for (std::size_t i = 0; i < 4; ++i) view.ray(corners[i].x, corners[i].y, origins[i], directions[i], near, far);
        glm::vec3 inside, along;
        view.ray(0.5f * (x0 + x1), 0.5f * (y0 + y1), inside, along, near, far);
        inside += along;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t next = (i + 1) % 4;
            origin_[i] = origins[i];
            normal_[i] = glm::cross(directions[i], origins[next] + directions[next] - origins[i]);
            if (glm::dot(normal_[i], inside - origin_[i]) < 0) normal_[i] = -normal_[i];
        }
    }

    /// Conservative, and monotone.
    bool meets(const Box3& box) const
    {
        for (std::size_t i = 0; i < 4; ++i) {
            const glm::vec3 &n = normal_[i], &o = origin_[i];
            const glm::vec3 furthest(n.x > 0 ? box.high.x : box.low.x, n.y > 0 ? box.high.y : box.low.y,
                                     n.z > 0 ? box.high.z : box.low.z);
            if (glm::dot(n, furthest - o) < 0) return false;
        }
        return true;
    }

 private:
    std::array<glm::vec3, 4> origin_, normal_;
};

}   // namespace

std::size_t KeptTile::bytes() const
{
    return sizeof(KeptTile) + points.capacity() * sizeof(KeptPoint) + reflections.capacity() * sizeof(KeptReflection) +
           whole.capacity() * sizeof(TilePoint) + whole_shadow_points.capacity() * sizeof(visibility::ShadowPoint) +
           color.capacity() * sizeof(glm::vec3) + blocks.capacity() * sizeof(Box3) + (bounced ? bounced->bytes() : 0);
}

void KeptTiles::forget()
{
    began_ = false;
    bounds_.reset();
    tiles_.clear();
    bytes_ = 0;
}

void KeptTiles::begin_frame(const FrameContext& frame, std::size_t tiles, int side, bool continues, float sun_radius)
{
    const scene::FrameChanges& changes = frame.state.changes();
    const bool only_objects = changes.lights_moved.empty() && changes.lights_relit.empty() &&
                              changes.materials_changed.empty() && changes.added.empty() && changes.removed.empty() &&
                              changes.promoted.empty() && changes.separated.empty();
    if (!began_ || !continues || !only_objects) {
        forget();
        began_ = true;
        return;
    }
    if (!bounds_) {
        bounds_ = std::make_unique<visibility::DynamicBounds>(frame.state, frame.rays);
        tiles_.resize(tiles);
        return;
    }

    // Drop the tiles that what changed may touch.
    bounds_->update(frame.state, frame.rays);
    std::vector<Box3> boxes;
    for (const visibility::DynamicBounds::Placed& placed : bounds_->placed()) {
        boxes.push_back(placed.before);
        boxes.push_back(bounds_->box(placed.index));
    }
    const BoxTree changed(boxes);
    const int columns = (frame.view.size.width + side - 1) / side;
    frame.tasks.for_each(tiles, [&](std::size_t index, int) {
        if (!tiles_[index]) return;
        const Tile place = tile_at(index, columns, side, frame.view.size);
        if (!may_change(*tiles_[index], place, changed, frame.state, frame.view, sun_radius)) return;
        bytes_ -= tiles_[index]->bytes();
        tiles_[index].reset();
    });
}

void KeptTiles::limit(std::size_t bytes)
{
    most_bytes_ = std::min(bytes, k_most_bytes);
    if (bytes_ > most_bytes_) forget();
}

std::unique_ptr<KeptTile> KeptTiles::take()
{
    return bytes_ < most_bytes_ - most_bytes_ / 8 ? std::make_unique<KeptTile>() : nullptr;
}

void KeptTiles::remember(KeptTile& tile, std::unique_ptr<IndirectLight::Remembered> bounced)
{
    if (tile.bounced) bytes_ -= tile.bounced->bytes();
    tile.bounced.reset();
    if (!bounced || bytes_ >= most_bytes_) return;
    bytes_ += bounced->bytes();
    tile.bounced = std::move(bounced);
}

void KeptTiles::keep(std::size_t tile, std::unique_ptr<KeptTile> kept)
{
    bytes_ += kept->bytes();
    tiles_[tile] = std::move(kept);
}

bool may_change(const KeptTile& tile, const Tile& place, const BoxTree& changed, const scene::SceneState& state,
                const scene::View& view, float sun_radius)
{
    bool found = false;
    const auto find = [&](const auto& meets) {
        if (!found)
            changed.find([&](const Box3& box) { return !found && meets(box); }, [&](std::uint32_t) { found = true; });
        return found;
    };

    // Test the camera rays, to their ends if all of them have one.
    const TilePyramid pyramid(place, view);
    const bool ends = !tile.misses && !view.orthographic;
    if (find([&](const Box3& box) {
            return pyramid.meets(box) && (!ends || visibility::may_shadow(box, tile.hits, view.eye, false));
        }))
        return true;

    // Test the segments to lights, block by block if the tile's own box does not settle it.
    if (tile.hits.empty()) return false;
    for (std::size_t l = 0; l < state.scene().lights.size(); ++l) {
        const scene::LightState& at = state.light(static_cast<scene::LightId>(l));
        if (!at.visible) continue;
        const scene::LightReach reach(state.scene().lights[l], at);
        const auto shadows = [&](const Box3& box, const Box3& points) {
            return reach.directional() ? visibility::may_shadow(box, points, reach.place(), sun_radius)
                                       : visibility::may_shadow(box, points, reach.place(), false);
        };
        for (const Box3& block : tile.blocks)
            if (!block.empty() && find([&](const Box3& box) { return shadows(box, tile.hits) && shadows(box, block); }))
                return true;
    }
    return false;
}

}   // namespace gnomon::trace
