// SPDX-License-Identifier: Apache-2.0
// Scenes made of numpy arrays.
#include <pybind11/stl.h>

#include <cstring>

#include "gnomon/gnomon.h"
#include "python/bindings/module.h"
#include "python/bindings/parts.h"

namespace gnomon::python {

namespace {

// A builder that can be closed, and is then empty.
class Builder {
 public:
    explicit Builder(const py::object& scene)
    {
        if (scene.is_none())
            builder_.emplace();
        else
            builder_.emplace(scene.cast<const Scene&>());
    }
    SceneBuilder& open()
    {
        if (!builder_) throw UsageError("the builder is closed");
        return *builder_;
    }
    void close() { builder_.reset(); }

 private:
    std::optional<SceneBuilder> builder_;
};

// The arrays of a mesh, and what holds them.
struct MeshArrays {
    Kept kept;
    std::vector<MeshPart> parts;
    std::vector<MorphTarget> targets;
    std::vector<float> weights;
    Mesh mesh;
};

void read_morph_targets(py::handle from, MeshArrays& to)
{
    if (from.is_none()) return;
    for (const py::handle one : from) {
        const std::string where = "morph_targets[" + std::to_string(to.targets.size()) + "]";
        MorphTarget& target = to.targets.emplace_back();
        if (!py::isinstance<py::dict>(one)) {
            target.positions = vec3s(one, where, to.kept);
            continue;
        }
        for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(one)) {
            const std::string name = py::str(key).cast<std::string>();
            std::span<const Vec3>* const member = name == "positions"  ? &target.positions
                                                  : name == "normals"  ? &target.normals
                                                  : name == "tangents" ? &target.tangents
                                                                       : nullptr;
            if (!member)
                throw UsageError(std::string(where).append(": no '").append(name).append(
                    "'; there are positions, normals and tangents"));
            *member = vec3s(value, std::string(where).append(".").append(name), to.kept);
        }
    }
}

// Parts are (material, number of triangles), one after the other.
void read_parts(py::handle from, MeshArrays& to)
{
    if (from.is_none()) return;
    std::uint32_t first = 0;
    for (const py::handle one : from) {
        const std::string where = "parts[" + std::to_string(to.parts.size()) + "]";
        if (!py::isinstance<py::tuple>(one) || py::len(one) != 2)
            throw py::type_error(where + " must be (material, number of triangles)");
        const auto pair = py::reinterpret_borrow<py::tuple>(one);
        const int count = read_as<int>(pair[1], where);
        if (count < 0) throw UsageError(where + " has a negative number of triangles");
        to.parts.push_back({id_of<MaterialId>(pair[0], where, "MaterialId"), first, static_cast<std::uint32_t>(count)});
        first += static_cast<std::uint32_t>(count);
    }
}

MeshArrays mesh_of(py::handle positions, py::handle indices, const py::kwargs& more)
{
    MeshArrays to;
    Mesh& mesh = to.mesh;
    if (positions.is_none()) throw py::type_error("positions must be an array of numbers");
    mesh.positions = vec3s(positions, "positions", to.kept);
    mesh.indices = triangles(indices, "triangles", to.kept);
    for (const auto& [key, value] : more) {
        const std::string name = py::str(key).cast<std::string>();
        if (name == "normals")
            mesh.normals = vec3s(value, name, to.kept);
        else if (name == "tangents")
            mesh.tangents = vec4s(value, name, to.kept);
        else if (name == "uvs")
            mesh.texcoords[0] = vec2s(value, name, to.kept);
        else if (name == "uvs2")
            mesh.texcoords[1] = vec2s(value, name, to.kept);
        else if (name == "colors")
            mesh.colors = vec4s(value, name, to.kept);
        else if (name == "parts")
            read_parts(value, to);
        else if (name == "morph_targets")
            read_morph_targets(value, to);
        else if (name == "morph_weights")
            to.weights = floats(value, name);
        else if (name == "joints")
            mesh.joints[0] = joints(value, name, to.kept);
        else if (name == "joints2")
            mesh.joints[1] = joints(value, name, to.kept);
        else if (name == "weights")
            mesh.weights[0] = vec4s(value, name, to.kept);
        else if (name == "weights2")
            mesh.weights[1] = vec4s(value, name, to.kept);
        else if (name == "name")
            read(value, name, mesh.name);
        else
            throw py::type_error("a mesh has no '" + name + "'");
    }
    mesh.parts = to.parts;
    mesh.morph_targets = to.targets;
    mesh.morph_weights = to.weights;
    return to;
}

NodeOptions node_options(const std::string& mobility, py::handle parent, const std::string& name)
{
    return {value_of<Mobility>(mobility, "mobility"), id_of<NodeId>(parent, "parent", "NodeId"), name};
}

InstanceOptions instance_options(const std::string& mobility, py::handle parent, const std::string& name,
                                 py::handle skin, py::handle morph_weights, py::handle reach)
{
    InstanceOptions options;
    options.mobility = value_of<Mobility>(mobility, "mobility");
    options.parent = id_of<NodeId>(parent, "parent", "NodeId");
    options.name = name;
    options.skin = id_of<SkinId>(skin, "skin", "SkinId");
    options.morph_weights = floats(morph_weights, "morph_weights");
    if (!reach.is_none()) read(reach, "reach", options.reach);
    return options;
}

TextureId add_texture(Builder& builder, py::handle pixels, bool srgb, const std::string& wrap_u,
                      const std::string& wrap_v, const std::string& magnify, const std::string& minify, bool mipmaps,
                      const std::string& name)
{
    Texture texture;
    texture.srgb = srgb;
    texture.wrap_u = value_of<Wrap>(wrap_u, "wrap_u"), texture.wrap_v = value_of<Wrap>(wrap_v, "wrap_v");
    texture.magnify = value_of<Filter>(magnify, "magnify"), texture.minify = value_of<Filter>(minify, "minify");
    texture.mipmaps = mipmaps;
    texture.name = name;
    if (py::isinstance<py::bytes>(pixels)) {
        char* data = nullptr;
        py::ssize_t length = 0;
        if (PyBytes_AsStringAndSize(pixels.ptr(), &data, &length) != 0) throw py::error_already_set();
        return builder.open().texture(std::as_bytes(std::span(data, static_cast<std::size_t>(length))), texture);
    }
    const py::array array = py::array::ensure(pixels);
    if (!array || !py::isinstance<py::array_t<std::uint8_t>>(array)) {
        PyErr_Clear();
        throw py::type_error("pixels must be an array of uint8, or the bytes of a PNG or JPEG file");
    }
    if (array.ndim() != 2 && array.ndim() != 3)
        throw UsageError("pixels has the shape " + shape_text(array) +
                         "; expected (height, width) or (height, width, channels)");
    const auto plain = py::array_t<std::uint8_t, py::array::c_style>::ensure(array);
    texture.width = static_cast<int>(plain.shape(1)), texture.height = static_cast<int>(plain.shape(0));
    texture.channels = plain.ndim() == 3 ? static_cast<int>(plain.shape(2)) : 1;
    texture.pixels = {plain.data(), static_cast<std::size_t>(plain.size())};
    return builder.open().texture(texture);
}

void set_environment(Builder& builder, py::handle pixels, int lights)
{
    const py::array_t<float> array = numbers<float>(pixels, "pixels", {-1, -1, 3});
    EnvironmentImage image;
    image.width = static_cast<int>(array.shape(1)), image.height = static_cast<int>(array.shape(0));
    image.pixels = {array.data(), static_cast<std::size_t>(array.size())};
    builder.open().environment(image, lights);
}

SkinId add_skin(Builder& builder, const std::vector<NodeId>& joints, py::handle inverse_bind, const std::string& name)
{
    Skin skin;
    skin.joints = joints;
    skin.name = name;
    for (const py::handle one : inverse_bind) skin.inverse_bind.push_back(transform(one, "inverse_bind"));
    return builder.open().skin(skin);
}

void remove_part(Builder& builder, py::handle id)
{
    SceneBuilder& open = builder.open();
    if (py::isinstance<NodeId>(id)) return open.remove(id.cast<NodeId>());
    if (py::isinstance<LightId>(id)) return open.remove(id.cast<LightId>());
    if (py::isinstance<CameraId>(id)) return open.remove(id.cast<CameraId>());
    if (py::isinstance<MeshId>(id)) return open.remove(id.cast<MeshId>());
    if (py::isinstance<SkinId>(id)) return open.remove(id.cast<SkinId>());
    if (py::isinstance<MaterialId>(id)) return open.remove(id.cast<MaterialId>());
    if (py::isinstance<TextureId>(id)) return open.remove(id.cast<TextureId>());
    throw py::type_error("expected an id");
}

void set_material(Builder& builder, py::handle of, py::handle material)
{
    if (py::isinstance<InstanceId>(of))
        builder.open().set_material(of.cast<InstanceId>(), id_of<MaterialId>(material, "material", "MaterialId"));
    else
        builder.open().set_material(id_of<MaterialId>(of, "material", "MaterialId or InstanceId"),
                                    read_as<Material>(material, "material"));
}

void add_geometry(py::class_<Builder>& builder)
{
    builder
        .def(
            "mesh",
            [](Builder& b, py::handle positions, py::handle indices, const py::kwargs& more) {
                return b.open().mesh(mesh_of(positions, indices, more).mesh);
            },
            py::arg("positions"), py::arg("triangles") = py::none(),
            "Adds a mesh, which instance() places in the scene. Its arrays are copied.\n\n"
            "positions      (n, 3) float: in object space, metres\n"
            "triangles      (m, 3) int: vertices, counter-clockwise seen from the front; None: the vertices in order\n"
            "normals        (n, 3) float: scaled to unit length; (0, 0, 0): of the triangles around; None: faceted\n"
            "tangents       (n, 4) float: of normal maps; w is -1 or 1\n"
            "uvs, uvs2      (n, 2) float: texture coordinates, from the upper left corner\n"
            "colors         (n, 4) float: linear RGBA, 0 to 1; multiplies the base colour\n"
            "parts          [(MaterialId, number of triangles), ...] that cover all triangles in order\n"
            "morph_targets  a list: (n, 3) offsets, or {'positions': ..., 'normals': ..., 'tangents': ...}\n"
            "morph_weights  one number per target; None: all 0\n"
            "joints, joints2, weights, weights2  (n, 4): of a skin\n"
            "name           need not be unique")
        .def(
            "set_mesh",
            [](Builder& b, const MeshId& id, py::handle positions, py::handle indices, const py::kwargs& more) {
                b.open().set_mesh(id, mesh_of(positions, indices, more).mesh);
            },
            py::arg("id"), py::arg("positions"), py::arg("triangles") = py::none(),
            "Replaces a mesh in all its instances; the arguments are those of mesh().")
        .def("texture", add_texture, py::arg("pixels"), py::kw_only(), py::arg("srgb") = true,
             py::arg("wrap_u") = "repeat", py::arg("wrap_v") = "repeat", py::arg("magnify") = "linear",
             py::arg("minify") = "linear", py::arg("mipmaps") = true, py::arg("name") = "",
             "texture(self, pixels, *, srgb=True, wrap_u='repeat', wrap_v='repeat', magnify='linear', minify='linear', "
             "mipmaps=True, name='')\n--\n\n"
             "Adds a texture.\n\n"
             "pixels   (height, width) or (height, width, 1 to 4) uint8, row 0 at the top; or the bytes of a PNG or "
             "JPEG "
             "file\n"
             "srgb     colour is sRGB-encoded; False: linear data, such as normals\n"
             "wrap_u, wrap_v   'repeat', 'mirror' or 'clamp'\n"
             "magnify, minify  'nearest' or 'linear'")
        .def("skin", add_skin, py::arg("joints"), py::arg("inverse_bind"), py::arg("name") = "",
             "skin(self, joints, inverse_bind, name='')\n--\n\n"
             "Adds a skin.\n\njoints        nodes\ninverse_bind  (joints, 4, 4) float: from the mesh's space to the "
             "joint's at rest");
}

void add_nodes(py::class_<Builder>& builder)
{
    builder
        .def(
            "node",
            [](Builder& b, py::handle place, const std::string& mobility, py::handle parent, const std::string& name) {
                return b.open().node(transform(place, "transform"), node_options(mobility, parent, name));
            },
            py::arg("transform") = py::none(), py::kw_only(), py::arg("mobility") = "fixed",
            py::arg("parent") = py::none(), py::arg("name") = "",
            "node(self, transform=None, *, mobility='fixed', parent=None, name='')\n--\n\n"
            "Adds a node without a mesh.\n\n"
            "transform  (4, 4) or (3, 4): to the parent's space\n"
            "mobility   'fixed', 'may_move' or 'may_deform': of everything below, too\n"
            "parent     None: the world")
        .def(
            "instance",
            [](Builder& b, const MeshId& mesh, py::handle material, py::handle place, const std::string& mobility,
               py::handle parent, const std::string& name, py::handle skin, py::handle weights, py::handle reach) {
                return b.open().instance(mesh, id_of<MaterialId>(material, "material", "MaterialId"),
                                         transform(place, "transform"),
                                         instance_options(mobility, parent, name, skin, weights, reach));
            },
            py::arg("mesh"), py::arg("material") = py::none(), py::arg("transform") = py::none(), py::kw_only(),
            py::arg("mobility") = "fixed", py::arg("parent") = py::none(), py::arg("name") = "",
            py::arg("skin") = py::none(), py::arg("morph_weights") = py::none(), py::arg("reach") = py::none(),
            "instance(self, mesh, material=None, transform=None, *, mobility='fixed', parent=None, name='', "
            "skin=None, "
            "morph_weights=None, reach=None)\n--\n\n"
            "Places a mesh in the scene.\n\n"
            "material   of the whole mesh; None: its parts have materials of their own, or a grey one\n"
            "transform  (4, 4) or (3, 4): to the parent's space\n"
            "mobility   'fixed'; 'may_move': transform and visibility may change; 'may_deform': vertices, too\n"
            "reach      ((x, y, z), (x, y, z)): the part of the world that it is expected to move in")
        .def(
            "attach",
            [](Builder& b, const NodeId& node, const MeshId& mesh, py::handle material, const std::string& mobility,
               py::handle skin, py::handle weights, py::handle reach) {
                return b.open().attach(node, mesh, id_of<MaterialId>(material, "material", "MaterialId"),
                                       instance_options(mobility, py::none(), "", skin, weights, reach));
            },
            py::arg("node"), py::arg("mesh"), py::arg("material") = py::none(), py::kw_only(),
            py::arg("mobility") = "fixed", py::arg("skin") = py::none(), py::arg("morph_weights") = py::none(),
            py::arg("reach") = py::none(),
            "attach(self, node, mesh, material=None, *, mobility='fixed', skin=None, morph_weights=None, "
            "reach=None)\n--\n\nGives a node that has none a mesh.")
        .def(
            "set_transform",
            [](Builder& b, const NodeId& node, py::handle place) {
                b.open().set_transform(node, transform(place, "transform"));
            },
            py::arg("node"), py::arg("transform"),
            "set_transform(self, node, transform)\n--\n\nReplaces a node's transform to its parent's space, and its "
            "track if it has one.")
        .def(
            "set_mobility",
            [](Builder& b, const NodeId& node, const std::string& mobility) {
                b.open().set_mobility(node, value_of<Mobility>(mobility, "mobility"));
            },
            py::arg("node"), py::arg("mobility"),
            "set_mobility(self, node, mobility)\n--\n\nDeclares what may change at a node and everything below it.")
        .def("remove", remove_part, py::arg("id"),
             "remove(self, id)\n--\n\nRemoves a part. With a node or instance goes everything below it; the node of a "
             "light or camera stays.\nRaises UsageError if something uses the part.");
}

void add_looks(py::class_<Builder>& builder)
{
    builder
        .def(
            "material", [](Builder& b, py::handle m) { return b.open().material(read_as<Material>(m, "material")); },
            py::arg("material"), "material(self, material)\n--\n\nAdds a Material.")
        .def("set_material", set_material, py::arg("of"), py::arg("material"),
             "set_material(self, of, material)\n--\n\nReplaces the values of a material (MaterialId, Material), or "
             "gives "
             "an instance another one (InstanceId, MaterialId).")
        .def(
            "light",
            [](Builder& b, py::handle light, py::handle place, const std::string& mobility, py::handle parent) {
                return b.open().light(read_as<Light>(light, "light"), transform(place, "transform"),
                                      node_options(mobility, parent, ""));
            },
            py::arg("light"), py::arg("transform") = py::none(), py::kw_only(), py::arg("mobility") = "fixed",
            py::arg("parent") = py::none(),
            "light(self, light, transform=None, *, mobility='fixed', parent=None)\n--\n\n"
            "Adds a Light and the node that carries it; it shines along the node's -Z.")
        .def(
            "set_light",
            [](Builder& b, const LightId& id, py::handle light) {
                b.open().set_light(id, read_as<Light>(light, "light"));
            },
            py::arg("id"), py::arg("light"),
            "set_light(self, id, light)\n--\n\nReplaces the values of a light; its node stays.")
        .def(
            "area_light",
            [](Builder& b, py::handle light, py::handle place, const std::string& mobility, py::handle parent,
               const std::string& name) {
                const AreaLightParts parts =
                    b.open().area_light(read_as<AreaLight>(light, "light"), transform(place, "transform"),
                                        instance_options(mobility, parent, name, py::none(), py::none(), py::none()));
                return py::make_tuple(parts.instance, parts.material);
            },
            py::arg("light"), py::arg("transform") = py::none(), py::kw_only(), py::arg("mobility") = "fixed",
            py::arg("parent") = py::none(), py::arg("name") = "",
            "area_light(self, light, transform=None, *, mobility='fixed', parent=None, name='')\n--\n\n"
            "Adds an AreaLight as a mesh with an emissive material: returns (InstanceId, MaterialId).")
        .def(
            "camera",
            [](Builder& b, py::handle camera, const std::string& mobility, py::handle parent) {
                return b.open().camera(read_as<Camera>(camera, "camera"), node_options(mobility, parent, ""));
            },
            py::arg("camera"), py::kw_only(), py::arg("mobility") = "fixed", py::arg("parent") = py::none(),
            "camera(self, camera, *, mobility='fixed', parent=None)\n--\n\n"
            "Adds a Camera and the node that carries it, whose transform is the camera's.")
        .def(
            "set_camera",
            [](Builder& b, const CameraId& id, py::handle camera) {
                b.open().set_camera(id, read_as<Camera>(camera, "camera"));
            },
            py::arg("id"), py::arg("camera"),
            "set_camera(self, id, camera)\n--\n\nReplaces the values of a camera, and its node's transform.")
        .def("environment", set_environment, py::arg("pixels"), py::kw_only(), py::arg("lights") = 16,
             "environment(self, pixels, *, lights=16)\n--\n\n"
             "Surrounds the scene with light.\n\n"
             "pixels  (height, width, 3) float: radiance in nits, longitude by latitude, the upper edge towards +Y and "
             "the centre towards -Z\n"
             "lights  directional lights that approximate it, a power of two from 1 to 1024")
        .def(
            "background", [](Builder& b, py::handle color) { b.open().background(read_as<Vec3>(color, "color")); },
            py::arg("color"),
            "background(self, color)\n--\n\nThe linear colour where rays leave the scene; it gives no light.")
        .def(
            "ambient", [](Builder& b, py::handle color) { b.open().ambient(read_as<Vec3>(color, "color")); },
            py::arg("color"),
            "ambient(self, color)\n--\n\nUniform light without shadows, used only without indirect light.")
        .def(
            "clip", [](Builder& b, double start, double end, double fps) { b.open().clip(start, end, fps); },
            py::arg("start"), py::arg("end"), py::arg("fps"),
            "clip(self, start, end, fps)\n--\n\nThe clip whose frames are numbered from 1; start and end in seconds.");
}

}   // namespace

