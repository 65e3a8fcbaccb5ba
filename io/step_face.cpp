#include "batten/io/step_face.h"

#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <STEPControl_Reader.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <StepBasic_Product.hxx>
#include <StepData_StepModel.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/core/plane.h"
#include "batten/fem/triangle_locator.h"
#include "batten/io/bicubic_patch.h"
#include "batten/io/cubic_splines.h"
#include "batten/io/occ_settings.h"
#include "batten/io/step_text.h"
#include "batten/io/whole_file.h"

namespace batten {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

gp_Pnt to_occ(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
Vec3 from_occ(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }
// ---- the boundary ---------------------------------------------------------------------------

/// A smooth part of the boundary, in space and in (u, v), over the same parameters.
struct Stretch {
  HermiteCurve curve, image;
  Vec2 uv(double t) const { return flat(image.evaluate(t)); }
  Vec2 first() const { return flat(image.position(0)); }
  Vec2 last() const { return flat(image.evaluate({image.segment_count() - 1, 1.0})); }
};
using Loop = std::vector<Stretch>;

/// From one parameter to a later one; smooth between.
HermiteCurve part(const HermiteCurve& whole, double from, double to) {
  const HermiteCurve curve = whole.with_nodes({from, to});
  std::vector<double> u;
  std::vector<Vec3> x, d;
  for (int i = 0; i <= curve.segment_count(); ++i) {
    const double at = curve.parameters()[i];
    if (at < from || at > to) continue;
    const int node = i % curve.node_count();
    u.push_back(at);
    x.push_back(curve.position(node));
    d.push_back(at == to ? curve.slope_in(node) : curve.slope_out(node));
  }
  Points positions(static_cast<long>(u.size()), 3), derivatives(positions.rows(), 3);
  for (size_t i = 0; i < u.size(); ++i) {
    positions.row(static_cast<long>(i)) = x[i];
    derivatives.row(static_cast<long>(i)) = d[i];
  }
  return {u, positions, derivatives};
}

/// The stretch cut at parameters; the whole one when none is inside.
Loop cut(const Stretch& whole, std::vector<double> at) {
  const double start = whole.curve.start(), end = whole.curve.end(), hair = 1e-9 * (end - start);
  std::erase_if(at, [&](double t) { return t <= start + hair || t >= end - hair; });
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end(), [&](double a, double b) { return b - a <= hair; }),
           at.end());
  if (at.empty()) return {whole};
  at.insert(at.begin(), start);
  at.push_back(end);
  Loop pieces;
  for (size_t i = 0; i + 1 < at.size(); ++i)
    pieces.push_back({part(whole.curve, at[i], at[i + 1]), part(whole.image, at[i], at[i + 1])});
  return pieces;
}

std::vector<double> corner_parameters(const HermiteCurve& curve) {
  std::vector<double> at;
  for (const int node : curve.mesh().corners()) at.push_back(curve.parameters()[node]);
  return at;
}

HermiteCurve shifted(const HermiteCurve& image, double du) {
  Points dofs = image.dofs();
  for (int i = 0; i < image.node_count(); ++i) dofs(image.mesh().position_dof(i), 0) += du;
  return {image.mesh(), std::move(dofs)};
}

Loop loop_of(const SkinnedRegion& region, const std::vector<BoundaryPiece>& pieces) {
  Loop loop;
  const double period = region.surface.mesh().period();
  for (const BoundaryPiece& piece : pieces) {
    Stretch whole{boundary_curve(region, piece), boundary_image(region, piece)};
    if (!(std::abs(whole.curve.start() - whole.image.start()) +
              std::abs(whole.curve.end() - whole.image.end()) <=
          1e-9 * (whole.curve.end() - whole.curve.start())))
      throw InputError("region '" + region.name + "': a boundary curve runs from " +
                       number(whole.curve.start()) + " to " + number(whole.curve.end()) +
                       ", its image in (u, v) from " + number(whole.image.start()) + " to " +
                       number(whole.image.end()));
    if (period > 0 && !loop.empty()) {
      const double du = loop.back().last().x() - whole.first().x();
      whole.image = shifted(whole.image, period * std::round(du / period));
    }
    auto at = corner_parameters(whole.curve);
    for (const double t : corner_parameters(whole.image)) at.push_back(t);
    for (Stretch& stretch : cut(whole, at)) loop.push_back(std::move(stretch));
  }
  return loop;
}

