// SPDX-License-Identifier: Apache-2.0
#pragma once
// The table of remembered surface points: by anchor, shared by all threads.
//
// Threads look up and add at once; a point is evaluated by whoever claims it for the frame first, and read by others
// once it is ready. What a point holds is a function of its anchor, the scene and the frame, so who did it does not
// matter. Points that were not seen lately go first when there are too many; between frames only.

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "irradiance_cache/light_tree/point_kernels.h"
#include "irradiance_cache/points/anchors.h"
#include "irradiance_cache/points/sky_light.h"

namespace gnomon::irradiance_cache {

inline constexpr std::uint32_t k_no_owner = scene::none;   // of what stands still

struct RememberedPoint {
    AnchorKey key = 0;
    bool exists = false;     // the anchor meets a surface
    bool waits = false;      // for its light, from a PointEngine
    float lift = 0;          // of where rays start
    glm::vec3 position{0};   // on the surface
    glm::vec3 normal{0};     // unit, shading
    glm::vec3 geometric_normal{0};
    // Of near light: free[0] is how far what lies nearest is.
    // Of lattice anchors: how far the way is open along the lattice, -b +b -c +c; and how much less of it is open a
    // unit further along the other axis, as what ends it stands.
    float free[4] = {0, 0, 0, 0};
    std::int16_t slopes[4] = {0, 0, 0, 0};
    // By colour: irradiance is dot(light, normal), near this point's own normal. If nothing moved; and present.
    glm::vec3 still[3] = {}, light[3] = {};
    std::uint32_t owner = k_no_owner;    // of what moves: EmitterTree::owner_of()
    std::uint32_t version = 0;           // of the emitters' geometry that `seen` belongs to; 0: never asked
    std::uint32_t dynamic_version = 0;   // that `light` belongs to
    // What it sees of the emitters past everything static; padded to k_seen_step. With a PointEngine, that has it.
    std::uint32_t count = 0;
    std::uint32_t kept = 0;   // the engine's name for it, if count > 0
    std::unique_ptr<SeenNode[]> seen;
    SkyMask sky;                                       // directions that it sees past everything static
    std::atomic<std::uint32_t> claimed{0}, ready{0};   // frames

    glm::vec3 origin() const { return position + lift * geometric_normal; }
    static constexpr float k_steepest = 4;   // slope
    float slope(int way) const { return static_cast<float>(slopes[way]) * (k_steepest / 32767); }
    void set_slope(int way, float s) { slopes[way] = static_cast<std::int16_t>(std::lround(s * (32767 / k_steepest))); }
};

class SurfacePoints {
 public:
    SurfacePoints();
    /// The point of an anchor, made empty if it is new. Thread-safe; the address stays until drop().
    RememberedPoint& at(AnchorKey key);
    /// A point's list of seen nodes has another length now. Thread-safe.
    void resized(std::size_t before, std::size_t after)
    {
        seen_bytes_.fetch_add((after - before) * sizeof(SeenNode), std::memory_order_relaxed);
    }
    /// Between frames: if the points take more than `budget` bytes, drops the longest unseen until a quarter of it is
    /// free; what was seen in `frame` stays, and half as much to as much beside it.
    /// @param dropped  called for each
    void drop_unseen(std::uint32_t frame, std::size_t budget,
                     const std::function<void(const RememberedPoint&)>& dropped);
    /// Between frames: drops all.
    void clear(const std::function<void(const RememberedPoint&)>& dropped);
    std::size_t size() const;
    std::size_t bytes() const;

 private:
    static constexpr std::size_t k_shards = 64;
    static std::uint64_t mixed(AnchorKey key)
    {
        key ^= key >> 31;
        key *= 0x9e3779b97f4a7c15ull;
        key ^= key >> 29;
        key *= 0xbf58476d1ce4e5b9ull;
        return key ^ (key >> 32);
    }
    struct Shard {
        std::mutex mutex;
        std::vector<RememberedPoint*> slots;   // open addressing; a power of two
        std::vector<std::unique_ptr<RememberedPoint>> points;
    };
    static void insert(Shard& shard, RememberedPoint* point);
    std::array<Shard, k_shards> shards_;
    std::atomic<std::size_t> seen_bytes_ = 0;   // of all lists
};

}   // namespace gnomon::irradiance_cache
