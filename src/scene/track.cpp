// SPDX-License-Identifier: Apache-2.0
#include "scene/track.h"

#include <algorithm>

namespace gnomon::scene {

bool VisibilityTrack::evaluate(double time) const
{
    const auto after = std::upper_bound(times.begin(), times.end(), time);
    return after == times.begin() ? true : visible[static_cast<std::size_t>(after - times.begin()) - 1];
}

glm::dmat4 TransformParts::matrix() const
{
    glm::dmat4 m = glm::mat4_cast(rotation);
    m[0] *= scale.x;
    m[1] *= scale.y;
    m[2] *= scale.z;
    m[3] = glm::dvec4(translation, 1);
    return m;
}

}   // namespace gnomon::scene
