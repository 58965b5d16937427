// SPDX-License-Identifier: Apache-2.0
#include "python/bindings/parts.h"

namespace gnomon::python {

namespace {

// `M` is the struct or a constant one: the same list serves for reading and for writing.
template <class M, class S>
concept Is = std::is_same_v<std::remove_const_t<M>, S>;

template <Is<TextureUse> M, class Visit>
void visit_fields(M& m, const Visit& visit)
{
    visit("texture", m.texture);
    visit("texcoord", m.texcoord);
    visit("offset", m.offset);
    visit("scale", m.scale);
    visit("rotation", m.rotation);
}

template <Is<MaterialLayers> M, class Visit>
void visit_fields(M& m, const Visit& visit)
{
    visit("specular", m.specular);
    visit("specular_texture", m.specular_texture);
    visit("specular_color", m.specular_color);
    visit("specular_color_texture", m.specular_color_texture);
    visit("clearcoat", m.clearcoat);
    visit("clearcoat_roughness", m.clearcoat_roughness);
    visit("clearcoat_texture", m.clearcoat_texture);
    visit("clearcoat_roughness_texture", m.clearcoat_roughness_texture);
    visit("clearcoat_normal_texture", m.clearcoat_normal_texture);
    visit("clearcoat_normal_scale", m.clearcoat_normal_scale);
    visit("sheen_color", m.sheen_color);
    visit("sheen_roughness", m.sheen_roughness);
    visit("sheen_color_texture", m.sheen_color_texture);
    visit("sheen_roughness_texture", m.sheen_roughness_texture);
    visit("anisotropy", m.anisotropy);
    visit("anisotropy_rotation", m.anisotropy_rotation);
    visit("anisotropy_texture", m.anisotropy_texture);
    visit("iridescence", m.iridescence);
    visit("iridescence_texture", m.iridescence_texture);
    visit("iridescence_ior", m.iridescence_ior);
    visit("iridescence_thickness_least", m.iridescence_thickness_least);
    visit("iridescence_thickness_most", m.iridescence_thickness_most);
    visit("iridescence_thickness_texture", m.iridescence_thickness_texture);
    visit("transmission_texture", m.transmission_texture);
    visit("thin_walled", m.thin_walled);
    visit("thickness", m.thickness);
    visit("thickness_texture", m.thickness_texture);
    visit("attenuation_color", m.attenuation_color);
    visit("attenuation_distance", m.attenuation_distance);
    visit("dispersion", m.dispersion);
    visit("emission_inner", m.emission_inner);
    visit("emission_outer", m.emission_outer);
}

template <Is<Material> M, class Visit>
void visit_fields(M& m, const Visit& visit)
{
    visit("name", m.name);
    visit("model", m.model);
    visit("base_color", m.base_color);
    visit("base_color_texture", m.base_color_texture);
    visit("double_sided", m.double_sided);
    visit("alpha", m.alpha);
    visit("alpha_mode", m.alpha_mode);
    visit("alpha_cutoff", m.alpha_cutoff);
    visit("metallic", m.metallic);
    visit("roughness", m.roughness);
    visit("metallic_roughness_texture", m.metallic_roughness_texture);
    visit("normal_texture", m.normal_texture);
    visit("normal_scale", m.normal_scale);
    visit("occlusion_texture", m.occlusion_texture);
    visit("occlusion_strength", m.occlusion_strength);
    visit("emissive", m.emissive);
    visit("emissive_texture", m.emissive_texture);
    visit("transmission", m.transmission);
    visit("ior", m.ior);
    visit("ambient", m.ambient);
    visit("specular", m.specular);
    visit("shine", m.shine);
    visit("transmittance", m.transmittance);
    visit("layers", m.layers);
    visit("outline", m.outline);
    visit("hidden_from_camera", m.hidden_from_camera);
}

template <Is<Light> M, class Visit>
void visit_fields(M& m, const Visit& visit)
{
    visit("name", m.name);
    visit("type", m.type);
    visit("color", m.color);
    visit("falloff", m.falloff);
    visit("profile", m.profile);
    visit("inner_angle", m.inner_angle);
    visit("outer_angle", m.outer_angle);
    visit("range", m.range);
}

template <Is<AreaLight> M, class Visit>
void visit_fields(M& m, const Visit& visit)
{
    visit("name", m.name);
    visit("shape", m.shape);
    visit("width", m.width);
    visit("height", m.height);
    visit("radiance", m.radiance);
    visit("two_sided", m.two_sided);
    visit("hidden_from_camera", m.hidden_from_camera);
    visit("inner_angle", m.inner_angle);
    visit("outer_angle", m.outer_angle);
}

template <Is<Intrinsics> M, class Visit>
void visit_fields(M& m, const Visit& visit)
{
    visit("fx", m.fx);
    visit("fy", m.fy);
    visit("cx", m.cx);
    visit("cy", m.cy);
    visit("size", m.size);
}

template <Is<Camera> M, class Visit>
void visit_fields(M& m, const Visit& visit)
{
    visit("name", m.name);
    visit("transform", m.transform);
    visit("vertical_fov", m.vertical_fov);
    visit("orthographic_height", m.orthographic_height);
    visit("intrinsics", m.intrinsics);
    visit("matrix", m.matrix);
    visit("shift_x", m.shift_x);
    visit("shift_y", m.shift_y);
    visit("near", m.near);
    visit("far", m.far);
    visit("resolution", m.resolution);
}

// Floats of any of Python's and numpy's types.
double number(py::handle from, const std::string& where)
{
    const double value = PyFloat_AsDouble(from.ptr());
    if (value == -1 && PyErr_Occurred()) {
        PyErr_Clear();
        throw py::type_error(where + " must be a number; found a " + Py_TYPE(from.ptr())->tp_name);
    }
    return value;
}

template <std::size_t n>
void numbers_of(py::handle from, const std::string& where, float* const (&to)[n])
{
    if (py::isinstance<py::str>(from) || !PySequence_Check(from.ptr()))
        throw py::type_error(where + " must be " + std::to_string(n) + " numbers; found a " +
                             Py_TYPE(from.ptr())->tp_name);
    const auto sequence = py::reinterpret_borrow<py::sequence>(from);
    if (sequence.size() != n)
        throw UsageError(where + " has " + std::to_string(sequence.size()) + " values; expected " + std::to_string(n));
    for (std::size_t i = 0; i < n; ++i) *to[i] = static_cast<float>(number(sequence[i], where));
}

}   // namespace

void read(py::handle from, const std::string& where, bool& to)
{
    // numpy's bool converts to an integer; integers of Python do not count as bool.
    if (!PyBool_Check(from.ptr()) && std::string(Py_TYPE(from.ptr())->tp_name) != "numpy.bool_")
        throw py::type_error(where + " must be True or False; found a " + Py_TYPE(from.ptr())->tp_name);
    to = PyObject_IsTrue(from.ptr()) == 1;
}

void read(py::handle from, const std::string& where, int& to)
{
    const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(from.ptr()));
    int overflow = 0;
    const long value = index ? PyLong_AsLongAndOverflow(index.ptr(), &overflow) : 0;
    if (!index) {
        PyErr_Clear();
        throw py::type_error(where + " must be an integer; found a " + Py_TYPE(from.ptr())->tp_name);
    }
    if (overflow || value != static_cast<int>(value))
        throw UsageError(where + " is " + py::str(from).cast<std::string>() + ", which is out of range");
    to = static_cast<int>(value);
}

