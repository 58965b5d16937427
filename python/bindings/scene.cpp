// SPDX-License-Identifier: Apache-2.0
// Scenes, and loading them.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "gnomon/gnomon.h"
#include "python/bindings/module.h"
#include "python/bindings/parts.h"
#include "python/bindings/run.h"

namespace gnomon::python {

namespace {

py::object load_scene(const std::filesystem::path& what, const py::object& progress, int threads, bool strict,
                      const py::object& animation, const py::object& ground, const std::string& variant, int memory)
{
    LoadOptions options;
    options.threads = threads;
    options.strict = strict;
    if (!animation.is_none()) options.animation = py::str(animation).cast<std::string>();
    read(ground, "ground", options.ground);
    options.variant = variant;
    options.memory = memory;
    std::optional<Scene> scene;
    run(progress, {}, [&](const Progress& report) {
        options.progress = report;
        scene.emplace(load(what.string(), options));
    });
    return py::cast(*scene);
}

py::object info_of(const Scene& scene)
{
    const SceneInfo info = scene.info();
    py::dict fields;
    fields["name"] = info.name;
    fields["triangles"] = info.triangles;
    fields["triangles_dynamic"] = info.triangles_dynamic;
    fields["objects"] = info.objects;
    fields["objects_dynamic"] = info.objects_dynamic;
    fields["meshes"] = info.meshes;
    fields["materials"] = info.materials;
    fields["textures"] = info.textures;
    fields["lights"] = info.lights;
    fields["cameras"] = info.cameras;
    fields["frames"] = info.frames;
    fields["fps"] = info.fps;
    fields["start"] = info.start;
    fields["end"] = info.end;
    fields["bounds"] = py::make_tuple(write(info.bounds_low), write(info.bounds_high));
    fields["resolution"] = write(info.resolution);
    py::list animations;
    for (const AnimationInfo& one : info.animations) {
        py::dict entry;
        entry["name"] = one.name;
        entry["start"] = one.start;
        entry["end"] = one.end;
        entry["frames"] = one.frames;
        entry["plays"] = one.plays;
        animations.append(make("AnimationInfo", entry));
    }
    fields["animations"] = animations;
    fields["variants"] = info.variants;
    fields["warnings"] = info.warnings;
    return make("SceneInfo", fields);
}

Scene with_environment(const Scene& scene, const std::filesystem::path& file, int lights)
{
    const py::gil_scoped_release unlocked;
    return scene.with_environment(file, lights);
}

void add_clip(py::class_<Scene>& scene)
{
    scene.def_property_readonly("frame_count", &Scene::frame_count, "Frames of the whole clip, at least 1; from 1.")
        .def_property_readonly("fps", &Scene::fps, "Frames a second of the clip.")
        .def_property_readonly("info", info_of, "Statistics, names and warnings: a SceneInfo.")
        .def("time_of", &Scene::time_of, py::arg("frame"),
             "time_of(self, frame)\n--\n\nThe time of a frame, from 1, in seconds.")
        .def("at_rate", &Scene::at_rate, py::arg("fps"),
             "at_rate(self, fps)\n--\n\nThe scene at another rate of frames a second.")
        .def("lasting", &Scene::lasting, py::arg("seconds"),
             "lasting(self, seconds)\n--\n\nA scene without animation with a clip of that length, for a turntable; "
             "others unchanged.")
        .def("with_lights", &Scene::with_lights, py::arg("count"),
             "with_lights(self, count)\n--\n\nThe scene with its first `count` lights alone.")
        .def("with_light_specs", &Scene::with_light_specs, py::arg("specs"),
             "with_light_specs(self, specs)\n--\n\nThe scene with other lights: 'point X Y Z R G B' or "
             "'spot X Y Z DX DY DZ HALF_ANGLE_DEG R G B', in candela.")
        .def("with_environment", with_environment, py::arg("file"), py::arg("lights") = 16,
             "with_environment(self, file, lights=16)\n--\n\n"
             "The scene with light from an environment map: an OpenEXR, Radiance HDR, PNG or JPEG file in longitude by "
             "latitude,\nor 'builtin:studio'. Raises InputError if the file is missing or invalid.\n\n"
             "`lights`: of directional lights that approximate it, a power of two from 1 to 1024.");
}

void add_parts(py::class_<Scene>& scene)
{
    scene.def_property_readonly("nodes", &Scene::nodes, "All nodes.")
        .def_property_readonly("instances", &Scene::instances, "All instances of meshes with triangles.")
        .def_property_readonly("lights", &Scene::lights, "All lights.")
        .def_property_readonly("cameras", &Scene::cameras, "All cameras.")
        .def_property_readonly("materials", &Scene::materials, "All materials.")
        .def_property_readonly("meshes", &Scene::meshes, "All meshes.")
        .def(
            "find_node", [](const Scene& s, const std::string& name) { return some(s.find_node(name)); },
            py::arg("name"), "find_node(self, name)\n--\n\nThe first node of that name, or None.")
        .def(
            "find_instance", [](const Scene& s, const std::string& name) { return some(s.find_instance(name)); },
            py::arg("name"), "find_instance(self, name)\n--\n\nThe first instance of that name, or None.")
        .def(
            "find_light", [](const Scene& s, const std::string& name) { return some(s.find_light(name)); },
            py::arg("name"), "find_light(self, name)\n--\n\nThe first light of that name, or None.")
        .def(
            "find_camera", [](const Scene& s, const std::string& name) { return some(s.find_camera(name)); },
            py::arg("name"), "find_camera(self, name)\n--\n\nThe first camera of that name, or None.")
        .def(
            "find_material", [](const Scene& s, const std::string& name) { return some(s.find_material(name)); },
            py::arg("name"), "find_material(self, name)\n--\n\nThe first material of that name, or None.");
}

py::object carrier_of(const Scene& scene, py::handle id)
{
    if (py::isinstance<LightId>(id)) return some(scene.node(id.cast<LightId>()));
    if (py::isinstance<CameraId>(id)) return some(scene.node(id.cast<CameraId>()));
    throw py::type_error("expected a LightId or a CameraId");
}

void add_values(py::class_<Scene>& scene)
{
    scene
        .def("name", &Scene::name, py::arg("node"),
             "name(self, node)\n--\n\nThe name of a node or instance; it may be empty, and need not be unique.")
        .def(
            "parent", [](const Scene& s, const NodeId& id) { return some(s.parent(id)); }, py::arg("node"),
            "parent(self, node)\n--\n\nThe node above, or None.")
        .def(
            "mobility", [](const Scene& s, const NodeId& id) { return name_of(s.mobility(id)); }, py::arg("node"),
            "mobility(self, node)\n--\n\nWhat may change at the node: 'fixed', 'may_move' or 'may_deform'.")
        .def("moving_node", &Scene::moving_node, py::arg("node"),
             "moving_node(self, node)\n--\n\nThe nearest node that may move, from this one up the hierarchy.")
        .def(
            "transform", [](const Scene& s, const NodeId& id) { return array_of(s.transform(id)); }, py::arg("node"),
            "transform(self, node)\n--\n\nThe node's transform to its parent's space at the clip's start: (4, 4).")
        .def("mesh", &Scene::mesh, py::arg("instance"), "mesh(self, instance)\n--\n\nThe mesh that it shows.")
        .def("node", carrier_of, py::arg("part"), "node(self, part)\n--\n\nThe node that carries a light or camera.")
        .def(
            "light", [](const Scene& s, const LightId& id) { return write(s.light(id)); }, py::arg("id"),
            "light(self, id)\n--\n\nThe values of a light: a Light.")
        .def(
            "material", [](const Scene& s, const MaterialId& id) { return write(s.material(id)); }, py::arg("id"),
            "material(self, id)\n--\n\nThe values of a material: a Material.")
        .def(
            "camera", [](const Scene& s, const CameraId& id) { return write(s.camera(id)); }, py::arg("id"),
            "camera(self, id)\n--\n\nThe values of a camera: a Camera; its transform is its node's.")
        .def(
            "instance_of", [](const Scene& s, std::uint32_t value) { return some(s.instance_of(value)); },
            py::arg("value"),
            "instance_of(self, value)\n--\n\nThe instance that a value of Frame.object_ids stands for; None for 0.")
        .def(
            "material_of", [](const Scene& s, std::uint32_t value) { return some(s.material_of(value)); },
            py::arg("value"),
            "material_of(self, value)\n--\n\nThe material that a value of Frame.material_ids stands for; None for 0.");
}

}   // namespace

void add_scene(py::module_& module)
{
    py::class_<Scene> scene(
        module, "Scene",
        "An immutable scene, made by load() or by a SceneBuilder. Copies share its data, and any "
        "number of threads may use it.\n\nFunctions that take an id raise UsageError for parts that "
        "the scene does not have.");
    scene.attr("__module__") = "gnomon";
    add_clip(scene);
    add_parts(scene);
    add_values(scene);
    module.def(
        "load", load_scene, py::arg("what"), py::kw_only(), py::arg("progress") = py::none(), py::arg("threads") = 0,
        py::arg("strict") = false, py::arg("animation") = py::none(), py::arg("ground") = py::none(),
        py::arg("variant") = "", py::arg("memory") = 2048,
        "load($module, what, *, progress=None, threads=0, strict=False, animation=None, ground=None, variant='', "
        "memory=2048)\n--\n\n"
        "Loads a scene: a file (.gltf, .glb, .obj, .ply, .stl, .aff), or 'builtin:NAME'.\n\n"
        "progress   called as progress(stage, done) with done from 0 to 1; False stops the work\n"
        "threads    0: all\n"
        "strict     refuses a glTF file with any error; otherwise harmless ones are repaired, with a warning\n"
        "animation  of a glTF file, by name or number from 0; 'all': all of them\n"
        "ground     whether a ground that shows shadows alone lies under the scene; None: with a studio's light\n"
        "variant    of a glTF file's materials, by name\n"
        "memory     MB that the file may ask for, all in all\n\n"
        "Raises InputError (with file, place and problem), UsageError for an unknown kind of file or animation, "
        "Interrupted, and what progress raises.");
}

}   // namespace gnomon::python
