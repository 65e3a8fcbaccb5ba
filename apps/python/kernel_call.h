// SPDX-License-Identifier: MPL-2.0
// Calls from Python into the kernel: without the GIL, and cancellable by Ctrl-C.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>

#include "batten/apps/python/bindings.h"
#include "batten/core/call_serializer.h"
#include "batten/core/progress.h"

namespace batten::python {

/// A long call into the kernel.
///
/// The kernel runs without the GIL (global interpreter lock), so other Python threads continue. It
/// polls for cancellation:
///
///     Ctrl-C                        PyErr_CheckSignals(), every 50 ms; raises KeyboardInterrupt
///     progress(stage, fraction)     the user's callback, if given; an exception that it raises
///                                   cancels the computation and is raised by the call
///
/// Must be constructed and called by a thread that holds the GIL.
class KernelCall {
 public:
  /// `progress`: a callable or None. Throws InputError for anything else.
  explicit KernelCall(py::object progress = py::none());

  /// Calls function(progress) without the GIL. The result must not be a Python object.
  template <class Function>
  auto operator()(const Function& function) {
    try {
      const py::gil_scoped_release free;
      return function(progress_);
    } catch (const CancelledError&) {
      if (python_error_) std::rethrow_exception(python_error_);
      throw;
    }
  }

 private:
  bool is_interrupted();
  void store_python_error();

  py::object callback_;
  Progress progress_;
  std::exception_ptr python_error_;  // exception raised by Python code; access with the GIL
  std::atomic<std::chrono::steady_clock::rep> asked_{0};
};

}  // namespace batten::python
