// Inner lines of rings: images that run on over the seam.
#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include "batten/core/errors.h"
#include "batten/core/plane.h"
#include "batten/fem/surface_projector.h"
#include "batten/skinning/domains/crossing.h"
#include "batten/skinning/domains/ring.h"

namespace batten {
namespace {

// The same closed curve, cut open at its start.
HermiteCurve opened(const HermiteCurve& closed) {
  const int n = closed.segment_count();
  Points x(n + 1, 3), slope(n + 1, 3);
  for (int i = 0; i <= n; ++i) {
    x.row(i) = closed.position(i % n);
    slope.row(i) = closed.slope_out(i % n);
  }
  return {closed.parameters(), x, slope};
}

// Nearest points of a curve, one after the other, u running on where the strip begins anew.
class Walk {
 public:
  Walk(const Surface& surface, const SurfaceProjector& projector, const Location& start)
      : surface_(surface), projector_(projector), where_(start), uv_(place(start)) {}

  Vec2 to(const Vec3& x) {
    p_ = x;
    where_ = projector_.nearest(x, where_).where;
    uv_ = surface_.mesh().image_near(place(where_), uv_);
    return uv_;
  }
  Vec3 foot() const { return surface_.position(where_); }
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
  Vec2 place(const Location& at) const { return surface_.mesh().shape(at.triangle).point(at.L); }
  const Surface& surface_;
  const SurfaceProjector& projector_;
  Location where_;
  Vec2 uv_;
  Vec3 p_ = Vec3::Zero();
};

// A curve sampled together with its nearest points: lengths of both so far.
struct Samples {
  std::vector<double> t, way, length;

