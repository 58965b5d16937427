// SPDX-License-Identifier: Apache-2.0
#include "area_light/cell_places.h"

namespace gnomon::area_light {

namespace {

// The radiance of the light's own sample place that is nearest.
glm::vec3 radiance_near(const scene::SizedLight& light, const glm::vec3& position)
{
    const scene::SizedPlace* nearest = nullptr;
    float least = k_infinity;
    for (const scene::SizedPlace& place : light.places) {
        const glm::vec3 way = place.position - position;
        const float square = glm::dot(way, way);
        if (square < least) least = square, nearest = &place;
    }
    return nearest ? nearest->radiance : light.faces.front().radiance;
}

}   // namespace

AreaLight area_light_of(const scene::SizedLight& light)
{
    const auto polygon = [](const scene::SizedFace& face) {
        return LightPolygon{face.corner, face.corners, face.normal};
    };
    AreaLight area;
    area.shape.outline = polygon(light.outline);
    if (light.faces.size() > 1)
        for (const scene::SizedFace& face : light.faces) area.shape.faces.push_back(polygon(face));
    area.two_sided = light.outline.two_sided;
    area.dynamic = light.dynamic;
    return area;
}

CellPlaces::CellPlaces(const AreaVisibility& visibility, std::size_t index, const scene::SizedLight& light)
    : one_radiance(light.cell_radiance.empty())
{
    for (std::size_t side = 0; side < (light.faces.front().two_sided ? 2u : 1u); ++side) {
        const LightCells& cells = visibility.cells(index, side == 1);
        for (int c = 0; c < k_cells; ++c) {
            if (cells.count(c) == 0) continue;
            scene::SizedPlace place;
            place.position = cells.position(c);
            place.radiance = one_radiance ? light.faces.front().radiance : radiance_near(light, place.position);
            place.area = cells.area_of_place() * static_cast<float>(cells.count(c));
            of[side].push_back(place);
            cell[side].push_back(static_cast<std::uint16_t>(c));
        }
    }
}

void CellPlaces::fill_seen(std::size_t side, const LightCells& of_side, const VisibleCells& cells,
                           std::uint8_t* seen) const
{
    for (std::size_t i = 0; i < of[side].size(); ++i) {
        const std::uint16_t c = cell[side][i];
        const int count = of_side.count(c);
        seen[i] = static_cast<std::uint8_t>((k_whole * cells[c] + count / 2) / count);
    }
}

}   // namespace gnomon::area_light
