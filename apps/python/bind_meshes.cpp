// SPDX-License-Identifier: MPL-2.0
// Binds meshes, deformers and mesh edits.

#include <algorithm>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <sstream>

#include "batten/apps/documents/edited_mesh.h"
#include "batten/apps/python/bindings.h"
#include "batten/apps/python/conversions.h"
#include "batten/apps/python/deformer_constraints.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/scene/deform_scene.h"
#include "batten/mesh/regions/feature_region_deformer.h"
#include "batten/scenes/mesh.h"
#include "batten/scenes/mesh_data.h"

namespace batten::python {

// Meshes.

namespace {

using namespace py::literals;

Mesh mesh_of_shells(ShellMesh shells, std::vector<MeshSet> sets = {}) {
  return KernelCall()([&](const Progress&) {
    return Mesh(std::make_shared<const detail::SharedMesh>(std::move(shells), std::move(sets)));
  });
}

Mesh mesh_of_arrays(const py::object& points, const py::object& faces) {
  ShellMesh shells;
  shells.points = points_from(points, "points");
  for (const std::vector<int>& face : faces_from(faces, "triangles")) shells.add_face(face);
  return mesh_of_shells(std::move(shells));
}

/// True for an object with points and cells, as those of meshio.
bool has_cells(const py::object& given) {
  return py::hasattr(given, "points") && py::hasattr(given, "cells");
}

/// Type and data of a block of cells, an object or a tuple; an empty type for anything else.
std::pair<std::string, py::object> type_and_data(py::handle block) {
  if (py::hasattr(block, "type") && py::hasattr(block, "data"))
    return {py::str(block.attr("type")), block.attr("data")};
  constexpr size_t both = 2;
  if (!py::isinstance<py::tuple>(block) || py::len(block) != both) return {};
  const auto pair = py::reinterpret_borrow<py::tuple>(block);
  return {py::str(pair[0]), pair[1]};
}

/// A mesh of the triangles and quads of a meshio.Mesh.
Mesh mesh_of_cells(const py::object& given) {
  ShellMesh shells;
  shells.points = points_from(given.attr("points"), "points");
  const std::string expected = ", expected cells of the types triangle and quad";
  const py::object cells = given.attr("cells");
  if (!py::isinstance<py::iterable>(cells))
    throw InputError("cells: found " + std::string(py::repr(cells)) + expected);
  for (const py::handle block : cells) {
    const auto [type, data] = type_and_data(block);
    if (type != "triangle" && type != "quad")
      throw InputError(
          "cells: found " +
          (type.empty() ? std::string(py::repr(block)) : "cells of the type '" + type + "'") +
          expected);
    for (const std::vector<int>& face : faces_from(data, "cells")) shells.add_face(face);
  }
  return mesh_of_shells(std::move(shells));
}

/// The given Mesh object, a mesh from points and faces, or one from an object with cells.
Mesh mesh_from(const py::object& given, const py::object& faces) {
  if (py::isinstance<Mesh>(given)) {
    if (!faces.is_none())
      throw InputError("triangles: found triangles together with a Mesh, expected None");
    return given.cast<Mesh>();
  }
  if (!faces.is_none()) return mesh_of_arrays(given, faces);
  if (has_cells(given)) return mesh_of_cells(given);
  throw InputError(
      "mesh: found points without triangles, expected points and triangles, a Mesh, or a mesh of "
      "meshio");
}

/// A view of the positions of nodes, which are the first vertices. `points` belongs to `owner`.
py::array nodes_view(std::shared_ptr<const void> owner, const Points& points, int node_count) {
  const auto size = static_cast<py::ssize_t>(sizeof(double));
  return array_view(std::move(owner), points.data(), {node_count, 3}, {size, points.rows() * size});
}

py::array mesh_points(const Mesh& mesh) {
  return nodes_view(mesh.shared_data(), mesh.points(), mesh.data().shells().node_count());
}

py::array mesh_triangles(const Mesh& mesh) {
  const auto& triangles = mesh.triangles();
  return rows_view(mesh.shared_data(), triangles.front().data(),
                   static_cast<py::ssize_t>(triangles.size()), 3);
}

py::array mesh_triangle_faces(const Mesh& mesh) {
  const std::vector<int>& faces = mesh.triangle_faces();
  return array_view(mesh.shared_data(), faces.data(), {static_cast<py::ssize_t>(faces.size())},
                    {sizeof(int)});
}

py::list mesh_faces(const Mesh& mesh) {
  py::list faces;
  for (const std::vector<int>& face : mesh.faces()) faces.append(py::tuple(py::cast(face)));
  return faces;
}

py::dict mesh_sets(const Mesh& mesh) {
  // A node set and a face set may have the same name.
  std::map<std::string, std::pair<std::vector<int>, std::vector<int>>> merged;
  std::vector<std::string> names;
  for (const MeshSet& set : mesh.sets()) {
    if (!merged.count(set.name)) names.push_back(set.name);
    auto& [nodes, faces] = merged[set.name];
    if (!set.nodes.empty()) nodes = set.nodes;
    if (!set.faces.empty()) faces = set.faces;
  }
  py::dict sets;
  for (const std::string& name : names) {
    auto& [nodes, faces] = merged.at(name);
    sets[py::str(name)] = py::dict("nodes"_a = array_of(nodes), "faces"_a = array_of(faces));
  }
  return sets;
}

py::list mesh_boundary_loops(const Mesh& mesh) {
  py::list loops;
  for (std::vector<int>& loop : mesh.boundary_loops()) loops.append(array_of(std::move(loop)));
  return loops;
}

void save_mesh(const Mesh& mesh, const py::object& path, const py::object& given,
               const std::string& unit) {
  const std::string file = path_from(path);
  std::optional<Points> points;
  if (!given.is_none()) points = points_from(given, "points");
  KernelCall()([&](const Progress&) { mesh.save(file, points ? *points : mesh.points(), unit); });
}

double save_as_read(const Mesh& mesh, const py::object& path, const py::object& given,
                    bool large_field) {
  const std::string file = path_from(path);
  const Points points = points_from(given, "points");
  return KernelCall()(
      [&](const Progress&) { return mesh.save_as_read(file, points, large_field); });
}

std::string mesh_repr(const Mesh& mesh) {
  const ShellMesh& shells = mesh.data().shells();
  return "<batten.Mesh: " + std::to_string(shells.node_count()) + " nodes, " +
         std::to_string(shells.face_count()) + " faces>";
}

/// The arrays that define a mesh, for pickle: points, nodes of all faces, number of nodes of each
/// face, 1 for each second-order face, sets.
py::tuple mesh_state(const Mesh& mesh) {
  const ShellMesh& shells = mesh.data().shells();
  std::vector<int> nodes, sizes, second_order;
  for (int f = 0; f < shells.face_count(); ++f) {
    const auto face = shells.face(f);
    nodes.insert(nodes.end(), face.begin(), face.end());
    sizes.push_back(static_cast<int>(face.size()));
    second_order.push_back(shells.second_order(f));
  }
  py::list sets;
  for (const MeshSet& set : mesh.sets())
    sets.append(
        py::make_tuple(set.name, set.title, array_of(set.nodes), array_of(set.faces), set.colour));
  return py::make_tuple(mesh_points(mesh), array_of(std::move(nodes)), array_of(std::move(sizes)),
                        array_of(std::move(second_order)), sets);
}

Mesh mesh_of_state(const py::tuple& state) {
  constexpr int any = std::numeric_limits<int>::max();
  ShellMesh shells;
  shells.points = points_from(state[0], "points");
  const std::vector<int> nodes = indices_from(state[1], "faces", shells.node_count());
  const std::vector<int> sizes = indices_from(state[2], "faces", any);
  const std::vector<int> second_order = indices_from(state[3], "faces", any);
  size_t start = 0;
  for (size_t f = 0; f < sizes.size(); ++f) {
    const auto size = static_cast<size_t>(sizes[f]);
    if (start + size > nodes.size() || f >= second_order.size())
      throw InputError("found an incomplete pickled mesh");
    shells.add_face(std::span(nodes).subspan(start, size), second_order[f] != 0);
    start += size;
  }
  std::vector<MeshSet> sets;
  for (const py::handle item : state[4]) {
    const auto set = item.cast<py::tuple>();
    sets.push_back({set[0].cast<std::string>(), set[1].cast<std::string>(),
                    indices_from(set[2], "nodes", shells.node_count()),
                    indices_from(set[3], "faces", shells.face_count()),
                    set[4].cast<std::string>()});
  }
  return mesh_of_shells(std::move(shells), std::move(sets));
}

py::dict hole_dict(const py::object& points, const py::object& given) {
  const Points p = points_from(points, "points");
  const std::vector<int> loop = indices_from(given, "loop", static_cast<int>(p.rows()));
  const HoleMeasure hole = measure_hole(p, loop);
  const auto triple = [](const Vec3& v) { return py::make_tuple(v.x(), v.y(), v.z()); };
  return py::dict("centre"_a = triple(hole.centre), "axis"_a = triple(hole.axis),
                  "radius"_a = hole.radius, "roundness"_a = hole.roundness,
                  "flatness"_a = hole.flatness, "perimeter"_a = hole.perimeter,
                  "circular"_a = hole.circular);
}

std::string loop_repr(const std::string& type, const std::string& name, const HoleMeasure& loop) {
  return "<batten." + type + " '" + name + "': radius " + format_number(loop.radius) + " at " +
         format_point(loop.centre) + ">";
}

const HoleMeasure& measure_of(const Hole& hole) { return hole; }
const HoleMeasure& measure_of(const DetectedFeature& feature) { return feature.measure; }

/// Binds what holes and features have in common: name, vertices, loop and the measure of the loop.
template <class Feature>
void bind_loop(py::class_<Feature>& c) {
  const auto number = [&](const char* name, double HoleMeasure::*member, const char* words) {
    c.def_property_readonly(
        name, [member](const Feature& one) { return measure_of(one).*member; }, words);
  };
  c.def_property_readonly(
       "vertices", [](const Feature& one) { return array_of(one.vertices); },
       "All vertices, ascending, for `features` of a Deformer.")
      .def_property_readonly(
          "loop", [](const Feature& one) { return array_of(one.loop); },
          "Vertices of the loop in order, for measure_hole().")
      .def_property_readonly(
          "centre", [](const Feature& one) { return array_of(measure_of(one).centre); },
          "Centre of the best-fit circle of the loop, array of 3.")
      .def_property_readonly(
          "axis", [](const Feature& one) { return array_of(measure_of(one).axis); },
          "Unit normal of the plane of the circle, array of 3.")
      .def_property_readonly(
          "circular", [](const Feature& one) { return measure_of(one).circular; },
          "Whether the loop is a circle (within 2 %).");
  number("radius", &HoleMeasure::radius, "Radius of the circle.");
  number("equivalent_radius", &HoleMeasure::equivalent_radius,
         "Radius of the circle with the same area as the loop.");
  number("roundness", &HoleMeasure::roundness,
         "Largest distance of a vertex of the loop from the circle, in its plane.");
  number("flatness", &HoleMeasure::flatness,
         "Largest distance of a vertex of the loop from the plane.");
  number("perimeter", &HoleMeasure::perimeter, "Length of the loop.");
}

void bind_holes(py::module_& m) {
  py::class_<Hole> hole(m, "Hole",
                        R"(A hole of a mesh: a boundary loop, its best-fit circle, its flange.

    >>> batten.read_mesh("examples/10-plate-with-holes/plate.obj").holes()[2]
    <batten.Hole 'hole-3': radius 42 at (150, 150, 0)>
)");
  hole.def_readonly("name", &Hole::name, "\"hole-1\", \"hole-2\" and so on, as in deform scenes.");
  bind_loop(hole);
  hole.def("__repr__", [](const Hole& one) { return loop_repr("Hole", one.name, one); });
  py::class_<DetectedFeature> feature(
      m, "DetectedFeature",
      R"(A suggested feature: a hole with its flange, or the area inside a closed crease.

    >>> plate = batten.read_mesh("examples/10-plate-with-holes/plate.obj")
    >>> plate.suggested_features()[2]
    <batten.DetectedFeature 'hole-3': radius 42 at (150, 150, 0)>
)");
  feature
      .def_readonly("name", &DetectedFeature::name,
                    "\"hole-1\", \"crease-1\" and so on, as in deform scenes.")
      .def_property_readonly(
          "kind",
          [](const DetectedFeature& one) {
            return one.kind == DetectedFeature::Kind::Hole ? "hole" : "crease";
          },
          "\"hole\": `loop` is its boundary; \"crease\": `loop` is the crease.")
      .def_readonly("flange_ends_at_crease", &DetectedFeature::flange_ends_at_crease,
                    "Whether the flange of a hole ends at a closed crease; True for a crease.");
  bind_loop(feature);
  feature.def("__repr__", [](const DetectedFeature& one) {
    return loop_repr("DetectedFeature", one.name, one.measure);
  });
}

std::vector<DetectedFeature> suggested_features(const Mesh& mesh, double crease_angle,
                                                int flange_rings, double flange_width,
                                                bool outer_loops, bool nested) {
  FeatureDetectionOptions options;
  options.crease_degrees = crease_angle;
  options.flange_rings = flange_rings;
  options.flange_width = flange_width;
  options.outer_loops = outer_loops;
  options.nested = nested;
  return KernelCall()([&](const Progress&) { return mesh.suggested_features(options); });
}

void bind_mesh_features(py::class_<Mesh>& c) {
  const FeatureDetectionOptions defaults;
  c.def(
       "holes",
       [](const Mesh& mesh, double flange_width) {
         return KernelCall()([&](const Progress&) { return mesh.holes(flange_width); });
       },
       "flange_width"_a = 0.0,
       R"(The holes, a list of Hole: all boundary loops except the longest one of each part, its outline.

The flange around a hole ends at a crease; without a crease, it has the width `flange_width` (model
units, 0: one ring of faces).)")
      .def(
          "suggested_features", &suggested_features, py::kw_only(),
          "crease_angle"_a = defaults.crease_degrees, "flange_rings"_a = defaults.flange_rings,
          "flange_width"_a = defaults.flange_width, "outer_loops"_a = defaults.outer_loops,
          "nested"_a = defaults.nested,
          R"(The features that deform scenes propose, a list of DetectedFeature, for `features` of a Deformer.

Holes with their flanges, and areas inside closed creases. Options as `[proposals]` in docs/deform.md:
`crease_angle` in degrees, above 0 and below 180; `flange_width` in model units, 0: one ring of faces.
Raises InputError.)")
      .def(
          "saliency",
          [](const Mesh& mesh) {
            const VecX values = KernelCall()([&](const Progress&) { return mesh.saliency(); });
            return array_of(std::vector<double>(values.begin(), values.end()));
          },
          R"(Mesh saliency of every vertex, n float64 from 0 to 1: how much it stands out from its surroundings.

Costs 10 s on one core for 100,000 vertices. Reference: Lee, Varshney, Jacobs 2005.)")
      .def(
          "crease_path",
          [](const Mesh& mesh, const py::object& through, bool closed) {
            const std::vector<Vec3> points = rows_of(points_from(through, "through"));
            return array_of(
                KernelCall()([&](const Progress&) { return mesh.crease_path(points, closed); }));
          },
          "through"_a, py::kw_only(), "closed"_a = false,
          R"(The shortest path along edges through the vertices nearest to the points n×3, following creases.

Indices in order, for a Chain. `closed`: returns to its first vertex, which is not repeated. Raises
InputError if the points lie on parts that are not connected.)");
}

void bind_mesh_output(py::class_<Mesh>& c) {
  c.def(
       "with_points",
       [](const Mesh& mesh, const py::object& given) {
         const Points points = points_from(given, "points");
         return KernelCall()([&](const Progress&) { return mesh.with_points(points); });
       },
       "points"_a, "The same faces and sets at other positions n×3, as a mesh without a file.")
      .def(
          "save", &save_mesh, "path"_a, "points"_a = py::none(), py::kw_only(), "unit"_a = "",
          R"(Writes a mesh file; the extension selects the format: .obj .off .ply .stl .vtp .vtu, and with `unit` .glb .3mf.

`points`: other node positions, n×3. Raises InputError, FileError.)")
      .def("save_as_read", &save_as_read, "path"_a, "points"_a, py::kw_only(),
           "large_field"_a = false,
           R"(Writes the input file with new node positions n×3 and everything else unchanged.

`large_field`: write the moved nodes of Nastran decks in large-field format. Returns the largest rounding
error of a coordinate, model units. Raises InputError, FileError.)")
      .def("__repr__", &mesh_repr)
      .def("__copy__", [](const py::object& self) { return self; })
      .def(
          "__deepcopy__", [](const py::object& self, const py::dict&) { return self; }, "memo"_a)
      .def(py::pickle(&mesh_state, &mesh_of_state));
}

}  // namespace

void bind_meshes(py::module_& m) {
  bind_holes(m);
  py::class_<Mesh> c(
      m, "Mesh",
      R"(A mesh of triangles, quads and polygons, from a file or from arrays. Immutable.

Meshes can be copied and pickled; an unpickled mesh has no file for save_as_read().

    >>> square = batten.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    >>> square.triangles.shape, square.boundary_loops[0].tolist()
    ((2, 3), [0, 1, 2, 3])
)");
  c.def(
       py::init(&mesh_from), "points"_a, "triangles"_a = py::none(),
       R"(A mesh of points n×3 and faces (indices from 0): triangles m×3, quads m×4, or a list of index lists.

Or of a meshio.Mesh with triangles and quads. Raises InputError.)")
      .def_property_readonly("points", &mesh_points, "Node positions, n×3 float64. A view.")
      .def_property_readonly("faces", &mesh_faces,
                             "Node indices of each face in order around it, as tuples.")
      .def_property_readonly(
          "triangles", &mesh_triangles,
          "Node indices of the triangles into which faces are split, m×3 int32. A view.")
      .def_property_readonly("triangle_faces", &mesh_triangle_faces,
                             "Index of the face that contains each triangle, m int32. A view.")
      .def_property_readonly(
          "corner_normals",
          [](const Mesh& mesh) {
            const Points& normals = mesh.corner_normals();
            const auto size = static_cast<py::ssize_t>(sizeof(double));
            const auto triangles = static_cast<py::ssize_t>(normals.rows() / 3);
            return array_view(mesh.shared_data(), normals.data(), {triangles, 3, 3},
                              {3 * size, size, 3 * triangles * size});
          },
          "Unit normals of the surface at the corners of the triangles, m×3×3 float64, for the "
          "mesh "
          "of a model; otherwise empty. A view.")
      .def_property_readonly("sets", &mesh_sets, "Sets of the file, {name: {nodes, faces}}.")
      .def_property_readonly("boundary_loops", &mesh_boundary_loops,
                             "Closed loops of boundary nodes: the outline and the holes.")
      .def_property_readonly("format", &Mesh::format,
                             "The file's format; empty for a mesh from arrays.")
      .def_property_readonly("notes", &Mesh::notes, "Repairs and remarks, as sentences.")
      .def(
          "vertices_in",
          [](const Mesh& mesh, const py::object& low, const py::object& high) {
            return array_of(mesh.vertices_in(vector_from(low, "low"), vector_from(high, "high")));
          },
          "low"_a, "high"_a, "The vertices in an axis-aligned box from `low` to `high`, ascending.")
      .def_property_readonly(
          "bounds",
          [](const Mesh& mesh) {
            const Box3 box = mesh.bounds();
            return py::make_tuple(array_of(Vec3(box.min())), array_of(Vec3(box.max())));
          },
          "Lower and upper corner of the bounding box, two arrays of 3.");
  bind_mesh_features(c);
  bind_mesh_output(c);
  m.def(
      "read_mesh",
      [](const py::object& path) {
        const std::string file = path_from(path);
        return KernelCall()([&](const Progress&) { return batten::read_mesh(file); });
      },
      "path"_a,
      R"(Reads a mesh file: OBJ, OFF, PLY, STL, VTP, VTU, Nastran, Abaqus, LS-DYNA, Radioss.

Raises InputError.

    >>> batten.read_mesh("examples/10-plate-with-holes/plate.obj")
    <batten.Mesh: 2784 nodes, 2548 faces>
)");
  m.def(
      "measure_hole", &hole_dict, "points"_a, "loop"_a,
      R"(The best-fit circle of a closed loop of points (indices), a dict: centre, axis, radius, roundness, flatness.

Lengths in the unit of the points.

    >>> t = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    >>> round(batten.measure_hole(np.c_[5 * np.cos(t), 5 * np.sin(t), 0 * t], range(12))["radius"], 9)
    5.0
)");
}

// Deformers that preserve the shape of features.

namespace {

using namespace py::literals;

Move new_move(const py::object& translate, const py::object& axis, double angle, double scale,
              const py::object& about) {
  Move move{vector_from(translate, "translate"), vector_from(axis, "axis"), angle, scale, {}};
  if (!about.is_none()) move.about = vector_from(about, "about");
  detail::transform_of(move);  // throws if the axis has no direction
  return move;
}

py::object about_of(const Move& move) {
  return move.about ? py::object(array_of(*move.about)) : py::object(py::none());
}

/// "batten.Move(translate=(0.0, 0.0, 1.0))": all arguments that differ from their defaults.
std::string move_repr(const Move& move) {
  const auto triple = [](const Vec3& v) {
    return std::string(py::repr(py::make_tuple(v.x(), v.y(), v.z())));
  };
  const auto number = [](double x) { return std::string(py::repr(py::float_(x))); };
  const Move none;
  std::string text;
  const auto add = [&](bool given, const std::string& name, const std::string& value) {
    if (given) text += (text.empty() ? "" : ", ") + name + "=" + value;
  };
  add(move.translate != none.translate, "translate", triple(move.translate));
  add(move.axis != none.axis, "axis", triple(move.axis));
  add(move.angle != none.angle, "angle", number(move.angle));
  add(move.scale != none.scale, "scale", number(move.scale));
  if (move.about) add(true, "about", triple(*move.about));
  return "batten.Move(" + text + ")";
}

/// Groups of vertices from a dict {name: vertices}, or from holes and detected features.
template <class Named>
std::vector<Named> named_from(const py::object& given, const std::string& what, int count) {
  const auto group = [&](const std::string& name, py::handle vertices) {
    return Named{name, indices_from(vertices, what + " '" + name + "'", count)};
  };
  std::vector<Named> all;
  if (py::isinstance<py::dict>(given)) {
    for (const auto& [name, vertices] : given.cast<py::dict>())
      all.push_back(group(py::str(name), vertices));
    return all;
  }
  const std::string expected = ", expected a dict {name: vertices}, or a list of holes or features";
  if (!py::isinstance<py::iterable>(given) || py::isinstance<py::str>(given))
    throw InputError(what + "s: found " + std::string(py::repr(given)) + expected);
  for (const py::handle one : given) {
    if (!py::isinstance<Hole>(one) && !py::isinstance<DetectedFeature>(one))
      throw InputError(what + "s: found " + std::string(py::repr(one)) + expected);
    all.push_back(group(py::str(one.attr("name")), one.attr("vertices")));
  }
  return all;
}

/// The inverse of named_from().
py::dict groups_dict(const std::vector<VertexGroup>& groups) {
  py::dict result;
  for (const VertexGroup& group : groups)
    result[py::str(group.name)] = array_of(std::vector<int>(group.vertices));
  return result;
}

std::map<std::string, Move> moves_from(const py::dict& given) {
  std::map<std::string, Move> moves;
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key);
    if (!py::isinstance<Move>(value))
      throw InputError("moves: found " + std::string(py::repr(value)) + " for '" + name +
                       "', expected a batten.Move");
    moves[name] = value.cast<Move>();
  }
  return moves;
}

