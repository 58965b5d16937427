// SPDX-License-Identifier: Apache-2.0
#pragma once
// What tiles keep of their first hits from frame to frame, as long as the camera stands still.
//
// A first hit, its surface and its light from points and suns depend on what lies between the eye, the surface and the
// lights. Where no dynamic object that changed was or is in between, all of them are those of the frame before, to the
// bit. So a tile keeps its first hits with the light they have without bounces, and is traced anew only if the box of
// an object that changed, as it was or as it is, may touch one of its camera rays, or a segment from what it shows to a
// light. Light that arrives by bounces, and what mirrors and glass show, is found anew in each frame: what moves in a
// room changes most of that.
//
// The proof is conservative: it tests boxes of 8 x 8 pixels' hits against boxes of objects.
//
// Cost: a frame: the tests of each tile against a tree of the changed boxes. A kept tile: copying its points. Memory:
// 100 bytes a pixel, and 570 for one that mirrors; and what bounced light remembers, 10 bytes a pixel of a plane.

#include <atomic>
#include <memory>
#include <vector>

#include "base/box_tree.h"
#include "trace/indirect_light.h"
#include "trace/point_batch.h"
#include "visibility/dynamic_bounds.h"

namespace gnomon::trace {

/// A first hit that reflects diffusely, or whose other reflection needs no ray: what its bounced light is found from.
struct KeptPoint {
    glm::vec3 position{0}, geometric_normal{0}, normal{0}, to_viewer{0};
    float width = 0;
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;
};

/// How it reflects its bounced light. Apart, because in most frames nothing else is read.
struct KeptReflection {
    glm::vec3 diffuse{0};
    float coverage = 1;
    std::uint16_t pixel = 0;   // of the tile
    scene::ShadingModel model = scene::ShadingModel::metallic_roughness;
    bool whole = false;   // the point is the next one of KeptTile::whole instead
};

/// A tile's first hits, before bounced light and what mirrors show.
struct KeptTile {
    static constexpr int k_block = 8;   // pixels a side

    std::vector<KeptPoint> points;   // in the order in which they are shaded
    std::vector<KeptReflection> reflections;
    // Those from which rays go on, or which need more than the above.
    std::vector<TilePoint> whole;
    std::vector<visibility::ShadowPoint> whole_shadow_points;
    std::vector<glm::vec3> color;                         // by pixel of the tile: their light, and the background
    Box3 hits;                                            // where camera rays end and shadow rays begin
    std::vector<Box3> blocks;                             // the same, by block of pixels
    bool misses = false;                                  // some camera ray left the scene
    std::unique_ptr<IndirectLight::Remembered> bounced;   // null: nothing is remembered

    std::size_t bytes() const;
};

class KeptTiles {
 public:
    static constexpr std::size_t k_most_bytes = std::size_t{256} << 20;
    /// Between frames. Tiles beyond it, less an eighth for what bounced light remembers, are traced in each frame.
    /// @param bytes  at most k_most_bytes count
    void limit(std::size_t bytes);

    /// Begins a frame: after the state advanced and the ray scene followed.
    /// @param continues  scene, view and options are those of the last frame that was begun, it was finished, and the
    ///                   state advanced once since. Tiles are kept from the second such frame on, so that frames of a
    ///                   camera that moves do not pay for it.
    /// @param sun_radius  angular, of directional lights, in radians
    void begin_frame(const FrameContext& frame, std::size_t tiles, int side, bool continues, float sun_radius);
    /// Forgets all tiles, for example because a frame was lit by something that they do not follow.
    void forget();

    /// Whether tiles that are traced in this frame should be kept.
    bool keeps() const { return bounds_ != nullptr; }
    /// Null: the tile must be traced. Thread-safe for different tiles, as keep().
    KeptTile* find(std::size_t tile) const { return keeps() ? tiles_[tile].get() : nullptr; }
    /// Memory for a tile that is traced; null: there is none left. It is kept once it is given back.
    std::unique_ptr<KeptTile> take();
    void keep(std::size_t tile, std::unique_ptr<KeptTile> kept);
    /// Keeps what a kept tile's bounced light remembers, if there is memory. Replaces what it remembered.
    void remember(KeptTile& tile, std::unique_ptr<IndirectLight::Remembered> bounced);

    std::size_t bytes() const { return bytes_; }

 private:
    std::size_t most_bytes_ = k_most_bytes;
    bool began_ = false;   // a frame
    std::unique_ptr<visibility::DynamicBounds> bounds_;
    std::vector<std::unique_ptr<KeptTile>> tiles_;   // null: must be traced
    std::atomic<std::size_t> bytes_ = 0;
};

/// Whether an object that changed may alter the first hits of a tile, or their light from points and suns.
/// @param changed     boxes of such objects, in this frame and the last one
/// @param sun_radius  angular, of directional lights, in radians
bool may_change(const KeptTile& tile, const Tile& place, const BoxTree& changed, const scene::SceneState& state,
                const scene::View& view, float sun_radius);

}   // namespace gnomon::trace
