#include "batten/fem/domain_loops.h"

#include "batten/core/errors.h"
#include "batten/core/plane.h"

namespace batten {

std::vector<PlanarCubic> planar_arcs(const HermiteCurve& curve) {
  std::vector<PlanarCubic> arcs;
  for (int s = 0; s < curve.segment_count(); ++s) {
    const int next = (s + 1) % curve.node_count();
    const double h = curve.mesh().length(s) / 3;
    const Vec2 p = flat(curve.position(s)), q = flat(curve.position(next));
    arcs.push_back({{p, p + h * flat(curve.slope_out(s)), q - h * flat(curve.slope_in(next)), q}});
  }
  return arcs;
}

DomainLoops::DomainLoops(std::vector<Loop> loops, Around around)
    : around_(around), loops_(std::move(loops)) {
  std::vector<size_t> first;
  for (const Loop& loop : loops_) {
    if (loop.empty()) throw InputError("a loop of the domain without curves");
    first.push_back(arcs_.size());
    for (const HermiteCurve& curve : loop) {
      if (!curve.dofs().col(2).isZero(0))
        throw InputError("a loop of the domain leaves the plane z = 0");
      for (const PlanarCubic& arc : planar_arcs(curve)) arcs_.push_back(arc);
    }
  }
  for (const PlanarCubic& arc : arcs_)
    for (const Vec2& p : arc.b) box_.extend(p);
  if (arcs_.empty()) box_.extend(Vec2::Zero());
  first.push_back(arcs_.size());
  const double size = box_.diagonal().norm();
  for (size_t l = 0; l < loops_.size(); ++l)
    for (size_t a = first[l]; a < first[l + 1]; ++a) {
      PlanarCubic& next = arcs_[a + 1 < first[l + 1] ? a + 1 : first[l]];
      if (!((next.b[0] - arcs_[a].b[3]).norm() <= 1e-9 * size))
        throw InputError("a loop of the domain is open at (" + number(arcs_[a].b[3].x()) + ", " +
                         number(arcs_[a].b[3].y()) + ")");
      next.b[0] = arcs_[a].b[3];  // the ray must not slip through
    }
  for (size_t a = 0; a < arcs_.size(); ++a) {
    const PlanarCubic& arc = arcs_[a];
    const BernsteinCubic v{{arc.b[0].y(), arc.b[1].y(), arc.b[2].y(), arc.b[3].y()}};
    const auto parts = v.monotone_parts();
    const Box2 box = box_around(arc.b);
    double before = arc.b[0].y();
    for (size_t i = 0; i + 1 < parts.size(); ++i) {
      const double after = i + 2 == parts.size() ? arc.b[3].y() : v.at(parts[i + 1]);
      if (before != after)
        monotone_.push_back({static_cast<int>(a), parts[i], parts[i + 1], before, after,
                             box.min().x(), box.max().x()});
      before = after;
    }
  }
}

bool DomainLoops::contains(const Vec2& p) const {
  int winding = around_ == Around::Inside ? 1 : 0;
  for (const Monotone& m : monotone_) {
    if ((m.v0 > p.y()) == (m.v1 > p.y()) || p.x() > m.u_high) continue;
    if (p.x() >= m.u_low) {
      const PlanarCubic& arc = arcs_[m.arc];
      const BernsteinCubic v{
          {arc.b[0].y() - p.y(), arc.b[1].y() - p.y(), arc.b[2].y() - p.y(), arc.b[3].y() - p.y()}};
      if (arc.at(v.zero(m.t0, m.t1)).x() <= p.x()) continue;
    }
    winding += m.v1 > m.v0 ? 1 : -1;
  }
  return winding > 0;
}

double DomainLoops::area() const {
  // ½ ∮ (u dv - v du): of degree 5 in t.
  constexpr double place = 0.7745966692414834;
  double twice = 0;
  for (const PlanarCubic& arc : arcs_)
    for (const auto& [t, w] :
         {std::pair{0.5 * (1 - place), 5.0 / 18}, {0.5, 8.0 / 18}, {0.5 * (1 + place), 5.0 / 18}}) {
      const Vec2 c = arc.at(t), d = arc.slope(t);
      twice += w * (c.x() * d.y() - c.y() * d.x());
    }
  return 0.5 * twice;
}

}  // namespace batten
