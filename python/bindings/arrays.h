// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts numpy arrays to the spans, vectors and matrices of the public interface, and back.
//
// Arrays of another number type or layout are converted, which copies them; spans of others show numpy's own memory.
// Spans are valid as long as the `Kept` that they were made with.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <span>
#include <string>
#include <vector>

#include "gnomon/gnomon.h"

namespace gnomon::python {

namespace py = pybind11;

/// Arrays that spans show.
using Kept = std::vector<py::object>;

/// An array of numbers of type T, in the order of C.
/// @param shape  expected; -1: any number
/// @throws UsageError      another shape, or integers that do not fit
/// @throws py::type_error  no array of numbers
template <class T>
py::array_t<T> numbers(py::handle from, const std::string& where, const std::vector<py::ssize_t>& shape);

/// Rows of points, directions or colours: (n, 3), (n, 4), (n, 2). None gives an empty span.
std::span<const Vec3> vec3s(py::handle from, const std::string& where, Kept& kept);
std::span<const Vec4> vec4s(py::handle from, const std::string& where, Kept& kept);   // see above
std::span<const Vec2> vec2s(py::handle from, const std::string& where, Kept& kept);   // see above
/// Rows of three indices: (n, 3), integers from 0.
std::span<const std::uint32_t> triangles(py::handle from, const std::string& where, Kept& kept);
/// Rows of four joints: (n, 4), integers from 0 to 65,535.
std::span<const Joints> joints(py::handle from, const std::string& where, Kept& kept);
/// Numbers in a row: (n).
std::vector<float> floats(py::handle from, const std::string& where);

/// A matrix for column vectors, 4 x 4, or 3 x 4 with the last row 0 0 0 1 left out.
Transform transform(py::handle from, const std::string& where);
/// The same matrix as an array of 4 x 4 doubles.
py::array_t<double> array_of(const Transform& transform);

/// A view of a layer: (height, width) of one channel, else (height, width, channels). It holds the layer's memory, and
/// cannot be written to.
py::array view_of(const Layer& layer);
/// The same of one channel.
py::array view_of(const Layer& layer, int channel);
/// An array of a vector's values, which it takes over.
template <class T>
py::array_t<T> owned(std::vector<T> values, std::vector<py::ssize_t> shape);

/// The shape as numpy prints it: "(4, 3)".
std::string shape_text(const py::array& array);

}   // namespace gnomon::python
