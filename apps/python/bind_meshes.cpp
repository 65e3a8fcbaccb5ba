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
#include "batten/apps/python/kernel_call.h"
#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
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

std::string hole_repr(const Hole& hole) {
  return "<batten.Hole '" + hole.name + "': radius " + format_number(hole.radius) + " at " +
         format_point(hole.centre) + ">";
}

void bind_holes(py::module_& m) {
  py::class_<Hole>(m, "Hole", "A hole of a mesh: a boundary loop, its best-fit circle, its flange.")
      .def_readonly("name", &Hole::name, "\"hole-1\", \"hole-2\" and so on, as in deform scenes.")
      .def_property_readonly(
          "vertices", [](const Hole& hole) { return array_of(hole.vertices); },
          "Vertices of the hole and of its flange, ascending, for `features` of a Deformer.")
      .def_property_readonly(
          "loop", [](const Hole& hole) { return array_of(hole.loop); },
          "Vertices of the boundary loop in order, for measure_hole().")
      .def_property_readonly(
          "centre", [](const Hole& hole) { return array_of(hole.centre); },
          "Centre of the circle, array of 3.")
      .def_property_readonly(
          "axis", [](const Hole& hole) { return array_of(hole.axis); },
          "Unit normal of the plane of the circle, array of 3.")
      .def_readonly("radius", &Hole::radius, "Radius of the circle.")
      .def_readonly("roundness", &Hole::roundness,
                    "Largest distance of a vertex from the circle, in its plane.")
      .def_readonly("flatness", &Hole::flatness, "Largest distance of a vertex from the plane.")
      .def_readonly("perimeter", &Hole::perimeter, "Length of the boundary loop.")
      .def_readonly("circular", &Hole::circular, "Whether the loop is a circle (within 2 %).")
      .def("__repr__", &hole_repr);
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

Meshes can be copied and pickled; an unpickled mesh has no file for save_as_read().)");
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
          "Unit normals of the surface at the corners of the triangles, m×3×3 float64, for the mesh "
          "of a model; otherwise empty. A view.")
      .def_property_readonly("sets", &mesh_sets, "Sets of the file, {name: {nodes, faces}}.")
      .def_property_readonly("boundary_loops", &mesh_boundary_loops,
                             "Closed loops of boundary nodes: the outline and the holes.")
      .def_property_readonly("format", &Mesh::format,
                             "The file's format; empty for a mesh from arrays.")
      .def_property_readonly("notes", &Mesh::notes, "Repairs and remarks, as sentences.")
      .def(
          "holes",
          [](const Mesh& mesh, double flange_width) {
            return KernelCall()([&](const Progress&) { return mesh.holes(flange_width); });
          },
          "flange_width"_a = 0.0,
          R"(The holes, a list of Hole: all boundary loops except the longest one of each part, its outline.

The flange around a hole ends at a crease; without a crease, it has the width `flange_width` (model
units, 0: one ring of faces).)")
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
  bind_mesh_output(c);
  m.def(
      "read_mesh",
      [](const py::object& path) {
        const std::string file = path_from(path);
        return KernelCall()([&](const Progress&) { return batten::read_mesh(file); });
      },
      "path"_a,
      "Reads a mesh file: OBJ, OFF, PLY, STL, VTP, VTU, Nastran, Abaqus, LS-DYNA, Radioss. Raises "
      "InputError.");
  m.def("measure_hole", &hole_dict, "points"_a, "loop"_a,
        "The best-fit circle of a closed loop of points (indices): centre, axis, radius, "
        "roundness, flatness. Lengths in the unit of the points.");
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

template <class Named>
std::vector<Named> named_from(const py::dict& given, const std::string& what, int count) {
  std::vector<Named> all;
  for (const auto& [name, vertices] : given) {
    Named one;
    one.name = py::str(name);
    one.vertices = indices_from(vertices, what + " '" + one.name + "'", count);
    all.push_back(std::move(one));
  }
  return all;
}

