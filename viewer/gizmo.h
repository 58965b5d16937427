// SPDX-License-Identifier: Apache-2.0
#pragma once
// The handles at the picked object: arrows move it along the world's axes, rings turn it about them, and the square in
// the middle scales it. Sizes are in the window's pixels, and do not depend on the distance of the object.

#include <array>
#include <optional>
#include <vector>

#include "viewer/projection.h"
#include "viewer/session.h"

namespace gnomon::viewer {

class Gizmo {
 public:
    /// The handles: of moves and turns, one for each axis of the world.
    enum class Handle { none, move_x, move_y, move_z, turn_x, turn_y, turn_z, scale };
    static constexpr std::array k_handles{Handle::move_x, Handle::move_y, Handle::move_z, Handle::turn_x,
                                          Handle::turn_y, Handle::turn_z, Handle::scale};
    static constexpr float k_arrow = 84, k_ring = 64, k_square = 7, k_near = 7;   // pixels

    /// The axis of a handle of moves or turns: 0 to 2.
    static int axis_of(Handle handle);
    static bool moves(Handle handle);

    /// @param pivot   around which the object turns and grows, in world space
    /// @param corner  top left corner of the view in the window
    /// @param size    of the view in the window
    Gizmo(const Camera& camera, const glm::vec3& pivot, const glm::vec2& corner, const glm::vec2& size);

    /// The handle at a place of the window.
    Handle at(const glm::vec2& place) const;
    /// The line of a handle in the window; empty if it cannot be seen, as a ring from its edge.
    std::vector<glm::vec2> line(Handle handle) const;

    /// What a drag does, in world space.
    struct Change {
        glm::vec3 move{0}, axis{0, 1, 0};
        float angle = 0, factor = 1;   // radians about the axis; a factor of the size
    };
    Change drag(Handle handle, const glm::vec2& from, const glm::vec2& to) const;

 private:
    std::optional<glm::vec2> in_window(const glm::vec3& point) const;
    glm::vec2 fraction_of(const glm::vec2& place) const { return (place - corner_) / size_; }
    std::optional<float> along(const glm::vec3& axis, const glm::vec2& place) const;
    std::optional<float> around(const glm::vec3& axis, const glm::vec2& place) const;

    Projection view_;
    glm::vec3 pivot_;
    glm::vec2 corner_, size_;
    float metres_per_pixel_;
};

/// An override after a change that began at `before`.
/// @param parent  from the space that the override's transform leads to, to the world
UserOverride changed(const UserOverride& before, const Gizmo::Change& change, const glm::dmat4& parent);

/// From the space above a picked node to the world; the unit matrix if the node has no size in some direction.
glm::dmat4 parent_of(const Picked& picked);
/// The pivot of a picked object, in world space.
glm::vec3 pivot_of(const Picked& picked);

}   // namespace gnomon::viewer
