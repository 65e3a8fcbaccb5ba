// SPDX-License-Identifier: MPL-2.0
// Messages about long computations: what was built, factored and solved, and warnings.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace batten {

/// Importance of a message. The numbers are those of Python's module `logging`.
enum class LogLevel {
  Debug = 10,   ///< steps of the solvers: factorizations, iterations
  Info = 20,    ///< results of a call: faces, elements, unknowns, files
  Warning = 30  ///< what the reports list as warnings
};

using LogFunction = std::function<void(LogLevel level, std::string_view message)>;

/// Sets the function that receives the messages of the whole process; an empty function turns them
/// off (default). It may be called by several threads, one at a time; what it does itself is not
/// logged. Exceptions from the function are ignored. Messages have no period at the end. Returns
/// after calls by other threads have finished.
void set_log(LogFunction function);

namespace detail {
bool log_is_on();
void write_log(LogLevel level, const std::string& message);
}  // namespace detail

/// Logs message(), which is evaluated only if a function is set. Takes a nanosecond otherwise.
template <class Message>
void log(LogLevel level, const Message& message) {
  if (detail::log_is_on()) detail::write_log(level, message());
}

}  // namespace batten