std::map<std::string, double> scales_from(const py::dict& given) {
  std::map<std::string, double> scales;
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key);
    scales[name] = numbers_from(py::make_tuple(value), "scales '" + name + "'").front();
  }
  return scales;
}

/// Points by name, for the argument `what`.
std::map<std::string, Vec3> named_points_from(const py::dict& given, const std::string& what) {
  std::map<std::string, Vec3> points;
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key);
    points[name] = vector_from(value, what + " '" + name + "'");
  }
  return points;
}

/// Choices of an argument, by name.
template <class Choice>
using Choices = std::vector<std::pair<std::string, Choice>>;

const Choices<RotationMode> kRotationModes{{"harmonic", RotationMode::Harmonic},
                                           {"estimated", RotationMode::Estimated},
                                           {"dual", RotationMode::Dual},
                                           {"nonlinear", RotationMode::Nonlinear}};
const Choices<DeformProblem::Weighting> kWeightings{{"area", DeformProblem::Weighting::Area},
                                                    {"uniform", DeformProblem::Weighting::Uniform}};

template <class Choice>
Choice choice_from(const std::string& given, const std::string& what,
                   const Choices<Choice>& choices) {
  std::vector<std::string> names;
  for (const auto& [name, choice] : choices) {
    if (name == given) return choice;
    names.push_back(name);
  }
  throw InputError(what + ": found '" + given + "', expected " + expected_one_of(given, names));
}

