// Binds meshes, deformers and mesh edits.

#include <fstream>
#include <memory>
#include <numbers>
#include <sstream>

#include "batten/apps/commands/documents/edited_mesh.h"
#include "batten/apps/commands/meshes/edit_session.h"
#include "batten/apps/python/bindings.h"
#include "batten/apps/python/conversions.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/scene/deform_scene.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/regions/feature_region_deformer.h"

namespace batten::python {

// Meshes.

/// A mesh from a file or from arrays, prepared for deformers. Immutable.
struct MeshObject {
  MeshSource source;
  bool of_file = false;
};

/// Makes a mesh from points n×3 and triangles m×3. Throws InputError, MeshError.
std::shared_ptr<MeshObject> mesh_of_arrays(const py::object& points, const py::object& triangles);

/// The given Mesh object, or a mesh from points and triangles.
std::shared_ptr<const MeshObject> mesh_from(const py::object& mesh_or_points,
                                            const py::object& triangles);

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

py::list boundary_loops_of(const MeshObject& mesh) {
  const MeshTopology& topology = mesh.source.prepared.mesh.topology();
  py::list loops;
  for (std::vector<int> loop : topology.boundary_loops()) {
    for (int& vertex : loop) vertex = topology.node_of(vertex);
    loops.append(array_of(std::move(loop)));
  }
  return loops;
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
      throw InputError("triangles: found triangles together with a Mesh, expected None");
    return given.cast<MeshPtr>();
  }
  if (triangles.is_none())
    throw InputError(
        "mesh: found points without triangles, expected a Mesh, or points and triangles");
  return mesh_of_arrays(given, triangles);
}

void bind_meshes(py::module_& m) {
  py::class_<MeshObject, MeshPtr>(m, "Mesh", "A mesh from a file or from arrays. Immutable.")
      .def(py::init(&mesh_of_arrays), "points"_a, "triangles"_a,
           "A mesh of points n×3 and triangles m×3 (indices from 0). Raises InputError, "
           "MeshError.")
      .def_property_readonly("points", &mesh_points, "Node positions, n×3 float64. A view.")
      .def_property_readonly("triangles", &mesh_triangles,
                             "Node indices of the triangles into which faces are split, m×3 int32.")
      .def_property_readonly("triangle_faces", &triangle_faces,
                             "Index of the face that contains each triangle, m int32. A view.")
      .def_property_readonly("sets", &sets_of, "Sets of the file, {name: {nodes, faces}}.")
      .def_property_readonly("boundary_loops", &boundary_loops_of,
                             "Closed loops of boundary nodes: the outline and the holes.")
      .def_property_readonly(
          "format", [](const MeshObject& mesh) { return mesh.source.file.format(); },
          "The file's format.")
      .def_property_readonly(
          "notes", [](const MeshObject& mesh) { return py::cast(mesh.source.prepared.notes); },
          "Repairs and remarks, as sentences.")
      .def(
          "save", &save_mesh, "path"_a, "points"_a = py::none(), py::kw_only(), "unit"_a = "",
          R"(Writes a mesh file; the extension selects the format: .obj .off .ply .stl .vtp .vtu, and with `unit` .glb .3mf.

`points`: other node positions, n×3. Raises InputError, FileError.)")
      .def("save_as_read", &save_as_read, "path"_a, "points"_a, py::kw_only(),
           "large_field"_a = false,
           R"(Writes the input file with new node positions n×3 and everything else unchanged.

`large_field`: write the moved nodes of Nastran decks in large-field format. Returns the largest rounding
error of a coordinate, model units. Raises InputError, FileError.)")
      .def("__repr__", &mesh_repr);
  m.def(
      "read_mesh", &read_mesh, "path"_a,
      "Reads a mesh file: OBJ, OFF, PLY, STL, VTP, VTU, Nastran, Abaqus, LS-DYNA, Radioss. Raises "
      "InputError.");
  m.def("measure_hole", &hole_dict, "points"_a, "loop"_a,
        "The best-fit circle of a closed loop of points (indices): centre, axis, radius, "
        "roundness, flatness. Lengths in the unit of the points.");
}

// Deformers that preserve the shape of features.

