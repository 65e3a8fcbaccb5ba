// SPDX-License-Identifier: MPL-2.0
// One trimmed B-spline face represents the region within the tolerance, verified with other
// readers.
#include "batten/io/step/step.h"

#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepClass_FaceClassifier.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Geom_BSplineSurface.hxx>
#include <STEPControl_Reader.hxx>
#include <ShapeAnalysis_Edge.hxx>
#include <ShapeAnalysis_Wire.hxx>
#include <ShapeFix_Shape.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <fstream>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/fem/curves/bicubic_patch.h"
#include "batten/fem/curves/bspline.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;
namespace fs = std::filesystem;

namespace {

using JetFormula = std::function<SurfaceJet(const Vec2&)>;

SurfaceJet wavy(const Vec2& p) {
  const double u = p.x(), v = p.y();
  SurfaceJet j{};
  j.x = {u + 0.1 * std::sin(2 * v), v + 0.1 * u * u, 0.2 * std::sin(3 * u) * std::cos(2 * v)};
  j.x_u = {1, 0.2 * u, 0.6 * std::cos(3 * u) * std::cos(2 * v)};
  j.x_v = {0.2 * std::cos(2 * v), 1, -0.4 * std::sin(3 * u) * std::sin(2 * v)};
  return j;
}

SurfaceJet paraboloid(const Vec2& p) {
  SurfaceJet j{};
  j.x = {p.x(), p.y(), 0.5 * p.squaredNorm()};
  j.x_u = {1, 0, p.x()};
  j.x_v = {0, 1, p.y()};
  return j;
}

SurfaceJet cylinder(const Vec2& p) {
  SurfaceJet j{};
  j.x = {std::sin(p.x()), p.y(), std::cos(p.x())};
  j.x_u = {std::cos(p.x()), 0, -std::sin(p.x())};
  j.x_v = {0, 1, 0};
  return j;
}

JetFormula placed(const JetFormula& f, double scale, const Vec3& at = Vec3::Zero()) {
  return [=](const Vec2& p) {
    SurfaceJet j = f(p);
    j.x = scale * j.x + at;
    j.x_u *= scale;
    j.x_v *= scale;
    return j;
  };
}

/// X(t) = x(c(t)) with the nodes of c.
HermiteCurve lifted(const HermiteCurve& pcurve, const JetFormula& f) {
  Points dofs(pcurve.dofs().rows(), 3);
  for (int i = 0; i < pcurve.node_count(); ++i) {
    const SurfaceJet j = f(pcurve.position(i).head<2>());
    const Vec3 d = pcurve.slope_out(i);
    dofs.row(pcurve.mesh().position_dof(i)) = j.x;
    dofs.row(pcurve.mesh().slope_out(i)) = d.x() * j.x_u + d.y() * j.x_v;
  }
  return {pcurve.mesh(), dofs};
}

double size_of(const SkinnedRegion& region) {
  Eigen::AlignedBox3d box;
  for (const auto& loop : region.boundary)
    for (const BoundarySegment& piece : loop) {
      const HermiteCurve curve = boundary_curve(region, piece);
      for (int i = 0; i < curve.node_count(); ++i) box.extend(curve.position(i));
    }
  return box.diagonal().norm();
}

const Vec2 hole_at(0.25, -0.1);

/// A disc of radius 0.5 with an eccentric hole, over squares that are not aligned with either.
SkinnedRegion disc(const JetFormula& f, int n, int segments = 48,
                   TriangleElement kind = TriangleElement::HCT) {
  const HermiteCurve outline = circle({0, 0}, 0.5, segments),
                     hole = circle(hole_at, 0.12, segments / 2, true);
  const DomainLoops loops({{outline}, {hole}});
  const EmbeddedGrid grid(squares({-0.503, -0.507}, 1.02 / n, n, n), loops);
  const Surface full = interpolated(grid.mesh, kind, f);
  SkinnedRegion region{"disc", Surface(grid.mesh, kind, full.dofs(), grid.trim), {}, 1, {}, {}};
  region.embedded.push_back({{}, lifted(outline, f), outline, {}});
  region.embedded.push_back({{}, lifted(hole, f), hole, {}});
  region.boundary = {{{BoundarySegment::Kind::Embedded, 0, false}},
                     {{BoundarySegment::Kind::Embedded, 1, false}}};
  region.size = size_of(region);
  return region;
}

/// The curve of the surface along a chain of mesh edges.
EdgeAlignedLine edge_aligned_line(const Surface& surface, const std::vector<int>& vertices) {
  const ParametricMesh& mesh = surface.mesh();
  EdgeAlignedLine aligned_line;
  aligned_line.vertices = vertices;
  const int n = static_cast<int>(vertices.size());
  Points x(n, 3), d(n, 3);
  Vec2 along = Vec2::Zero();
  for (int i = 0; i + 1 < n; ++i) {
    const int e = mesh.edge_between(vertices[i], vertices[i + 1]);
    aligned_line.edges.push_back(e);
    const Vec2 step = (mesh.edges()[e].low == vertices[i] ? 1 : -1) * mesh.edge_tangent(e);
    if (i == 0) aligned_line.parameters.push_back(0);
    aligned_line.parameters.push_back(aligned_line.parameters.back() + mesh.edge_length(e));
    along = step;
  }
  for (int i = 0; i < n; ++i) {
    const auto row = [&](int k) {
      return surface.dofs().row(surface.dof_map().vertex(vertices[i], k));
    };
    x.row(i) = row(0);
    d.row(i) = along.x() * row(1) + along.y() * row(2);
  }
  aligned_line.fitted = HermiteCurve(aligned_line.parameters, x, d);
  return aligned_line;
}

/// The unit square with its four sides as mesh-aligned curves, one of them against the direction of
/// the loop.
SkinnedRegion square(const JetFormula& f, int n) {
  const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(n, 1));
  SkinnedRegion region{"square", interpolated(mesh, TriangleElement::HCT, f), {}, 1, {}, {}};
  std::vector<int> side[4];
  for (int i = 0; i <= n; ++i) {
    side[0].push_back(i);
    side[1].push_back(i * (n + 1) + n);
    side[2].push_back(n * (n + 1) + i);  // against the loop
    side[3].push_back((n - i) * (n + 1));
  }
  region.boundary.resize(1);
  for (int s = 0; s < 4; ++s) {
    region.edge_aligned.push_back(edge_aligned_line(region.surface, side[s]));
    region.boundary[0].push_back({BoundarySegment::Kind::EdgeAligned, s, s == 2});
  }
  region.size = size_of(region);
  return region;
}

