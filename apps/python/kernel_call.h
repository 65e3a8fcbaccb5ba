// A call from Python into the kernel: without the interpreter's lock, and stopped by Ctrl-C.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <thread>

#include "batten/apps/python/bindings.h"
#include "batten/core/progress.h"

namespace batten::python {

/// One long call. The kernel runs without the interpreter's lock, so that other threads of Python go
/// on, and asks now and then whether it shall stop:
///
///     Ctrl-C                        PyErr_CheckSignals(), every 50 ms: KeyboardInterrupt
///     progress(stage, fraction)     called where it is given; what it raises stops the computation
///                                   and is what the call raises
///
/// Made and run by a thread that holds the interpreter's lock.
class KernelCall {
 public:
  /// `progress`: a callable, or None. Throws InputError for anything else.
  explicit KernelCall(py::object progress = py::none());

  /// Calls function(progress) without the lock. What it returns must not be Python's.
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
  std::exception_ptr python_error_;  // by Python code; with the lock
  std::atomic<std::chrono::steady_clock::rep> asked_{0};
};

/// Lets one thread after the other use an object whose calls run without the interpreter's lock.
class CallSerializer {
 public:
  /// Calls function() in this thread's turn, to be used without the interpreter's lock. Throws Error
  /// where the thread has the turn already: a progress function that uses its own object.
  template <class Function>
  auto operator()(const Function& function) {
    if (owner_.load() == std::this_thread::get_id())
      throw Error(
          "found a call from inside of another call of the same object, expected it after that");
    const std::lock_guard lock(mutex_);
    const OwnerScope mine(owner_);
    return function();
  }

 private:
  struct OwnerScope {
    explicit OwnerScope(std::atomic<std::thread::id>& of) : owner(of) {
      owner = std::this_thread::get_id();
    }
    ~OwnerScope() { owner = std::thread::id(); }
    OwnerScope(const OwnerScope&) = delete;
    std::atomic<std::thread::id>& owner;
  };
  std::mutex mutex_;
  std::atomic<std::thread::id> owner_{};
};

}  // namespace batten::python
