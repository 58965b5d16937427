// SPDX-License-Identifier: Apache-2.0
// Rendered frames: views of their layers without a copy.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "gnomon/gnomon.h"
#include "python/bindings/module.h"
#include "python/bindings/parts.h"

namespace gnomon::python {

namespace {

// The option that makes a layer.
const char* option_of(const std::string& layer)
{
    if (layer == "id") return "RenderOptions.ids";
    if (layer == "motion") return "RenderOptions.motion";
    if (layer == "alpha") return "another RenderOptions.background";
    return "RenderOptions.layers";
}

const Layer& layer_of(const Frame& frame, const std::string& name)
{
    if (const Layer* layer = frame.layer(name)) return *layer;
    for (const char* known : {"depth", "normal", "albedo", "direct", "indirect", "shadow", "alpha", "id", "motion"})
        if (name == known) throw UsageError("the frame has no layer '" + name + "': " + option_of(name) + " makes it");
    std::string names;
    for (const Layer& layer : frame.layers) names += (names.empty() ? "'" : ", '") + layer.name + "'";
    throw UsageError("there is no layer '" + name + "'; the frame has " + names);
}

template <int channel>
py::array one_channel(const Frame& frame)
{
    return view_of(layer_of(frame, "id"), channel);
}

py::array srgb8(const Frame& frame, bool alpha)
{
    std::vector<std::uint8_t> pixels;
    {
        const py::gil_scoped_release unlocked;
        pixels = alpha ? frame.to_srgb8_alpha() : frame.to_srgb8();
    }
    return owned(std::move(pixels), {frame.size.height, frame.size.width, alpha ? 4 : 3});
}

py::array srgb16(const Frame& frame, bool alpha)
{
    std::vector<std::uint16_t> pixels;
    {
        const py::gil_scoped_release unlocked;
        pixels = alpha ? frame.to_srgb16_alpha() : frame.to_srgb16();
    }
    return owned(std::move(pixels), {frame.size.height, frame.size.width, alpha ? 4 : 3});
}

void write_file(const Frame& frame, const std::filesystem::path& file, int quality, const std::string& exr_type,
                const std::string& exr_compression)
{
    const ImageOptions options{.quality = quality,
                               .exr_type = value_of<ExrType>(exr_type, "exr_type"),
                               .exr_compression = value_of<ExrCompression>(exr_compression, "exr_compression")};
    const py::gil_scoped_release unlocked;
    frame.write(file, options);
}

py::dict times_of(const Frame& frame)
{
    py::dict times;
    for (std::size_t i = 0; i < FrameTimes::k_stages; ++i) times[FrameTimes::k_names[i]] = frame.times.ms[i];
    return times;
}

// A flat list of names, because hosts print and compare them.
py::dict counters_of(const Frame& frame)
{
    const FrameCounters& c = frame.counters;
    py::dict all;
    all["shadow_rays"] = c.shadow.rays;
    all["shadow_rays_skipped"] = c.shadow.rays_skipped;
    all["shadow_rays_dynamic_only"] = c.shadow.rays_dynamic_only;
    all["indirect_clusters"] = c.indirect.clusters;
    all["indirect_rays"] = c.indirect.rays;
    all["updated_nodes"] = c.update.nodes;
    all["updated_instances"] = c.update.instances;
    all["began_anew"] = c.update.began_anew;
    all["sampled_pixels"] = c.samples.pixels;
    all["samples_taken"] = c.samples.taken;
    all["primary_rays"] = c.primary_rays;
    all["reflection_rays"] = c.reflection_rays;
    all["refraction_rays"] = c.refraction_rays;
    all["draws"] = c.draws;
    all["kept_image"] = c.kept_image;
    return all;
}

void add_views(py::class_<Frame>& frame)
{
    const auto layer = [](const char* name) { return [name](const Frame& of) { return view_of(layer_of(of, name)); }; };
    frame
        .def_property_readonly("color", layer(""),
                               "(height, width, 3) float32: linear light, Rec. 709 primaries, 0 or more.")
        .def_property_readonly(
            "depth", layer("depth"),
            "(height, width) float32: metres along the camera's axis; 0: nothing. Needs layers=True.")
        .def_property_readonly("normal", layer("normal"),
                               "(height, width, 3) float32: shading normal in world space, of unit length; 0: nothing. "
                               "Needs layers=True.")
        .def_property_readonly("albedo", layer("albedo"),
                               "(height, width, 3) float32: reflectance, 0 to 1. Needs layers=True.")
        .def_property_readonly("direct", layer("direct"),
                               "(height, width, 3) float32: direct light. Needs layers=True.")
        .def_property_readonly("indirect", layer("indirect"),
                               "(height, width, 3) float32: indirect light. Needs layers=True.")
        .def_property_readonly("shadow", layer("shadow"),
                               "(height, width, lights) float32: 1 lit to 0 in shadow, by light. Needs layers=True.")
        .def_property_readonly("alpha", layer("alpha"),
                               "(height, width) float32: 0 to 1. Needs another background than 'environment'.")
        .def_property_readonly("object_ids", one_channel<0>,
                               "(height, width) uint32: values for Scene.instance_of(); 0: nothing. Needs ids=True.")
        .def_property_readonly("material_ids", one_channel<1>,
                               "(height, width) uint32: values for Scene.material_of(); 0: nothing. Needs ids=True.")
        .def_property_readonly(
            "motion", layer("motion"),
            "(height, width, 2) float32: from where the surface point was a frame before to where it "
            "is, in pixels to the right and down. Needs motion=True.")
        .def_property_readonly(
            "layers",
            [](const Frame& of) {
                std::vector<std::string> names;
                for (const Layer& one : of.layers) names.push_back(one.name);
                return names;
            },
            "Names of the layers that the frame has; '' is the image.")
        .def(
            "layer", [](const Frame& of, const std::string& name) { return view_of(layer_of(of, name)); },
            py::arg("name"),
            "layer(self, name)\n--\n\nA view of a layer by its name: (height, width) of one channel, else (height, "
            "width, channels).\nRaises UsageError if the frame has no such layer.");
}

void add_description(py::class_<Frame>& frame)
{
    frame
        .def_property_readonly(
            "size", [](const Frame& of) { return write(of.size); }, "(width, height) in pixels.")
        .def_readonly("exposure", &Frame::exposure, "Stops that srgb8() and write() apply before tone mapping.")
        .def_readonly("time", &Frame::time, "Time of the scene in seconds.")
        .def_readonly("frame", &Frame::frame, "Number of the clip's frame, from 1; 0 if a time was given.")
        .def_readonly("complete", &Frame::complete, "False: indirect_ray_limit left out light that later frames bring.")
        .def_readonly("noise", &Frame::noise,
                      "Of a reference: root mean square of its standard error, divided by its mean.")
        .def_readonly("milliseconds", &Frame::milliseconds, "Time that it took, without loading and writing.")
        .def_property_readonly("times", times_of, "The same time by stage: {stage: milliseconds}.")
        .def_property_readonly(
            "counters", counters_of,
            "What was done and what was avoided: {name: number}. 'updated_nodes' is the length of the "
            "list of changes,\nand 'began_anew' tells whether everything was computed again.")
        .def_property_readonly(
            "world_to_camera", [](const Frame& of) { return array_of(of.world_to_camera); },
            "(4, 4) float64: from the world to the camera's space, which looks along -Z with +Y up.")
        .def_property_readonly(
            "world_to_image", [](const Frame& of) { return array_of(of.world_to_image); },
            "(4, 4) float64: from the world to the image. After division by w, x goes from 0 at the left edge to 1 at "
            "the right,\nand y from 0 at the upper edge to 1 at the lower.");
}

}   // namespace

void add_frame(py::module_& module)
{
    py::class_<Frame> frame(
        module, "Frame",
        "A rendered frame. Its layers are numpy arrays that show the renderer's memory, without a copy.\n\n"
        "Lifetime: an array holds its memory, and stays valid and unchanged as long as it exists, also after the frame "
        "and the renderer\nare gone. The renderer writes later frames into other memory meanwhile. Arrays cannot be "
        "written to; copy() makes one that can.\nA host that drops frame and arrays before it renders the next one "
        "needs "
        "memory for one frame alone.");
    frame.def(py::init<const Frame&>(), py::arg("frame"),
              "__init__(self, frame)\n--\n\nShares another frame's memory.");
    frame.attr("__module__") = "gnomon._gnomon";
    add_views(frame);
    add_description(frame);
    frame
        .def("srgb8", srgb8, py::kw_only(), py::arg("alpha") = false,
             "srgb8(self, *, alpha=False)\n--\n\n(height, width, 3 or 4) uint8: as the image is shown, by exposure, "
             "tone "
             "mapping and sRGB. A new array.\n\nalpha  adds a channel of alpha, which is not associated")
        .def("srgb16", srgb16, py::kw_only(), py::arg("alpha") = false,
             "srgb16(self, *, alpha=False)\n--\n\nThe same as srgb8() with 16 bits a channel: uint16.")
        .def("write", write_file, py::arg("file"), py::kw_only(), py::arg("quality") = 90,
             py::arg("exr_type") = "float", py::arg("exr_compression") = "zip",
             "write(self, file, *, quality=90, exr_type='float', exr_compression='zip')\n--\n\n"
             "Writes .png, .jpg (both as the image is shown) or .exr (all layers, linear). The file is replaced at "
             "once.\n\n"
             "quality          of .jpg, 0 to 100\n"
             "exr_type         'half' or 'float'\n"
             "exr_compression  'none', 'rle', 'zips', 'zip', 'piz' or 'pxr24'\n\n"
             "Raises UsageError for another extension, and MissingError if it cannot be written.");
}

}   // namespace gnomon::python