/// ∫ |x_u × x_v| inside the loops.
double area_of(const SkinnedRegion& region) {
  double area = 0;
  const ParametricMesh& mesh = region.surface.mesh();
  const Trim trim(mesh, boundary_loops(region));
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TriangleRule rule = trim.rule(t, 6);
    for (long k = 0; k < rule.weights.size(); ++k)
      area += rule.weights[k] * mesh.shape(t).area *
              region.surface.jet({t, rule.L.row(k).transpose()}).area_vector().norm();
  }
  return area;
}

/// The single face of a file, in the numbers of the file.
TopoDS_Face face_of(const fs::path& file, const char* unit = "MM") {
  OccSettings occ;
  occ.set_unit(unit);
  STEPControl_Reader reader;
  REQUIRE(reader.ReadFile(file.string().c_str()) == IFSelect_RetDone);
  reader.TransferRoots();
  TopExp_Explorer faces(reader.OneShape(), TopAbs_FACE);
  REQUIRE(faces.More());
  const TopoDS_Face face = TopoDS::Face(faces.Current());
  faces.Next();
  REQUIRE(!faces.More());
  return face;
}

/// Defects of a face according to OpenCASCADE's analysers and repair tools.
std::string validity_errors(const TopoDS_Face& face, double tolerance) {
  std::string text;
  if (!BRepCheck_Analyzer(face).IsValid()) text += "not valid; ";
  for (TopExp_Explorer it(face, TopAbs_WIRE); it.More(); it.Next()) {
    ShapeAnalysis_Wire wire(TopoDS::Wire(it.Current()), face, tolerance);
    if (wire.CheckOrder()) text += "order; ";
    if (wire.CheckConnected()) text += "not connected; ";
    if (wire.CheckSmall(tolerance)) text += "small edges; ";
    if (wire.CheckEdgeCurves()) text += "curves of edges; ";
    if (wire.CheckDegenerated()) text += "degenerated; ";
    if (wire.CheckClosed()) text += "open; ";
    if (wire.CheckSelfIntersection()) text += "self-intersection; ";
    if (wire.CheckLacking()) text += "lacking; ";
  }
  for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
    ShapeAnalysis_Edge check;
    double deviation;
    if (check.CheckSameParameter(TopoDS::Edge(it.Current()), face, deviation))
      text += "parameters of an edge; ";
  }
  ShapeFix_Shape fix(face);
  fix.SetPrecision(tolerance);
  if (fix.Perform()) text += "repaired; ";
  return text;
}

