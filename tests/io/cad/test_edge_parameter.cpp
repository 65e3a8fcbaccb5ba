// SPDX-License-Identifier: MPL-2.0
// The parametrisation of shared edges, as seen by readers of the file.
#include "batten/io/step/step_check.h"

#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <GeomAPI_PointsToBSplineSurface.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>

#include <algorithm>

#include "batten/io/step/step.h"
#include "batten/tests/io/cad/bop_faults.h"
#include "batten/tests/io/cad/step_models.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using namespace batten_test;

namespace {

int faults_of_step(const BuiltModel& made, const std::string& name, double tolerance) {
  StepFaceOptions options;
  options.tolerance = tolerance;
  const auto path = scratch("edge_parameter") / (name + ".step");
  const StepReport report = write_step_faces(path, made.model.skinned(), 0.001, options);
  CHECK(report.valid);
  // Otherwise the test has no effect.
  CHECK(report.max_gap > 1e-5);
  return batten_test::faults(path);
}

/// A wavy edge above a plane, with the same range for the curve and its pcurve.
struct WavyEdge {
  TopoDS_Edge edge;
  TopoDS_Face face;
};
WavyEdge wavy_edge(const std::vector<double>& heights) {
  const int n = static_cast<int>(heights.size());
  TColgp_Array1OfPnt poles(1, n);
  TColgp_Array1OfPnt2d flat(1, n);
  for (int i = 1; i <= n; ++i) {
    poles(i) = {10.0 * (i - 1) / (n - 1), 5.0 + (i % 3), heights[static_cast<size_t>(i - 1)]};
    flat(i) = {poles(i).X(), poles(i).Y()};
  }
  TColStd_Array1OfReal knots(1, n - 2);
  TColStd_Array1OfInteger times(1, n - 2);
  times.Init(1);
  times(1) = times(n - 2) = 4;
  for (int i = 1; i <= n - 2; ++i) knots(i) = 2 + 0.5 * i * i;
  TColgp_Array2OfPnt corners(1, 2, 1, 2);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) corners(i + 1, j + 1) = {20.0 * i, 20.0 * j, 0};
  TColStd_Array1OfReal ends(1, 2);
  TColStd_Array1OfInteger twice(1, 2);
  ends(1) = 0;
  ends(2) = 20;
  twice.Init(2);
  WavyEdge made;
  BRep_Builder builder;
  builder.MakeFace(made.face, new Geom_BSplineSurface(corners, ends, ends, twice, twice, 1, 1),
                   1e-7);
  builder.MakeEdge(made.edge, new Geom_BSplineCurve(poles, knots, times, 3), 1e-7);
  builder.UpdateEdge(made.edge, new Geom2d_BSplineCurve(flat, knots, times, 3), made.face, 1e-7);
  return made;
}

}  // namespace

TEST_CASE("the largest gap lies at a sample point of the reader, and no curve changes its shape",
          "[io][step]") {
  const WavyEdge made = wavy_edge({0, 0.01, -0.02, 0.005, 0.03, -0.01, 0.002, 0});
  double first, last;
  const Handle(Geom_Curve) before = BRep_Tool::Curve(made.edge, first, last);
  reparametrize_for_gap_check(made.edge, 1e-7);
  double from, to;
  const Handle(Geom_Curve) after = BRep_Tool::Curve(made.edge, from, to);
  CHECK(from == first);
  CHECK(to == last);
  const double w = parameter_weight(*after);
  CHECK(w != Approx(1).margin(0.01));

  constexpr int n = 22'000;
  double highest = 0, seen = 0, moved = 0;
  const Handle(Geom2d_Curve) pcurve = BRep_Tool::CurveOnSurface(made.edge, made.face, from, to);
  for (int i = 0; i <= n; ++i) {
    const double share = double(i) / n;
    highest = std::max(highest, std::abs(after->Value(first + share * (last - first)).Z()));
    if (i % 1000 == 0)
      seen = std::max(seen, std::abs(after->Value(first + share * (last - first)).Z()));
    const double t = first + share * (last - first),
                 s = first + reparametrized_fraction(share, w) * (last - first);
    moved = std::max(moved, before->Value(t).Distance(after->Value(s)));
    const gp_Pnt p = before->Value(t);
    moved = std::max(moved, pcurve->Value(s).Distance({p.X(), p.Y()}));
  }
  CHECK(moved < 1e-13 * 20);
  CHECK(seen > (1 - 1e-9) * highest);
  CHECK(BRep_Tool::Tolerance(made.edge) >= highest);
}

TEST_CASE("edges on their faces keep their parameter", "[io][step]") {
  const WavyEdge made = wavy_edge({0, 1e-9, 0, 0, 2e-9, 0, 0, 0});
  reparametrize_for_gap_check(made.edge, 1e-7);
  double first, last;
  CHECK(parameter_weight(*BRep_Tool::Curve(made.edge, first, last)) == 1);
}

TEST_CASE("files whose faces share edges pass OpenCASCADE's check before boolean operations",
          "[io][step]") {
  CHECK(faults_of_step(build_model(octants()), "ball", 1e-3) == 0);
  const RegionSearchOptions regions = region_specs({{{"low"}, {"high"}}, {{"low"}}, {{"high"}}});
  CHECK(
      faults_of_step(build_model({oval_line("low", 0, 0), oval_line("high", 15, 1.0)}, regions, 4),
                     "oval", 0.01) == 0);
  CHECK(faults_of_step(mouse(8, false), "mouse", 0.015) == 0);
}