template <class Choice>
std::string name_of(Choice wanted, const Choices<Choice>& choices) {
  for (const auto& [name, choice] : choices)
    if (choice == wanted) return name;
  return "";
}

using DeformerPtr = std::shared_ptr<Deformer>;

DeformerPtr new_deformer(const py::object& given, const py::object& triangles,
                         const py::object& fixed, const py::object& handles,
                         const py::object& features, const py::object& keep_orientation,
                         const py::object& region, const py::dict& constraints,
                         const py::dict& chains, const py::dict& linear_constraints,
                         const std::string& rotation_mode, const std::string& weighting) {
  const Mesh mesh = mesh_from(given, triangles);
  const int count = mesh.data().shells().node_count();
  DeformerSettings settings;
  settings.fixed = indices_from(fixed, "fixed", count);
  settings.handles = named_from<VertexGroup>(handles, "handle", count);
  settings.features = named_from<VertexGroup>(features, "feature", count);
  settings.keep_orientation = named_from<VertexGroup>(keep_orientation, "feature", count);
  if (!region.is_none())
    settings.region_of_interest = indices_from(region, "region_of_interest", count);
  settings.constraints = constraints_from(constraints, count);
  settings.chains = chains_from(chains, count);
  settings.linear_constraints = linear_constraints_from(linear_constraints, count);
  settings.rotation_mode = choice_from(rotation_mode, "rotation_mode", kRotationModes);
  settings.weighting = choice_from(weighting, "weighting", kWeightings);
  return KernelCall()([&](const Progress&) { return std::make_shared<Deformer>(mesh, settings); });
}

