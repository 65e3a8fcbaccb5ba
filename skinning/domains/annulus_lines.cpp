// Inner lines of rings: images that run on over the seam.
#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include "batten/core/errors.h"
#include "batten/core/planar_geometry.h"
#include "batten/fem/surface_projector.h"
#include "batten/skinning/domains/annulus_domain.h"
#include "batten/skinning/domains/curve_crossing.h"

namespace batten {
namespace {

// The same closed curve, cut open at its start.
HermiteCurve cut_open(const HermiteCurve& closed) {
  const int n = closed.segment_count();
  Points x(n + 1, 3), slope(n + 1, 3);
  for (int i = 0; i <= n; ++i) {
    x.row(i) = closed.position(i % n);
    slope.row(i) = closed.slope_out(i % n);
  }
  return {closed.parameters(), x, slope};
}

// Nearest points of a curve, one after the other, u running on where the strip begins anew.
class ClosestPointTracker {
 public:
  ClosestPointTracker(const Surface& surface, const SurfaceProjector& projector,
                      const Location& start)
      : surface_(surface), projector_(projector), where_(start), uv_(uv_of(start)) {}

  Vec2 to(const Vec3& x) {
    p_ = x;
    where_ = projector_.nearest(x, where_).where;
    uv_ = surface_.mesh().image_near(uv_of(where_), uv_);
    return uv_;
  }
  Vec3 foot_point() const { return surface_.position(where_); }
  // The slope in (u, v) of the nearest points of a curve that has this slope at the last point or,
  // with a speed, as fast as that in space. Beside the surface nearest points are faster or slower
  // than the curve: J'J du + (x - p)·(x_uu …) du = J' dp.
  Vec2 pull(const Vec3& slope, std::optional<double> speed = {}) const {
    const SurfaceJet jet = surface_.jet(where_);
    Eigen::Matrix<double, 3, 2> J;
    J << jet.x_u, jet.x_v;
    const Vec3 off = jet.x - p_;
    const Mat2 G = J.transpose() * J;
    Mat2 H;
    H << jet.x_uu.dot(off), jet.x_uv.dot(off), jet.x_uv.dot(off), jet.x_vv.dot(off);
    H += G;
    constexpr double far = 0.1;  // near a centre of curvature nearest points run away
    const bool near = H(0, 0) > 0 && H.determinant() > far * G.determinant();
    const Vec2 d = (near ? H : G).ldlt().solve(J.transpose() * slope);
    return speed ? Vec2(*speed / std::max((J * d).norm(), 1e-300) * d) : d;
  }

 private:
  Vec2 uv_of(const Location& at) const { return surface_.mesh().shape(at.triangle).point(at.L); }
  const Surface& surface_;
  const SurfaceProjector& projector_;
  Location where_;
  Vec2 uv_;
  Vec3 p_ = Vec3::Zero();
};

// A curve sampled together with its nearest points: lengths of both so far.
struct Samples {
  std::vector<double> t, path_length, length;