/// Where a stretch crosses lines of constant u: parameters, ascending.
std::vector<double> crossings(const Stretch& stretch, double u) {
  std::vector<double> found;
  const auto arcs = planar_arcs(stretch.image);
  for (size_t k = 0; k < arcs.size(); ++k) {
    BernsteinCubic distance;
    for (size_t i = 0; i < 4; ++i) distance.b[i] = arcs[k].b[i].x() - u;
    for (const double s : distance.zeros())
      found.push_back(stretch.image.parameters()[k] + s * stretch.image.mesh().length(k));
  }
  return found;
}

/// A loop around a ring, begun anew where it crosses u = seam (mod period), and moved there.
Loop begun_at(const Loop& loop, double seam, double period) {
  const bool forward = loop.back().last().x() > loop.front().first().x();
  const double begin = forward ? seam : seam + period;
  const double size = 1e-9 * period;
  Loop pieces;
  size_t first = std::numeric_limits<size_t>::max();
  for (const Stretch& stretch : loop) {
    std::vector<double> at;
    double low = infinity, high = -infinity;
    for (const PlanarCubic& arc : planar_arcs(stretch.image))
      for (const Vec2& p : arc.b) {
        low = std::min(low, p.x());
        high = std::max(high, p.x());
      }
    for (double k = std::ceil((low - begin) / period); begin + k * period <= high; ++k)
      for (const double t : crossings(stretch, begin + k * period)) at.push_back(t);
    for (Stretch& piece : cut(stretch, at)) {
      const double turns = (piece.first().x() - begin) / period;
      if (first > pieces.size() && std::abs(turns - std::round(turns)) * period <= size)
        first = pieces.size();
      pieces.push_back(std::move(piece));
    }
  }
  if (first >= pieces.size()) return {};
  std::rotate(pieces.begin(), pieces.begin() + static_cast<long>(first), pieces.end());
  for (size_t i = 0; i < pieces.size(); ++i) {
    const double to = i == 0 ? begin : pieces[i - 1].last().x();
    const double du = period * std::round((to - pieces[i].first().x()) / period);
    pieces[i].image = shifted(pieces[i].image, du);
  }
  return pieces;
}

DomainLoops::Loop images(const Loop& loop) {
  DomainLoops::Loop result;
  for (const Stretch& stretch : loop) result.push_back(stretch.image);
  return result;
}

HermiteCurve straight(const Vec2& a, const Vec2& b) {
  Points x(2, 3), d(2, 3);
  x << a.x(), a.y(), 0, b.x(), b.y(), 0;
  d << b.x() - a.x(), b.y() - a.y(), 0, b.x() - a.x(), b.y() - a.y(), 0;
  return {{0, 1}, x, d};
}

/// The boundary of a region as a face has it.
struct Boundary {
  std::vector<Loop> loops;  ///< of a ring, the first two are one wire, with the seam between them
  double period = 0;
  double seam = 0;  ///< its u
  DomainLoops domain;

  explicit Boundary(const SkinnedRegion& region) : period(region.surface.mesh().period()) {
    if (region.boundary.empty() || (period > 0 && region.boundary.size() < 2))
      throw InputError("region '" + region.name + "': no boundary loops; expected an outline");
    for (const auto& pieces : region.boundary) {
      if (pieces.empty())
        throw InputError("region '" + region.name + "': a boundary loop without lines");
      loops.push_back(loop_of(region, pieces));
    }
    if (period > 0) unroll(region.name);
    std::vector<DomainLoops::Loop> all;
    for (const Loop& loop : loops) all.push_back(images(loop));
    if (period > 0) {
      // Along one loop, up the seam, back along the other, down the seam.
      DomainLoops::Loop around = all[0];
      around.push_back(straight(loops[0].back().last(), loops[1].front().first()));
      around.insert(around.end(), all[1].begin(), all[1].end());
      around.push_back(straight(loops[1].back().last(), loops[0].front().first()));
      all.erase(all.begin(), all.begin() + 2);
      all.insert(all.begin(), around);
    }
    domain = DomainLoops(std::move(all));
  }

  bool contains(Vec2 uv) const {
    if (period > 0) uv.x() -= std::floor((uv.x() - seam) / period) * period;
    return domain.contains(uv);
  }