/// The largest distance between edges of a face and the face, at many parameters.
double off_face(const TopoDS_Face& face) {
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  double most = 0;
  for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
    double first, last;
    const TopoDS_Edge& edge = TopoDS::Edge(it.Current());
    const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
    const Handle(Geom2d_Curve) line = BRep_Tool::CurveOnSurface(edge, face, first, last);
    for (int i = 0; i <= 2000; ++i) {
      const double t = first + (last - first) * i / 2000;
      const gp_Pnt2d uv = line->Value(t);
      most = std::max(most, curve->Value(t).Distance(surface->Value(uv.X(), uv.Y())));
    }
  }
  return most;
}

/// Outward normal of a face at (u, v).
Vec3 normal_of(const TopoDS_Face& face, const Vec2& uv) {
  gp_Pnt p;
  gp_Vec du, dv;
  BRep_Tool::Surface(face)->D1(uv.x(), uv.y(), p, du, dv);
  const gp_Vec n = du.Crossed(dv).Normalized() * (face.Orientation() == TopAbs_REVERSED ? -1 : 1);
  return {n.X(), n.Y(), n.Z()};
}

TopAbs_State side_of(const TopoDS_Face& face, const Vec2& uv) {
  return BRepClass_FaceClassifier(face, gp_Pnt2d(uv.x(), uv.y()), 1e-9).State();
}

int wires_of(const TopoDS_Face& face) {
  int count = 0;
  for (TopExp_Explorer it(face, TopAbs_WIRE); it.More(); it.Next()) ++count;
  return count;
}

/// All checks of a file within its tolerance.
void expect_face(const SkinnedRegion& region, const StepReport& r, const char* unit = "MM") {
  CHECK(r.reached);
  CHECK(*r.max_deviation <= r.tolerance);
  CHECK(*r.max_deviation > 0);
  CHECK(r.valid);
  CHECK(r.faces == 1);
  int pieces = 0;
  for (const auto& loop : region.boundary) pieces += static_cast<int>(loop.size());
  CHECK(r.edges == pieces);
  CHECK(r.free_edges == pieces);
  const double size = region.size;
  double far = 0;
  for (int v = 0; v < region.surface.mesh().vertex_count(); ++v)
    far = std::max(far, region.surface.dofs().row(region.surface.dof_map().vertex(v)).norm());
  // The edges are on the boundary of the face: readers use them as its curves.
  const double coincidence = 1e-7 * (unit == std::string("M") ? 1e-3 : 1) + 2e-15 * far;
  CHECK(r.edge_deviation <= 1.001 * *r.max_deviation);
  CHECK(r.max_gap <= coincidence);
  CHECK(off_face(face_of(r.file, unit)) <= coincidence);
  CHECK(r.bytes == fs::file_size(r.file));

  const TopoDS_Face face = face_of(r.file, unit);
  CHECK(validity_errors(face, coincidence) == "");
  CHECK(wires_of(face) == static_cast<int>(region.boundary.size()));

  // Measured independently of the report: points, sides, normals, area.
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  const TriangleLocator locator(region.surface.mesh());
  const DomainLoops loops = boundary_loops(region);
  Random random(5);
  double deviation = 0;
  int inside = 0, disagree = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec2 uv(random.between(loops.low().x(), loops.high().x()),
                  random.between(loops.low().y(), loops.high().y()));
    const bool in = loops.contains(uv);
    disagree += in != (side_of(face, uv) == TopAbs_IN);
    if (!in) continue;
    ++inside;
    const SurfaceJet jet = region.surface.jet(locator.locate(uv));
    const gp_Pnt p = surface->Value(uv.x(), uv.y());
    deviation = std::max(deviation, (Vec3(p.X(), p.Y(), p.Z()) - jet.x).norm());
    if (k % 50 == 0) CHECK(normal_of(face, uv).dot(jet.normal()) > 0.999);
  }
  CHECK(inside > 500);
  CHECK(disagree <= 1);  // on the curve
  CHECK(deviation <= r.tolerance);
  CHECK(deviation <= 1.02 * *r.max_deviation + 1e-15 * far);
  // Effect of the tolerance on the area: along the boundary, and its square inside.
  CHECK(r.area == Approx(area_of(region)).epsilon(20 * r.tolerance / size + 1e-6));
}

}  // namespace

