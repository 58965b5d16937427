// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which places on static surfaces have others so near that they want near light (near_light.h): a few per cent of most
// pictures.
//
// Every static triangle is cut into cells of about the near radius; of a cell's sides a few short rays, spread over the
// cell, tell once and for all whether anything stands close. A function of the static geometry and the radius alone.
//
// Cost: a byte a cell and side; `rays` short rays where one is asked for the first
// time. A look-up is two reads.

#include <atomic>
#include <memory>
#include <vector>

#include "ray/ray_scene.h"

namespace gnomon::light_quadtree {

struct NearHintOptions {
    float radius = 0;       // scene units
    float cell = 3;         // radii: size of a cell
    int most_cells = 128;   // along a triangle's longest side
    int rays = 16;          // a cell and side,
    float reach = 1.5f;     // radii: their length; rather too long than that something is missed
};

class NearHints {
 public:
    using Cell = std::uint32_t;   // of one side
    NearHints(const scene::Scene& scene, const ray::RayScene& rays, const NearHintOptions& options);

    /// @param triangle  among all of the scene; of something static
    Cell cell_at(std::uint32_t triangle, float u, float v, bool front) const
    {
        const std::uint32_t side = sides_[triangle];
        const auto at = [&](float x) {
            return std::min(static_cast<std::uint32_t>(x * static_cast<float>(side)), side - 1);
        };
        return 2 * (first_[triangle] + at(std::max(u, 0.0f)) * side + at(std::max(v, 0.0f))) + (front ? 1u : 0u);
    }
    enum class State : std::uint8_t { unknown, asked, none, near };
    State state(Cell cell) const { return static_cast<State>(states_[cell].load(std::memory_order_acquire)); }
    /// Whether the caller is the one to answer for a cell.
    bool claim(Cell cell)
    {
        std::uint8_t expected = 0;
        return states_[cell].compare_exchange_strong(expected, static_cast<std::uint8_t>(State::asked));
    }
    /// A cell with the place on the scene by which it was found.
    struct Asked {
        Cell cell;
        scene::ObjectId object;
        std::uint32_t triangle;   // of the object
        std::uint32_t at;         // among all of the scene
        bool front;
    };
    struct Scratch {
        ray::RayQueue rays;
        ray::Hits hits;
        std::vector<std::size_t> first;
        std::uint64_t cast = 0;   // counts up
    };
    /// Answers claimed cells. From any thread.
    void answer(const ray::RayScene& rays, const std::vector<Asked>& asked, Scratch& scratch);
    std::size_t bytes() const;

 private:
    NearHintOptions options_;
    std::vector<glm::vec3> directions_;
    std::vector<std::uint32_t> first_;
    std::vector<std::uint8_t> sides_;
    std::size_t cells_ = 0;
    std::unique_ptr<std::atomic<std::uint8_t>[]> states_;
};

}   // namespace gnomon::light_quadtree