namespace {

using namespace py::literals;

/// The class Move: motion of a handle. If `about` is None, the centre is the mean of its vertices.
struct MoveObject {
  HandleTransform move;
  bool about_mean = true;
};

MoveObject new_move(const py::object& translation, const py::object& axis, double angle,
                    double scale, const py::object& about) {
  MoveObject result;
  result.move.translation = vector_from(translation, "translate");
  const Vec3 along = vector_from(axis, "axis");
  if (along.norm() == 0) throw InputError("axis: found length 0, expected a direction");
  result.move.rotation_vector = to_rotation_vector(along, angle * std::numbers::pi / 180);
  result.move.scale = scale;
  result.about_mean = about.is_none();
  if (!result.about_mean) result.move.about = vector_from(about, "about");
  return result;
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

/// Converts a dict to one move per handle, in the order of the handles; missing ones do not move.
std::vector<HandleTransform> moves_from(const py::dict& given, const std::vector<Handle>& handles,
                                        const TriangleMesh& mesh) {
  std::vector<HandleTransform> moves(handles.size());
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key);
    size_t h = 0;
    while (h < handles.size() && handles[h].name != name) ++h;
    if (h == handles.size())
      throw InputError("moves: found '" + name + "', expected a handle's name");
    if (!py::isinstance<MoveObject>(value))
      throw InputError("moves: found " + std::string(py::repr(value)) + " for '" + name +
                       "', expected a batten.Move");
    const auto move = value.cast<MoveObject>();
    moves[h] = move.move;
    if (!move.about_mean) continue;
    for (const int v : handles[h].vertices) moves[h].about += mesh.point(v);
    moves[h].about /= static_cast<double>(handles[h].vertices.size());
  }
  return moves;
}

/// A form-feature deformer, with its problem.
struct DeformerObject {
  std::shared_ptr<const MeshObject> mesh;
  DeformProblem problem;
  std::unique_ptr<FormFeatureDeformer> deformer;
  CallSerializer serialize;
};
using DeformerPtr = std::shared_ptr<DeformerObject>;

std::vector<double> scales_from(const py::dict& given, const std::vector<FormFeature>& features) {
  if (given.empty()) return {};
  std::vector<double> scales(features.size(), 1);
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key);
    size_t f = 0;
    while (f < features.size() && features[f].name != name) ++f;
    if (f == features.size())
      throw InputError("scales: found '" + name + "', expected a feature's name");
    scales[f] = numbers_from(py::make_tuple(value), "scales '" + name + "'").front();
  }
  return scales;
}

/// Positions of the mesh nodes, which are the first vertices.
Points nodes_of(const Points& vertices, const MeshObject& mesh) {
  return node_positions(vertices, mesh.source.file);
}

DeformerPtr new_deformer(const py::object& given, const py::object& triangles,
                         const py::object& fixed, const py::dict& handles, const py::dict& features,
                         const py::dict& keep_orientation, const py::object& region) {
  auto result = std::make_shared<DeformerObject>();
  result->mesh = mesh_from(given, triangles);
  const TriangleMesh& mesh = result->mesh->source.prepared.mesh;
  const int count = mesh.topology().node_count();
  DeformProblem problem;
  problem.fixed = indices_from(fixed, "fixed", count);
  problem.handles = named_from<Handle>(handles, "handle", count);
  problem.features = named_from<FormFeature>(features, "feature", count);
  for (FormFeature& feature : named_from<FormFeature>(keep_orientation, "feature", count)) {
    feature.kind = FormFeature::Kind::TranslationOnly;
    problem.features.push_back(feature);
  }
  if (!region.is_none()) problem.region = indices_from(region, "region_of_interest", count);
  problem = expand_to_nodes(std::move(problem), mesh.topology());
  result->problem = problem;
  result->deformer = KernelCall()(
      [&](const Progress&) { return std::make_unique<FormFeatureDeformer>(mesh, problem); });
  return result;
}

py::array deform(const DeformerPtr& of, const py::dict& moves, const py::dict& scales,
                 bool correct) {
  DeformEdit edit;
  edit.handles = moves_from(moves, of->problem.handles, of->mesh->source.prepared.mesh);
  edit.feature_scales = scales_from(scales, of->problem.features);
  return array_of(KernelCall()([&](const Progress&) {
    return of->serialize([&] {
      of->deformer->deform(edit);
      if (correct) of->deformer->correct();
      return nodes_of(of->deformer->positions(), *of->mesh);
    });
  }));
}

