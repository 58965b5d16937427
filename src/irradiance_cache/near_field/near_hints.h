// SPDX-License-Identifier: Apache-2.0
#pragma once
// Hints of where the near field (near_light.h) is needed: which places on static surfaces have others close by. In most
// images these are a few per cent of the pixels.
//
// Every static triangle is divided into cells of about the near radius. Short rays, spread over a side of a cell,
// decide once whether anything is close to it. The answer is a function of the static geometry and the radius, so a
// forgotten hint is found again as it was.
//
// Threads claim unknown cells, answer all that they claimed, and only then wait for those that others claimed; the wait
// sleeps on a condition variable.
//
// Cost: 16 to 32 bytes per cell and side that was looked up; `rays` short rays for one that is new. A look-up takes one
// of many locks.

#include <array>
#include <condition_variable>
#include <mutex>
#include <vector>

#include "ray/ray_scene.h"

namespace gnomon::irradiance_cache {

struct NearHintOptions {
    float radius = 0;       // scene units
    float cell = 3;         // radii: size of a cell
    int most_cells = 128;   // at most, along a triangle's longest side
    int rays = 32;          // per cell and side: a cell that they call free although it is not ends light abruptly
    float reach = 1.5f;     // radii: their length; a hint too many costs less than a surface that is missed
    std::size_t memory = 4u << 20;   // bytes; beyond that, cells unused for two such amounts are forgotten
};

class NearHints {
 public:
    using Cell = std::uint64_t;   // names one side of a cell
    enum class State : std::uint8_t { unknown, claimed, none, near };

    explicit NearHints(const NearHintOptions& options);

    /// Rays that the answer for a cell takes.
    std::uint64_t rays_of_cell() const { return directions_.size(); }
    /// Cells along a triangle's longest side.
    std::uint32_t cells_along(const glm::vec3 (&corners)[3]) const;
    /// @param triangle  among all of the scene; of a static object
    /// @param side      cells_along() it
    static Cell cell_at(std::uint32_t triangle, std::uint32_t side, float u, float v, bool front);

    State state(Cell cell);
    /// The same; but an unknown cell is claimed, and the caller must answer or abandon it.
    State claim(Cell cell);
    /// A claimed cell, and its place in the scene.
    struct Claim {
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
    /// Answers claimed cells. Thread-safe.
    void answer(const ray::RayScene& rays, const std::vector<Claim>& claims, Scratch& scratch);
    /// Wakes all who wait, because some cells will not be answered. Thread-safe.
    void abandon() noexcept;
    /// Waits until a cell is answered. Thread-safe.
    /// @return  State::claimed if it was abandoned
    State wait(Cell cell);

    /// Between frames: forgets cells if they take too much memory. Every claimed cell must be answered.
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
        Table now, before;   // cells that are looked up move from the second to the first
    };
    static constexpr std::size_t k_shards = 64;
    Shard& shard_of(Cell cell);
    static std::uint64_t* find(Shard& shard, Cell cell);

    NearHintOptions options_;
    std::vector<glm::vec3> directions_;
    std::array<Shard, k_shards> shards_;
    std::mutex wait_mutex_;
    std::condition_variable answered_;
    bool abandoned_ = false;   // under wait_mutex_
};

}   // namespace gnomon::irradiance_cache
