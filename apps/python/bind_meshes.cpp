// Meshes: of files and of arrays.
#include "batten/apps/commands/meshes/mesh_source.h"
#include "batten/apps/python/arrays.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/apps/python/mesh_object.h"
#include "batten/apps/python/scenes.h"
#include "batten/core/errors.h"
#include "batten/io/files/length_units.h"
#include "batten/mesh/features/hole_measure.h"

namespace batten::python {
namespace {

using namespace py::literals;
using MeshPtr = std::shared_ptr<MeshObject>;

MeshPtr read_mesh(const py::object& path) {
  const std::string file = path_from(path);
  return KernelCall()([&](const Progress&) {
    return std::make_shared<MeshObject>(MeshObject{read_source(file), true});
  });
}

py::array mesh_points(const MeshPtr& mesh) {
  const Points& points = mesh->source.file.shells().points;
  const auto size = static_cast<py::ssize_t>(sizeof(double));
  return array_view(mesh, points.data(), {points.rows(), 3}, {size, points.rows() * size});
}

py::array mesh_triangles(const MeshPtr& mesh) {
  const MeshTopology& topology = mesh->source.prepared.mesh.topology();
  if (topology.vertex_count() == topology.node_count())
    return rows_view(mesh, topology.triangles().front().data(), topology.triangle_count(), 3);
  std::vector<std::array<int, 3>> triangles = topology.triangles();
  for (auto& triangle : triangles)
    for (int& corner : triangle) corner = topology.node_of(corner);
  return array_of(std::move(triangles));
}

py::array triangle_faces(const MeshPtr& mesh) {
  const std::vector<int>& faces = mesh->source.prepared.face_of_triangle;
  return array_view(mesh, faces.data(), {static_cast<py::ssize_t>(faces.size())}, {sizeof(int)});
}

py::dict sets_of(const MeshObject& mesh) {
  py::dict sets;
  for (const MeshSet& set : mesh.source.file.sets())
    sets[py::str(set.name)] = py::dict("nodes"_a = array_of(std::vector<int>(set.nodes)),
                                       "faces"_a = array_of(std::vector<int>(set.faces)));
  return sets;
}

py::list rims_of(const MeshObject& mesh) {
  const MeshTopology& topology = mesh.source.prepared.mesh.topology();
  py::list rims;
  for (std::vector<int> loop : topology.boundary_loops()) {
    for (int& vertex : loop) vertex = topology.node_of(vertex);
    rims.append(array_of(std::move(loop)));
  }
  return rims;
}

void save_mesh(const MeshObject& mesh, const py::object& path, const py::object& given,
               const std::string& unit) {
  const std::string file = path_from(path);
  const Points points =
      given.is_none() ? mesh.source.file.shells().points : points_from(given, "points");
  const long nodes = mesh.source.file.shells().node_count();
  if (points.rows() != nodes)
    throw InputError("points: found " + std::to_string(points.rows()) +
                     " rows, expected one for each of the " + std::to_string(nodes) + " nodes");
  KernelCall()([&](const Progress&) {
    ShellMesh shells = mesh.source.file.shells();
    shells.points = points;
    write_mesh(file, shells, mesh.source.file.sets(), unit.empty() ? 0 : unit_in_metres(unit));
  });
}

double save_as_read(const MeshObject& mesh, const py::object& path, const py::object& given,
                    bool large_field_nodes) {
  const std::string file = path_from(path);
  const Points points = points_from(given, "points");
  MeshWriteOptions options;
  options.large_field_nodes = large_field_nodes;
  return KernelCall()(
      [&](const Progress&) { return mesh.source.file.write(file, points, options).largest; });
}

std::string mesh_repr(const MeshObject& mesh) {
  const ShellMesh& shells = mesh.source.file.shells();
  return "<batten.Mesh: " + std::to_string(shells.node_count()) + " nodes, " +
         std::to_string(shells.face_count()) + " faces>";
}

py::dict hole_dict(const py::object& points, const py::object& loop) {
  const Points p = points_from(points, "points");
  const std::vector<int> rim = indices_from(loop, "rim", static_cast<int>(p.rows()));
  const HoleMeasure hole = measure_hole(p, rim);
  const auto triple = [](const Vec3& v) { return py::make_tuple(v.x(), v.y(), v.z()); };
  return py::dict("centre"_a = triple(hole.centre), "axis"_a = triple(hole.axis),
                  "radius"_a = hole.radius, "roundness"_a = hole.roundness,
                  "flatness"_a = hole.flatness, "perimeter"_a = hole.perimeter,
                  "circular"_a = hole.circular);
}

}  // namespace

std::shared_ptr<MeshObject> mesh_of_arrays(const py::object& points, const py::object& triangles) {
  ShellMesh shells;
  shells.points = points_from(points, "points");
  const auto corners = triangles_from(triangles, "triangles");
  for (const std::array<int, 3>& triangle : corners) {
    for (const int corner : triangle)
      if (corner >= shells.node_count())
        throw InputError("triangles: found " + std::to_string(corner) + ", expected 0 to " +
                         std::to_string(shells.node_count() - 1));
    shells.add_face(triangle);
  }
  return KernelCall()([&](const Progress&) {
    PreparedMesh prepared = prepare(shells);
    return std::make_shared<MeshObject>(
        MeshObject{{MeshFile::from_shells(std::move(shells)), std::move(prepared)}, false});
  });
}

std::shared_ptr<const MeshObject> mesh_from(const py::object& given, const py::object& triangles) {
  if (py::isinstance<MeshObject>(given)) {
    if (!triangles.is_none())
      throw InputError("triangles: found some beside a Mesh, expected None");
    return given.cast<MeshPtr>();
  }
  if (triangles.is_none())
    throw InputError("mesh: found points without triangles, expected a Mesh, or both");
  return mesh_of_arrays(given, triangles);
}

void bind_meshes(py::module_& m) {
  py::class_<MeshObject, MeshPtr>(m, "Mesh", "A mesh of a file or of arrays. It does not change.")
      .def(py::init(&mesh_of_arrays), "points"_a, "triangles"_a,
           "A mesh of points n×3 and triangles m×3, from 0. Raises InputError, MeshError.")
      .def_property_readonly("points", &mesh_points, "Places of the nodes, n×3 float64. A view.")
      .def_property_readonly("triangles", &mesh_triangles,
                             "Corners of the triangles that faces are cut into, m×3 int32.")
      .def_property_readonly("triangle_faces", &triangle_faces,
                             "The face that each triangle is a part of, m int32. A view.")
      .def_property_readonly("sets", &sets_of, "Sets of the file, {name: {nodes, faces}}.")
      .def_property_readonly("rims", &rims_of,
                             "Loops of boundary nodes: the outline and the holes.")
      .def_property_readonly(
          "format", [](const MeshObject& mesh) { return mesh.source.file.format(); },
          "The file's format.")
      .def_property_readonly(
          "notes", [](const MeshObject& mesh) { return py::cast(mesh.source.prepared.notes); },
          "What was repaired or noticed, in sentences.")
      .def(
          "save", &save_mesh, "path"_a, "points"_a = py::none(), py::kw_only(), "unit"_a = "",
          R"(Writes a mesh file by its ending: .obj .off .ply .stl .vtp .vtu, and with `unit` .glb .3mf.

`points`: other places of the nodes, n×3. Raises InputError, FileError.)")
      .def("save_as_read", &save_as_read, "path"_a, "points"_a, py::kw_only(),
           "wide_nodes"_a = false,
           R"(Writes the file that was read with other coordinates n×3, all else in it unchanged.

Returns the largest rounding of a coordinate, model units. Raises InputError, FileError.)")
      .def("__repr__", &mesh_repr);
  m.def("read_mesh", &read_mesh, "path"_a,
        "A mesh file: OBJ, OFF, PLY, STL, VTP, VTU, Nastran, Abaqus, LS-DYNA, Radioss. Raises "
        "InputError.");
  m.def("measure_hole", &hole_dict, "points"_a, "rim"_a,
        "The circle nearest to a closed loop of points: centre, axis, radius, roundness, flatness. "
        "Lengths in "
        "the points' unit.");
}

}  // namespace batten::python
