// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs long work without Python's global lock, so that other threads of Python go on, and stops it at a signal.
//
// Python runs the handlers of signals in its main thread alone, and only between its own instructions. In the main
// thread, the work therefore runs in a thread beside it, while the main thread looks for signals every 10 ms. In any
// other thread, it runs there. All of the process's long work of the main thread uses one thread, which is kept.

#include <pybind11/pybind11.h>

#include <functional>

#include "gnomon/types.h"

namespace gnomon::python {

namespace py = pybind11;

/// Runs `work` with a Progress that calls `callback` and returns false once the work is to stop.
/// @param callback  None, or called as callback(stage: str, done: float); False stops the work
/// @param cancel    makes the work stop sooner than its next Progress; may be empty
/// @throws what the callback or the handler of a signal raised (Ctrl-C: KeyboardInterrupt), else what the work throws
/// @throws UsageError  this process was forked from one in which such work had run
void run(const py::object& callback, const std::function<void()>& cancel,
         const std::function<void(const Progress&)>& work);

/// To be called once, when the module is loaded: notes the main thread, and stops work when the interpreter ends.
void prepare_runs();

}   // namespace gnomon::python
