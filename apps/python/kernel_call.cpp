// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/python/kernel_call.h"

#include <string>

#include "batten/io/files/text.h"

namespace batten::python {

KernelCall::KernelCall(py::object progress) : callback_(std::move(progress)) {
  progress_.cancelled = [this] { return is_interrupted(); };
  if (callback_.is_none()) return;
  if (!PyCallable_Check(callback_.ptr()))
    throw InputError(
        "progress: found an object that is not callable, expected a function progress(stage, "
        "fraction)");
  progress_.report = [this](std::string_view stage, double fraction) {
    const py::gil_scoped_acquire lock;
    if (python_error_) throw CancelledError();
    try {
      callback_(py::str(printable(stage)), fraction);
    } catch (const py::error_already_set&) {
      store_python_error();
      throw CancelledError();
    }
  };
}

void KernelCall::store_python_error() { python_error_ = std::current_exception(); }

bool KernelCall::is_interrupted() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  const auto pause = std::chrono::steady_clock::duration(std::chrono::milliseconds(50));
  if (now.count() - asked_.load(std::memory_order_relaxed) < pause.count()) return false;
  asked_.store(now.count(), std::memory_order_relaxed);
  const py::gil_scoped_acquire lock;
  if (python_error_) return true;
  if (PyErr_CheckSignals() == 0) return false;
  try {
    throw py::error_already_set();
  } catch (const py::error_already_set&) {
    store_python_error();
  }
  return true;
}

}  // namespace batten::python
