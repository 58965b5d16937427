// SPDX-License-Identifier: Apache-2.0
// Matrices that place things. They come from the library, because numpy's sines and products may differ in the last bit
// from processor to processor, and images with them.
#include <pybind11/stl.h>

#include <cmath>
#include <optional>

#include "python/bindings/module.h"
#include "python/bindings/parts.h"

namespace gnomon::python {

namespace {

py::object finite(const Transform& transform, const char* message)
{
    for (const double value : transform.m)
        if (!std::isfinite(value)) throw UsageError(message);
    return array_of(transform);
}

py::object rotation(py::handle axis, double radians)
{
    return finite(Transform::rotation(read_as<Vec3>(axis, "axis"), radians),
                  "rotation needs a finite angle, and an axis that is not 0");
}

py::object look_at(py::handle eye, py::handle target, py::handle up)
{
    return finite(
        Transform::look_at(read_as<Vec3>(eye, "eye"), read_as<Vec3>(target, "target"), read_as<Vec3>(up, "up")),
        "look_at needs a direction, and `up` must not be parallel to it");
}

py::object compose(const py::args& matrices)
{
    Transform product;
    for (const py::handle one : matrices) product = product * transform(one, "a matrix");
    return array_of(product);
}

py::object inverse(py::handle matrix)
{
    // The columns of the adjugate of the upper left 3 x 3, divided by its determinant; then the translation back.
    const Transform of = transform(matrix, "the matrix");
    const auto at = [&](std::size_t row, std::size_t column) { return of.m[4 * column + row]; };
    const auto cofactor = [&](std::size_t row, std::size_t column) {
        const std::size_t a = (row + 1) % 3, b = (row + 2) % 3, c = (column + 1) % 3, d = (column + 2) % 3;
        return at(a, c) * at(b, d) - at(a, d) * at(b, c);
    };
    const double determinant = at(0, 0) * cofactor(0, 0) + at(0, 1) * cofactor(0, 1) + at(0, 2) * cofactor(0, 2);
    Transform result;
    for (std::size_t row = 0; row < 3; ++row) {
        double moved = 0;
        for (std::size_t column = 0; column < 3; ++column) {
            const double value = cofactor(column, row) / determinant;
            result.m[4 * column + row] = value;
            moved -= value * of.m[12 + column];
        }
        result.m[12 + row] = moved;
    }
    return finite(result, "a singular matrix, or one that is not finite, has no inverse");
}

}   // namespace

void add_transforms(py::module_& module)
{
    module.def(
        "translation", [](double x, double y, double z) { return array_of(Transform::translation(x, y, z)); },
        py::arg("x"), py::arg("y"), py::arg("z"),
        "translation($module, x, y, z)\n--\n\nA (4, 4) matrix that moves by x, y and z metres.");
    module.def(
        "scaling",
        [](double x, std::optional<double> y, std::optional<double> z) {
            return array_of(Transform::scaling(x, y.value_or(x), z.value_or(x)));
        },
        py::arg("x"), py::arg("y") = py::none(), py::arg("z") = py::none(),
        "scaling($module, x, y=None, z=None)\n--\n\nA (4, 4) matrix that scales by x, y and z, or by x along all "
        "axes.");
    module.def(
        "rotation", rotation, py::arg("axis"), py::arg("radians"),
        "rotation($module, axis, radians)\n--\n\n"
        "A (4, 4) matrix that turns about an axis through the origin, counter-clockwise seen against the axis.\n\n"
        "axis  three numbers; it need not have unit length");
    module.def(
        "look_at", look_at, py::arg("eye"), py::arg("target"), py::arg("up") = py::make_tuple(0, 1, 0),
        "look_at($module, eye, target, up=(0, 1, 0))\n--\n\n"
        "The (4, 4) matrix from the space of a camera or a light at `eye`, which look along -Z with +Y up, to the "
        "world.\n\nRaises UsageError if `eye` is `target`, or `up` is parallel to the direction between them.");
    module.def("compose", compose,
               "compose($module, *matrices)\n--\n\n"
               "The product of matrices of (4, 4) or (3, 4): the last is applied first. Its bits are the same on every "
               "processor, which those of numpy's @ need not be.");
    module.def("inverse", inverse, py::arg("matrix"),
               "inverse($module, matrix)\n--\n\n"
               "The inverse of an affine matrix of (4, 4) or (3, 4), with the same bits on every processor.\n\nRaises "
               "UsageError if it is singular.");
}

}   // namespace gnomon::python
