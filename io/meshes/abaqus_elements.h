// Element types of Abaqus and CalculiX. Internal.
#pragma once

#include <string>

#include "batten/io/meshes/mesh_file_types.h"

namespace batten {

/// What an element of a type is. Corners and middle nodes of a face, or the nodes of another
/// element; `count` is 0 for types that are not known.
struct AbaqusElement {
  bool face = false;
  int corners = 0, middle = 0;
  NonShellElement::Kind kind = NonShellElement::Kind::Other;
  int count = 0;
  bool direction = false;  ///< a further node may say how a beam is turned
};
AbaqusElement abaqus_element(const std::string& type);

}  // namespace batten