TEST_CASE("B-splines of an axis sum to one, are C2 and repeat where they close", "[io][step]") {
  for (const bool periodic : {false, true}) {
    const SplineAxis axis({0, 0.5, 0.7, 1.5, 2, 2.25}, periodic);
    CAPTURE(periodic);
    CHECK(axis.functions() == (periodic ? 5 : 8));
    for (int k = 0; k < axis.intervals(); ++k) {
      CHECK(axis.basis(k, 0.3).sum() == Approx(1).epsilon(1e-14));
      CHECK(axis.basis(k, 0.3).minCoeff() >= 0);
      if (k + 1 == axis.intervals() && !periodic) continue;
      const int next = (k + 1) % axis.intervals();
      for (int d = 0; d <= 2; ++d) {
        const Eigen::Vector4d a = axis.basis(k, 1, d) / std::pow(axis.length(k), d),
                              b = axis.basis(next, 0, d) / std::pow(axis.length(next), d);
        CHECK(std::abs(a[0]) < 1e-12);
        CHECK((a.tail<3>() - b.head<3>()).norm() < 1e-11);
      }
    }
    CHECK(axis.interval(0.7) == 2);
    CHECK(axis.interval(2.25) == 4);
    CHECK(axis.interval(2.25 + 0.6) == (periodic ? 1 : 4));
  }
}

TEST_CASE("A fitted patch of few poles is a bicubic surface exactly", "[io][step]") {
  const auto x = [](const Vec2& p) {
    return Vec3(p.x() + p.y() * p.y() * p.y(), p.y() - p.x() * p.x(),
                p.x() * p.x() * p.x() * p.y());
  };
  const auto rim = [](const BoundaryStep& longest) {
    std::vector<Vec2> points;
    for (double t = 0; t < 2 * pi; t += longest(points.back()).minCoeff())
      points.push_back(0.9 * Vec2(std::cos(t), std::sin(t)));
    return points;
  };
  const PatchTarget target{
      [](const Vec2& p) { return p.norm() < 0.9; }, x, rim, {-1, -1}, {1, 1}, false};
  const PatchFit fit = fit_bicubic_patch(target, {1e-5});
  CHECK(fit.reached);
  CHECK(fit.deviation <= 1e-5);
  CHECK(fit.patch.poles.rows() <= 11 * 11);
  CHECK((fit.patch.position({0.3, -0.4}) - x({0.3, -0.4})).norm() <= 1e-5);
}

TEST_CASE("A disc with a hole is one face within each tolerance", "[io][step]") {
  const fs::path folder = scratch("step_face");
  const SkinnedRegion region = disc(placed(wavy, 100), 32);
  int poles = 0;
  for (const double relative : {1e-3, 1e-4, 1e-5}) {
    CAPTURE(relative);
    const StepReport r = write_step_faces(folder / "disc.step", {&region}, 1e-3,
                                          {.tolerance = relative * region.size});
    expect_face(region, r);
    const TopoDS_Face face = face_of(r.file);
    CHECK(side_of(face, hole_at) == TopAbs_OUT);
    CHECK(side_of(face, hole_at + Vec2(0.13, 0)) == TopAbs_IN);
    const int now = r.patches[0].poles_u * r.patches[0].poles_v;
    CHECK(now > poles);
    CHECK(now < 3000);
    poles = now;
  }
}

TEST_CASE("Outside of the trim the face is calm", "[io][step]") {
  // Viewers use the bounding box of the poles as that of the part.
  const JetFormula ripples = [](const Vec2& p) {
    SurfaceJet j = wavy(p);
    const double phase = 18 * p.x() + 6 * p.y();
    j.x.z() += 0.03 * std::sin(phase);
    j.x_u.z() += 0.54 * std::cos(phase);
    j.x_v.z() += 0.18 * std::cos(phase);
    return j;
  };
  const SkinnedRegion region = disc(ripples, 36, 64);
  for (const double relative : {1e-3, 1e-4}) {
    CAPTURE(relative);
    const StepReport r = write_step_faces(scratch("step_face") / "disc.step", {&region}, 1e-3,
                                          {.tolerance = relative * region.size});
    CHECK(r.reached);
    const TopoDS_Face face = face_of(r.file);
    const auto spline = Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(face));
    REQUIRE(!spline.IsNull());
    const gp_Pnt middle = spline->Value(0, 0);
    double farthest = 0;
    for (int i = 1; i <= spline->NbUPoles(); ++i)
      for (int j = 1; j <= spline->NbVPoles(); ++j)
        farthest = std::max(farthest, spline->Pole(i, j).Distance(middle));
    CHECK(farthest < 0.8 * region.size);
  }
}

TEST_CASE("A square of four runs is one face with four edges", "[io][step]") {
  const fs::path folder = scratch("step_face");
  const struct {
    const char* name;
    JetFormula f;
  } shapes[] = {{"paraboloid", paraboloid}, {"cylinder", cylinder}, {"wavy", wavy}};
  for (const auto& shape : shapes) {
    CAPTURE(shape.name);
    const SkinnedRegion region = square(placed(shape.f, 2), 12);
    const StepReport r =
        write_step_faces(folder / "square.step", {&region}, 1, {.tolerance = 1e-4 * region.size});
    expect_face(region, r, "M");
    CHECK(r.line_gap <= 1e-13);
  }
}

