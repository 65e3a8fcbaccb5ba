// SPDX-License-Identifier: MPL-2.0
// Exception classes of Batten, grouped by exit code, and the formatting of numbers and words in
// their messages.
//
// Each class corresponds to one exit code of the program (docs/conventions.md). The library may
// also throw std::bad_alloc, and std::logic_error if a call violates a documented precondition (for
// example an index out of range).
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace batten {

/// Base class of all exceptions that Batten throws deliberately.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Invalid or unsupported input: a scene, a curve, a file or an argument. Exit code 1. The message
/// states what was found, where, and what is expected.
class InputError : public Error {
 public:
  using Error::Error;
};

/// Invalid mesh of the (u, v) plane, for example a triangle without area or an edge shared by three
/// triangles. If the mesh was generated from curves, the curves leave too little space for
/// elements.
class MeshError : public InputError {
 public:
  using InputError::InputError;
};

/// Thrown by require_memory() if a computation would need more memory than is available.
class MemoryError : public InputError {
 public:
  using InputError::InputError;
};

/// Contradictory constraints. Exit code 2.
class ConflictError : public Error {
 public:
  /// One contradiction: the names of the constraints involved, and the amount by which they
  /// contradict each other, in the unit of the right-hand side of the constraint that was checked
  /// last.
  struct Conflict {
    std::vector<std::string> names;
    double amount = 0;
    /// Unit of `amount` as text with a leading space, for example " degrees of rotation". Empty:
    /// the unit of the right-hand side of the constraint.
    std::string unit = {};
  };
  /// `where`: prefix of the message, for example the file and line of the input.
  explicit ConflictError(std::vector<Conflict> conflicts, const std::string& where = "");
  const std::vector<Conflict>& conflicts() const { return conflicts_; }

 private:
  std::vector<Conflict> conflicts_;
};

/// Thrown if no solution was found because the system of equations is singular or the load exceeds
/// the limit load. Exit code 3.
class NoSolutionError : public Error {
 public:
  using Error::Error;
};

/// The user cancelled the computation. Exit code 130.
class CancelledError : public Error {
 public:
  CancelledError() : Error("cancelled") {}
};

/// Formats a number with up to 6 significant digits ("%.6g"), independently of the locale.
std::string format_number(double value);

/// Element of `words` with the smallest edit distance to `word`, for "did you mean" messages.
/// Returns "" if the smallest distance exceeds 1 and also exceeds a third of the length of `word`.
std::string closest_match(const std::string& word, const std::vector<std::string>& words);

/// Suffix of a message about an unknown word: "; did you mean 'x'?" if closest_match() finds a
/// similar word x in `words`, otherwise "".
std::string did_you_mean(const std::string& word, const std::vector<std::string>& words);

}  // namespace batten
