// SPDX-License-Identifier: Apache-2.0
#pragma once
// The parts of the extension module. Each adds its classes and functions.
//
// Documentation begins with the function's signature as Python's `inspect` reads it, then "--" and an empty line.

#include <pybind11/pybind11.h>

namespace gnomon::python {

void add_ids(pybind11::module_& module);          // typed ids
void add_transforms(pybind11::module_& module);   // matrices
void add_scene(pybind11::module_& module);        // Scene, load
void add_builder(pybind11::module_& module);      // SceneBuilder
void add_frame(pybind11::module_& module);        // Frame
void add_renderer(pybind11::module_& module);     // Renderer

}   // namespace gnomon::python
