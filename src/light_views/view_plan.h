// SPDX-License-Identifier: Apache-2.0
#pragma once
// The update of one light view in a frame: the steps of Oh and Shin [2004, 3.1].
//
// Each view has a static buffer (static objects) and a rendering buffer (all objects). A buffer has two layers: the
// depth of the object nearest to the light at a texel, and that object's number (the item). If two objects are equally
// near, the higher number wins, independent of the order of drawing; so a buffer depends only on its contents, not on
// history.
//
// An executor carries out the steps in this order:
//   1. erase     rendering := static, in these rectangles (where dynamic objects were drawn last)     [1.1, DD]
//   2. rebuild   rendering := empty, in these rectangles (static objects that moved or vanished)      [1.2, SD]
//   3. redraw    draws static objects into one of these rectangles each, clipped to it                [1.3, SS]
//   4.           static := rendering, in the rectangles of 2                                          [2]
//   5. settle    draws objects that have come to rest                                                 [1.4, DS]
//   6.           static := rendering, in the rectangles of 5                                          [2]
//   7. dynamics  draws dynamic objects                                                                [3]
// In steps 5 and 7, a texel whose depth equals the static buffer's gets the higher of both items. Objects are in
// ascending order within each rectangle of 3, within 5 and within 7, and are drawn where they are nearer or equally
// near.
// DEVIATION(Oh and Shin 2004, 3.1): buffers are copied by footprint instead of completely, and erased SD areas are
// rebuilt before any DS is drawn, so that each step touches only the texels that its objects cover.

#include <vector>

#include "light_views/rect.h"
#include "scene/ids.h"

namespace gnomon::light_views {

struct ViewPlan {
    enum class Kind : std::uint8_t {
        idle,          // nothing changes: no draw, no copy
        incremental,   // the steps above
        whole,         // the same with all static objects redrawn: the view is new, or its light came to rest
        restless,      // the light moves: the rendering buffer is emptied and everything drawn (`dynamics`); the static
                       // buffer is not updated or used until the next `whole`
    };
    struct Redraw {
        scene::ObjectId object = scene::none;
        std::uint32_t rect = 0;   // index into rebuild
    };
    struct Settle {
        scene::ObjectId object = scene::none;
        Rect rect;
    };

    Kind kind = Kind::idle;
    std::vector<Rect> erase;
    std::vector<Rect> rebuild;
    std::vector<Redraw> redraw;   // ordered by rectangle, then by object
    std::vector<Settle> settle;
    std::vector<scene::ObjectId> dynamics;
    /// Objects whose shadow textures may have changed, ascending: those drawn in 5 and 7, and static objects whose
    /// footprint meets that of a change, before or after it, unless they lie completely nearer to the light [3.2]. Only
    /// with LightViewsOptions::receivers.
    std::vector<scene::ObjectId> receivers;
    std::vector<scene::ObjectId>
        departed;   // had a footprint and have none now; only with receivers, and only for `incremental`

    void clear();
    std::size_t draws() const { return redraw.size() + settle.size() + dynamics.size(); }
    std::size_t copies() const { return erase.size() + rebuild.size() + settle.size(); }
};

inline void ViewPlan::clear()
{
    kind = Kind::idle;
    erase.clear(), rebuild.clear(), redraw.clear(), settle.clear(), dynamics.clear(), receivers.clear(),
        departed.clear();
}

}   // namespace gnomon::light_views