 private:
  /// A seam that meets no hole, if possible where the first loop begins.
  void unroll(const std::string& name) {
    const double start = loops[0].front().first().x();
    const auto turns = [&](const Loop& loop) {
      return (loop.back().last().x() - loop.front().first().x()) / period;
    };
    if (turns(loops[1]) > 0) std::swap(loops[0], loops[1]);
    if (std::abs(turns(loops[0]) - 1) + std::abs(turns(loops[1]) + 1) > 1e-6)
      throw InputError("region '" + name + "': the two rims of a ring run " +
                       number(turns(loops[0])) + " and " + number(turns(loops[1])) +
                       " times around it; expected once each, with the ring to their left");
    constexpr int tries = 64;
    for (int k = 0; k < tries; ++k) {
      seam = start + period * k / tries;
      std::vector<Loop> moved{begun_at(loops[0], seam, period), begun_at(loops[1], seam, period)};
      bool free = !moved[0].empty() && !moved[1].empty();
      for (size_t h = 2; h < loops.size() && free; ++h) {
        double low = infinity, high = -infinity;
        for (const Stretch& stretch : loops[h])
          for (const PlanarCubic& arc : planar_arcs(stretch.image))
            for (const Vec2& p : arc.b) {
              low = std::min(low, p.x());
              high = std::max(high, p.x());
            }
        const double back = -std::floor((low - seam) / period) * period;
        free = high + back < seam + period;
        moved.push_back(loops[h]);
        for (Stretch& stretch : moved.back()) stretch.image = shifted(stretch.image, back);
      }
      if (!free) continue;
      loops = std::move(moved);
      return;
    }
    throw InputError("region '" + name +
                     "': no straight seam from rim to rim of the ring is free of holes");
  }
};

// ---- one region -----------------------------------------------------------------------------

class FaceMaker {
 public:
  FaceMaker(const SkinnedRegion& region, const StepFaceOptions& options)
      : region_(region),
        options_(options),
        boundary_((check(region), region)),
        middle_(middle(boundary_)),
        near_origin_(moved_by(region.surface, -middle_)),
        locator_(region.surface.mesh()) {
    for (const Loop& loop : boundary_.loops)
      for (const Stretch& stretch : loop) box_.extend(box_of(stretch.curve));
    size_ = box_.diagonal().norm();
    goal_ = 0.9 * options.tolerance;
    fit(nullptr);
  }

  const SkinnedRegion& region() const { return region_; }
  const Boundary& boundary() const { return boundary_; }
  double size() const { return size_; }
  /// Of edges and vertices, once the face is made.
  double tolerance() const { return widest_; }
  int cells() const { return fit_.patch.u.intervals() * fit_.patch.v.intervals(); }
  Vec3 position(const Vec2& uv) const {
    return near_origin_.position(locator_.locate(uv)) + middle_;
  }

  /// After the file was measured: whether another fit may help, and is made.
  bool refine(double deviation) {
    if (!fit_.reached || !std::isfinite(deviation)) return false;
    goal_ *= 0.9 * options_.tolerance / deviation;
    const PatchFit before = fit_;
    fit(&before.patch);
    if (fit_.reached) return true;
    fit_ = before;
    return false;
  }

  TopoDS_Face make() {
    const BicubicPatch& patch = fit_.patch;
    TColgp_Array2OfPnt poles(1, patch.u.functions(), 1, patch.v.functions());
    for (int i = 0; i < patch.u.functions(); ++i)
      for (int j = 0; j < patch.v.functions(); ++j)
        poles(i + 1, j + 1) = to_occ(
            patch.poles.row(static_cast<long>(i) * patch.v.functions() + j).transpose() + middle_);
    const auto [u, u_times] = knots(patch.u);
    const auto [v, v_times] = knots(patch.v);
    surface_ = new Geom_BSplineSurface(poles, u, v, u_times, v_times, 3, 3, patch.u.periodic());
    widest_ = 1e-9 * size_;
    builder_.MakeFace(face_, surface_, widest_);

    if (boundary_.period > 0) {
      add_ring();
    } else {
      add_wire(boundary_.loops[0]);
    }
    for (size_t k = boundary_.period > 0 ? 2 : 1; k < boundary_.loops.size(); ++k)
      add_wire(boundary_.loops[k]);
    return face_;
  }

  int poles_u() const { return fit_.patch.u.functions(); }
  int poles_v() const { return fit_.patch.v.functions(); }