  // The parameter at which the way is this long; a closed line's goes on around.
  double at(double target, bool closed) const {
    const double span = t.back() - t.front();
    const double turns = closed ? std::floor(target / way.back()) : 0;
    target -= turns * way.back();
    const auto above = std::upper_bound(way.begin(), way.end(), target);
    const auto k = static_cast<size_t>(
        std::clamp<long>(above - way.begin(), 1, static_cast<long>(way.size()) - 1));
    const double part =
        std::clamp((target - way[k - 1]) / std::max(way[k] - way[k - 1], 1e-300), 0.0, 1.0);
    return t[k - 1] + part * (t[k] - t[k - 1]) + turns * span;
  }
  // Mean of the way over what it would be if it were even: a closed line is turned by that, so that
  // it does not matter where it begins.
  double offset() const {
    double sum = 0;
    for (size_t k = 1; k < t.size(); ++k) {
      const double scale = way.back() / length.back();
      sum += 0.5 * (length[k] - length[k - 1]) *
             (way[k] + way[k - 1] - scale * (length[k] + length[k - 1]));
    }
    return sum / length.back();
  }
};

// Where each node of the image takes its place from: the node's own parameter or, `evenly`, the
// parameter at which the way on the surface has the share that the node has of the curve's length.
std::vector<double> sources(const std::vector<double>& nodes, const Samples& s, bool closed,
                            bool evenly) {
  if (!evenly || !(s.way.back() > 0)) return nodes;
  std::vector<double> from;
  const size_t each = (s.t.size() - 1) / (nodes.size() - 1);
  const double offset = closed ? s.offset() : 0;
  for (size_t i = 0; i < nodes.size(); ++i)
    from.push_back(s.at(offset + s.length[each * i] / s.length.back() * s.way.back(), closed));
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
void run_on(EmbeddedLine& line, const Surface& surface, const SurfaceProjector& projector,
            const TriangleLocator& locator, bool evenly) {
  const ParametricMesh& mesh = surface.mesh();
  const HermiteCurve curve = line.fitted;
  const std::vector<double> nodes = line.image.parameters();
  const Location start = locator.locate(flat(line.image.position(0)));
  constexpr int each = 16;  // samples a segment
  Samples samples{{nodes[0]}, {0}, {0}};
  Walk walk(surface, projector, start);
  Vec3 x = curve.evaluate(nodes[0]);
  const Vec2 first = walk.to(x);
  Vec2 last = first;
  Vec3 foot = walk.foot();
  for (size_t i = 0; i + 1 < nodes.size(); ++i)
    for (int k = 1; k <= each; ++k) {
      samples.t.push_back(nodes[i] + (nodes[i + 1] - nodes[i]) * k / each);
      const Vec3 next = curve.evaluate(samples.t.back());
      last = walk.to(next);
      samples.way.push_back(samples.way.back() + (walk.foot() - foot).norm());
      samples.length.push_back(samples.length.back() + (next - x).norm());
      x = next;
      foot = walk.foot();
    }
  const double around = std::round((last.x() - first.x()) / mesh.period());
  if (curve.closed() && around != 0) line.fitted = opened(curve);

  const CurveMesh image(nodes, line.fitted.closed());
  const std::vector<double> from = sources(nodes, samples, curve.closed(), evenly);
  const double span = curve.end() - curve.start(),
               scale = samples.way.back() / samples.length.back();
  Points dofs = Points::Zero(image.dof_count(), 3);
  Walk again(surface, projector, start);
  double here = nodes[0], shift = 0;
  for (int i = 0; i < image.node_count(); ++i) {
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
    dofs.row(image.position_dof(i)) << rounded(c.x() + shift), rounded(c.y()), 0;
    dofs.row(image.slope_out(i)) = rounded_slope({d.x(), d.y(), 0}, span);
  }
  if (curve.closed() && around != 0) {
    // It ends where it begins, once around.
    const int end = image.node_count() - 1;
    dofs.row(image.position_dof(end)) = dofs.row(image.position_dof(0));
    dofs(image.position_dof(end), 0) += around * mesh.period();
    dofs.row(image.slope_out(end)) = dofs.row(image.slope_out(0));
  }
  line.image = {image, std::move(dofs)};
}

// A hole does not reach around: on the same strip cut open opposite to it, it is like any other.
void embed_hole(const Outline& hole, const Surface& surface, const SurfaceProjector& projector,
                const DomainTask& task, RegionParts& parts) {
  const ParametricMesh& mesh = surface.mesh();
  const auto place = [&](const Vec3& p) {
    const Location at = projector.nearest(p).where;
    return mesh.shape(at.triangle).point(at.L);
  };
  // The middle of the range of u.
  Vec2 uv = place(hole.pieces[0].start);
  double low = uv.x(), high = low;
  constexpr int samples = 32;
  for (const Outline::Piece& piece : hole.pieces) {
    const InputCurve& c = *piece.stretch.curve;
    for (int k = 0; k <= samples; ++k) {
      uv = mesh.image_near(place(c.evaluate(c.start() + (c.end() - c.start()) * k / samples)), uv);
      low = std::min(low, uv.x());
      high = std::max(high, uv.x());
    }
  }
  if (!(high - low < 0.9 * mesh.period()))
    throw InputError("the hole with line '" + hole.pieces[0].stretch.name +
                     "' runs around the ring: two rings would be left (a line that bounds a ring "
                     "has role = \"outline\")");
  const double turn = rounded(0.5 * (mesh.period() - low - high));
  std::vector<Vec2> vertices = mesh.vertices();
  for (Vec2& p : vertices) p = mesh.wrapped({p.x() + turn, p.y()});
  const Surface turned(
      std::make_shared<ParametricMesh>(std::move(vertices), mesh.triangles(), mesh.period()),
      surface.kind(), surface.dofs());
  const size_t first = parts.embedded.size();
  embed_on(turned, {hole}, {}, task, parts);
  const double begin = parts.embedded[first].image.position(0).x() - turn,
               back = mesh.wrapped({begin, 0}).x() - begin - turn;
  for (size_t i = first; i < parts.embedded.size(); ++i) {
    HermiteCurve& image = parts.embedded[i].image;
    Points dofs = image.dofs();
    for (int n = 0; n < image.node_count(); ++n) dofs(image.mesh().position_dof(n), 0) += back;
    image = {image.mesh(), std::move(dofs)};
  }
}

}  // namespace

void embed_on_ring(const Surface& surface, const std::vector<Outline>& holes,
                   const std::vector<Stretch>& inner, const DomainTask& task, RegionParts& parts) {
  for (const Stretch& line : inner)
    if (line.treatment == CharacterLine::Treatment::Fitted)
      throw InputError("line '" + line.name +
                       "' cannot be fitted: inner lines of rings are embedded");
  const SurfaceProjector projector(surface);
  for (const Outline& hole : holes) embed_hole(hole, surface, projector, task, parts);
  const size_t before = parts.embedded.size();
  // Fits the lines; what it says of images that cross the seam is not used.
  embed_on(surface, {}, inner, task, parts);
  const TriangleLocator locator(surface.mesh());
  for (size_t i = before; i < parts.embedded.size(); ++i) {
    // Where lines cross, nearest points keep them together.
    EmbeddedLine& line = parts.embedded[i];
    const double near = 10 * task.join;
    bool alone = true;
    for (size_t j = 0; j < parts.embedded.size() && alone; ++j) {
      const InputCurve &a = *line.line.curve, &b = *parts.embedded[j].line.curve;
      std::vector<Vec3> ends;
      for (const double s : {a.start(), a.end()})
        for (const double t : {b.start(), b.end()})
          if ((a.evaluate(s) - b.evaluate(t)).norm() <= near) ends.push_back(a.evaluate(s));
      alone = j == i || !BoxedCurve(a).crossing(BoxedCurve(b), near, ends, 20 * near).found;
    }
    run_on(line, surface, projector, locator, alone);
  }
}

}  // namespace batten
