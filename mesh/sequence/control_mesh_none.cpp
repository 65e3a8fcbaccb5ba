#include "batten/core/errors.h"
#include "batten/mesh/sequence/control_mesh.h"

namespace batten {

TriangleMesh control_mesh(const TriangleMesh&, const ControlMeshOptions&) {
  throw InputError("a control mesh is made by CGAL, which this build is without: give one");
}

}  // namespace batten