 private:
  static void check(const SkinnedRegion& region) {
    if (!region.surface.dofs().allFinite())
      throw InputError("STEP: region '" + region.name + "' has dofs that are not finite");
  }
  static Eigen::AlignedBox3d box_of(const HermiteCurve& curve) {
    Eigen::AlignedBox3d box;
    for (int s = 0; s < curve.segment_count(); ++s)
      for (int k = 0; k <= 4; ++k) box.extend(curve.evaluate({s, k / 4.0}));
    return box;
  }
  static Vec3 middle(const Boundary& boundary) {
    Eigen::AlignedBox3d box;
    for (const Loop& loop : boundary.loops)
      for (const Stretch& stretch : loop) box.extend(box_of(stretch.curve));
    return box.center();
  }
  static Surface moved_by(const Surface& surface, const Vec3& shift) {
    Points dofs = surface.dofs();
    for (int v = 0; v < surface.mesh().vertex_count(); ++v)
      dofs.row(surface.dof_map().vertex(v)) += shift.transpose();
    return {surface.shared_mesh(), surface.kind(), std::move(dofs)};
  }

  void fit(const BicubicPatch* start) {
    PatchTarget target;
    target.inside = [&](const Vec2& uv) { return boundary_.contains(uv); };
    target.position = [&](const Vec2& uv) { return near_origin_.position(locator_.locate(uv)); };
    target.rim = [&](double spacing) {
      std::vector<Vec2> points;
      for (const Loop& loop : boundary_.loops)
        for (const Stretch& stretch : loop)
          for (const PlanarCubic& arc : planar_arcs(stretch.image)) {
            const double length = (arc.b[1] - arc.b[0]).norm() + (arc.b[2] - arc.b[1]).norm() +
                                  (arc.b[3] - arc.b[2]).norm();
            const int n = 1 + static_cast<int>(length / spacing);
            for (int k = 0; k < n; ++k) points.push_back(arc.at((k + 0.5) / n));
            points.push_back(arc.b[3]);
          }
      return points;
    };
    target.low = boundary_.domain.low();
    target.high = boundary_.domain.high();
    target.periodic = boundary_.period > 0;
    if (target.periodic) {
      target.low.x() = boundary_.seam;
      target.high.x() = boundary_.seam + boundary_.period;
    }
    fit_ =
        fit_bicubic_patch(target, goal_, {options_.most_poles, options_.most_poles_in_all}, start);
  }

  static std::pair<TColStd_Array1OfReal, TColStd_Array1OfInteger> knots(const SplineAxis& axis) {
    const int n = axis.intervals() + 1;
    TColStd_Array1OfReal values(1, n);
    TColStd_Array1OfInteger times(1, n);
    for (int i = 1; i <= n; ++i) {
      values(i) = axis.knots()[i - 1];
      times(i) = !axis.periodic() && (i == 1 || i == n) ? 4 : 1;
    }
    return {values, times};
  }
  static std::pair<TColStd_Array1OfReal, TColStd_Array1OfInteger> knots(const CubicSpline& spline) {
    const int n = static_cast<int>(spline.knots.size());
    TColStd_Array1OfReal values(1, n);
    TColStd_Array1OfInteger times(1, n);
    for (int i = 1; i <= n; ++i) {
      values(i) = spline.knots[i - 1];
      times(i) = spline.multiplicities[i - 1];
    }
    return {values, times};
  }

  double widened(double distance) {
    const double tolerance = std::max(1e-9 * size_, 1.01 * distance);
    widest_ = std::max(widest_, tolerance);
    return tolerance;
  }

  /// Where stretches meet, at the end of `before` and the start of `after`.
  TopoDS_Vertex vertex(const Stretch& before, const Stretch& after) {
    const Vec3 p = after.curve.position(0);
    const Vec3 q = before.curve.evaluate({before.curve.segment_count() - 1, 1.0});
    double distance = (p - q).norm();
    for (const Vec2& uv : {before.last(), after.first()})
      distance = std::max(distance, (from_occ(surface_->Value(uv.x(), uv.y())) - p).norm());
    TopoDS_Vertex result;
    builder_.MakeVertex(result, to_occ(p), widened(distance));
    return result;
  }