void read(py::handle from, const std::string& where, std::uint64_t& to)
{
    const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(from.ptr()));
    if (!index) {
        PyErr_Clear();
        throw py::type_error(where + " must be an integer; found a " + Py_TYPE(from.ptr())->tp_name);
    }
    to = PyLong_AsUnsignedLongLong(index.ptr());
    if (PyErr_Occurred()) {
        PyErr_Clear();
        throw UsageError(where + " is " + py::str(from).cast<std::string>() + ", which is out of range");
    }
}

void read(py::handle from, const std::string& where, float& to)
{
    to = static_cast<float>(number(from, where));
}

void read(py::handle from, const std::string& where, double& to)
{
    to = number(from, where);
}

void read(py::handle from, const std::string& where, std::string& to)
{
    if (!py::isinstance<py::str>(from))
        throw py::type_error(where + " must be a str; found a " + Py_TYPE(from.ptr())->tp_name);
    to = from.cast<std::string>();
}

void read(py::handle from, const std::string& where, Vec2& to)
{
    numbers_of<2>(from, where, {&to.x, &to.y});
}

void read(py::handle from, const std::string& where, Vec3& to)
{
    numbers_of<3>(from, where, {&to.x, &to.y, &to.z});
}

void read(py::handle from, const std::string& where, float (&to)[3])
{
    numbers_of<3>(from, where, {&to[0], &to[1], &to[2]});
}

void read(py::handle from, const std::string& where, Size& to)
{
    if (py::isinstance<py::str>(from) || !PySequence_Check(from.ptr()) || py::len(from) != 2)
        throw py::type_error(where + " must be (width, height)");
    const auto sequence = py::reinterpret_borrow<py::sequence>(from);
    read(sequence[0], where, to.width);
    read(sequence[1], where, to.height);
}

