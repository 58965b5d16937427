// SPDX-License-Identifier: Apache-2.0
#pragma once
// Remembers roughly how much bounced light arrives where, for pixels whose cache points are left to a later frame:
// means by cells of two grids and by the axis that the surface faces most; between axes, it is mixed. A mean over the
// whole image in their place would make dark corners glow, and bright halls dark.

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "base/math.h"

namespace gnomon::irradiance_cache {

class RoughLight {
 public:
    /// The irradiance of a pixel, or of a patch.
    struct Sample {
        glm::vec3 position, normal, irradiance;
        float weight = 1;   // above 0
    };
    /// @param bounds  of the scene, for the cells' width
    explicit RoughLight(const Box3& bounds);

    /// Nothing is known.
    bool empty() const { return means_.empty(); }
    /// What arrives at a point; where nothing near it is known, what arrives in the mean. Thread-safe.
    glm::vec3 at(const glm::vec3& position, const glm::vec3& normal) const;
    /// Between frames: notes what pixels of the last frame received.
    void note(const std::vector<Sample>& samples);
    std::size_t bytes() const;

 private:
    struct Mean {
        glm::vec3 before{0};   // of frames before
        glm::vec3 sum{0};      // of this frame
        float weight = 0;      // of its samples
        bool known = false;    // before
    };
    using Key = std::uint64_t;
    static Key key(const glm::ivec3& cell, int axis, bool negative, int grid);
    glm::vec3 place(const glm::vec3& position, int grid) const;

    static constexpr int k_grids = 2;
    float inverse_width_[k_grids];
    std::unordered_map<Key, Mean> means_;
    Mean everywhere_;
    std::vector<Mean*> changed_;
};

}   // namespace gnomon::irradiance_cache
