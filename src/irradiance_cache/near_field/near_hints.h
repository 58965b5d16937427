// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which places on static surfaces have others so near that they want near light (near_light.h): a few per cent of most
// images.
//
// Every static triangle is cut into cells of about the near radius; of a cell's sides a few short rays, spread over the
// cell, tell once and for all whether anything stands close. A function of the static geometry and the radius alone: so
// what was forgotten is found again as it was.
//
// Cost: 16 to 32 bytes a cell and side, of those that were asked for; `rays` short rays where one is asked for the
// first time. A look-up takes a lock, one of many.

#include <array>
#include <mutex>
#include <vector>

#include "ray/ray_scene.h"

namespace gnomon::irradiance_cache {

struct NearHintOptions {
    float radius = 0;                // scene units
    float cell = 3;                  // radii: size of a cell
    int most_cells = 128;            // along a triangle's longest side; no more than that
    int rays = 16;                   // a cell and side,
    float reach = 1.5f;              // radii: their length; rather too long than that something is missed
    std::size_t memory = 4u << 20;   // bytes; beyond, what two such amounts ago was asked for is forgotten
};

class NearHints {
 public:
    using Cell = std::uint64_t;   // of one side: names it
    enum class State : std::uint8_t { unknown, asked, none, near };

    explicit NearHints(const NearHintOptions& options);

    /// Cells along a triangle's longest side.
    std::uint32_t cells_along(const glm::vec3 (&corners)[3]) const;
    /// @param triangle  among all of the scene; of something static
    /// @param side      cells_along() it
    static Cell cell_at(std::uint32_t triangle, std::uint32_t side, float u, float v, bool front);

    State state(Cell cell);
    /// The same, but of a cell that was unknown: it counts as asked now, and the caller is the one to answer.
    State claim(Cell cell);
    /// A cell with the place on the scene by which it was found.
    struct Asked {
        Cell cell;
        scene::ObjectId object;
        std::uint32_t triangle;   // of the object
        std::uint32_t side;       // cells_along() it
    };
    struct Scratch {
        ray::RayQueue rays;
        ray::Hits hits;
        std::uint64_t cast = 0;   // counts up
    };
    /// Answers claimed cells. From any thread.
    void answer(const ray::RayScene& rays, const std::vector<Asked>& asked, Scratch& scratch);

    /// Between frames: forgets if they take too much. Every claimed cell must have its answer.
    void end_frame();
    std::size_t bytes() const;

 private:
    // A cell's name and its state in one word; open addressing, a power of two of slots, at most half of them taken.
    struct Table {
        std::vector<std::uint64_t> slots;
        std::size_t taken = 0;
        std::uint64_t* find(Cell cell);
        void add(std::uint64_t word);
    };
    struct Shard {
        std::mutex mutex;
        Table now, before;   // what is asked for moves from the second to the first
    };
    static constexpr std::size_t k_shards = 64;
    Shard& shard_of(Cell cell);
    static std::uint64_t* find(Shard& shard, Cell cell);

    NearHintOptions options_;
    std::vector<glm::vec3> directions_;
    std::array<Shard, k_shards> shards_;
};

}   // namespace gnomon::irradiance_cache
