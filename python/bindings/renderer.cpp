// SPDX-License-Identifier: Apache-2.0
// The renderer: what changed goes in, frames come out.
#include "gnomon/renderer.h"

#include <pybind11/stl.h>

#include <chrono>
#include <memory>

#include "python/bindings/module.h"
#include "python/bindings/parts.h"
#include "python/bindings/run.h"

namespace gnomon::python {

namespace {

// A renderer that can be closed. A render in another thread holds what it uses until it ends.
class OpenRenderer {
 public:
    explicit OpenRenderer(py::handle options)
        : renderer_(std::make_shared<Renderer>(read_as<RenderOptions>(options, "options")))
    {
    }
    std::shared_ptr<Renderer> open() const
    {
        if (!renderer_) throw UsageError("the renderer is closed");
        return renderer_;
    }
    void close()
    {
        const std::shared_ptr<Renderer> last = std::move(renderer_);
        if (last) last->cancel();
        const py::gil_scoped_release unlocked;   // freeing caches takes a while
        std::shared_ptr<Renderer>(last).reset();
    }

 private:
    std::shared_ptr<Renderer> renderer_;
};

// What a frame is rendered from, and the arrays that it shows.
struct Input {
    Kept kept;
    FrameInput frame;
};

// Calls `take(key, value)` for each item of a dictionary.
template <class Take>
void for_each_value(py::handle from, const char* where, const Take& take)
{
    if (from.is_none()) return;
    if (!py::isinstance<py::dict>(from))
        throw py::type_error(std::string(where) + " must be a dict from ids to values");
    for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(from)) take(key, value);
}

void read_nodes(Input& in, const py::kwargs& from)
{
    for_each_value(from["transforms"], "transforms", [&](py::handle id, py::handle value) {
        in.frame.transforms.push_back(
            {id_of<NodeId>(id, "a key of transforms", "NodeId or InstanceId"), transform(value, "a transform")});
    });
    for_each_value(from["visibility"], "visibility", [&](py::handle id, py::handle value) {
        in.frame.visibility.push_back({id_of<NodeId>(id, "a key of visibility", "NodeId or InstanceId"),
                                       read_as<bool>(value, "a value of visibility")});
    });
    for_each_value(from["vertices"], "vertices", [&](py::handle id, py::handle value) {
        InstanceVertices& to = in.frame.vertices.emplace_back();
        to.instance = id_of<InstanceId>(id, "a key of vertices", "InstanceId");
        if (py::hasattr(value, "positions")) {
            to.positions = vec3s(value.attr("positions"), "Vertices.positions", in.kept);
            to.normals = vec3s(value.attr("normals"), "Vertices.normals", in.kept);
        } else {
            to.positions = vec3s(value, "a value of vertices", in.kept);
        }
    });
    for_each_value(from["morph_weights"], "morph_weights", [&](py::handle id, py::handle value) {
        in.frame.morph_weights.push_back(
            {id_of<InstanceId>(id, "a key of morph_weights", "InstanceId"), floats(value, "morph_weights")});
    });
}

// The element of a list whose part has that id.
template <class Id, class List, class Part>
auto& value_in_force(List& list, Part part, const Id& id, const char* where)
{
    for (auto& each : list)
        if (each.*part == id) return each;
    throw UsageError(std::string(where) + " has a value for a part that gets none of the shutter's opening");
}

// Values of the shutter's closing, for parts that get one of its opening.
void read_closing(Input& in, py::handle from)
{
    if (from.is_none()) return;
    FrameInput& frame = in.frame;
    if (const py::object camera = from.attr("camera"); !camera.is_none())
        frame.camera_closing = read_as<Camera>(camera, "Closing.camera");
    for_each_value(from.attr("transforms"), "Closing.transforms", [&](py::handle id, py::handle value) {
        const auto node = id_of<NodeId>(id, "a key of Closing.transforms", "NodeId or InstanceId");
        value_in_force(frame.transforms, &NodeTransform::node, node, "Closing.transforms").closing =
            transform(value, "a transform");
    });
    for_each_value(from.attr("vertices"), "Closing.vertices", [&](py::handle id, py::handle value) {
        const auto instance = id_of<InstanceId>(id, "a key of Closing.vertices", "InstanceId");
        value_in_force(frame.vertices, &InstanceVertices::instance, instance, "Closing.vertices").closing_positions =
            vec3s(value, "a value of Closing.vertices", in.kept);
    });
    for_each_value(from.attr("morph_weights"), "Closing.morph_weights", [&](py::handle id, py::handle value) {
        const auto instance = id_of<InstanceId>(id, "a key of Closing.morph_weights", "InstanceId");
        value_in_force(frame.morph_weights, &MorphWeights::instance, instance, "Closing.morph_weights").closing =
            floats(value, "morph_weights");
    });
    for_each_value(from.attr("lights"), "Closing.lights", [&](py::handle id, py::handle value) {
        const auto light = id_of<LightId>(id, "a key of Closing.lights", "LightId");
        value_in_force(frame.lights, &LightValues::light, light, "Closing.lights").closing =
            read_as<Light>(value, "a light");
    });
    for_each_value(from.attr("materials"), "Closing.materials", [&](py::handle id, py::handle value) {
        const auto material = id_of<MaterialId>(id, "a key of Closing.materials", "MaterialId");
        value_in_force(frame.materials, &MaterialValues::material, material, "Closing.materials").closing =
            read_as<Material>(value, "a material");
    });
}

void read_looks(Input& in, const py::kwargs& from)
{
    for_each_value(from["lights"], "lights", [&](py::handle id, py::handle value) {
        in.frame.lights.push_back({id_of<LightId>(id, "a key of lights", "LightId"), read_as<Light>(value, "a light")});
    });
    for_each_value(from["materials"], "materials", [&](py::handle id, py::handle value) {
        in.frame.materials.push_back(
            {id_of<MaterialId>(id, "a key of materials", "MaterialId"), read_as<Material>(value, "a material")});
    });
    if (from["released"].is_none()) return;
    for (const py::handle id : from["released"]) {
        if (py::isinstance<LightId>(id))
            in.frame.released_lights.push_back(id.cast<LightId>());
        else if (py::isinstance<MaterialId>(id))
            in.frame.released_materials.push_back(id.cast<MaterialId>());
        else
            in.frame.released_nodes.push_back(id_of<NodeId>(id, "released", "NodeId, LightId or MaterialId"));
    }
}

PixelFormat format_of(const py::array& array, const std::string& where)
{
    if (py::isinstance<py::array_t<float>>(array)) return PixelFormat::f32;
    if (py::isinstance<py::array_t<std::uint32_t>>(array)) return PixelFormat::u32;
    if (py::isinstance<py::array_t<std::uint8_t>>(array)) return PixelFormat::rgba8;
    if (array.dtype().kind() == 'f' && array.itemsize() == 2) return PixelFormat::f16;
    throw py::type_error(where + " must be an array of float32, float16, uint32, or uint8 for RGBA");
}

// Layers that the host wants in arrays of its own. Only the sizes of pixels are checked here: the renderer checks the
// rest, and needs the lowest address.
void read_outputs(Input& in, py::handle from)
{
    if (from.is_none()) return;
    for (const auto& [key, value] : py::cast<py::dict>(from)) {
        const std::string where = "out['" + py::str(key).cast<std::string>() + "']";
        if (!py::isinstance<py::array>(value)) throw py::type_error(where + " must be an array");
        py::array array = py::reinterpret_borrow<py::array>(value);
        if (!array.writeable()) throw UsageError(where + " cannot be written to");
        if (array.ndim() != 2 && array.ndim() != 3)
            throw UsageError(where + " has the shape " + shape_text(array) + "; expected (height, width[, channels])");
        if (array.ndim() == 3 && array.shape(2) > 1 && array.strides(2) != array.itemsize())
            throw UsageError(where + ": the channels of a pixel must be adjacent");
        if (array.strides(1) <= 0) throw UsageError(where + ": rows must run from left to right");
        const py::ssize_t channels = array.ndim() == 3 ? array.shape(2) : 1, rows = array.shape(0);
        const py::ssize_t stride = array.strides(0), last_row = stride * (rows - 1);
        Output& to = in.frame.outputs.emplace_back();
        to.layer = py::str(key).cast<std::string>();
        to.format = format_of(array, where);
        to.data = static_cast<char*>(array.mutable_data()) + (stride < 0 ? last_row : 0);
        to.pixel_stride = array.strides(1);
        to.row_stride = stride;
        to.bytes = static_cast<std::size_t>(std::abs(last_row) + array.strides(1) * (array.shape(1) - 1) +
                                            channels * array.itemsize());
        in.kept.push_back(array);
    }
}

// The shape of an output, which the renderer knows by its bytes alone.
void check_output_shapes(py::handle from, const Size& size)
{
    if (from.is_none()) return;
    for (const auto& [key, value] : py::cast<py::dict>(from)) {
        const py::array array = py::reinterpret_borrow<py::array>(value);
        if (array.shape(0) != size.height || array.shape(1) != size.width)
            throw UsageError("out['" + py::str(key).cast<std::string>() + "'] has the shape " + shape_text(array) +
                             "; the image has " + std::to_string(size.height) + " rows of " +
                             std::to_string(size.width) + " pixels");
    }
}

py::object render(const OpenRenderer& renderer, const Scene& scene, const py::kwargs& from)
{
    const std::shared_ptr<Renderer> open = renderer.open();
    Input in;
    FrameInput& frame = in.frame;
    read(from["time"], "time", frame.time);
    read(from["frame"], "frame", frame.frame);
    read(from["camera"], "camera", frame.camera);
    read(from["turn"], "turn", frame.turn);
    read(from["indirect_ray_limit"], "indirect_ray_limit", frame.indirect_ray_limit);
    read_nodes(in, from);
    read_looks(in, from);
    read_closing(in, from["closing"]);
    read_outputs(in, from["out"]);
    if (!frame.outputs.empty()) {
        const RenderOptions& options = open->options();
        const bool of_host = frame.camera && frame.camera->resolution != Size{};
        check_output_shapes(from["out"], options.size != Size{} ? options.size
                                         : of_host              ? frame.camera->resolution
                                         : frame.camera         ? Size{1280, 720}
                                                                : default_size(scene, options.camera));
    }
    std::optional<Frame> result;
    run(
        from["progress"], [&] { open->cancel(); },
        [&](const Progress& progress) { result.emplace(open->render(scene, frame, progress)); });
    return py::cast(std::move(*result));
}

py::object pick(const OpenRenderer& renderer, int x, int y)
{
    const Pick found = renderer.open()->pick(x, y);
    if (!found.hit) return py::none();
    py::dict fields;
    fields["instance"] = some(found.instance);
    fields["material"] = some(found.material);
    fields["triangle"] = found.triangle;
    fields["position"] = write(found.position);
    fields["normal"] = write(found.normal);
    fields["depth"] = write(found.depth);
    return make("Pick", fields);
}

py::object report(const OpenRenderer& renderer)
{
    const FrameReport last = renderer.open()->report();
    py::dict fields;
    fields["everything"] = last.everything;
    fields["instances"] = last.instances;
    fields["lights"] = last.lights;
    fields["materials"] = last.materials;
    py::list rectangles;
    for (const PixelRectangle& one : last.rectangles)
        rectangles.append(py::make_tuple(one.x, one.y, one.width, one.height));
    fields["rectangles"] = rectangles;
    return make("FrameReport", fields);
}

void improve(const OpenRenderer& renderer, double seconds)
{
    const std::shared_ptr<Renderer> open = renderer.open();
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    run(py::none(), {}, [&](const Progress& progress) {
        open->improve([&] { return progress({"preparing", 0}) && std::chrono::steady_clock::now() < end; });
    });
}

}   // namespace

