// SPDX-License-Identifier: Apache-2.0
#pragma once
// Draws the handles at the picked object, and moves, turns and scales it while one of them is dragged.

#include <optional>

#include "viewer/gizmo.h"
#include "viewer/panel.h"

namespace gnomon::viewer {

class ObjectHandles {
 public:
    /// Follows the mouse. Where it goes down on a handle, the picked object is frozen, and a drag begins.
    /// @param gizmo  of this window frame; none: no drag begins
    /// @return whether the mouse is dragging a handle
    bool follow(const std::optional<Gizmo>& gizmo, Panel& panel, OverrideList& overrides);
    /// Puts the object back where the drag found it.
    /// @pre dragged()
    void cancel(OverrideList& overrides);
    void forget() { drag_.reset(); }
    bool dragged() const { return drag_.has_value(); }
    /// @param free  the mouse does nothing else
    void draw(const Gizmo& gizmo, bool free) const;

 private:
    struct Drag {
        Gizmo gizmo;
        Gizmo::Handle handle = Gizmo::Handle::none;
        glm::vec2 from{0};
        glm::dmat4 parent{1};
        UserOverride before;
        bool held = false;   // before the drag
    };
    std::optional<Drag> drag_;
};

}   // namespace gnomon::viewer
