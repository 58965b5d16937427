// SPDX-License-Identifier: Apache-2.0
#include "gnomon/math.h"

#include <glm/gtc/matrix_transform.hpp>

#include "api/convert.h"

namespace gnomon {

Transform Transform::translation(double x, double y, double z)
{
    Transform result;
    result.m[12] = x, result.m[13] = y, result.m[14] = z;
    return result;
}

Transform Transform::scaling(double x, double y, double z)
{
    Transform result;
    result.m[0] = x, result.m[5] = y, result.m[10] = z;
    return result;
}

Transform Transform::rotation(const Vec3& axis, double radians)
{
    return api::transform_of(glm::rotate(glm::dmat4(1), radians, glm::normalize(glm::dvec3(api::vec(axis)))));
}

Transform Transform::look_at(const Vec3& eye, const Vec3& target, const Vec3& up)
{
    return api::transform_of(
        glm::inverse(glm::lookAt(glm::dvec3(api::vec(eye)), glm::dvec3(api::vec(target)), glm::dvec3(api::vec(up)))));
}

Transform operator*(const Transform& outer, const Transform& inner)
{
    Transform result;
    for (std::size_t column = 0; column < 4; ++column)
        for (std::size_t row = 0; row < 4; ++row) {
            double sum = 0;
            for (std::size_t k = 0; k < 4; ++k) sum += outer.m[4 * k + row] * inner.m[4 * column + k];
            result.m[4 * column + row] = sum;
        }
    return result;
}

}   // namespace gnomon