py::array deform(Deformer& deformer, const py::dict& given, const py::dict& factors, bool correct,
                 const py::dict& given_origins, const py::dict& given_targets) {
  const auto moves = moves_from(given);
  const auto scales = scales_from(factors);
  const auto origins = named_points_from(given_origins, "origins"),
             targets = named_points_from(given_targets, "targets");
  return array_of(KernelCall()(
      [&](const Progress&) { return deformer.deform(moves, scales, correct, origins, targets); }));
}

/// Rates of the handles: {handle: {"translate": vector, "rotation": vector, "scale": number}}.
std::map<std::string, DeformerRates::Move> move_rates_from(const py::dict& given) {
  std::map<std::string, DeformerRates::Move> rates;
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key), what = "moves '" + name + "'";
    if (!py::isinstance<py::dict>(value))
      throw InputError(what + ": found " + std::string(py::repr(value)) +
                       ", expected a dict with translate, rotation, scale");
    DeformerRates::Move& rate = rates[name];
    for (const auto& [word, number] : py::cast<py::dict>(value)) {
      const std::string component = py::str(word);
      if (component == "translate")
        rate.translate = vector_from(number, what + " translate");
      else if (component == "rotation")
        rate.rotation = vector_from(number, what + " rotation");
      else if (component == "scale")
        rate.scale = numbers_from(py::make_tuple(number), what + " scale").front();
      else
        throw InputError(what + ": found '" + component + "', expected " +
                         expected_one_of(component, {"translate", "rotation", "scale"}));
    }
  }
  return rates;
}