void add_renderer(py::module_& module)
{
    // The class `gnomon.Renderer` derives from this one; its documentation is there.
    py::class_<OpenRenderer>(module, "Renderer", "The base of gnomon.Renderer.")
        .def(py::init<py::handle>(), py::arg("options"))
        .def("_render", render, py::arg("scene"))
        .def("_set_options",
             [](const OpenRenderer& r, py::handle options) {
                 r.open()->set_options(read_as<RenderOptions>(options, "options"));
             })
        .def_property_readonly(
            "options", [](const OpenRenderer& r) { return write(r.open()->options()); },
            "The options in force, as a new RenderOptions.")
        .def("pick", pick, py::arg("x"), py::arg("y"),
             "pick(self, x, y)\n--\n\nWhat the last frame shows at the centre of a pixel, from the top left corner, "
             "from "
             "0: a Pick, or None.")
        .def("report", report, "report(self)\n--\n\nWhat the last frame changed: a FrameReport.")
        .def(
            "cancel", [](const OpenRenderer& r) { r.open()->cancel(); },
            "cancel(self)\n--\n\nMakes the render in progress, if any, stop and raise Interrupted. From any thread.")
        .def(
            "transform", [](const OpenRenderer& r, const NodeId& id) { return array_of(r.open()->transform(id)); },
            py::arg("node"),
            "transform(self, node)\n--\n\nA node's transform to its parent's space in the last frame: (4, 4).")
        .def(
            "world_transform",
            [](const OpenRenderer& r, const NodeId& id) { return array_of(r.open()->world_transform(id)); },
            py::arg("node"),
            "world_transform(self, node)\n--\n\nA node's transform to the world in the last frame: (4, 4).")
        .def(
            "visible", [](const OpenRenderer& r, const NodeId& id) { return r.open()->visible(id); }, py::arg("node"),
            "visible(self, node)\n--\n\nWhether a node and all nodes above it were shown in the last frame.")
        .def_property_readonly(
            "camera", [](const OpenRenderer& r) { return write(r.open()->camera()); },
            "The Camera of the last frame, with its transform to the world.")
        .def_property_readonly(
            "bounds", [](const OpenRenderer& r) { return write(r.open()->bounds()); },
            "Bounds of the objects that the last frame could show: ((x, y, z), (x, y, z)).")
        .def_property_readonly(
            "device", [](const OpenRenderer& r) { return r.open()->device(); },
            "The Vulkan device that rendered the last frame; '' if none did.")
        .def_property_readonly(
            "remembered_bytes", [](const OpenRenderer& r) { return r.open()->remembered_bytes(); },
            "Bytes of remembered results, textures and geometry aside.")
        .def("improve", improve, py::arg("seconds"),
             "improve(self, seconds)\n--\n\nUses time without work: proves results for later frames.")
        .def(
            "forget", [](const OpenRenderer& r) { r.open()->forget(); },
            "forget(self)\n--\n\nForgets the scene, the values that were handed over and everything remembered.")
        .def("close", &OpenRenderer::close,
             "close(self)\n--\n\nLets go of its memory; frames stay valid. A render in progress in another thread "
             "stops.");
}

}   // namespace gnomon::python