py::array positions_of(const DeformerPtr& of) {
  const Points& points = of->deformer->positions();
  const auto size = static_cast<py::ssize_t>(sizeof(double));
  return array_view(of, points.data(), {of->mesh->source.file.shells().node_count(), 3},
                    {size, points.rows() * size});
}

/// A deformer that preserves feature regions in the result of any other deformer.
struct RegionsObject {
  std::shared_ptr<const MeshObject> mesh;
  std::vector<Handle> handles;
  std::unique_ptr<FeatureRegionDeformer> deformer;
  CallSerializer serialize;
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
  auto result = std::make_unique<RegionsObject>();
  result->mesh = mesh_from(given, triangles);
  const TriangleMesh& mesh = result->mesh->source.prepared.mesh;
  const int count = mesh.topology().vertex_count();
  const auto still = indices_from(fixed, "fixed", count);
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
  const TriangleMesh& mesh = of.mesh->source.prepared.mesh;
  const auto handles = moves_from(moves, of.handles, mesh);
  return array_of(KernelCall()([&](const Progress&) {
    return of.serialize([&] { return Points(of.deformer->deform(shape, handles)); });
  }));
}

void bind_deformer(py::module_& m) {
  py::class_<DeformerObject, DeformerPtr>(
      m, "Deformer",
      R"(Morphs a mesh whose form features keep their shape exactly; factorized once.

min ½|A p - b|² subject to C p = d: mean-curvature vectors are preserved up to a smooth field of
rotations; fixed vertices, handles and features are exact constraints.
Reference: Masuda, Yoshioka, Furukawa 2006 (docs/theory/deformers.md).)")
      .def(
          py::init(&new_deformer), "mesh"_a, "triangles"_a = py::none(), py::kw_only(),
          "fixed"_a = py::tuple(), "handles"_a = py::dict(), "features"_a = py::dict(),
          "keep_orientation"_a = py::dict(), "region_of_interest"_a = py::none(),
          R"(`mesh`: a Mesh, or points n×3 with `triangles` m×3. Vertices are indices from 0 or masks of n.

`handles`, `features` (rotate with the sheet), `keep_orientation` (features without rotation): {name:
vertices}. `region_of_interest`: vertices that may move (None: all). Raises InputError, NoSolutionError.)")
      .def("deform", &deform, "moves"_a, py::kw_only(), "scales"_a = py::dict(),
           "correct"_a = false,
           R"(Positions of all vertices after an edit of the original mesh, n×3 float64.

`moves`: {handle: Move}; `scales`: {feature: factor}. Costs a pair of triangular solves; `correct`: one
more, to reduce rounding errors. Raises InputError, ConflictError; positions are then unchanged.)")
      .def_property_readonly(
          "positions", &positions_of,
          "Positions of the last deform(), n×3: a view, which the next call overwrites.")
      .def_property_readonly(
          "residual",
          [](const DeformerPtr& of) {
            return KernelCall()([&](const Progress&) {
              return of->serialize([&] { return of->deformer->hard_residual(); });
            });
          },
          "Largest violation of the exact constraints, relative to the size.")
      .def_property_readonly(
          "unknowns", [](const DeformerPtr& of) { return of->deformer->counts().unknowns; },
          "Number of unknowns per coordinate, after elimination of the constraints.")
      .def_property_readonly(
          "notes", [](const DeformerPtr& of) { return py::cast(of->deformer->notes()); },
          "Remarks about parts of the mesh without handles or fixed vertices, as sentences.");
}

}  // namespace

void bind_deformers(py::module_& m) {
  py::class_<MoveObject>(m, "Move", "Motion of a handle: p = about + s R (p⁰ - about) + translate.")
      .def(py::init(&new_move), py::kw_only(), "translate"_a = py::make_tuple(0., 0., 0.),
           "axis"_a = py::make_tuple(0., 0., 1.), "angle"_a = 0.0, "scale"_a = 1.0,
           "about"_a = py::none(),
           "`translate` and `about` in model units (about = None: the mean of the handle's "
           "vertices); rotation by `angle` degrees about `axis`; `scale` above 0.");
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
  std::shared_ptr<MeshObject> mesh;
  CallSerializer serialize;

  Points nodes() const { return node_positions(edited.shape(), mesh->source.file); }
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
    made->mesh = std::make_shared<MeshObject>(MeshObject{made->edited.source(), true});
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
      .def_readonly("mesh", &MeshEditObject::mesh, "The Mesh as it was read.");
}

}  // namespace batten::python
