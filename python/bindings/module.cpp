// SPDX-License-Identifier: Apache-2.0
// The extension module gnomon._gnomon, on which the Python package `gnomon` rests.
#include "python/bindings/module.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "gnomon/gnomon.h"
#include "python/bindings/errors.h"
#include "python/bindings/parts.h"
#include "python/bindings/run.h"

namespace gnomon::python {

namespace {

template <class Id, class... Bases>
void add_id(py::module_& module, const char* name, const char* doc)
{
    py::class_<Id, Bases...>(module, name, doc)
        .def("__eq__",
             [](const Id& a, py::handle b) {
                 return py::isinstance<Id>(b) ? py::object(py::bool_(a == b.cast<Id>()))
                                              : py::reinterpret_borrow<py::object>(Py_NotImplemented);
             })
        .def("__hash__", [](const Id& id) { return id.stamp; })
        .def("__repr__",
             [name](const Id& id) { return "<" + std::string(name) + " " + std::to_string(id.index) + ">"; })
        .attr("__module__") = "gnomon";
}

py::object compare_files(const std::filesystem::path& test, const std::filesystem::path& reference,
                         const std::string& layer, int threads)
{
    CompareOptions options;
    options.layer = layer;
    options.threads = threads;
    CompareResult result;
    {
        const py::gil_scoped_release unlocked;
        result = compare(test, reference, options);
    }
    py::dict fields;
    fields["size"] = write(result.size);
    fields["rmse"] = result.rmse;
    fields["relmse"] = result.relmse;
    fields["psnr"] = write(result.psnr);
    fields["ssim"] = write(result.ssim);
    fields["flip"] = write(result.flip);
    fields["max_abs"] = result.max_abs;
    fields["pixels_different"] = result.pixels_different;
    return make("CompareResult", fields);
}

// What the library's structs hold by default, for a test that the dataclasses hold the same.
py::dict defaults()
{
    py::dict all;
    all["MaterialLayers"] = write(MaterialLayers{});
    all["Material"] = write(Material{});
    all["Light"] = write(Light{});
    all["AreaLight"] = write(AreaLight{});
    all["Camera"] = write(Camera{});
    all["ReferenceLightOptions"] = write(ReferenceLightOptions{});
    all["RenderOptions"] = write(RenderOptions{});
    return all;
}

}   // namespace

void add_ids(py::module_& module)
{
    add_id<MeshId>(module, "MeshId", "A mesh, which any number of instances may show.");
    add_id<MaterialId>(module, "MaterialId", "A material.");
    add_id<TextureId>(module, "TextureId", "A texture, which any number of materials may use.");
    add_id<SkinId>(module, "SkinId", "A skin: the joints that deform a mesh.");
    add_id<LightId>(module, "LightId", "A light; the node that carries it is Scene.node().");
    add_id<CameraId>(module, "CameraId", "A camera; the node that carries it is Scene.node().");
    add_id<NodeId>(module, "NodeId", "A node of the hierarchy: a transform relative to the parent's.");
    add_id<InstanceId, NodeId>(module, "InstanceId", "A node with a mesh: an object.");
}

}   // namespace gnomon::python

PYBIND11_MODULE(_gnomon, module)
{
    using namespace gnomon::python;
    py::options options;
    options.disable_function_signatures();
    module.doc() = "The compiled part of the package gnomon.";
    translate_errors();
    prepare_runs();
    add_ids(module);
    add_transforms(module);
    add_scene(module);
    add_builder(module);
    add_frame(module);
    add_renderer(module);
    module.def("compare", compare_files, py::arg("test"), py::arg("reference"), py::kw_only(), py::arg("layer") = "",
               py::arg("threads") = 0,
               "compare($module, test, reference, *, layer='', threads=0)\n--\n\n"
               "Compares two image files, and returns a CompareResult.\n\n"
               "`layer` names a layer of OpenEXR files ('depth', 'shadow', or one channel: 'shadow.L0'); '' is the "
               "image.\nRaises InputError if a file is missing or invalid, and UsageError if sizes differ.");
    module.def(
        "instruction_set", [] { return std::string(gnomon::instruction_set_name()); },
        "instruction_set($module)\n--\n\n"
        "The instruction set that this process uses: 'sse4.2', 'avx', 'avx2' or 'avx512'.\n\n"
        "The environment variable GNOMON_ISA limits it. Images have the same bytes with any of them.");
    module.def("_defaults", defaults, "_defaults($module)\n--\n\nDataclasses with the library's own defaults.");
    module.attr("__version__") = std::string(gnomon::version());
}
