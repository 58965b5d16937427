// SPDX-License-Identifier: Apache-2.0
#include "python/bindings/arrays.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>

namespace gnomon::python {

namespace {

std::string text_of(const std::vector<py::ssize_t>& shape)
{
    std::string text = "(";
    for (std::size_t i = 0; i < shape.size(); ++i)
        text += (i ? ", " : "") + (shape[i] < 0 ? "n" : std::to_string(shape[i]));
    return text + (shape.size() == 1 ? ",)" : ")");
}

void check_shape(const py::array& array, const std::string& where, const std::vector<py::ssize_t>& shape)
{
    bool fits = array.ndim() == static_cast<py::ssize_t>(shape.size());
    for (std::size_t i = 0; fits && i < shape.size(); ++i)
        fits = shape[i] < 0 || array.shape(static_cast<py::ssize_t>(i)) == shape[i];
    if (!fits) throw UsageError(where + " has the shape " + shape_text(array) + "; expected " + text_of(shape));
}

bool is_one_of(std::string_view kinds, char kind)
{
    return kinds.find(kind) != std::string_view::npos;
}

py::array any_array(py::handle from, const std::string& where)
{
    py::array array = py::array::ensure(from);
    if (!array || !is_one_of("fiub", array.dtype().kind())) {
        PyErr_Clear();
        throw py::type_error(where + " must be an array of numbers");
    }
    return array;
}

// Integers of any type, checked against the range of T.
template <class T>
py::array_t<T> integers(py::handle from, const std::string& where, const std::vector<py::ssize_t>& shape)
{
    const py::array array = any_array(from, where);
    check_shape(array, where, shape);
    if (!is_one_of("iu", array.dtype().kind()) && array.size() > 0)
        throw py::type_error(where + " must be an array of integers");
    if (!py::isinstance<py::array_t<T>>(array) && array.size() > 0) {
        const auto wide = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(array);
        const std::int64_t* values = wide.data();
        for (py::ssize_t i = 0; i < wide.size(); ++i)
            if (values[i] < 0 || values[i] > std::int64_t{std::numeric_limits<T>::max()})
                throw UsageError(where + " contains " + std::to_string(values[i]) + "; expected 0 to " +
                                 std::to_string(std::numeric_limits<T>::max()));
    }
    return py::array_t<T, py::array::c_style | py::array::forcecast>::ensure(array);
}

template <class V>
std::span<const V> rows(py::handle from, const std::string& where, Kept& kept)
{
    if (from.is_none()) return {};
    constexpr py::ssize_t columns = sizeof(V) / sizeof(float);
    const py::array_t<float> array = numbers<float>(from, where, {-1, columns});
    kept.push_back(array);
    return {reinterpret_cast<const V*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}

}   // namespace

std::string shape_text(const py::array& array)
{
    return text_of({array.shape(), array.shape() + array.ndim()});
}

template <class T>
py::array_t<T> numbers(py::handle from, const std::string& where, const std::vector<py::ssize_t>& shape)
{
    const py::array array = any_array(from, where);
    check_shape(array, where, shape);
    return py::array_t<T, py::array::c_style | py::array::forcecast>::ensure(array);
}
template py::array_t<float> numbers<float>(py::handle, const std::string&, const std::vector<py::ssize_t>&);
template py::array_t<double> numbers<double>(py::handle, const std::string&, const std::vector<py::ssize_t>&);

std::span<const Vec3> vec3s(py::handle from, const std::string& where, Kept& kept)
{
    return rows<Vec3>(from, where, kept);
}

std::span<const Vec4> vec4s(py::handle from, const std::string& where, Kept& kept)
{
    return rows<Vec4>(from, where, kept);
}

std::span<const Vec2> vec2s(py::handle from, const std::string& where, Kept& kept)
{
    return rows<Vec2>(from, where, kept);
}

std::span<const std::uint32_t> triangles(py::handle from, const std::string& where, Kept& kept)
{
    if (from.is_none()) return {};
    const py::array_t<std::uint32_t> array = integers<std::uint32_t>(from, where, {-1, 3});
    kept.push_back(array);
    return {array.data(), static_cast<std::size_t>(array.size())};
}

std::span<const Joints> joints(py::handle from, const std::string& where, Kept& kept)
{
    if (from.is_none()) return {};
    const py::array_t<std::uint16_t> array = integers<std::uint16_t>(from, where, {-1, 4});
    kept.push_back(array);
    return {reinterpret_cast<const Joints*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}

std::vector<float> floats(py::handle from, const std::string& where)
{
    if (from.is_none()) return {};
    const py::array_t<float> array = numbers<float>(from, where, {-1});
    return {array.data(), array.data() + array.size()};
}

Transform transform(py::handle from, const std::string& where)
{
    Transform result;
    if (from.is_none()) return result;
    const py::array array = any_array(from, where);
    if (array.ndim() != 2 || (array.shape(0) != 3 && array.shape(0) != 4) || array.shape(1) != 4)
        throw UsageError(where + " has the shape " + shape_text(array) + "; expected (4, 4) or (3, 4)");
    const py::array_t<double> matrix = numbers<double>(array, where, {-1, 4});
    for (py::ssize_t row = 0; row < matrix.shape(0); ++row)
        for (py::ssize_t column = 0; column < 4; ++column)
            result.m[static_cast<std::size_t>(4 * column + row)] = matrix.at(row, column);
    return result;
}

py::array_t<double> array_of(const Transform& transform)
{
    py::array_t<double> matrix(std::vector<py::ssize_t>{4, 4});
    for (py::ssize_t row = 0; row < 4; ++row)
        for (py::ssize_t column = 0; column < 4; ++column)
            matrix.mutable_at(row, column) = transform.m[static_cast<std::size_t>(4 * column + row)];
    return matrix;
}

namespace {

// An array whose base holds the layer's memory.
py::array view(const Layer& layer, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides, const char* data)
{
    const py::dtype type = layer.format == PixelFormat::u32 ? py::dtype::of<std::uint32_t>() : py::dtype::of<float>();
    using Memory = std::shared_ptr<const void>;
    const py::capsule base(new Memory(layer.memory), [](void* held) { delete static_cast<Memory*>(held); });
    py::array array(type, std::move(shape), std::move(strides), data, base);
    array.attr("flags").attr("writeable") = false;
    return array;
}

}   // namespace

py::array view_of(const Layer& layer)
{
    std::vector<py::ssize_t> shape{layer.size.height, layer.size.width};
    std::vector<py::ssize_t> strides{layer.row_stride, layer.pixel_stride};
    if (layer.channels.size() != 1 || layer.name == "shadow") {
        shape.push_back(static_cast<py::ssize_t>(layer.channels.size()));
        strides.push_back(4);
    }
    return view(layer, std::move(shape), std::move(strides), static_cast<const char*>(layer.data));
}

py::array view_of(const Layer& layer, int channel)
{
    return view(layer, {layer.size.height, layer.size.width}, {layer.row_stride, layer.pixel_stride},
                static_cast<const char*>(layer.data) + 4 * static_cast<std::ptrdiff_t>(channel));
}

template <class T>
py::array_t<T> owned(std::vector<T> values, std::vector<py::ssize_t> shape)
{
    auto* const memory = new std::vector<T>(std::move(values));
    const py::capsule base(memory, [](void* held) { delete static_cast<std::vector<T>*>(held); });
    return py::array_t<T>(std::move(shape), memory->data(), base);
}
template py::array_t<std::uint8_t> owned(std::vector<std::uint8_t>, std::vector<py::ssize_t>);
template py::array_t<std::uint16_t> owned(std::vector<std::uint16_t>, std::vector<py::ssize_t>);

}   // namespace gnomon::python
