// SPDX-License-Identifier: Apache-2.0
#pragma once
// What one light view needs done this frame: the steps of Oh and Shin [2004, 3.1] for the present motion.
//
// Each view has a static buffer (what stands still) and a rendering buffer (everything). A buffer holds two layers: the
// depth of what is nearest the light at a texel, and that object's number (the item). Where two objects are equally
// near, the higher number wins, whatever the order of drawing: so a buffer depends on what is there, not on how it
// came.
//
// An executor carries out the steps in this order:
//   1. erase     rendering := static, in these rectangles (what was dynamic the last time)            [1.1, DD]
//   2. rebuild   rendering := empty, in these rectangles (what stood still and no longer does)        [1.2, SD]
//   3. redraw    draws static objects into one of these rectangles each, clipped to it                [1.3, SS]
//   4.           static := rendering, in the rectangles of 2                                          [2]
//   5. settle    draws objects that have come to rest                                                 [1.4, DS]
//   6.           static := rendering, in the rectangles of 5                                          [2]
//   7. dynamics  draws what moves                                                                     [3]
// In steps 5 and 7 a texel whose depth equals the static buffer's takes the higher item of both. Objects ascend within
// each rectangle of 3, within 5 and within 7, and are drawn where their depth is nearer or equal.
// DEVIATION(Oh and Shin 2004, 3.1): buffers are copied by footprint instead of whole, and what is erased of SD is
// rebuilt before any DS is drawn, so that each step touches only what its objects cover.

#include <vector>

#include "light_views/rect.h"
#include "scene/ids.h"

namespace gnomon::light_views {

struct ViewPlan {
    enum class Kind : std::uint8_t {
        idle,          // nothing to do: no draw, no copy
        incremental,   // the steps above
        whole,         // the same, with everything static redrawn: the view is new, or its light has come to rest
        restless,      // the light moves: the rendering buffer is emptied and everything drawn (`dynamics`); the static
                       // buffer is left alone, and unused until the next `whole`
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
    std::vector<Redraw> redraw;   // by rectangle, then ascending
    std::vector<Settle> settle;
    std::vector<scene::ObjectId> dynamics;
    /// Objects whose shadow textures may have changed, ascending: what is drawn in 5 and 7, and static objects whose
    /// footprint meets that of a change, before or after, unless all of them lies nearer the light [3.2]. Filled on
    /// demand (LightViewsOptions::receivers).
    std::vector<scene::ObjectId> receivers;
    std::vector<scene::ObjectId>
        departed;   // had a footprint and have none now; on demand too; for `incremental` alone

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
