// SPDX-License-Identifier: MPL-2.0
// Binds models: curves as arrays, or scenes, and the surfaces that they produce.
#include "batten/apps/python/conversions.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/core/errors.h"
#include "batten/scenes/fit_surface.h"
#include "batten/scenes/lines/line_files.h"
#include "batten/scenes/mesh.h"
#include "batten/scenes/model.h"

namespace batten::python {
namespace {

using namespace py::literals;

double number_above_0(const py::object& given, const std::string& what) {
  if (given.is_none()) return 0;
  const double value = PyFloat_AsDouble(given.ptr());
  if (PyErr_Occurred())
    PyErr_Clear();
  else if (std::isfinite(value) && value > 0)
    return value;
  throw InputError(what + ": found " + std::string(py::repr(given)) +
                   ", expected a number above 0");
}

InputLine line_of(const std::string& name, const py::handle& given) {
  InputLine line{name};
  if (py::isinstance<HermiteCurve>(given))
    line.curve = std::make_shared<const HermiteCurve>(given.cast<HermiteCurve>());
  else
    line.points = rows_of(points_from(given, "curve '" + name + "'"));
  return line;
}

std::map<std::string, double> values_by_name(const py::object& given) {
  const auto values = values_from(given);
  return {values.begin(), values.end()};
}

/// Facets of a model, computed without the GIL. The model keeps them alive.
const Facets& facets_of(const Model& model) {
  return *KernelCall()([&](const Progress&) { return &model.facets(); });
}

py::array rows_of_model(const Model& model, const double* data, size_t count) {
  return rows_view(model.shared_data(), data, static_cast<py::ssize_t>(count / 3), 3);
}

py::array points_of(const Model& model) {
  const Facets& facets = facets_of(model);
  return rows_of_model(model, facets.points.data(), facets.points.size());
}

py::array normals_of(const Model& model) {
  const Facets& facets = facets_of(model);
  return rows_of_model(model, facets.normals.data(), facets.normals.size());
}

py::array curvatures_of(const Model& model) {
  const Facets& facets = facets_of(model);
  return rows_view(model.shared_data(), facets.curvatures.data(),
                   static_cast<py::ssize_t>(facets.curvatures.size() / 2), 2);
}

py::array triangles_of(const Model& model) {
  const Facets& facets = facets_of(model);
  return rows_view(model.shared_data(), facets.triangles.front().data(),
                   static_cast<py::ssize_t>(facets.triangles.size()), 3);
}

py::array triangle_faces_of(const Model& model) {
  const Facets& facets = facets_of(model);
  return array_view(model.shared_data(), facets.faces.data(),
                    {static_cast<py::ssize_t>(facets.faces.size())}, {sizeof(int)});
}

py::array array_of_points(const std::vector<Vec3>& given) {
  Points points(static_cast<long>(given.size()), 3);
  for (long i = 0; i < points.rows(); ++i) points.row(i) = given[static_cast<size_t>(i)];
  return array_of(std::move(points));
}

py::array array_of_vector(const Vec3& v) { return array_of(std::vector<double>{v[0], v[1], v[2]}); }

py::object report_of(const Model& model) {
  return json_object(KernelCall()([&](const Progress& hook) { return model.report(hook); }));
}

void picture(const Model& model, const py::object& path, int width, int height, double azimuth,
             double elevation, const std::string& field, int contours, int zebra, bool mesh,
             const std::string& title) {
  const std::string file = path_from(path);
  const PictureView view{width, height, azimuth, elevation, field, contours, zebra, mesh, title};
  KernelCall()([&](const Progress&) { model.picture(file, view); });
}

std::string model_repr(const Model& model) {
  const size_t faces = model.faces().size();
  return "<batten.Model '" + model.name() + "': " + std::to_string(faces) +
         (faces == 1 ? " face, " : " faces, ") + std::to_string(model.element_count()) +
         " elements, in " + model.unit() + ">";
}

std::string point_repr(const SurfacePoint& p) {
  return "<batten.SurfacePoint " + format_point(p.position) + " of '" + p.face + "', u " +
         format_number(p.u) + ", v " + format_number(p.v) + ">";
}

std::string edge_repr(const ModelEdge& edge) {
  std::string faces;
  for (const std::string& face : edge.faces) faces += (faces.empty() ? "'" : ", '") + face + "'";
  return "<batten.Edge '" + edge.name + "': " + edge.continuity + ", of " + faces + ">";
}

py::dict curves_of_file(const py::object& path, const std::string& unit, double corner_angle) {
  const std::string file = path_from(path);
  const auto lines = KernelCall()([&](const Progress&) {
    std::vector<std::pair<std::string, std::vector<Vec3>>> read;
    for (const SourceLine& line : read_source_file(file, unit, unit.empty() ? "mm" : unit))
      read.emplace_back(line.name, sample_line(line, corner_angle).points);
    return read;
  });
  py::dict result;
  for (const auto& [name, points] : lines) {
    std::string free = name;
    for (int n = 2; result.contains(free); ++n) free = name + " " + std::to_string(n);
    result[py::str(free)] = array_of_points(points);
  }
  return result;
}

void bind_making(py::module_& m) {
  m.def(
      "skin",
      [](const py::dict& curves, const py::object& fit_tolerance, const py::object& edge_length,
         const py::object& corner_angle, const py::iterable& inner, const py::iterable& holes,
         const py::iterable& smooth, const py::iterable& crease, const std::string& name,
         const std::string& unit, const std::string& settings, const py::object& progress) {
        std::vector<InputLine> lines;
        for (const auto& [key, given] : curves) lines.push_back(line_of(py::str(key), given));
        const SkinSettings task{name,
                                unit,
                                number_above_0(fit_tolerance, "fit_tolerance"),
                                number_above_0(edge_length, "edge_length"),
                                number_above_0(corner_angle, "corner_angle"),
                                names_from(inner, "inner"),
                                names_from(holes, "holes"),
                                names_from(smooth, "smooth"),
                                names_from(crease, "crease"),
                                settings};
        return KernelCall(progress)([&](const Progress& hook) { return skin(lines, task, hook); });
      },
      "curves"_a, py::kw_only(), "fit_tolerance"_a = py::none(), "edge_length"_a = py::none(),
      "corner_angle"_a = py::none(), "inner"_a = py::tuple(), "holes"_a = py::tuple(),
      "smooth"_a = py::tuple(), "crease"_a = py::tuple(), "name"_a = "surface", "unit"_a = "mm",
      "settings"_a = "", "progress"_a = py::none(),
      R"(Fits surfaces through curves, {name: points n×3, or a Curve}, and finds the faces they bound.

Curves in `inner` lie on a face, those in `holes` trim one. `fit_tolerance`, `edge_length`: model
units (defaults: 1e-4 and 1/20 of the size). `corner_angle`: degrees. `smooth`, `crease`: names of
curves along which faces meet smoothly, or with a crease (G0). `settings`: text of a scene without
curves and unit, for everything else (docs/scenes.md). `progress(stage, fraction)`: an exception that
it raises stops the computation. Raises InputError, ConflictError, NoSolutionError.
Reference: Celniker, Gossard 1991: K q = F with the curves as constraints (docs/theory/domains.md).

    >>> panel = batten.skin(rim, fit_tolerance=0.01, edge_length=10)
    >>> panel.faces
    ['surface'])");
  m.def(
      "load",
      [](const py::object& path, const py::object& values, const py::object& progress) {
        const std::string file = path_from(path);
        const auto given = values_by_name(values);
        return KernelCall(progress)([&](const Progress& hook) { return load(file, given, hook); });
      },
      "path"_a, py::kw_only(), "values"_a = py::none(), "progress"_a = py::none(),
      R"(The model of a scene file (.toml), or of a curve file.

`values`: parameters {name: value} that replace those of the scene. Raises InputError,
`FILE:LINE:COLUMN: found …, expected …`, ConflictError, NoSolutionError.

    >>> model.save("panel.toml")
    []
    >>> batten.load("panel.toml", values={"beta": 2}).parameters["beta"]
    2.0)");
  m.def(
      "parse",
      [](const std::string& text, const py::object& folder, const py::object& values,
         const py::object& progress) {
        const std::string base = path_from(folder);
        const auto given = values_by_name(values);
        return KernelCall(progress)(
            [&](const Progress& hook) { return parse(text, base, given, hook); });
      },
      "text"_a, py::kw_only(), "folder"_a = ".", "values"_a = py::none(), "progress"_a = py::none(),
      R"(The model of a scene given as text; paths in it are relative to `folder`.

`values`: parameters {name: value}. Raises the exceptions of load().

    >>> bool((batten.parse(model.scene).points == model.points).all())
    True)");
  m.def(
      "read_curves", &curves_of_file, "path"_a, py::kw_only(), "unit"_a = "",
      "corner_angle"_a = 20.0,
      R"(The curves of a file, {name: points n×3}: tables of points, CAD curves, drawings, sketches.

Points are those of the file; CAD curves are sampled uniformly by arc length between their corners,
where they turn by more than `corner_angle` degrees. `unit`: length unit of a file that states none.
The vertices of a polyline of a drawing are returned as points, of which skin() detects corners by
their angles; load() of the file keeps every vertex as a corner. Raises InputError.

    >>> batten.write_curves("rim.csv", rim)
    []
    >>> batten.read_curves("rim.csv")["left"].shape[1]
    3)");
}

/// The curves of fit_surface(): a dict of arrays or curves, a file name, a list of file names, None.
void set_curves(FitSettings& settings, const py::object& given) {
  if (given.is_none()) return;
  if (py::isinstance<py::dict>(given)) {
    for (const auto& [key, curve] : given.cast<py::dict>())
      settings.curves.push_back(line_of(py::str(key), curve));
    if (settings.curves.empty()) throw InputError("curves: found none, expected one or more");
    return;
  }
  if (!py::isinstance<py::list>(given) && !py::isinstance<py::tuple>(given)) {
    settings.curve_files.emplace_back(path_from(given));
    return;
  }
  for (const py::handle file : given)
    settings.curve_files.emplace_back(path_from(py::reinterpret_borrow<py::object>(file)));
}

Model fitted_model(const py::object& target, const py::object& curves,
                   const py::object& fit_tolerance, const py::object& edge_length,
                   const py::object& gap_tolerance, bool cage, const std::string& name,
                   const std::string& unit, const py::object& progress) {
  FitSettings settings;
  settings.name = name;
  settings.unit = unit;
  settings.fit_tolerance = number_above_0(fit_tolerance, "fit_tolerance");
  settings.edge_length = number_above_0(edge_length, "edge_length");
  settings.gap_tolerance = number_above_0(gap_tolerance, "gap_tolerance");
  settings.cage = cage;
  set_curves(settings, curves);
  if (py::isinstance<Mesh>(target)) {
    const Mesh mesh = target.cast<Mesh>();
    return KernelCall(progress)(
        [&](const Progress& hook) { return fit_surface(mesh, settings, hook); });
  }
  const std::string file = path_from(target);
  return KernelCall(progress)(
      [&](const Progress& hook) { return fit_surface(file, settings, hook); });
}

void bind_fitting(py::module_& m) {
  m.def("fit_surface", &fitted_model, "target"_a, py::kw_only(), "curves"_a = py::none(),
        "fit_tolerance"_a = py::none(), "edge_length"_a = py::none(),
        "gap_tolerance"_a = py::none(), "cage"_a = false, "name"_a = "", "unit"_a = "mm",
        "progress"_a = py::none(),
        R"(The model fitted to a given surface: same as `batten fit` (docs/fit.md), to the last bit.

`target`: a Mesh, or the name of a CAD or mesh file. `curves`: those that bound the faces, {name:
points n×3, or a Curve}, or names of curve files; None: the edges of the CAD file, or the creases and
free edges of the mesh. `fit_tolerance`: largest accepted distance, default 1e-4 of the size.
`edge_length`, `gap_tolerance`: model units. `cage`: the target is the Catmull-Clark limit of the mesh.
report["target"] has the distances in both directions. Raises InputError, ConflictError,
NoSolutionError. Algorithm: fixed-point iteration (docs/fit.md).

    >>> fitted = batten.fit_surface(model.mesh(), curves=rim, fit_tolerance=0.5)
    >>> fitted.report["target"]["reached"]
    True)");
}

void bind_points(py::module_& m) {
  py::class_<SurfacePoint>(m, "SurfacePoint",
                           R"(A point of a surface, with its geometry: Model.nearest(), Model.at().

    >>> p = model.nearest([50, 50, 100])
    >>> p.position.shape, p.normal.shape, p.face
    ((3,), (3,), 'panel')
    >>> mean, gaussian = (p.k1 + p.k2) / 2, p.k1 * p.k2)")
      .def_property_readonly(
          "position", [](const SurfacePoint& p) { return array_of_vector(p.position); },
          "Array of 3, model units.")
      .def_property_readonly(
          "normal", [](const SurfacePoint& p) { return array_of_vector(p.normal); },
          "Unit normal, array of 3.")
      .def_readonly("k1", &SurfacePoint::k1,
                    "Larger principal curvature, 1/length; positive where the surface bends "
                    "towards the normal.")
      .def_readonly("k2", &SurfacePoint::k2, "Smaller principal curvature, 1/length.")
      .def_readonly("face", &SurfacePoint::face, "Name of the face.")
      .def_readonly("u", &SurfacePoint::u, "Parameter u in the domain of the face.")
      .def_readonly("v", &SurfacePoint::v, "Parameter v in the domain of the face.")
      .def_readonly("distance", &SurfacePoint::distance, "Distance from the query point.")
      .def("__repr__", &point_repr);
  py::class_<ModelEdge>(m, "Edge",
                        R"(An edge of a model, at which faces end or meet: Model.edges.

    >>> sorted(edge.name for edge in model.edges if edge.continuity == "free edge")
    ['back', 'front', 'left', 'right'])")
      .def_readonly("name", &ModelEdge::name, "Name of the curve that the edge follows.")
      .def_readonly("faces", &ModelEdge::faces, "Names of the faces at the edge.")
      .def_readonly("continuity", &ModelEdge::continuity,
                    "'free edge', 'G0', 'G1' or 'non-manifold'.")
      .def_readonly("angle", &ModelEdge::angle_deg,
                    "Largest angle between the normals of the two faces, degrees.")
      .def_readonly("gap", &ModelEdge::gap, "Largest distance between the two faces, model units.")
      .def("__repr__", &edge_repr);
}

void bind_evaluation(py::class_<Model>& c) {
  c.def(
       "nearest",
       [](const Model& model, const py::object& point) {
         const Vec3 p = vector_from(point, "point");
         return KernelCall()([&](const Progress&) { return model.nearest(p); });
       },
       "point"_a,
       R"(The SurfacePoint nearest to a point in space, an array of 3. Raises InputError.

    >>> model.nearest([50, 50, 100]).distance < 100
    True)")
      .def(
          "at",
          [](const Model& model, const std::string& face, double u, double v) {
            return KernelCall()([&](const Progress&) { return model.at(face, u, v); });
          },
          "face"_a, "u"_a, "v"_a,
          "The SurfacePoint of a face at the parameters (u, v), as in SurfacePoint. Raises "
          "InputError outside of the domain of the face.")
      .def_property_readonly(
          "area",
          [](const Model& model) {
            return KernelCall()([&](const Progress&) { return model.area(); });
          },
          "Total area of all faces, model units².")
      .def_property_readonly(
          "volume",
          [](const Model& model) {
            return KernelCall()([&](const Progress&) { return model.volume(); });
          },
          "Enclosed volume, model units³. Raises InputError unless the faces "
          "form closed shells.")
      .def_property_readonly(
          "bounds",
          [](const Model& model) {
            const Box3 box = KernelCall()([&](const Progress&) { return model.bounds(); });
            return py::make_tuple(array_of_vector(box.min()), array_of_vector(box.max()));
          },
          "Lower and upper corner of the bounding box, two arrays of 3.")
      .def(
          "mesh",
          [](const Model& model) {
            return KernelCall()([&](const Progress&) { return model.mesh(); });
          },
          R"(One Mesh of all faces, without cracks when it is deformed: faces share the vertices on a common curve.

It has `sets` of the faces (triangles) and curves (vertices), and `corner_normals`.)")
      .def(
          "load_effects",
          [](const Model& model, const py::object& progress) {
            py::dict effects;
            for (const LoadEffect& effect : KernelCall(progress)(
                     [&](const Progress& hook) { return model.load_effects(hook); }))
              effects[py::str(effect.parameter)] = effect;
            return effects;
          },
          py::kw_only(), "progress"_a = py::none(),
          R"(How much each load, curve offset and slider displaces the surface, {name: LoadEffect}.

Takes a small change of each parameter from its value in the model, with one or two solves.)")
      .def(
          "gradients",
          [](const Model& model, const py::object& progress) {
            return KernelCall(progress)(
                [&](const Progress& hook) { return model.gradients(hook); });
          },
          py::kw_only(), "progress"_a = py::none(),
          R"(Area and volume with their derivatives with respect to the parameters: ModelGradients.

Computes the derivative of the shape at the first call: about six solves per parameter. Raises
InputError for shapes without derivatives: of sessions that are not in equilibrium, fitted or lofted.)")
      .def_property_readonly(
          "edges",
          [](const Model& model) {
            return KernelCall()([&](const Progress&) { return model.edges(); });
          },
          "The edges at which faces end or meet, a list of Edge.");
}

/// Copies and pickles: a model is immutable, and its scene is the model.
void bind_copies(py::class_<Model>& c) {
  c.def("__copy__", [](const Model& model) { return model; })
      .def(
          "__deepcopy__", [](const Model& model, const py::dict&) { return model; }, "memo"_a)
      .def(py::pickle(
          [](const Model& model) { return py::make_tuple(model.scene(), model.folder().string()); },
          [](const py::tuple& state) {
            const auto text = state[0].cast<std::string>();
            const auto folder = state[1].cast<std::string>();
            return KernelCall()(
                [&](const Progress& hook) { return parse(text, folder, {}, hook); });
          }));
}

}  // namespace

void bind_models(py::module_& m) {
  bind_points(m);
  py::class_<Model> c(m, "Model",
                      R"(Curves, the surface through them, and what acts on it. Immutable.

Made by skin(), load(), parse() and Session.model(). Models can be copied and pickled.

    >>> model.faces, model.curves
    (['panel'], ['front', 'right', 'back', 'left'])
    >>> model.points.shape[1], model.triangles.shape[1]
    (3, 3)
    >>> model.area > 100 * 100
    True)");
  c.def_property_readonly("name", &Model::name, "Name, which is that of the scene.")
      .def_property_readonly("unit", &Model::unit, "Length unit.")
      .def_property_readonly("faces", &Model::faces, "Names of the faces that have a surface.")
      .def_property_readonly("curves", &Model::curves, "Names of the curves.")
      .def_property_readonly(
          "fit_tolerance", &Model::fit_tolerance,
          "Maximum distance of the fitted curves from the input curves, model units.")
      .def_property_readonly("parameters", &Model::parameters,
                             "Values of the scene's parameters, {name: value}.")
      .def_property_readonly("points", &points_of,
                             "Points of the surface's triangles, n×3 float64, model units. A view.")
      .def_property_readonly("normals", &normals_of,
                             "Exact unit normals x_u × x_v at the points, n×3 float64. A view.")
      .def_property_readonly(
          "curvatures", &curvatures_of,
          R"(Principal curvatures k1 ≥ k2 at the points, n×2 float64, 1/length. A view.

Positive where the surface bends towards the normal. Averaged over the elements around a point, as in
VTK files; nearest() and at() give the curvatures in one element.

    >>> mean, gaussian = model.curvatures.mean(axis=1), model.curvatures.prod(axis=1)
    >>> mean.shape == gaussian.shape == (len(model.points),)
    True)")
      .def_property_readonly(
          "triangles", &triangles_of,
          "Point indices of the triangles, m×3 int32, counter-clockwise. A view.")
      .def_property_readonly("triangle_faces", &triangle_faces_of,
                             "Index into `faces` of each triangle, m int32. A view.")
      .def(
          "curve",
          [](const Model& model, const std::string& name, int count) {
            return array_of_points(model.curve(name, count));
          },
          "name"_a, "count"_a = 97,
          R"(Points along a curve, uniform in its parameter, count×3, model units. Raises InputError.

    >>> model.curve("front", count=3).shape
    (3, 3))")
      .def_property_readonly("report", &report_of,
                             "All measured values, as in report.json (docs/scenes.md).")
      .def_property_readonly(
          "failed_checks",
          [](const Model& model) {
            return KernelCall()([&](const Progress& hook) { return model.failed_checks(hook); });
          },
          "The failed checks, as sentences with the amount; [] if all checks passed.")
      .def(
          "with_values",
          [](const Model& model, const py::dict& values, const py::object& progress) {
            const auto given = values_by_name(values);
            return KernelCall(progress)(
                [&](const Progress& hook) { return model.with_values(given, hook); });
          },
          "values"_a, py::kw_only(), "progress"_a = py::none(),
          R"(The shape of the same curves for other parameter values {name: value}.

Raises the exceptions of load().

    >>> stiff = model.with_values({"alpha": 5}))")
      .def_property_readonly(
          "scene", &Model::scene,
          "The scene of the model as text (docs/scenes.md), with everything that acts on it; "
          "parse(scene) is the same model.")
      .def(
          "save",
          [](const Model& model, const py::object& path, const py::object& progress) {
            const std::string file = path_from(path);
            return KernelCall(progress)(
                [&](const Progress& hook) { return model.save(file, hook); });
          },
          "path"_a, py::kw_only(), "progress"_a = py::none(),
          R"(Writes the surface to a file; the extension selects the format. The file is complete or absent.

.step .iges .brep .glb .stl .obj .ply .off .3mf .vtp .vtu .inp, and .toml for the scene. Returns the failed checks, as sentences.
Raises InputError for another extension, FileError if the file cannot be written.

    >>> model.save("panel.stl")
    [])")
      .def("picture", &picture, "path"_a, py::kw_only(), "width"_a = 1600, "height"_a = 1000,
           "azimuth"_a = -30.0, "elevation"_a = 30.0, "field"_a = "none", "contours"_a = 0,
           "zebra"_a = 0, "mesh"_a = false, "title"_a = "",
           R"(Draws the surface to a PNG file. Without an X server, it starts a virtual one (Xvfb).

Call it on the main thread. `width`, `height`: pixels. `azimuth`, `elevation`: degrees. `field`: none, mean, gauss, faces.
`contours`: number of height contours. `zebra`: number of zebra stripes.)")
      .def("__repr__", &model_repr);
  bind_evaluation(c);
  bind_copies(c);
  bind_making(m);
  bind_fitting(m);
}

}  // namespace batten::python