TEST_CASE("A calm face of few triangles has few poles, more triangles are looked at more closely",
          "[io][step]") {
  const auto poles = [](const SkinnedRegion& region) {
    const StepReport r = write_step_faces(scratch("step_face") / "calm.step", {&region}, 1,
                                          {.tolerance = 1e-3 * region.size});
    CHECK(r.reached);
    CHECK(*r.max_deviation <= 1e-3 * region.size);
    return r.patches[0].poles_u * r.patches[0].poles_v;
  };
  CHECK(poles(square(paraboloid, 3)) == 5 * 5);
  // A ripple with a wavelength of three triangles: between the samples of 2 × 2 cells.
  const JetFormula ripple = [](const Vec2& p) {
    const double k = 8 * pi, c = std::cos(k * p.x()) * 0.02 * k;
    SurfaceJet j{};
    j.x = {p.x(), p.y(), 0.02 * std::sin(k * p.x())};
    j.x_u = {1, 0, c};
    j.x_v = {0, 1, 0};
    return j;
  };
  CHECK(poles(square(ripple, 24)) > 100);
}

TEST_CASE("A file claims no more than readers see, who would compute its borders anew",
          "[io][step]") {
  const fs::path file = scratch("step_face") / "claim.step";
  const auto claimed = [&](double scale) {
    const SkinnedRegion region = square(placed(paraboloid, scale), 4);
    write_step_faces(file, {&region}, 1, {.tolerance = 1e-8 * scale});
    std::ifstream in(file);
    std::string all{std::istreambuf_iterator<char>(in), {}};
    const std::string entity = "LENGTH_MEASURE(";
    return std::stod(all.substr(all.find(entity) + entity.size()));
  };
  CHECK(claimed(1) >= 1e-7);
  CHECK(claimed(1e-3) <= 2e-8);  // a tiny model: 1e-5 of its size
}

TEST_CASE("Far away, in metres and on Z12 elements the face is the same", "[io][step]") {
  const fs::path folder = scratch("step_face");
  const Vec3 far(1e7, -2e7, 5e6);
  const SkinnedRegion near = disc(wavy, 16), away = disc(placed(wavy, 1, far), 16),
                      large = disc(placed(wavy, 1000), 16),
                      rational = disc(wavy, 16, 48, TriangleElement::Z12);
  const auto write = [&](const SkinnedRegion& region, double unit) {
    return write_step_faces(folder / "disc.step", {&region}, unit,
                            {.tolerance = 1e-5 * region.size});
  };
  const StepReport a = write(near, 1);
  expect_face(near, a, "M");
  const StepReport b = write(away, 1);
  expect_face(away, b, "M");
  CHECK(*b.max_deviation == Approx(*a.max_deviation).epsilon(1e-3));
  CHECK(b.patches[0].poles_u == a.patches[0].poles_u);
  CHECK(b.patches[0].poles_v == a.patches[0].poles_v);
  const StepReport c = write(large, 1e-3);
  expect_face(large, c);
  CHECK(*c.max_deviation == Approx(1000 * *a.max_deviation).epsilon(1e-6));
  CHECK(c.area == Approx(1e6 * a.area).epsilon(1e-6));
  // The same file with its real size: read in metres it has the numbers of `near`.
  const TopoDS_Face face = face_of(c.file, "M");
  const gp_Pnt p = BRep_Tool::Surface(face)->Value(0.1, 0.2);
  CHECK((Vec3(p.X(), p.Y(), p.Z()) - wavy({0.1, 0.2}).x).norm() <= 2e-4);
  expect_face(rational, write(rational, 1), "M");
}

TEST_CASE("The nearest points of surface and file are within the deviation", "[io][step]") {
  const SkinnedRegion region = disc(wavy, 12);
  const StepReport r = write_step_faces(scratch("step_face") / "disc.step", {&region}, 1,
                                        {.tolerance = 1e-3 * region.size});
  const TopoDS_Face face = face_of(r.file, "M");
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  const TriangleLocator locator(region.surface.mesh());
  const DomainLoops loops = boundary_loops(region);
  Random random(3);
  for (int k = 0; k < 40; ++k) {
    const Vec2 uv(random.between(-0.5, 0.5), random.between(-0.5, 0.5));
    if (!loops.contains(uv)) continue;
    const gp_Pnt p = surface->Value(uv.x(), uv.y());
    CHECK(region.surface.closest_point({p.X(), p.Y(), p.Z()}).distance <= 1.001 * *r.max_deviation);
    const Vec3 x = region.surface.position(locator.locate(uv));
    BRepExtrema_DistShapeShape nearest(BRepBuilderAPI_MakeVertex(gp_Pnt(x.x(), x.y(), x.z())),
                                       face);
    CHECK(nearest.Value() <= 1.001 * *r.max_deviation);
  }
}

