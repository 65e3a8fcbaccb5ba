// A part of the surface of a shell.
#pragma once

#include <optional>
#include <vector>

#include "batten/core/box.h"
#include "batten/core/errors.h"

namespace batten {

/// A part of the surface of a model, on which something acts, or where something holds it.
struct ShellPart {
  std::vector<int> regions = {};  ///< none: all
  std::optional<Box3> box =
      {};  ///< what lies in it only; its border is met to a 32nd of an element
};

/// A part that holds nothing of the surface.
class EmptyPartError : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace batten