py::array deformer_jvp(Deformer& deformer, const py::dict& moves, const py::dict& scales,
                       const py::dict& origins, const py::dict& targets) {
  const DeformerRates rates{move_rates_from(moves), scales_from(scales),
                            named_points_from(origins, "origins"),
                            named_points_from(targets, "targets")};
  return array_of(KernelCall()([&](const Progress&) { return deformer.jvp(rates); }));
}

py::dict deformer_vjp(Deformer& deformer, const py::object& given) {
  const Points weights = points_from(given, "weights");
  const DeformerRates gradient =
      KernelCall()([&](const Progress&) { return deformer.vjp(weights); });
  const auto vectors = [](const std::map<std::string, Vec3>& all) {
    py::dict dict;
    for (const auto& [name, vector] : all) dict[py::str(name)] = array_of(vector);
    return dict;
  };
  py::dict moves;
  for (const auto& [name, move] : gradient.moves)
    moves[py::str(name)] = py::dict("translate"_a = array_of(move.translate),
                                    "rotation"_a = array_of(move.rotation), "scale"_a = move.scale);
  return py::dict("moves"_a = moves, "scales"_a = gradient.scales,
                  "origins"_a = vectors(gradient.origins), "targets"_a = vectors(gradient.targets));
}

py::array deformer_positions(const DeformerPtr& of) {
  return nodes_view(of, of->state().positions(), of->mesh().data().shells().node_count());
}