  TopoDS_Edge edge(const Stretch& stretch, const TopoDS_Vertex& a, const TopoDS_Vertex& b) {
    const CubicSpline space = cubic_splines({"", stretch.curve, {}, {}}).front();
    const CubicSpline plane = cubic_splines({"", stretch.image, {}, {}}).front();
    TColgp_Array1OfPnt poles(1, static_cast<int>(space.poles.size()));
    for (int i = 1; i <= poles.Length(); ++i) poles(i) = to_occ(space.poles[i - 1]);
    TColgp_Array1OfPnt2d flat_poles(1, static_cast<int>(plane.poles.size()));
    for (int i = 1; i <= flat_poles.Length(); ++i)
      flat_poles(i) = {plane.poles[i - 1].x(), plane.poles[i - 1].y()};
    const auto [t, times] = knots(space);
    const auto [s, flat_times] = knots(plane);
    const Handle(Geom_BSplineCurve) curve = new Geom_BSplineCurve(poles, t, times, 3);
    const Handle(Geom2d_BSplineCurve) line = new Geom2d_BSplineCurve(flat_poles, s, flat_times, 3);

    double distance = 0;
    const int n = std::max(8 * (curve->NbKnots() + line->NbKnots()), 4 * (poles_u() + poles_v()));
    const double first = space.knots.front(), last = space.knots.back();
    for (int i = 0; i <= n; ++i) {
      const double at = first + (last - first) * i / n;
      const gp_Pnt2d uv = line->Value(at);
      distance = std::max(distance, curve->Value(at).Distance(surface_->Value(uv.X(), uv.Y())));
    }
    TopoDS_Edge result;
    builder_.MakeEdge(result, curve, widened(distance));
    builder_.UpdateEdge(result, line, face_, widened(distance));
    finish(result, a, b, first, last);
    return result;
  }

  void finish(TopoDS_Edge& edge, const TopoDS_Vertex& a, const TopoDS_Vertex& b, double first,
              double last) {
    builder_.Add(edge, a.Oriented(TopAbs_FORWARD));
    builder_.Add(edge, b.Oriented(TopAbs_REVERSED));
    builder_.Range(edge, first, last);
    builder_.SameRange(edge, true);
    builder_.SameParameter(edge, true);
  }

  /// Edges of a loop; the vertices at which it begins and ends are the same.
  std::vector<TopoDS_Edge> edges(const Loop& loop) {
    const size_t n = loop.size();
    std::vector<TopoDS_Vertex> vertices;
    for (size_t k = 0; k < n; ++k) vertices.push_back(vertex(loop[(k + n - 1) % n], loop[k]));
    std::vector<TopoDS_Edge> result;
    for (size_t k = 0; k < n; ++k)
      result.push_back(edge(loop[k], vertices[k], vertices[(k + 1) % n]));
    return result;
  }

  void add_wire(const Loop& loop) {
    TopoDS_Wire wire;
    builder_.MakeWire(wire);
    for (const TopoDS_Edge& e : edges(loop)) builder_.Add(wire, e.Oriented(TopAbs_FORWARD));
    wire.Closed(true);
    builder_.Add(face_, wire);
  }

  void add_ring() {
    const auto low = edges(boundary_.loops[0]), high = edges(boundary_.loops[1]);
    const Vec2 from = boundary_.loops[0].front().first();
    const Vec2 to = boundary_.loops[1].back().last();
    const auto line = [&](double u) {
      TColgp_Array1OfPnt2d poles(1, 2);
      TColStd_Array1OfReal values(1, 2);
      TColStd_Array1OfInteger times(1, 2);
      poles(1) = {u, values(1) = from.y()};
      poles(2) = {u, values(2) = to.y()};
      times.Init(2);
      return new Geom2d_BSplineCurve(poles, values, times, 1);
    };
    const double left = boundary_.seam, right = left + boundary_.period;
    const TopoDS_Vertex a = TopExp::FirstVertex(low.front()), b = TopExp::FirstVertex(high.front());
    const Handle(Geom_Curve) curve = surface_->UIso(left);
    double distance = std::max(curve->Value(from.y()).Distance(BRep_Tool::Pnt(a)),
                               curve->Value(to.y()).Distance(BRep_Tool::Pnt(b)));
    TopoDS_Edge seam;
    builder_.MakeEdge(seam, curve, widened(0));
    // Met forward first, on the right side.
    builder_.UpdateEdge(seam, line(right), line(left), face_, widened(0));
    widened(distance);
    finish(seam, a, b, from.y(), to.y());
    TopoDS_Wire wire;
    builder_.MakeWire(wire);
    for (const TopoDS_Edge& e : low) builder_.Add(wire, e.Oriented(TopAbs_FORWARD));
    builder_.Add(wire, seam.Oriented(TopAbs_FORWARD));
    for (const TopoDS_Edge& e : high) builder_.Add(wire, e.Oriented(TopAbs_FORWARD));
    builder_.Add(wire, seam.Oriented(TopAbs_REVERSED));
    wire.Closed(true);
    builder_.Add(face_, wire);
  }