TEST_CASE("Where a surface deviates from its curve, the edge stays on the face", "[io][step]") {
  SkinnedRegion region = disc(wavy, 16);
  Points dofs = region.embedded[0].fitted.dofs();
  const HermiteCurve& curve = region.embedded[0].fitted;
  for (int i = 0; i < curve.node_count(); ++i) dofs(curve.mesh().position_dof(i), 2) += 3e-4;
  region.embedded[0].fitted = HermiteCurve(curve.mesh(), dofs);
  const StepReport r =
      write_step_faces(scratch("step_face") / "disc.step", {&region}, 1e-3, {.tolerance = 1e-5});
  CHECK(r.reached);
  CHECK(r.valid);
  CHECK(*r.max_deviation <= 1e-5);
  CHECK(r.line_gap == Approx(3e-4).epsilon(0.02));
  CHECK(r.max_gap <= 1e-7);
  CHECK(r.edge_deviation <= 1e-5);
  CHECK(validity_errors(face_of(r.file), 1e-7) == "");
  CHECK(off_face(face_of(r.file)) <= 1e-7);
}

TEST_CASE("A tolerance that cannot be reached is reported and the file is there", "[io][step]") {
  const SkinnedRegion region = disc(wavy, 12);
  const fs::path file = scratch("step_face") / "disc.step";
  const StepReport r = write_step_faces(
      file, {&region}, 1, {.tolerance = 1e-7, .max_poles = 24, .max_poles_total = 400});
  CHECK(!r.reached);
  CHECK(*r.max_deviation > 1e-7);
  CHECK(*r.max_deviation < 1e-3);
  CHECK(r.valid);
  CHECK(r.patches[0].poles_u <= 24);
  CHECK(r.patches[0].poles_v <= 24);
  CHECK(r.patches[0].poles_u * r.patches[0].poles_v <= 400);
  // Few triangles need few poles, whatever the tolerance.
  const SkinnedRegion coarse = disc(wavy, 4);
  const StepReport few = write_step_faces(file.parent_path() / "few.step", {&coarse}, 1,
                                          {.tolerance = 1e-9, .max_poles_per_triangle = 1});
  CHECK(!few.reached);
  CHECK(few.patches[0].poles_u * few.patches[0].poles_v <= 6'000);
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face_of(file, "M"));
  const gp_Pnt p = surface->Value(0.1, 0.2);
  CHECK((Vec3(p.X(), p.Y(), p.Z()) - wavy({0.1, 0.2}).x).norm() <= *r.max_deviation + 1e-5);
}

TEST_CASE("Corners of a closed boundary curve are vertices of the face", "[io][step]") {
  // A lens: one closed curve with two corners in space and in (u, v).
  const double a = 0.35;
  const auto at = [&](double t, bool before) {  // two arcs, t in [0, 1] and [1, 2]
    const double s = (before ? t <= 1 : t < 1) ? 1 : -1, w = s > 0 ? t : t - 1;
    return std::pair{Vec3(s * a * (2 * w - 1), -s * a * 2 * w * (1 - w), 0),
                     Vec3(s * 2 * a, -s * a * 2 * (1 - 2 * w), 0)};
  };
  std::vector<double> u;
  for (int i = 0; i <= 8; ++i) u.push_back(i / 4.0);
  const CurveMesh mesh(u, true, {0, 4});
  Points dofs(mesh.dof_count(), 3), lift(mesh.dof_count(), 3);
  for (int i = 0; i < 8; ++i) {
    const double t_in = i == 0 ? 2 : u[i];
    const Vec3 p = at(u[i], false).first, out = at(u[i], false).second, in = at(t_in, true).second;
    const SurfaceJet j = wavy(p.head<2>());
    dofs.row(mesh.position_dof(i)) = p;
    lift.row(mesh.position_dof(i)) = j.x;
    dofs.row(mesh.slope_in(i)) = in;
    lift.row(mesh.slope_in(i)) = in.x() * j.x_u + in.y() * j.x_v;
    dofs.row(mesh.slope_out(i)) = out;
    lift.row(mesh.slope_out(i)) = out.x() * j.x_u + out.y() * j.x_v;
  }
  const HermiteCurve outline(mesh, dofs), space(mesh, lift);
  const EmbeddedGrid grid(squares({-0.5, -0.5}, 1.0 / 24, 24, 24), DomainLoops({{outline}}));
  SkinnedRegion region{
      "lens",
      Surface(grid.mesh, TriangleElement::HCT,
              interpolated(grid.mesh, TriangleElement::HCT, wavy).dofs(), grid.trim),
      {},
      1,
      {{{}, space, outline, {}}},
      {{{BoundarySegment::Kind::Embedded, 0, false}}}};
  const StepReport r =
      write_step_faces(scratch("step_face") / "lens.step", {&region}, 1, {.tolerance = 1e-4});
  CHECK(r.reached);
  CHECK(r.valid);
  CHECK(r.edges == 2);
  CHECK(r.edge_deviation <= 1e-4);
  CHECK(off_face(face_of(r.file, "M")) <= 1e-10);
  CHECK(validity_errors(face_of(r.file, "M"), 1e-4) == "");
}