/// The mesh and the settings of a deformer, for pickle: the arguments of new_deformer().
py::tuple deformer_state(const Deformer& of) {
  const DeformerSettings& s = of.settings();
  py::object region = py::none();
  if (s.region_of_interest) region = array_of(std::vector<int>(*s.region_of_interest));
  return py::make_tuple(of.mesh(), array_of(std::vector<int>(s.fixed)), groups_dict(s.handles),
                        groups_dict(s.features), groups_dict(s.keep_orientation), region,
                        dict_of(s.constraints), dict_of(s.chains), dict_of(s.linear_constraints),
                        name_of(s.rotation_mode, kRotationModes),
                        name_of(s.weighting, kWeightings));
}

DeformerPtr deformer_of_state(const py::tuple& state) {
  return new_deformer(state[0], py::none(), state[1], state[2], state[3], state[4], state[5],
                      state[6], state[7], state[8], state[9].cast<std::string>(),
                      state[10].cast<std::string>());
}

/// A deformer that preserves feature regions in the result of any other deformer.
struct RegionsObject {
  Mesh mesh;
  std::vector<Handle> handles = {};
  std::unique_ptr<FeatureRegionDeformer> deformer = nullptr;
  CallSerializer serialize = {};
};

std::vector<FeatureRegion> feature_regions_from(const py::dict& given, int triangles) {
  std::vector<FeatureRegion> regions;
  for (const auto& [name, faces] : given) {
    FeatureRegion region;
    region.name = py::str(name);
    region.faces = indices_from(faces, "region '" + region.name + "'", triangles);
    if (region.faces.empty())
      throw InputError("region '" + region.name + "': found no triangles, expected one or more");
    regions.push_back(std::move(region));
  }
  return regions;
}

std::unique_ptr<RegionsObject> new_regions(const py::object& given, const py::object& triangles,
                                           const py::dict& regions, const py::object& fixed,
                                           const py::object& handles, bool soft, double weight) {
  const Mesh whole = mesh_from(given, triangles);
  const TriangleMesh& mesh = whole.data().mesh();
  const int count = mesh.topology().vertex_count();
  const auto still = indices_from(fixed, "fixed", count);
  std::unique_ptr<RegionsObject> result(new RegionsObject{whole});
  result->handles = named_from<Handle>(handles, "handle", count);
  const auto kept = feature_regions_from(regions, mesh.triangle_count());
  FeatureRegionOptions options;
  options.kind = soft ? FeatureRegionOptions::Kind::Soft : FeatureRegionOptions::Kind::Hard;
  if (soft) options.weight = weight;
  result->deformer = KernelCall()([&](const Progress&) {
    return std::make_unique<FeatureRegionDeformer>(mesh, kept, still, result->handles, options);
  });
  return result;
}

py::array keep_regions(RegionsObject& of, const py::object& estimate, const py::dict& moves) {
  const Points shape = points_from(estimate, "estimate");
  const auto handles = detail::transforms_of(moves_from(moves), of.handles, of.mesh.data().mesh());
  return array_of(KernelCall()([&](const Progress&) {
    return of.serialize([&] { return Points(of.deformer->deform(shape, handles)); });
  }));
}

void bind_deformer_results(py::class_<Deformer, DeformerPtr>& c) {
  c.def_property_readonly("positions", &deformer_positions,
                          "Positions of the last deform(), n×3: a view, which the next call "
                          "overwrites.")
      .def_property_readonly(
          "residual",
          [](const Deformer& of) {
            return KernelCall()([&](const Progress&) { return of.residual(); });
          },
          "Largest violation of the exact constraints, relative to the size.")
      .def_property_readonly(
          "report",
          [](const Deformer& of) {
            return KernelCall()([&](const Progress&) { return of.report(); });
          },
          "Convergence of the last deform(), a DeformerReport.")
      .def_property_readonly("unknowns", &Deformer::unknowns,
                             "Number of unknowns per coordinate, after elimination of the "
                             "constraints.")
      .def_property_readonly(
          "notes", &Deformer::notes,
          "Remarks about parts of the mesh without handles or fixed vertices, as sentences.")
      .def_property_readonly("mesh", &Deformer::mesh, "The Mesh that is deformed.")
      .def(py::pickle(&deformer_state, &deformer_of_state));
}

