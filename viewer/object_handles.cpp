// SPDX-License-Identifier: Apache-2.0
#include "viewer/object_handles.h"

#include <imgui.h>

namespace gnomon::viewer {

namespace {

constexpr ImU32 k_axis_colors[] = {IM_COL32(232, 84, 84, 255), IM_COL32(110, 196, 90, 255),
                                   IM_COL32(86, 140, 240, 255)};
constexpr ImU32 k_square_color = IM_COL32(235, 235, 235, 255), k_active = IM_COL32(255, 196, 64, 255),
                k_below = IM_COL32(0, 0, 0, 160);
constexpr float k_width = 2.5f, k_width_below = 5, k_tip = 5;   // pixels

glm::vec2 mouse()
{
    const ImVec2 at = ImGui::GetIO().MousePos;
    return {at.x, at.y};
}

}   // namespace

bool ObjectHandles::follow(const std::optional<Gizmo>& gizmo, Panel& panel, OverrideList& overrides)
{
    if (!drag_) {
        if (!gizmo || !panel.picked || ImGui::GetIO().WantCaptureMouse || !ImGui::IsMouseClicked(0)) return false;
        const Gizmo::Handle handle = gizmo->at(mouse());
        if (handle == Gizmo::Handle::none) return false;
        const bool held = overrides.find(panel.picked->node) != nullptr;
        drag_ = Drag{*gizmo, handle, mouse(), parent_of(*panel.picked), panel.freeze(overrides), held};
        return true;
    }
    UserOverride* const held = overrides.find(drag_->before.node);
    if (!held || !ImGui::IsMouseDown(0)) {
        drag_.reset();
        return true;
    }
    *held = changed(drag_->before, drag_->gizmo.drag(drag_->handle, drag_->from, mouse()), drag_->parent);
    if (*held != drag_->before && panel.picked) panel.moved.insert(panel.picked->name);
    return true;
}

void ObjectHandles::cancel(OverrideList& overrides)
{
    const NodeId node = drag_->before.node;
    if (UserOverride* const held = overrides.find(node)) *held = drag_->before;
    if (!drag_->held) std::erase_if(overrides.list, [&](const UserOverride& o) { return o.node == node; });
    drag_.reset();
}

void ObjectHandles::draw(const Gizmo& gizmo, bool free) const
{
    Gizmo::Handle active = Gizmo::Handle::none;
    if (drag_)
        active = drag_->handle;
    else if (free && !ImGui::GetIO().WantCaptureMouse)
        active = gizmo.at(mouse());
    ImDrawList* const draw = ImGui::GetBackgroundDrawList();
    for (const Gizmo::Handle handle : Gizmo::k_handles) {
        std::vector<ImVec2> points;
        for (const glm::vec2& point : gizmo.line(handle)) points.emplace_back(point.x, point.y);
        if (points.size() < 2) continue;
        ImU32 color = k_square_color;
        if (handle == active)
            color = k_active;
        else if (handle != Gizmo::Handle::scale)
            color = k_axis_colors[Gizmo::axis_of(handle)];
        const auto count = static_cast<int>(points.size());
        draw->AddPolyline(points.data(), count, k_below, ImDrawFlags_None, k_width_below);
        draw->AddPolyline(points.data(), count, color, ImDrawFlags_None, k_width);
        if (Gizmo::moves(handle)) draw->AddCircleFilled(points.back(), k_tip, color);
    }
}

}   // namespace gnomon::viewer