  const SkinnedRegion& region_;
  const StepFaceOptions& options_;
  Boundary boundary_;
  Vec3 middle_;
  Surface near_origin_;
  TriangleLocator locator_;
  Eigen::AlignedBox3d box_;
  double size_ = 0, goal_ = 0, widest_ = 0;
  PatchFit fit_;
  BRep_Builder builder_;
  Handle(Geom_BSplineSurface) surface_;
  TopoDS_Face face_;
};

// ---- reading back ---------------------------------------------------------------------------

/// Largest of many values, computed on all threads.
template <class Function>
double largest(size_t count, const Function& value) {
  const int parts = static_cast<int>(std::min<size_t>(count, 64));
  std::vector<double> of(static_cast<size_t>(parts), 0.0);
  parallel_parts(parts, [&](int p) {
    for (size_t i = count * p / parts; i < count * (p + 1) / parts; ++i) {
      const double found = value(i);
      of[p] = std::max(of[p], std::isfinite(found) ? found : infinity);
    }
  });
  return parts > 0 ? *std::max_element(of.begin(), of.end()) : 0;
}

/// Points of the region's surface, by triangles: n² of each.
std::vector<Vec2> points_of_region(const FaceMaker& made) {
  const ParametricMesh& mesh = made.region().surface.mesh();
  const double per_triangle = 6.0 * made.cells() / mesh.triangle_count();
  const int n = std::clamp(static_cast<int>(std::ceil(std::sqrt(per_triangle))), 3, 24);
  std::vector<Vec2> points;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TriangleShape shape = mesh.shape(t);
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const double a = (i + 1.0 / 3) / n, b = (j + 1.0 / 3) / n;
        const Vec2 uv = shape.point({a, b, 1 - a - b});
        if (made.boundary().contains(uv)) points.push_back(uv);
      }
  }
  return points;
}

/// Points of the file's face, by its knots: 3×3 of each cell that are inside of its trim.
std::vector<Vec2> points_of_face(const TopoDS_Face& face, const Geom_BSplineSurface& surface) {
  std::vector<Vec2> points;
  BRepTopAdaptor_FClass2d classifier(face, 1e-9);
  const int n = surface.NbUKnots() * surface.NbVKnots() > 10'000 ? 2 : 3;
  for (int i = 1; i < surface.NbUKnots(); ++i)
    for (int j = 1; j < surface.NbVKnots(); ++j)
      for (int k = 0; k < n * n; ++k) {
        const double s = (k / n + 0.5) / n, t = (k % n + 0.5) / n;
        const gp_Pnt2d uv((1 - s) * surface.UKnot(i) + s * surface.UKnot(i + 1),
                          (1 - t) * surface.VKnot(j) + t * surface.VKnot(j + 1));
        if (classifier.Perform(uv) == TopAbs_IN) points.emplace_back(uv.X(), uv.Y());
      }
  return points;
}

