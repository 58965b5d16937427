// SPDX-License-Identifier: Apache-2.0
#pragma once
// Makes exceptions of Python, defined in the package, of those that the library throws.

namespace gnomon::python {

/// To be called once, when the module is loaded.
void translate_errors();

}   // namespace gnomon::python