  // The parameter at which the way is this long; a closed line's goes on around.
  double at(double target, bool closed) const {
    const double span = t.back() - t.front();
    const double periods = closed ? std::floor(target / path_length.back()) : 0;
    target -= periods * path_length.back();
    const auto above = std::upper_bound(path_length.begin(), path_length.end(), target);
    const auto k = static_cast<size_t>(std::clamp<long>(above - path_length.begin(), 1,
                                                        static_cast<long>(path_length.size()) - 1));
    const double part = std::clamp(
        (target - path_length[k - 1]) / std::max(path_length[k] - path_length[k - 1], 1e-300), 0.0,
        1.0);
    return t[k - 1] + part * (t[k] - t[k - 1]) + periods * span;
  }
  // Mean of the way over what it would be if it were even: a closed line is turned by that, so that
  // it does not matter where it begins.
  double offset() const {
    double sum = 0;
    for (size_t k = 1; k < t.size(); ++k) {
      const double scale = path_length.back() / length.back();
      sum += 0.5 * (length[k] - length[k - 1]) *
             (path_length[k] + path_length[k - 1] - scale * (length[k] + length[k - 1]));
    }
    return sum / length.back();
  }
};

// Where each node of the image takes its place from: the node's own parameter or, `evenly`, the
// parameter at which the way on the surface has the share that the node has of the curve's length.
std::vector<double> source_parameters(const std::vector<double>& nodes, const Samples& s,
                                      bool closed, bool evenly) {
  if (!evenly || !(s.path_length.back() > 0)) return nodes;
  std::vector<double> from;
  const size_t each = (s.t.size() - 1) / (nodes.size() - 1);
  const double offset = closed ? s.offset() : 0;
  for (size_t i = 0; i < nodes.size(); ++i)
    from.push_back(
        s.at(offset + s.length[each * i] / s.length.back() * s.path_length.back(), closed));
  if (closed) {
    from.back() = from.front() + nodes.back() - nodes.front();
  } else {
    from.front() = nodes.front();
    from.back() = nodes.back();
  }
  return from;
}

// The line's image, its nodes at the parameters of `line.image`, beginning where that begins. A
// closed line that runs around the ring has no closed image: both are cut open.
void embed_across_seam(EmbeddedLine& line, const Surface& surface,
                       const SurfaceProjector& projector, const TriangleLocator& locator,
                       bool evenly) {
  const ParametricMesh& mesh = surface.mesh();
  const HermiteCurve curve = line.fitted;
  const std::vector<double> nodes = line.pcurve.parameters();
  const Location start = locator.locate(drop_z(line.pcurve.position(0)));
  constexpr int each = 16;  // samples a segment
  Samples samples{{nodes[0]}, {0}, {0}};
  ClosestPointTracker tracker(surface, projector, start);
  Vec3 x = curve.evaluate(nodes[0]);
  const Vec2 first = tracker.to(x);
  Vec2 last = first;
  Vec3 foot_point = tracker.foot_point();
  for (size_t i = 0; i + 1 < nodes.size(); ++i)
    for (int k = 1; k <= each; ++k) {
      samples.t.push_back(nodes[i] + (nodes[i + 1] - nodes[i]) * k / each);
      const Vec3 next = curve.evaluate(samples.t.back());
      last = tracker.to(next);
      samples.path_length.push_back(samples.path_length.back() +
                                    (tracker.foot_point() - foot_point).norm());
      samples.length.push_back(samples.length.back() + (next - x).norm());
      x = next;
      foot_point = tracker.foot_point();
    }
  const double around = std::round((last.x() - first.x()) / mesh.period());
  if (curve.closed() && around != 0) line.fitted = cut_open(curve);

  const CurveMesh pcurve(nodes, line.fitted.closed());
  const std::vector<double> from = source_parameters(nodes, samples, curve.closed(), evenly);
  const double span = curve.end() - curve.start(),
               scale = samples.path_length.back() / samples.length.back();
  Points dofs = Points::Zero(pcurve.dof_count(), 3);
  ClosestPointTracker again(surface, projector, start);
  double here = nodes[0], shift = 0;
  for (int i = 0; i < pcurve.node_count(); ++i) {
    // In small steps: a long one might end on another sheet.
    const double to = from[i], before = here;
    const double step = span / static_cast<double>(samples.t.size() - 1);
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(to - before) / step)));
    Vec2 c;
    for (int k = 1; k <= steps; ++k) {
      here = before + (to - before) * k / steps;
      c = again.to(curve.evaluate(here));
    }
    const Vec3 slope = curve.evaluate(nodes[i], 1);
    const Vec2 d =
        evenly ? again.pull(curve.evaluate(to, 1), scale * slope.norm()) : again.pull(slope);
    if (i == 0) shift = mesh.wrapped(c).x() - c.x();  // the line begins within one period
    dofs.row(pcurve.position_dof(i)) << round_to_grid(c.x() + shift), round_to_grid(c.y()), 0;
    dofs.row(pcurve.slope_out(i)) = round_slope_to_grid({d.x(), d.y(), 0}, span);
  }
  if (curve.closed() && around != 0) {
    // It ends where it begins, once around.
    const int end = pcurve.node_count() - 1;
    dofs.row(pcurve.position_dof(end)) = dofs.row(pcurve.position_dof(0));
    dofs(pcurve.position_dof(end), 0) += around * mesh.period();
    dofs.row(pcurve.slope_out(end)) = dofs.row(pcurve.slope_out(0));
  }
  line.pcurve = {pcurve, std::move(dofs)};
}