void add_builder(py::module_& module)
{
    py::class_<Builder> builder(
        module, "SceneBuilder",
        "Makes scenes of parts, and changes scenes that exist; one thread at a time.\n\n"
        "A builder can be finished as often as needed; the scenes share what they have in common, and ids stay valid. "
        "Nothing is added by\ndefault: a scene without lights is dark. Use it in a `with` statement, or call close(), "
        "to "
        "let go of its memory at a known time.\n\n"
        "Functions raise UsageError for ids that the builder does not have, numbers that are not finite or out of "
        "range, "
        "and arrays whose\nlengths disagree; TypeError for other types. The builder is then as before.");
    builder.attr("__module__") = "gnomon";
    builder.def(
        py::init<const py::object&>(), py::arg("scene") = py::none(),
        "__init__(self, scene=None)\n--\n\nBegins with nothing, or continues a scene, whose parts keep their ids.");
    add_geometry(builder);
    add_nodes(builder);
    add_looks(builder);
    builder
        .def(
            "finish",
            [](Builder& b, bool light, bool camera) {
                return b.open().finish({.default_light = light, .default_camera = camera});
            },
            py::kw_only(), py::arg("default_light") = false, py::arg("default_camera") = false,
            "finish(self, *, default_light=False, default_camera=False)\n--\n\n"
            "Makes a Scene of what there is now. The builder can go on.\n\n"
            "default_light   add a sky and a sun, or a light below a room's ceiling, to a scene without light\n"
            "default_camera  add a camera that shows the whole scene")
        .def("close", &Builder::close, "close(self)\n--\n\nLets go of its memory; scenes that it made stay.")
        .def(
            "__enter__", [](py::object self) { return self; }, "__enter__(self)\n--\n\nReturns the builder.")
        .def(
            "__exit__", [](Builder& b, const py::args&) { b.close(); }, "Closes the builder.");
}

}   // namespace gnomon::python
