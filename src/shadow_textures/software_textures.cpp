// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/software_textures.h"

namespace gnomon::shadow_textures {

using light_views::Casters;
using light_views::Rect;
using light_views::SoftwareBuffer;
using light_views::ViewPlan;
using light_views::ViewProjection;

namespace {

ReceiverTexture black(const Rect& rect)
{
    ReceiverTexture texture{rect, {}};
    texture.bits.assign(ReceiverTexture::row_words(rect) * static_cast<std::size_t>(rect.height()), 0u);
    return texture;
}

template <class Lit>
ReceiverTexture made_of(const Rect& rect, const Lit& lit)
{
    ReceiverTexture texture = black(rect);
    for (int y = rect.y0; y < rect.y1; ++y)
        for (int x = rect.x0; x < rect.x1; ++x)
            if (lit(x, y)) texture.set(x, y, true);
    return texture;
}

}   // namespace

bool ReceiverTexture::lit(int x, int y) const
{
    if (x < rect.x0 || x >= rect.x1 || y < rect.y0 || y >= rect.y1) return false;
    const auto column = static_cast<unsigned>(x - rect.x0);
    return bits[static_cast<std::size_t>(y - rect.y0) * row_words(rect) + column / 32] >> (column % 32) & 1u;
}

void ReceiverTexture::set(int x, int y, bool on)
{
    const auto column = static_cast<unsigned>(x - rect.x0);
    std::uint32_t& word = bits[static_cast<std::size_t>(y - rect.y0) * row_words(rect) + column / 32];
    word = on ? word | 1u << (column % 32) : word & ~(1u << (column % 32));
}

ReceiverTexture texture_by_depth(const ViewProjection& view, const SoftwareBuffer& everything,
                                 const scene::SceneState& state, scene::ObjectId receiver, const Rect& rect)
{
    SoftwareBuffer own(view.size);
    draw_object(own, view, state, receiver, rect);
    return made_of(rect, [&](int x, int y) {
        const std::size_t i = own.at(x, y);
        return own.item[i] != 0 && own.depth[i] >= everything.depth[i];
    });
}

ReceiverTexture texture_by_casters(const ViewProjection& view, const Casters& casters, const scene::SceneState& state,
                                   scene::ObjectId receiver, const Rect& rect)
{
    SoftwareBuffer own(view.size);
    draw_object(own, view, state, receiver, rect);
    SoftwareBuffer shadowed = own;
    const light_views::DistanceRange mine =
        light_views::distance_range(view, state.object_matrix(receiver), casters.box(receiver));
    for (scene::ObjectId o = 0; o < state.scene().objects.size(); ++o) {
        if (o == receiver || !casters.casts(o) || !state.object_there(o)) continue;
        if (light_views::distance_range(view, state.object_matrix(o), casters.box(o)).nearest > mine.farthest) continue;
        draw_object(shadowed, view, state, o, rect);
    }
    return made_of(rect, [&](int x, int y) {
        const std::size_t i = own.at(x, y);
        return own.item[i] != 0 && own.depth[i] >= shadowed.depth[i];
    });
}

ReceiverTexture texture_by_items(const SoftwareBuffer& everything, scene::ObjectId receiver, const Rect& rect)
{
    return made_of(rect, [&](int x, int y) { return everything.item[everything.at(x, y)] == receiver + 1; });
}

void CoherentTextures::update(const light_views::LightView& view, const SoftwareBuffer& everything,
                              const Casters& casters, const scene::SceneState& state)
{
    updated_ = 0;
    const ViewPlan& plan = view.plan;
    if (plan.kind == ViewPlan::Kind::whole || plan.kind == ViewPlan::Kind::restless) textures_.clear();
    for (const scene::ObjectId object : plan.departed) textures_.erase(object);
    for (const scene::ObjectId object : plan.receivers) {
        const Rect rect = casters.footprint(view.projection, state, object);
        textures_[object] = texture_by_depth(view.projection, everything, state, object, rect);
        ++updated_;
    }
}

}   // namespace gnomon::shadow_textures