// A hole does not reach around: on the same strip cut open opposite to it, it is like any other.
void embed_hole(const Outline& hole, const Surface& surface, const SurfaceProjector& projector,
                const DomainInput& task, RegionGeometry& geometry) {
  const ParametricMesh& mesh = surface.mesh();
  const auto uv_of = [&](const Vec3& p) {
    const Location at = projector.nearest(p).where;
    return mesh.shape(at.triangle).point(at.L);
  };
  // The middle of the range of u.
  Vec2 uv = uv_of(hole.segments[0].start);
  double low = uv.x(), high = low;
  constexpr int samples = 32;
  for (const Outline::OrientedSegment& piece : hole.segments) {
    const InputCurve& c = *piece.segment.curve;
    for (int k = 0; k <= samples; ++k) {
      uv = mesh.image_near(uv_of(c.evaluate(c.start() + (c.end() - c.start()) * k / samples)), uv);
      low = std::min(low, uv.x());
      high = std::max(high, uv.x());
    }
  }
  if (!(high - low < 0.9 * mesh.period()))
    throw InputError("the hole with line '" + hole.segments[0].segment.name +
                     "' runs around the ring: two rings would be left (a line that bounds a ring "
                     "has role = \"outline\")");
  const double u_shift = round_to_grid(0.5 * (mesh.period() - low - high));
  std::vector<Vec2> vertices = mesh.vertices();
  for (Vec2& p : vertices) p = mesh.wrapped({p.x() + u_shift, p.y()});
  const Surface shifted_surface(
      std::make_shared<ParametricMesh>(std::move(vertices), mesh.triangles(), mesh.period()),
      surface.kind(), surface.dofs());
  const size_t first = geometry.embedded.size();
  embed_on_surface(shifted_surface, {hole}, {}, task, geometry);
  const double begin = geometry.embedded[first].pcurve.position(0).x() - u_shift,
               back = mesh.wrapped({begin, 0}).x() - begin - u_shift;
  for (size_t i = first; i < geometry.embedded.size(); ++i) {
    HermiteCurve& pcurve = geometry.embedded[i].pcurve;
    Points dofs = pcurve.dofs();
    for (int n = 0; n < pcurve.node_count(); ++n) dofs(pcurve.mesh().position_dof(n), 0) += back;
    pcurve = {pcurve.mesh(), std::move(dofs)};
  }
}

}  // namespace

void embed_on_annulus(const Surface& surface, const std::vector<Outline>& holes,
                      const std::vector<SmoothSegment>& inner, const DomainInput& task,
                      RegionGeometry& geometry) {
  for (const SmoothSegment& line : inner)
    if (line.mesh_alignment == CharacterLine::MeshAlignment::EdgeAligned)
      throw InputError("line '" + line.name +
                       "' cannot be fitted: inner lines of rings are embedded");
  const SurfaceProjector projector(surface);
  for (const Outline& hole : holes) embed_hole(hole, surface, projector, task, geometry);
  const size_t before = geometry.embedded.size();
  // Fits the lines; what it says of images that cross the seam is not used.
  embed_on_surface(surface, {}, inner, task, geometry);
  const TriangleLocator locator(surface.mesh());
  for (size_t i = before; i < geometry.embedded.size(); ++i) {
    // Where lines cross, nearest points keep them together.
    EmbeddedLine& line = geometry.embedded[i];
    const double near = 10 * task.gap_tolerance;
    bool alone = true;
    for (size_t j = 0; j < geometry.embedded.size() && alone; ++j) {
      const InputCurve &a = *line.line.curve, &b = *geometry.embedded[j].line.curve;
      std::vector<Vec3> ends;
      for (const double s : {a.start(), a.end()})
        for (const double t : {b.start(), b.end()})
          if ((a.evaluate(s) - b.evaluate(t)).norm() <= near) ends.push_back(a.evaluate(s));
      alone = j == i || !BoxedCurve(a).crossing(BoxedCurve(b), near, ends, 20 * near).found;
    }
    embed_across_seam(line, surface, projector, locator, alone);
  }
}

}  // namespace batten