/// The inverse of named_from().
py::dict dict_of(const std::vector<VertexGroup>& groups) {
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

using DeformerPtr = std::shared_ptr<Deformer>;

DeformerPtr new_deformer(const py::object& given, const py::object& triangles,
                         const py::object& fixed, const py::dict& handles, const py::dict& features,
                         const py::dict& keep_orientation, const py::object& region) {
  const Mesh mesh = mesh_from(given, triangles);
  const int count = mesh.data().shells().node_count();
  DeformerSettings settings;
  settings.fixed = indices_from(fixed, "fixed", count);
  settings.handles = named_from<VertexGroup>(handles, "handle", count);
  settings.features = named_from<VertexGroup>(features, "feature", count);
  settings.keep_orientation = named_from<VertexGroup>(keep_orientation, "feature", count);
  if (!region.is_none())
    settings.region_of_interest = indices_from(region, "region_of_interest", count);
  return KernelCall()([&](const Progress&) { return std::make_shared<Deformer>(mesh, settings); });
}

py::array deform(Deformer& deformer, const py::dict& given, const py::dict& factors, bool correct) {
  const auto moves = moves_from(given);
  const auto scales = scales_from(factors);
  return array_of(
      KernelCall()([&](const Progress&) { return deformer.deform(moves, scales, correct); }));
}

py::array deformer_positions(const DeformerPtr& of) {
  return nodes_view(of, of->state().deformer.positions(), of->mesh().data().shells().node_count());
}

/// The mesh and the settings of a deformer, for pickle: the arguments of new_deformer().
py::tuple deformer_state(const Deformer& of) {
  const DeformerSettings& s = of.settings();
  py::object region = py::none();
  if (s.region_of_interest) region = array_of(std::vector<int>(*s.region_of_interest));
  return py::make_tuple(of.mesh(), array_of(std::vector<int>(s.fixed)), dict_of(s.handles),
                        dict_of(s.features), dict_of(s.keep_orientation), region);
}

DeformerPtr deformer_of_state(const py::tuple& state) {
  return new_deformer(state[0], py::none(), state[1], state[2], state[3], state[4], state[5]);
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
                                           const py::dict& handles, bool soft, double weight) {
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

void bind_deformer(py::module_& m) {
  py::class_<Deformer, DeformerPtr>(
      m, "Deformer",
      R"(Morphs a mesh whose form features keep their shape exactly; factorized once.

min ½|A p - b|² subject to C p = d: mean-curvature vectors are preserved up to a smooth field of
rotations; fixed vertices, handles and features are exact constraints. A copied or unpickled deformer
is computed again from the mesh and the settings, and starts without an edit.
Reference: Masuda, Yoshioka, Furukawa 2006 (docs/theory/deformers.md).)")
      .def(
          py::init(&new_deformer), "mesh"_a, "triangles"_a = py::none(), py::kw_only(),
          "fixed"_a = py::tuple(), "handles"_a = py::dict(), "features"_a = py::dict(),
          "keep_orientation"_a = py::dict(), "region_of_interest"_a = py::none(),
          R"(`mesh`: a Mesh, or points n×3 with `triangles` (faces, as for a Mesh). Vertices are indices from 0 or masks of n.

`handles`, `features` (rotate with the sheet), `keep_orientation` (features without rotation): {name:
vertices}. `region_of_interest`: vertices that may move (None: all). Raises InputError, NoSolutionError.)")
      .def("deform", &deform, "moves"_a, py::kw_only(), "scales"_a = py::dict(),
           "correct"_a = false,
           R"(Positions of all vertices after an edit of the original mesh, n×3 float64.

`moves`: {handle: Move}; `scales`: {feature: factor}. Costs a pair of triangular solves; `correct`: one
more, to reduce rounding errors. Raises InputError, ConflictError; positions are then unchanged.)")
      .def_property_readonly(
          "positions", &deformer_positions,
          "Positions of the last deform(), n×3: a view, which the next call overwrites.")
      .def_property_readonly(
          "residual",
          [](const Deformer& of) {
            return KernelCall()([&](const Progress&) { return of.residual(); });
          },
          "Largest violation of the exact constraints, relative to the size.")
      .def_property_readonly("unknowns", &Deformer::unknowns,
                             "Number of unknowns per coordinate, after elimination of the "
                             "constraints.")
      .def_property_readonly(
          "notes", &Deformer::notes,
          "Remarks about parts of the mesh without handles or fixed vertices, as sentences.")
      .def_property_readonly("mesh", &Deformer::mesh, "The Mesh that is deformed.")
      .def(py::pickle(&deformer_state, &deformer_of_state));
}

void bind_moves(py::module_& m) {
  py::class_<Move>(m, "Move", "Motion of a handle: p = about + s R (p⁰ - about) + translate.")
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
      .def_readonly("scale", &Move::scale)
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
  bind_deformer(m);
  py::class_<RegionsObject>(
      m, "FeatureRegions",
      R"(Preserves regions of a mesh in the result of any deformer; factorized once.

Reference: Hu, Song, Cao 2012, Mesh editing with feature region preservation (docs/theory/deformers.md).)")
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
the output of `batten deform` (docs/deform.md).)")
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
