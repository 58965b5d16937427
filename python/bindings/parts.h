// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts the plain structs of the public interface to and from the dataclasses of the Python package.
//
// Each struct has one list of its fields (parts.cpp, options.cpp). Reading takes the attributes of any object by these
// names; writing calls the dataclass of the same name.

#include <pybind11/pybind11.h>

#include <optional>
#include <string>
#include <type_traits>

#include "gnomon/gnomon.h"
#include "python/bindings/arrays.h"
#include "python/bindings/names.h"

namespace gnomon::python {

/// Reads a value of Python's. `where` names it in messages: "Material.roughness".
/// @throws py::type_error  another type
/// @throws UsageError      another shape, or no such name
void read(py::handle from, const std::string& where, bool& to);
void read(py::handle from, const std::string& where, int& to);             // see above
void read(py::handle from, const std::string& where, std::uint64_t& to);   // see above
void read(py::handle from, const std::string& where, float& to);           // see above
void read(py::handle from, const std::string& where, double& to);          // see above
void read(py::handle from, const std::string& where, std::string& to);     // see above
void read(py::handle from, const std::string& where, Vec2& to);            // see above
void read(py::handle from, const std::string& where, Vec3& to);            // see above
void read(py::handle from, const std::string& where, float (&to)[3]);      // see above
void read(py::handle from, const std::string& where, Size& to);            // see above
void read(py::handle from, const std::string& where, Box& to);             // see above
void read(py::handle from, const std::string& where, Transform& to);       // see above
void read(py::handle from, const std::string& where, TextureId& to);       // see above
void read(py::handle from, const std::string& where, TextureUse& to);      // see above
void read(py::handle from, const std::string& where, MaterialLayers& to);
void read(py::handle from, const std::string& where, Material& to);
void read(py::handle from, const std::string& where, Light& to);
void read(py::handle from, const std::string& where, AreaLight& to);
void read(py::handle from, const std::string& where, Intrinsics& to);
void read(py::handle from, const std::string& where, Camera& to);
void read(py::handle from, const std::string& where, ReferenceLightOptions& to);
void read(py::handle from, const std::string& where, RenderOptions& to);

template <class E>
requires std::is_enum_v<E>
void read(py::handle from, const std::string& where, E& to)
{
    std::string name;
    read(from, where, name);
    to = value_of<E>(name, where);
}

/// None gives no value.
template <class T>
void read(py::handle from, const std::string& where, std::optional<T>& to)
{
    to.reset();
    if (!from.is_none()) read(from, where, to.emplace());
}

/// The same as a result.
template <class T>
T read_as(py::handle from, const std::string& where)
{
    T value{};
    read(from, where, value);
    return value;
}

/// Writes a value as Python has it.
py::object write(bool value);
py::object write(int value);                  // see above
py::object write(std::uint64_t value);        // see above
py::object write(float value);                // see above
py::object write(double value);               // see above
py::object write(const std::string& value);   // see above
py::object write(const Vec2& value);          // see above
py::object write(const Vec3& value);          // see above
py::object write(const float (&value)[3]);    // see above
py::object write(const Size& value);          // see above
py::object write(const Box& value);           // see above
py::object write(const Transform& value);     // see above
py::object write(const TextureId& value);     // see above
py::object write(const TextureUse& value);
py::object write(const MaterialLayers& value);
py::object write(const Material& value);
py::object write(const Light& value);
py::object write(const AreaLight& value);
py::object write(const Intrinsics& value);
py::object write(const Camera& value);
py::object write(const ReferenceLightOptions& value);
py::object write(const RenderOptions& value);

template <class E>
requires std::is_enum_v<E> py::object write(E value)
{
    return py::str(name_of(value));
}

template <class T>
py::object write(const std::optional<T>& value)
{
    return value ? write(*value) : py::none();
}

/// Reads each field of a struct from the attribute of its name.
struct FieldReader {
    py::handle from;
    const char* of;

    template <class T>
    void operator()(const char* name, T& member) const
    {
        if (!py::hasattr(from, name))
            throw py::type_error(std::string("expected a ") + of + ", which has '" + name + "'; found a " +
                                 Py_TYPE(from.ptr())->tp_name);
        read(from.attr(name), std::string(of) + "." + name, member);
    }
};

/// Collects the fields of a struct as keyword arguments.
struct FieldWriter {
    py::dict into;

    template <class T>
    void operator()(const char* name, const T& member) const
    {
        into[name] = write(member);
    }
};

/// Calls a class of the package with keyword arguments.
py::object make(const char* name, const py::dict& fields);

/// An id, or None if it refers to nothing.
template <class Id>
py::object some(const Id& id)
{
    return id ? py::cast(id) : py::none();
}

/// An id; None gives one that refers to nothing.
/// @throws py::type_error  another kind of object
template <class Id>
Id id_of(py::handle from, const std::string& where, const char* kind)
{
    if (from.is_none()) return {};
    if (!py::isinstance<Id>(from))
        throw py::type_error(where + " must be a " + kind + "; found a " + Py_TYPE(from.ptr())->tp_name);
    return from.cast<Id>();
}

}   // namespace gnomon::python