void bind_deformer(py::module_& m) {
  py::class_<DeformerReport>(m, "DeformerReport", R"(Convergence of Deformer.deform().

    >>> plate = batten.read_mesh("examples/10-plate-with-holes/plate.obj")
    >>> x = plate.points[:, 0]
    >>> deformer = batten.Deformer(plate, fixed=x == 0, handles={"end": x == 300}, rotation_mode="nonlinear")
    >>> bent = deformer.deform({"end": batten.Move(translate=[-40, 0, 110])})
    >>> deformer.report.converged
    True
)")
      .def_readonly("iterations", &DeformerReport::iterations,
                    "Iterations of the estimate of rotations; 0: the rotation mode needs none.")
      .def_readonly("converged", &DeformerReport::converged,
                    "False: the rotations still changed after the last iteration.")
      .def_readonly("last_correction", &DeformerReport::last_correction,
                    "Largest change of a coordinate by the last correction of rounding errors, "
                    "relative to the size of the mesh; 0: no correction.");
  py::class_<Deformer, DeformerPtr> c(
      m, "Deformer",
      R"(Morphs a mesh whose form features keep their shape exactly; factorized once.

min ½|A p - b|² subject to C p = d: mean-curvature vectors are preserved up to a smooth field of
rotations; fixed vertices, handles, features and constraints are exact. A copied or unpickled deformer
is computed again from the mesh and the settings, and starts without an edit.
Reference: Masuda, Yoshioka, Furukawa 2006 (docs/theory/deformers.md).

    >>> plate = batten.read_mesh("examples/10-plate-with-holes/plate.obj")
    >>> x = plate.points[:, 0]
    >>> deformer = batten.Deformer(plate, fixed=x == 0, handles={"end": x == 300}, features=plate.holes())
    >>> bent = deformer.deform({"end": batten.Move(translate=[-40, 0, 110], axis=[0, -1, 0], angle=75)})
    >>> round(batten.measure_hole(bent, plate.holes()[2].loop)["radius"], 9)
    42.0
)");
  c.def(
       py::init(&new_deformer), "mesh"_a, "triangles"_a = py::none(), py::kw_only(),
       "fixed"_a = py::tuple(), "handles"_a = py::dict(), "features"_a = py::dict(),
       "keep_orientation"_a = py::dict(), "region_of_interest"_a = py::none(),
       "constraints"_a = py::dict(), "chains"_a = py::dict(), "linear_constraints"_a = py::dict(),
       "rotation_mode"_a = "harmonic", "weighting"_a = "area",
       R"(`mesh`: a Mesh, or points n×3 with `triangles` (faces, as for a Mesh). Vertices are indices from 0 or masks of n.

`handles`, `features` (rotate with the sheet), `keep_orientation` (features without rotation): {name:
vertices}, or a list of Hole or DetectedFeature. `region_of_interest`: vertices that may move (None: all).
`constraints`: {name: OnPlane or OnLine}; `chains`: {name: Chain}; `linear_constraints`: {name:
LinearConstraint}. `rotation_mode`: "harmonic" (linear), "estimated", "dual" or "nonlinear" (ARAP): how
features and curvature rotate if no handle prescribes it (docs/deform.md). `weighting`: "area" or
"uniform". Raises InputError, NoSolutionError.)")
      .def("deform", &deform, "moves"_a, py::kw_only(), "scales"_a = py::dict(),
           "correct"_a = false, "origins"_a = py::dict(), "targets"_a = py::dict(),
           R"(Positions of all vertices after an edit of the original mesh, n×3 float64.

`moves`: {handle: Move}; `scales`: {feature: factor}; `origins`: {constraint: another point of its plane or
line}; `targets`: {linear constraint: another value}. With rotation_mode "harmonic", costs a pair of
triangular solves; `correct`: one more, to reduce rounding errors. The other modes iterate and always
correct (`report`). Raises InputError, ConflictError; positions are then unchanged.)")
      .def(
          "jvp", &deformer_jvp, "moves"_a = py::dict(), py::kw_only(), "scales"_a = py::dict(),
          "origins"_a = py::dict(), "targets"_a = py::dict(),
          R"(Directional derivative of the positions at the last deform(), n×3: Jacobian times vector.

`moves`: {handle: {"translate": rate (3), "rotation": rate of the rotation vector in degrees (3), "scale":
rate}}; `scales`, `origins`, `targets`: rates by name, as in deform(). Exact with rotation_mode "harmonic", at the
cost of one solve; otherwise central differences of order four, exact to about 1e-9. Raises InputError,
ConflictError.)")
      .def("vjp", &deformer_vjp, "weights"_a,
           R"(Gradient of (weights * positions).sum() at the last deform(): vector times Jacobian.

`weights`: n×3, the derivative of an objective with respect to the positions. Returns a dict of the
arguments of jvp(): "moves", "scales", "origins", "targets". Exact with rotation_mode "harmonic", at the cost of one
solve; otherwise one jvp() for each number in it. Raises InputError, ConflictError.)");
  bind_deformer_results(c);
}

void bind_moves(py::module_& m) {
  py::class_<Move>(m, "Move", R"(Motion of a handle: p = about + s R (p⁰ - about) + translate.

    >>> batten.Move(translate=[0, 0, 10], angle=30)
    batten.Move(translate=(0.0, 0.0, 10.0), angle=30.0)
)")
      .def(py::init(&new_move), py::kw_only(), "translate"_a = py::make_tuple(0., 0., 0.),
           "axis"_a = py::make_tuple(0., 0., 1.), "angle"_a = 0.0, "scale"_a = 1.0,
           "about"_a = py::none(),
           "`translate` and `about` in model units (about = None: the mean of the handle's "
           "vertices); rotation by `angle` degrees about `axis`; `scale` above 0.")
      .def_property_readonly(
          "translate", [](const Move& move) { return array_of(move.translate); },
          "Array of 3, model units.")
      .def_property_readonly(
          "axis", [](const Move& move) { return array_of(move.axis); }, "Array of 3.")
      .def_readonly("angle", &Move::angle, "Degrees.")
      .def_readonly("scale", &Move::scale, "Factor above 0.")
      .def_property_readonly("about", &about_of, "Array of 3, model units, or None.")
      .def("__repr__", &move_repr)
      .def(py::pickle(
          [](const Move& move) {
            return py::make_tuple(array_of(move.translate), array_of(move.axis), move.angle,
                                  move.scale, about_of(move));
          },
          [](const py::tuple& state) {
            return new_move(state[0], state[1], state[2].cast<double>(), state[3].cast<double>(),
                            state[4]);
          }));
}

}  // namespace

