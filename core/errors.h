// What can go wrong, by what the user has to do about it. Each class is one exit code of the
// program (docs/conventions.md). Besides these the library throws std::bad_alloc, and
// std::logic_error for a call that breaks what its header asks for (an index out of range).
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace batten {

/// Base of all errors that Batten throws on purpose.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The input is wrong or not supported: a scene, a line, a file, an argument. Exit code 1.
/// The message says what was found, where, and what was expected.
class InputError : public Error {
 public:
  using Error::Error;
};

/// A mesh of the (u, v) plane that cannot be: a triangle without area, an edge of three triangles.
/// Where the mesh was made from lines, they leave too little room for elements.
class MeshError : public InputError {
 public:
  using InputError::InputError;
};

/// Constraints contradict each other. Exit code 2.
class ConflictError : public Error {
 public:
  /// One contradiction: the constraints that take part in it and by how much they miss each other
  /// (in the units of the right-hand side of the row that was checked last).
  struct Conflict {
    std::vector<std::string> names;
    double amount = 0;
    /// Said behind the amount, as " degrees of turn"; empty: the unit of the right-hand side.
    std::string unit = {};
  };
  /// `where` is said before the message.
  explicit ConflictError(std::vector<Conflict> conflicts, const std::string& where = "");
  const std::vector<Conflict>& conflicts() const { return conflicts_; }

 private:
  std::vector<Conflict> conflicts_;
};

/// The problem has no solution that could be found: a singular system, a load past its limit.
/// Exit code 3.
class NoSolutionError : public Error {
 public:
  using Error::Error;
};

/// The user asked to stop. Exit code 130.
class CancelledError : public Error {
 public:
  CancelledError() : Error("cancelled") {}
};

/// "value" with as many digits as are needed to tell it from its neighbours of interest ("%.6g").
std::string format_number(double value);

/// The word of `words` nearest to `word` by edit distance, or "" when none is near enough to be
/// meant (more than a third of its letters differ, and more than one).
std::string closest_match(const std::string& word, const std::vector<std::string>& words);

}  // namespace batten