void read(py::handle from, const std::string& where, Box& to)
{
    if (!PySequence_Check(from.ptr()) || py::len(from) != 2)
        throw py::type_error(where + " must be (low, high), of three numbers each");
    const auto sequence = py::reinterpret_borrow<py::sequence>(from);
    read(sequence[0], where, to.low);
    read(sequence[1], where, to.high);
}

void read(py::handle from, const std::string& where, Transform& to)
{
    to = transform(from, where);
}

void read(py::handle from, const std::string& where, TextureId& to)
{
    to = id_of<TextureId>(from, where, "TextureId");
}

// A texture alone stands for its plain use; None for no texture.
void read(py::handle from, const std::string& where, TextureUse& to)
{
    if (from.is_none()) return;
    if (py::isinstance<TextureId>(from))
        to.texture = from.cast<TextureId>();
    else
        visit_fields(to, FieldReader{from, "TextureUse"});
    (void)where;
}

void read(py::handle from, const std::string&, MaterialLayers& to)
{
    visit_fields(to, FieldReader{from, "MaterialLayers"});
}

void read(py::handle from, const std::string&, Material& to)
{
    visit_fields(to, FieldReader{from, "Material"});
}

void read(py::handle from, const std::string&, Light& to)
{
    visit_fields(to, FieldReader{from, "Light"});
}

void read(py::handle from, const std::string&, AreaLight& to)
{
    visit_fields(to, FieldReader{from, "AreaLight"});
}

void read(py::handle from, const std::string&, Intrinsics& to)
{
    visit_fields(to, FieldReader{from, "Intrinsics"});
}

void read(py::handle from, const std::string&, Camera& to)
{
    visit_fields(to, FieldReader{from, "Camera"});
}

py::object write(bool value)
{
    return py::bool_(value);
}

py::object write(int value)
{
    return py::int_(value);
}

py::object write(std::uint64_t value)
{
    return py::int_(value);
}

// As the shortest decimal number that is this float: 0.8, not 0.800000011920929.
py::object write(float value)
{
    char text[32];
    PyOS_snprintf(text, sizeof text, "%.9g", static_cast<double>(value));
    for (int digits = 1; digits < 9; ++digits) {
        char shorter[32];
        PyOS_snprintf(shorter, sizeof shorter, "%.*g", digits, static_cast<double>(value));
        if (static_cast<float>(PyOS_string_to_double(shorter, nullptr, nullptr)) == value)
            return py::float_(PyOS_string_to_double(shorter, nullptr, nullptr));
    }
    return py::float_(PyOS_string_to_double(text, nullptr, nullptr));
}

py::object write(double value)
{
    return py::float_(value);
}

py::object write(const std::string& value)
{
    return py::str(value);
}

py::object write(const Vec2& value)
{
    return py::make_tuple(write(value.x), write(value.y));
}

py::object write(const Vec3& value)
{
    return py::make_tuple(write(value.x), write(value.y), write(value.z));
}

py::object write(const float (&value)[3])
{
    return py::make_tuple(write(value[0]), write(value[1]), write(value[2]));
}

py::object write(const Size& value)
{
    return py::make_tuple(value.width, value.height);
}

py::object write(const Box& value)
{
    return py::make_tuple(write(value.low), write(value.high));
}

py::object write(const Transform& value)
{
    return array_of(value);
}

py::object write(const TextureId& value)
{
    return some(value);
}

py::object write(const TextureUse& value)
{
    if (!value.texture) return py::none();
    FieldWriter writer;
    visit_fields(value, writer);
    return make("TextureUse", writer.into);
}

py::object write(const MaterialLayers& value)
{
    FieldWriter writer;
    visit_fields(value, writer);
    return make("MaterialLayers", writer.into);
}

py::object write(const Material& value)
{
    FieldWriter writer;
    visit_fields(value, writer);
    return make("Material", writer.into);
}

py::object write(const Light& value)
{
    FieldWriter writer;
    visit_fields(value, writer);
    return make("Light", writer.into);
}

py::object write(const AreaLight& value)
{
    FieldWriter writer;
    visit_fields(value, writer);
    return make("AreaLight", writer.into);
}

py::object write(const Intrinsics& value)
{
    FieldWriter writer;
    visit_fields(value, writer);
    return make("Intrinsics", writer.into);
}

py::object write(const Camera& value)
{
    FieldWriter writer;
    visit_fields(value, writer);
    return make("Camera", writer.into);
}

py::object make(const char* name, const py::dict& fields)
{
    return py::module_::import("gnomon").attr(name)(**fields);
}

}   // namespace gnomon::python
