#include "batten/core/errors.h"
#include "batten/mesh/sequence/control_mesh.h"

namespace batten {

TriangleMesh control_mesh(const TriangleMesh&, const ControlMeshOptions&) {
  throw InputError("Batten was built without CGAL and cannot create a control mesh; provide one");
}

}  // namespace batten