void measure_face(const TopoDS_Face& face, const FaceMaker& made, StepFacePatch& report) {
  const Handle(Geom_BSplineSurface) surface =
      Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(face));
  report.deviation = report.edge_gap = report.edge_deviation = infinity;
  if (surface.IsNull()) return;
  const double begin = made.boundary().seam, period = made.boundary().period;
  const auto on_file = [&](const Vec2& uv) {
    const double u = period > 0 ? uv.x() - std::floor((uv.x() - begin) / period) * period : uv.x();
    return from_occ(surface->Value(u, uv.y()));
  };
  std::vector<Vec2> points = points_of_region(made);
  for (const Vec2& uv : points_of_face(face, *surface)) points.push_back(uv);

  // Boundary curves, each with the edge of the file that is nearest to it at the same share of the
  // parameter.
  struct Edge {
    Handle(Geom_Curve) curve;
    Handle(Geom2d_Curve) line;
    double first, last;
    double at(double share) const { return first + share * (last - first); }
  };
  std::vector<Edge> edges;
  double gap = 0;
  for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
    const TopoDS_Edge& edge = TopoDS::Edge(it.Current());
    Edge e;
    double first, last;
    e.curve = BRep_Tool::Curve(edge, e.first, e.last);
    e.line = BRep_Tool::CurveOnSurface(edge, face, first, last);
    if (e.curve.IsNull() || e.line.IsNull()) return;
    const int n = 4 * (surface->NbUKnots() + surface->NbVKnots());
    for (int i = 0; i <= n; ++i) {
      const double t = e.at(double(i) / n);
      const gp_Pnt2d uv = e.line->Value(t);
      gap = std::max(gap, e.curve->Value(t).Distance(surface->Value(uv.X(), uv.Y())));
    }
    TopoDS_Vertex a, b;
    TopExp::Vertices(edge, a, b);
    if (!a.IsNull()) gap = std::max(gap, BRep_Tool::Pnt(a).Distance(e.curve->Value(e.first)));
    if (!b.IsNull()) gap = std::max(gap, BRep_Tool::Pnt(b).Distance(e.curve->Value(e.last)));
    if (!BRep_Tool::IsClosed(edge, face)) edges.push_back(e);
  }
  report.edge_deviation = 0;
  std::vector<char> used(edges.size());
  for (const Loop& loop : made.boundary().loops)
    for (const Stretch& stretch : loop) {
      const double start = stretch.curve.start(), end = stretch.curve.end();
      const auto apart = [&](const Edge& e, double share) {
        const Vec3 p = from_occ(e.curve->Value(e.at(share)));
        return (p - stretch.curve.evaluate(start + share * (end - start))).norm();
      };
      size_t mine = edges.size();
      double nearest = infinity;
      for (size_t k = 0; k < edges.size(); ++k) {
        double distance = 0;
        for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9})
          distance = std::max(distance, apart(edges[k], share));
        if (used[k] || distance >= nearest) continue;
        nearest = distance;
        mine = k;
      }
      if (mine == edges.size()) {
        report.edge_deviation = infinity;
        continue;
      }
      used[mine] = 1;
      const int n = 8 * (stretch.curve.segment_count() + stretch.image.segment_count() +
                         surface->NbUKnots() + surface->NbVKnots());
      for (int i = 0; i <= n; ++i) {
        const double share = double(i) / n, t = start + share * (end - start);
        report.edge_deviation = std::max(report.edge_deviation, apart(edges[mine], share));
        const Vec2 uv = i < n ? stretch.uv(t) : stretch.last();
        points.push_back(uv);
        const Vec3 x = i < n ? stretch.curve.evaluate(t)
                             : stretch.curve.evaluate({stretch.curve.segment_count() - 1, 1.0});
        report.line_gap = std::max(report.line_gap, (made.position(uv) - x).norm());
        const gp_Pnt2d of_file = edges[mine].line->Value(edges[mine].at(share));
        points.emplace_back(of_file.X(), of_file.Y());
      }
    }
  if (std::find(used.begin(), used.end(), 0) != used.end()) report.edge_deviation = infinity;
  report.edge_gap = gap;
  report.deviation = largest(points.size(), [&](size_t i) {
    return (on_file(points[i]) - made.position(points[i])).norm();
  });
}

std::vector<TopoDS_Face> read_faces(const std::filesystem::path& path, TopoDS_Shape& shape) {
  STEPControl_Reader reader;
  if (reader.ReadFile(path.string().c_str()) == IFSelect_RetDone) {
    reader.TransferRoots();
    shape = reader.OneShape();
  }
  std::vector<TopoDS_Face> faces;
  if (shape.IsNull()) return faces;
  for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
    faces.push_back(TopoDS::Face(it.Current()));
  return faces;
}

StepFaceReport measured(const std::filesystem::path& path, const std::vector<FaceMaker>& made,
                        double tolerance) {
  StepFaceReport report;
  report.bytes = std::filesystem::file_size(path);
  report.tolerance = tolerance;
  TopoDS_Shape shape;
  const auto faces = read_faces(path, shape);
  if (faces.size() != made.size())
    throw Error(path.string() + ": OpenCASCADE reads " + std::to_string(faces.size()) +
                " faces where " + std::to_string(made.size()) + " were written");
  report.faces = static_cast<int>(faces.size());
  TopTools_IndexedMapOfShape edges;
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  report.edges = edges.Extent();
  std::vector<int> uses(static_cast<size_t>(edges.Extent()));
  for (const TopoDS_Face& face : faces)
    for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next())
      ++uses[static_cast<size_t>(edges.FindIndex(e.Current()) - 1)];
  report.free_edges = static_cast<int>(std::count(uses.begin(), uses.end(), 1));
  report.valid = BRepCheck_Analyzer(shape).IsValid();
  GProp_GProps properties;
  BRepGProp::SurfaceProperties(shape, properties);
  report.area = properties.Mass();
  report.reached = true;
  for (size_t k = 0; k < faces.size(); ++k) {
    StepFacePatch patch;
    patch.region = made[k].region().name;
    patch.poles_u = made[k].poles_u();
    patch.poles_v = made[k].poles_v();
    measure_face(faces[k], made[k], patch);
    patch.reached = patch.deviation <= tolerance;
    report.reached = report.reached && patch.reached;
    report.deviation = std::max(report.deviation, patch.deviation);
    report.edge_gap = std::max(report.edge_gap, patch.edge_gap);
    report.line_gap = std::max(report.line_gap, patch.line_gap);
    report.edge_deviation = std::max(report.edge_deviation, patch.edge_deviation);
    report.patches.push_back(patch);
  }
  return report;
}

