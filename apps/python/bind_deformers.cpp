// Deformers: meshes whose features keep their shape.
#include <numbers>

#include "batten/apps/python/arrays.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/apps/python/mesh_object.h"
#include "batten/core/errors.h"
#include "batten/core/rotations.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/regions/feature_region_deformer.h"

namespace batten::python {
namespace {

using namespace py::literals;

/// How a handle moves, as Python says it: `about` None is the mean of its vertices.
struct MoveObject {
  HandleTransform move;
  bool about_mean = true;
};

MoveObject new_move(const py::object& translation, const py::object& axis, double degrees,
                    double scale, const py::object& about) {
  MoveObject result;
  result.move.translation = vector_from(translation, "shift");
  const Vec3 along = vector_from(axis, "axis");
  if (along.norm() == 0) throw InputError("axis: found length 0, expected a direction");
  result.move.rotation_vector = to_rotation_vector(along, degrees * std::numbers::pi / 180);
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

/// One move for each handle, in their order; handles without one stay.
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

/// A deformer that keeps form features, and the places that it found last.
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

/// Places of the nodes, which are the first vertices.
Points nodes_of(const Points& vertices, const MeshObject& mesh) {
  return node_positions(vertices, mesh.source.file);
}

DeformerPtr new_deformer(const py::object& given, const py::object& triangles,
                         const py::object& fixed, const py::dict& handles, const py::dict& features,
                         const py::dict& upright, const py::object& region) {
  auto result = std::make_shared<DeformerObject>();
  result->mesh = mesh_from(given, triangles);
  const TriangleMesh& mesh = result->mesh->source.prepared.mesh;
  const int count = mesh.topology().node_count();
  DeformProblem problem;
  problem.fixed = indices_from(fixed, "fixed", count);
  problem.handles = named_from<Handle>(handles, "handle", count);
  problem.features = named_from<FormFeature>(features, "feature", count);
  for (FormFeature& feature : named_from<FormFeature>(upright, "feature", count)) {
    feature.kind = FormFeature::Kind::TranslationOnly;
    problem.features.push_back(feature);
  }
  if (!region.is_none()) problem.region = indices_from(region, "region", count);
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

/// A deformer that keeps feature regions in the result of any other one.
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
      R"(Deforms a mesh whose form features keep their shape exactly; factored once.

min ½|A p - b|² under C p = d: mean-curvature vectors are kept while they turn with a smooth field of
rotations; fixed vertices, handles and features hold exactly.
Source: Masuda, Yoshioka, Furukawa 2006 (docs/theory/deformers.md).)")
      .def(
          py::init(&new_deformer), "mesh"_a, "triangles"_a = py::none(), py::kw_only(),
          "fixed"_a = py::tuple(), "handles"_a = py::dict(), "features"_a = py::dict(),
          "keep_direction"_a = py::dict(), "region"_a = py::none(),
          R"(`mesh`: a Mesh, or points n×3 with `triangles` m×3. Vertices are numbers from 0 or masks of n.

`handles`, `features` (turn with the sheet), `keep_direction` (features that do not turn): {name:
vertices}. `region`: vertices that may move (None: all). Raises InputError, NoSolutionError.)")
      .def("deform", &deform, "moves"_a, py::kw_only(), "scales"_a = py::dict(),
           "correct"_a = false,
           R"(Places of all vertices after an edit of the mesh as it was given, n×3 float64.

`moves`: {handle: Move}; `scales`: {feature: factor}. A pair of triangular solves; `correct`: once
more, against roundings. Raises InputError, ConflictError; positions then stay.)")
      .def_property_readonly(
          "positions", &positions_of,
          "Places of the last deform(), n×3: a view, which the next one overwrites.")
      .def_property_readonly(
          "residual",
          [](const DeformerPtr& of) {
            return KernelCall()([&](const Progress&) {
              return of->serialize([&] { return of->deformer->hard_residual(); });
            });
          },
          "Largest violation of what is held, over the size.")
      .def_property_readonly(
          "unknowns", [](const DeformerPtr& of) { return of->deformer->counts().unknowns; },
          "Unknowns of one coordinate, after the constraints.")
      .def_property_readonly(
          "notes", [](const DeformerPtr& of) { return py::cast(of->deformer->notes()); },
          "Parts of the mesh that nothing moves or holds, in sentences.");
}

}  // namespace

void bind_deformers(py::module_& m) {
  py::class_<MoveObject>(m, "Move", "How a handle moves: p = about + s R (p⁰ - about) + shift.")
      .def(py::init(&new_move), py::kw_only(), "shift"_a = py::make_tuple(0., 0., 0.),
           "axis"_a = py::make_tuple(0., 0., 1.), "degrees"_a = 0.0, "scale"_a = 1.0,
           "about"_a = py::none(),
           "`shift`, `about` in model units (None: the mean of the handle's vertices); a turn by "
           "`degrees` about "
           "`axis`; `scale` above 0.");
  bind_deformer(m);
  py::class_<RegionsObject>(m, "FeatureRegions",
                            R"(Keeps regions of a mesh in the result of any deformer; factored once.

Source: Hu, Song, Cao 2012, Mesh editing with feature region preservation (docs/theory/deformers.md).)")
      .def(
          py::init(&new_regions), "mesh"_a, "triangles"_a = py::none(), py::kw_only(), "regions"_a,
          "fixed"_a = py::tuple(), "handles"_a = py::dict(), "soft"_a = false, "weight"_a = 2e7,
          R"(`regions`: {name: triangles}, numbers or masks of m; `fixed`, `handles`: as of a Deformer.

Hard regions are rigid exactly; `soft` ones nearly, by `weight`. Raises InputError, NoSolutionError.)")
      .def(
          "deform", &keep_regions, "estimate"_a, "moves"_a,
          R"(Places of all vertices, n×3: regions turned as `estimate` (n×3) has turned them, and rigid.

`moves`: {handle: Move}, those of the estimate. One solve. Raises InputError, ConflictError.)");
}

}  // namespace batten::python