TEST_CASE("An annulus is one face that closes in u, with a seam, holes beside it", "[io][step]") {
  // A wavy tube with a waist; its boundaries start at different angles.
  const int n = 24, m = 12;
  const double period = 3, speed = 2 * pi / period;
  const JetFormula tube = [=](const Vec2& p) {
    const double c = std::cos(speed * p.x()), s = std::sin(speed * p.x()), v = p.y();
    const double r = 0.5 + 0.1 * v * v, r_v = 0.2 * v;
    SurfaceJet j{};
    j.x = {r * c, r * s, v + 0.05 * s};
    j.x_u = {-speed * r * s, speed * r * c, 0.05 * speed * c};
    j.x_v = {r_v * c, r_v * s, 1};
    return j;
  };
  std::vector<Vec2> vertices;
  std::vector<ParametricMesh::Triangle> triangles;
  for (int j = 0; j <= m; ++j)
    for (int i = 0; i < n; ++i) vertices.emplace_back(period * i / n, -0.6 + 1.5 * j / m);
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * n + i, b = j * n + (i + 1) % n, c = a + n, d = b + n;
      triangles.push_back({a, b, d});
      triangles.push_back({a, d, c});
    }
  const auto mesh = std::make_shared<ParametricMesh>(vertices, triangles, period);
  Points dofs = interpolated(mesh, TriangleElement::HCT, tube).dofs();
  for (int e = 0; e < mesh->edge_count(); ++e) {  // also midpoints across the seam
    const auto& edge = mesh->edges()[e];
    const Vec2 a = mesh->vertices()[edge.low], n_e = mesh->edge_normal(e);
    const SurfaceJet j = tube(0.5 * (a + mesh->image_near(mesh->vertices()[edge.high], a)));
    dofs.row(DofMap(*mesh).edge(e)) = n_e.x() * j.x_u + n_e.y() * j.x_v;
  }
  const Surface surface(mesh, TriangleElement::HCT, dofs);
  const auto rim = [&](double start, double v, double direction) {
    return hermite(0, period, 30, false, [=](double t, int order) {
      return order == 0 ? Vec3(start + direction * t, v + 0.1 * std::sin(speed * t), 0)
                        : Vec3(direction, 0.1 * speed * std::cos(speed * t), 0);
    });
  };
  const HermiteCurve low = rim(0.4, -0.4, 1), high = rim(5.1, 0.7, -1),
                     hole = circle({0.5, 0.1}, 0.2, 24, true);
  for (const bool with_hole : {false, true}) {
    CAPTURE(with_hole);
    SkinnedRegion region{"tube", surface, {}, 1, {}, {}};
    for (const HermiteCurve& pcurve : {low, high, hole}) {
      if (pcurve.closed() && !with_hole) continue;
      region.boundary.push_back(
          {{BoundarySegment::Kind::Embedded, static_cast<int>(region.embedded.size()), false}});
      region.embedded.push_back({{}, lifted(pcurve, tube), pcurve, {}});
    }
    const StepReport r =
        write_step_faces(scratch("step_face") / "tube.step", {&region}, 1e-3, {.tolerance = 1e-4});
    CHECK(r.reached);
    CHECK(r.valid);
    CHECK(r.edge_deviation <= 1e-4);
    CHECK(r.max_gap <= 1e-7);
    CHECK(off_face(face_of(r.file)) <= 1e-7);
    CHECK(r.free_edges == r.edges - 1);
    const TopoDS_Face face = face_of(r.file);
    CHECK(validity_errors(face, 2e-4) == "");
    // A boundary that does not start at the seam is split there.
    CHECK(r.edges == 4 + 2 * with_hole);
    double area = 0;
    for (int i = 0; i < 2000; ++i)
      for (int j = 0; j < 200; ++j) {
        const double u = period * (i + 0.5) / 2000;
        const double v0 = -0.4 + 0.1 * std::sin(speed * (u - 0.4)),
                     v1 = 0.7 + 0.1 * std::sin(speed * (5.1 - u)),
                     v = v0 + (v1 - v0) * (j + 0.5) / 200;
        if (with_hole && (Vec2(u, v) - Vec2(0.5, 0.1)).norm() < 0.2) continue;
        area += tube({u, v}).area_vector().norm() * period / 2000 * (v1 - v0) / 200;
      }
    CHECK(r.area == Approx(area).epsilon(1e-3));
    std::swap(region.embedded[1].pcurve, region.embedded[0].pcurve);
    std::swap(region.embedded[1].fitted, region.embedded[0].fitted);
    CHECK(write_step_faces(r.file, {&region}, 1e-3, {.tolerance = 1e-4}).reached);  // either order
    region.boundary[1][0].reversed = true;
    CHECK(error_message([&] {
            write_step_faces(r.file, {&region}, 1e-3, {.tolerance = 1e-4});
          }).find("-1 times around") != std::string::npos);
    const Vec3 normal = normal_of(face, {1.2, 0.1});
    CHECK(normal.dot(tube({1.2, 0.1}).normal()) > 0.999);
  }
}

