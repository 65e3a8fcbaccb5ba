// A line of points as it stood in a file.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// One line of a file: its points in their order, two or more (.curves: one or more).
struct NamedPoints {
  std::string name;          ///< unique in the file
  std::vector<Vec3> points;  ///< model units
  int first_line = 0;        ///< row of the file where it starts, counted from 1, for messages
  std::string format_note =
      {};  ///< in words, of a file's first line: title, columns, decimal commas
};

}  // namespace batten
