// SPDX-License-Identifier: MPL-2.0
// Binds curves: fairing, fitting and fairness measures.
#include "batten/apps/python/conversions.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/curve_files.h"

namespace batten::python {
namespace {

using namespace py::literals;

Points evaluated(const HermiteCurve& curve, const std::vector<double>& at, int order) {
  constexpr int most = 3;
  if (order < 0 || order > most)
    throw InputError("order: found " + std::to_string(order) + ", expected 0 to 3");
  Points points(static_cast<long>(at.size()), 3);
  for (size_t i = 0; i < at.size(); ++i)
    points.row(static_cast<long>(i)) = curve.evaluate(at[i], order);
  return points;
}

py::array sample(const HermiteCurve& curve, int count) {
  if (count < 2) throw InputError("count: found " + std::to_string(count) + ", expected 2 or more");
  std::vector<double> at;
  for (int i = 0; i < count; ++i)
    at.push_back(curve.start() + (curve.end() - curve.start()) * i / (count - 1));
  return array_of(evaluated(curve, at, 0));
}

py::dict fairness_of(const HermiteCurve& curve) {
  const Fairness f = fairness(curve);
  return py::dict("length"_a = f.length, "bending"_a = f.bending, "variation"_a = f.variation,
                  "largest_curvature"_a = f.largest_curvature, "largest_jump"_a = f.largest_jump,
                  "extrema"_a = f.extrema, "inflections"_a = f.inflections);
}

std::optional<std::vector<int>> corners_from(const py::object& given, size_t points) {
  if (given.is_none()) return {};
  return indices_from(given, "corners", static_cast<int>(points));
}

void smoothing(FairOptions& options, const py::object& noise, const py::object& deviation,
               const py::object& wavelength) {
  if (!noise.is_none() + !deviation.is_none() + !wavelength.is_none() > 1)
    throw InputError("noise, deviation, wavelength: found several, expected one at most");
  const auto take = [&](const py::object& given, FairOptions::Smoothing how, double& value,
                        const char* what) {
    if (given.is_none()) return;
    options.smoothing = how;
    value = numbers_from(py::make_tuple(given), what).front();
  };
  take(noise, FairOptions::Smoothing::Noise, options.noise, "noise");
  take(deviation, FairOptions::Smoothing::Deviation, options.deviation, "deviation");
  take(wavelength, FairOptions::Smoothing::Wavelength, options.wavelength, "wavelength");
}

FairCurve fair(const py::object& given, const py::object& noise, const py::object& deviation,
               const py::object& wavelength, const py::object& closed, const py::object& corners,
               double corner_angle, bool fix_ends, bool reject_outliers, const std::string& name) {
  const std::vector<Vec3> points = rows_of(points_from(given, "points"));
  FairOptions options;
  smoothing(options, noise, deviation, wavelength);
  options.closed = optional_bool_from(closed, "closed");
  options.corners = corners_from(corners, points.size());
  options.corner_angle = corner_angle;
  options.fix_ends = fix_ends;
  options.reject_outliers = reject_outliers;
  return KernelCall()([&](const Progress&) { return fair_points(name, points, options); });
}

HermiteCurve fitted(const py::object& given, double tolerance, const py::object& closed,
                    const py::object& corners, double corner_angle, const std::string& name) {
  const std::vector<Vec3> points = rows_of(points_from(given, "points"));
  FitOptions options;
  options.tolerance = tolerance;
  options.closed = optional_bool_from(closed, "closed");
  options.corners = corners_from(corners, points.size());
  options.corner_angle = corner_angle;
  return KernelCall()([&](const Progress&) { return fit_points(name, points, options).curve; });
}

NamedCurve named_curve(const std::string& name, const py::handle& given) {
  NamedCurve line;
  line.name = name;
  if (py::isinstance<HermiteCurve>(given)) {
    line.curve = given.cast<HermiteCurve>();
    constexpr int pieces = 96;
    for (int i = 0; i <= pieces; ++i)
      line.parameters.push_back(line.curve.start() +
                                (line.curve.end() - line.curve.start()) * i / pieces);
  } else if (py::isinstance<FairCurve>(given)) {
    const auto fair = given.cast<FairCurve>();
    line.curve = fair.curve;
    line.parameters = fair.parameters;
  } else {
    const std::vector<Vec3> points = rows_of(points_from(given, "curve '" + name + "'"));
    line.curve = interpolating_spline(name, points);
    line.parameters = line.curve.parameters();
  }
  return line;
}

py::list save_curves(const py::object& path, const py::dict& given, const std::string& unit) {
  const std::string file = path_from(path);
  std::vector<NamedCurve> curves;
  for (const auto& [name, one] : given) curves.push_back(named_curve(py::str(name), one));
  CurveFileOptions options;
  options.unit_in_metres = unit_in_metres(unit);
  const std::vector<std::string> left_out =
      KernelCall()([&](const Progress&) { return write_curves(file, curves, options); });
  return py::cast(left_out);
}

std::string curve_repr(const HermiteCurve& curve) {
  return "<batten.Curve: cubics " + std::to_string(curve.parameters().size() - 1) + ", length " +
         format_number(curve.length()) + (curve.closed() ? ", closed>" : ">");
}

std::string fair_curve_repr(const FairCurve& fair) {
  return "<batten.FairCurve: wavelength " + format_number(fair.wavelength) + ", deviation " +
         format_number(fair.deviation.max) + ", outliers " + std::to_string(fair.outliers.size()) +
         ">";
}

void bind_curve_class(py::module_& m) {
  py::class_<HermiteCurve>(m, "Curve",
                           R"(A C1 piecewise cubic curve with parameter u. Immutable.

Made by fit() and fair(). Lengths are in the unit of the points.

    >>> curve = batten.fit([[0, 0, 0], [1, 1, 0], [2, 0, 0]], tolerance=1e-3)
    >>> curve.evaluate([curve.start, curve.end]).tolist()
    [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]
    >>> u = np.linspace(curve.start, curve.end, 50)
    >>> curve.curvature(u).shape
    (50,))")
      .def_property_readonly("start", &HermiteCurve::start, "First parameter.")
      .def_property_readonly("end", &HermiteCurve::end, "Last parameter.")
      .def_property_readonly("closed", &HermiteCurve::closed, "Whether the curve is closed.")
      .def_property_readonly("length", &HermiteCurve::length, "Arc length, model units.")
      .def_property_readonly(
          "parameters",
          [](const HermiteCurve& curve) {
            return array_of(std::vector<double>(curve.parameters()));
          },
          "Parameters of the nodes, n float64.")
      .def(
          "evaluate",
          [](const HermiteCurve& curve, const py::object& u, int order) {
            return array_of(evaluated(curve, numbers_from(u, "u"), order));
          },
          "u"_a, py::kw_only(), "order"_a = 0,
          "Positions (order 0) or derivatives of order 1 to 3 with respect to u at n parameters, "
          "n×3.")
      .def(
          "curvature",
          [](const HermiteCurve& curve, const py::object& u) {
            std::vector<double> values;
            for (const double at : numbers_from(u, "u")) values.push_back(curve.curvature(at));
            return array_of(std::move(values));
          },
          "u"_a, "Curvature at n parameters, 1/length.")
      .def("sample", &sample, "count"_a = 97, "Points uniform in u, count×3, model units.")
      .def(
          "fairness", &fairness_of,
          R"(Fairness measures: length, bending ∫κ²ds (1/length), variation ∫(dκ/ds)²ds (1/length³),
largest_curvature, largest_jump (curvature jump, 1/length), and the numbers of curvature extrema and
inflections.)")
      .def("__repr__", &curve_repr);
}

}  // namespace

void bind_curves(py::module_& m) {
  bind_curve_class(m);
  py::class_<FairCurve>(m, "FairCurve", R"(A fair curve and its statistics: fair().

    >>> x = np.linspace(0, 10, 60)
    >>> fair = batten.fair(np.c_[x, np.sin(x), 0 * x], deviation=0.01)
    >>> fair.curve.fairness()["inflections"], fair.outliers.tolist()
    (3, []))")
      .def_readonly("curve", &FairCurve::curve, "The Curve.")
      .def_property_readonly(
          "points",
          [](const FairCurve& fair) { return array_of(evaluated(fair.curve, fair.parameters, 0)); },
          "The curve points nearest to the given points, n×3, model units.")
      .def_property_readonly(
          "parameters",
          [](const FairCurve& fair) { return array_of(std::vector<double>(fair.parameters)); },
          "Parameters of these curve points, n float64.")
      .def_property_readonly(
          "outliers",
          [](const FairCurve& fair) { return array_of(std::vector<int>(fair.outliers)); },
          "Indices of the points that were rejected as outliers, int32.")
      .def_property_readonly(
          "deviation", [](const FairCurve& fair) { return fair.deviation.max; },
          "Largest distance of the other points from the curve, model units.")
      .def_property_readonly(
          "rms", [](const FairCurve& fair) { return fair.deviation.rms; },
          "Root mean square of these distances, model units.")
      .def_readonly("wavelength", &FairCurve::wavelength,
                    "Wavelength whose amplitude is halved, model units; 0: no smoothing.")
      .def_readonly("noise", &FairCurve::noise,
                    "Estimated noise perpendicular to the curve, model units.")
      .def_readonly("converged", &FairCurve::converged, "Whether the parameters converged.")
      .def("__repr__", &fair_curve_repr);
  m.def("fair", &fair, "points"_a, py::kw_only(), "noise"_a = py::none(),
        "deviation"_a = py::none(), "wavelength"_a = py::none(), "closed"_a = py::none(),
        "corners"_a = py::none(), "corner_angle"_a = 50.0, "fix_ends"_a = false,
        "reject_outliers"_a = true, "name"_a = "curve",
        R"(The smoothing spline of points n×3 in their order.

The amount of smoothing is determined by cross-validation, or by one of `noise` (RMS distance),
`deviation` (maximum distance) and `wavelength`, model units. `corners`: indices of points, or None:
those where the polyline turns by more than `corner_angle` degrees. `fix_ends`: interpolate the end
points. Raises InputError, NoSolutionError.
Reference: min Σ|X(u_i) - p_i|² + ρ∫(1-b)(ra)⁶|X_uuu|² + b(ra)⁴|X_uu|² du (docs/theory/curves.md).

    >>> x = np.linspace(0, 10, 60)
    >>> wavy = np.c_[x, np.sin(x) + 0.01 * np.sin(40 * x), 0 * x]
    >>> smooth = batten.fair(wavy, wavelength=2)
    >>> smooth.deviation < 0.05
    True)");
  m.def(
      "write_curves", &save_curves, "path"_a, "curves"_a, py::kw_only(), "unit"_a = "mm",
      R"(Writes {name: points n×3, Curve or FairCurve}; the extension selects the format: .csv .obj .curves .vtp .dxf .svg .step .iges.

Points are interpolated by a curve that is C2 between corners. Returns sentences about curves that
were not written. Raises InputError, FileError.

    >>> batten.write_curves("rim.dxf", rim)
    [])");
  m.def(
      "fit", &fitted, "points"_a, "tolerance"_a, py::kw_only(), "closed"_a = py::none(),
      "corners"_a = py::none(), "corner_angle"_a = 50.0, "name"_a = "curve",
      R"(Approximates points n×3 in their order by a Curve of few cubics within `tolerance` (model units).

Raises InputError. Reference: least squares with parameters of the nearest points (docs/theory/curves.md).

    >>> angle = np.linspace(0, np.pi, 200)
    >>> arc = batten.fit(np.c_[np.cos(angle), np.sin(angle), 0 * angle], tolerance=1e-3)
    >>> abs(arc.length - np.pi) < 1e-3
    True)");
}

}  // namespace batten::python