void bind_deformers(py::module_& m) {
  bind_moves(m);
  bind_constraints(m);
  bind_deformer(m);
  py::class_<RegionsObject>(
      m, "FeatureRegions",
      R"(Preserves regions of a mesh in the result of any deformer; factorized once.

Reference: Hu, Song, Cao 2012, Mesh editing with feature region preservation (docs/theory/deformers.md).

    >>> plate = batten.read_mesh("examples/10-plate-with-holes/plate.obj")
    >>> x, hole = plate.points[:, 0], plate.holes()[2]
    >>> kept = {"fixed": x == 0, "handles": {"end": x == 300}}
    >>> moves = {"end": batten.Move(translate=[-40, 0, 110], axis=[0, -1, 0], angle=75)}
    >>> estimate = batten.Deformer(plate, **kept).deform(moves)
    >>> inside = np.isin(plate.triangles, hole.vertices).all(1)
    >>> regions = batten.FeatureRegions(plate, regions={"hole": inside}, **kept)
    >>> round(batten.measure_hole(regions.deform(estimate, moves), hole.loop)["radius"], 9)
    42.0
)")
      .def(
          py::init(&new_regions), "mesh"_a, "triangles"_a = py::none(), py::kw_only(), "regions"_a,
          "fixed"_a = py::tuple(), "handles"_a = py::dict(), "soft"_a = false, "weight"_a = 2e7,
          R"(`regions`: {name: triangles}, indices or masks of m; `fixed`, `handles`: as for a Deformer.

Regions are exactly rigid, or with `soft` approximately, by a penalty `weight`. Raises InputError,
NoSolutionError.)")
      .def(
          "deform", &keep_regions, "estimate"_a, "moves"_a,
          R"(Positions of all vertices, n×3: rigid regions, with the rotations that they have in `estimate` (n×3).

`moves`: {handle: Move}, those of the estimate. Costs one solve. Raises InputError, ConflictError.)");
}

// Interactive edits of a mesh, defined by a deform scene.

namespace {

using namespace py::literals;

/// A deform scene with its current parameter values. Calls from several threads are serialised.
struct MeshEditObject {
  EditedMesh edited;
  std::vector<std::string> names;  // names of all parameters
  std::optional<Mesh> mesh;        // as it was read
  CallSerializer serialize;

  Points nodes() const { return node_positions(edited.shape(), mesh->data().source.file); }
};

std::string full_text(const std::string& file) {
  require_input_file(file, "a deform scene", "");
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::unique_ptr<MeshEditObject> new_mesh_edit(const py::object& path, const py::object& progress) {
  const std::string file = path_from(path);
  return KernelCall(progress)([&](const Progress& hook) {
    auto made = std::make_unique<MeshEditObject>();
    const std::string text = full_text(file);
    for (const Parameter& p : parse_deform_scene(text, file).parameters())
      made->names.push_back(p.name);
    made->edited.rebuild(SceneText(text, file), file, hook);
    if (!made->edited.problem().empty()) throw InputError(made->edited.problem());
    made->mesh = Mesh(std::make_shared<const detail::SharedMesh>(made->edited.source()));
    return made;
  });
}

void set_number(MeshEditObject& of, const std::string& name, double value) {
  KernelCall()([&](const Progress&) {
    of.serialize([&] {
      of.edited.check(name, value);
      if (!of.edited.moves(name))
        throw InputError("found '" + name + "', expected a parameter of a handle of the last edit");
      of.edited.set(name, value);
    });
  });
}

double number_of(MeshEditObject& of, const std::string& name) {
  return KernelCall()(
      [&](const Progress&) { return of.serialize([&] { return of.edited.value(name); }); });
}

bool has_number(const MeshEditObject& of, const py::object& name) {
  const auto is_name = [&](const std::string& one) { return py::str(one).equal(name); };
  return std::any_of(of.names.begin(), of.names.end(), is_name);
}

py::dict numbers_of(MeshEditObject& of) {
  py::dict values;
  for (const std::string& name : of.names) values[py::str(name)] = number_of(of, name);
  return values;
}

}  // namespace

void bind_edits(py::module_& m) {
  py::class_<MeshEditObject>(
      m, "MeshEdit",
      R"(Interactive edits of a deform scene: the parameters of the last edit's handles can be changed.

Features and constraints are those of the scene; factorized once. The result of solve() is the same as
the output of `batten deform` (docs/deform.md).

    >>> edit = batten.MeshEdit("examples/10-plate-with-holes/direction.toml")
    >>> edit["edit.right.angle"]
    75.0
    >>> edit["edit.right.angle"] = 60
    >>> edit.solve()
    >>> edit.points.shape
    (2784, 3)
)")
      .def(py::init(&new_mesh_edit), "path"_a, py::kw_only(), "progress"_a = py::none(),
           "Reads a deform scene and applies its edits. Raises InputError, ConflictError, "
           "NoSolutionError.")
      .def_property_readonly("parameters", &numbers_of,
                             "Parameters of all edits, {\"EDIT.HANDLE.x\": value, …}.")
      .def("__setitem__", &set_number, "name"_a, "value"_a)
      .def("__getitem__", &number_of, "name"_a)
      .def("__contains__", &has_number, "name"_a)
      .def("__iter__", [](const MeshEditObject& of) { return py::iter(py::cast(of.names)); })
      .def(
          "update",
          [](MeshEditObject& of) {
            return KernelCall()([&](const Progress&) {
              return of.serialize([&] { return of.edited.solve_preview(); });
            });
          },
          "Updates the shape quickly, as during a drag: a pair of triangular solves; True if it "
          "has "
          "converged. Raises the exceptions of solve().")
      .def(
          "solve",
          [](MeshEditObject& of) {
            KernelCall()(
                [&](const Progress&) { of.serialize([&] { of.edited.solve_to_equilibrium(); }); });
          },
          "Solves to convergence. Raises ConflictError, NoSolutionError; shape and parameters are "
          "then restored.")
      .def_property_readonly(
          "points",
          [](MeshEditObject& of) {
            return array_of(KernelCall()(
                [&](const Progress&) { return of.serialize([&] { return of.nodes(); }); }));
          },
          "Node positions, n×3 float64; a new array.")
      .def_property_readonly(
          "mesh", [](const MeshEditObject& of) { return *of.mesh; }, "The Mesh as it was read.");
}

}  // namespace batten::python
