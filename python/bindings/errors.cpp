// SPDX-License-Identifier: Apache-2.0
#include "python/bindings/errors.h"

#include <pybind11/pybind11.h>

#include "gnomon/error.h"

namespace gnomon::python {

namespace py = pybind11;

namespace {

template <class... Values>
void raise(const char* name, const Values&... values)
{
    const py::object type = py::module_::import("gnomon._errors").attr(name);
    PyErr_SetObject(type.ptr(), type(values...).ptr());
}

}   // namespace

void translate_errors()
{
    // NOLINTNEXTLINE(performance-unnecessary-value-param): the type of pybind11's translators
    py::register_local_exception_translator([](std::exception_ptr thrown) {
        try {
            if (thrown) std::rethrow_exception(thrown);
        } catch (const InputError& error) {
            raise("InputError", error.what(), error.file(), error.place(), error.problem());
        } catch (const UsageError& error) {
            raise("UsageError", error.what());
        } catch (const MissingError& error) {
            raise("MissingError", error.what());
        } catch (const InterruptedError& error) {
            raise("Interrupted", error.what());
        } catch (const InternalError& error) {
            raise("InternalError", error.what());
        } catch (const Error& error) {
            raise("Error", error.what());
        }
    });
}

}   // namespace gnomon::python