/// Whether OpenCASCADE finds nothing wrong with what was written; readers repair silently.
bool save(const std::filesystem::path& path, std::vector<FaceMaker>& made, OccSettings& occ,
          const StepFaceOptions& options) {
  BRep_Builder builder;
  TopoDS_Compound compound;
  TopoDS_Shape shape;
  builder.MakeCompound(compound);
  double tolerance = 0;
  for (FaceMaker& maker : made) {
    TopoDS_Shell shell;
    builder.MakeShell(shell);
    builder.Add(shell, maker.make());
    builder.Add(compound, shell);
    shape = shell;
    tolerance = std::max(tolerance, maker.tolerance());
  }
  if (made.size() > 1) shape = compound;
  occ.set("write.precision.mode", 2);  // the value given next
  occ.set("write.precision.val", tolerance);
  STEPControl_Writer writer;
  if (writer.Transfer(shape, STEPControl_AsIs) != IFSelect_RetDone)
    throw Error(path.string() + ": OpenCASCADE cannot turn the surface into STEP");
  // OpenCASCADE counts the products of a process in their names.
  const Handle(TCollection_HAsciiString) name = new TCollection_HAsciiString(options.name.c_str());
  const auto& model = *writer.Model();
  for (int e = 1; e <= model.NbEntities(); ++e)
    if (const auto product = Handle(StepBasic_Product)::DownCast(model.Value(e));
        !product.IsNull()) {
      product->SetId(name);
      product->SetName(name);
    }
  save_step(writer, path, {options.name, options.author, "surfaces"});
  return BRepCheck_Analyzer(shape).IsValid();
}

}  // namespace

StepFaceReport write_step_face(const std::filesystem::path& path,
                               const std::vector<const SkinnedRegion*>& regions,
                               double model_unit_in_metres, const StepFaceOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  if (regions.empty()) throw InputError(path.string() + ": no region to write");
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
    throw InputError(path.string() + ": found a tolerance of " + number(options.tolerance) +
                     "; expected a length above 0");
  if (options.most_poles < 16 || options.most_poles_in_all < 256)
    throw InputError(path.string() + ": found a limit of " + std::to_string(options.most_poles) +
                     " poles in a direction and " + std::to_string(options.most_poles_in_all) +
                     " in all; expected 16 and 256 or more");
  const std::string unit = cad_unit(model_unit_in_metres);
  WholeFile file(path);
  std::vector<FaceMaker> made;
  made.reserve(regions.size());
  for (const SkinnedRegion* region : regions) made.emplace_back(*region, options);

  OccSettings occ;
  occ.set_unit(unit);
  occ.set("write.step.schema", "AP214IS");
  occ.set("write.step.product.name", options.name.c_str());
  occ.set("write.step.assembly", 0);  // one product, not one for each face
  occ.set("write.surfacecurve.mode", 1);
  try {
    StepFaceReport report;
    for (int round = 0; round < 4; ++round) {
      const bool valid = save(file.temporary(), made, occ, options);
      report = measured(file.temporary(), made, options.tolerance);
      report.valid = report.valid && valid;
      bool again = false;
      for (size_t k = 0; k < made.size(); ++k)
        if (!report.patches[k].reached)
          again = made[k].refine(report.patches[k].deviation) || again;
      if (!again) break;
    }
    file.commit();
    report.file = path;
    report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
  } catch (const Standard_Failure& failure) {
    throw Error(path.string() +
                ": OpenCASCADE failed to write or read it: " + failure.GetMessageString());
  }
}

}  // namespace batten