TEST_CASE("Several model faces are several CAD faces, each with its own knots", "[io][step]") {
  const SkinnedRegion one = disc(wavy, 12), two = square(placed(paraboloid, 1, {2, 0, 0}), 6);
  const StepReport r =
      write_step_faces(scratch("step_face") / "two.step", {&one, &two}, 1, {.tolerance = 1e-4});
  CHECK(r.reached);
  CHECK(r.valid);
  CHECK(r.faces == 2);
  CHECK(r.edges == 6);
  REQUIRE(r.patches.size() == 2);
  CHECK(r.patches[0].region == "disc");
  CHECK(r.patches[1].region == "square");
  CHECK(r.area == Approx(area_of(one) + area_of(two)).epsilon(1e-3));
}

TEST_CASE("The file has the same bytes on one thread and on two", "[io][step]") {
  const SkinnedRegion region = disc(wavy, 12);
  const fs::path folder = scratch("step_face");
  const auto text = [&](int threads) {
    const ThreadGuard guard(threads);
    const fs::path file = folder / "disc.step";
    write_step_faces(file, {&region}, 1, {.tolerance = 1e-4});
    std::string all, line;
    for (std::ifstream in(file); std::getline(in, line);) all += line + "\n";
    return all.substr(all.find("DATA;"));  // after the time stamp
  };
  const std::string one = text(1);
  CHECK((one == text(2)));
  CHECK(one.find("PRODUCT('surface','surface'") != std::string::npos);
}

TEST_CASE("Invalid faces are refused and leave an older file unchanged", "[io][step]") {
  const fs::path file = scratch("step_face") / "face.step";
  const SkinnedRegion good = disc(wavy, 8);
  std::ofstream(file) << "older";
  const auto error_of = [&](const SkinnedRegion& region, double unit, double tolerance) {
    return error_message(
        [&] { write_step_faces(file, {&region}, unit, {.tolerance = tolerance}); });
  };
  CHECK(error_message([&] {
          write_step_faces(file, {}, 1, {.tolerance = 1});
        }).find("no face to write") != std::string::npos);
  CHECK(error_of(good, 1, 0).find("tolerance of 0") != std::string::npos);
  CHECK(error_of(good, 1, std::nan("")).find("tolerance of") != std::string::npos);
  CHECK(error_message([&] {
          write_step_faces(file, {&good}, 1, {.tolerance = 1, .max_poles = 3});
        }).find("limit of 3 poles") != std::string::npos);
  CHECK(error_of(good, 0.123, 1).find("model unit") != std::string::npos);
  SkinnedRegion bare = good;
  bare.boundary.clear();
  CHECK(error_of(bare, 1, 1).find("'disc': found no boundary") != std::string::npos);
  SkinnedRegion wrong = good;
  Points dofs = good.surface.dofs();
  dofs(7, 1) = std::nan("");
  wrong.surface = Surface(good.surface.shared_mesh(), TriangleElement::HCT, dofs);
  CHECK(error_of(wrong, 1, 1).find("not finite") != std::string::npos);
  SkinnedRegion uneven = good;
  uneven.embedded[1].pcurve = uneven.embedded[1].pcurve.with_scaled_parameter(2);
  CHECK(error_of(uneven, 1, 1).find("its curve in (u, v)") != std::string::npos);
  CHECK(error_message([&] {
          write_step_faces(file.parent_path() / "none" / "f.step", {&good}, 1, {.tolerance = 1e-3});
        }).find("none") != std::string::npos);
  std::string text;
  std::ifstream(file) >> text;
  CHECK(text == "older");
  CHECK(std::distance(fs::directory_iterator(file.parent_path()), {}) == 1);
}
