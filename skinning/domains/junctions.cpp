// SPDX-License-Identifier: MPL-2.0
// Intersections of embedded lines with each other, with edge-aligned lines and with hole
// boundaries.

#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/skinning/domains/domain_input.h"

namespace batten {
namespace {

HermiteCurve shifted(const HermiteCurve& pcurve, double du) {
  Points dofs = pcurve.dofs();
  for (int i = 0; i < pcurve.node_count(); ++i) dofs(pcurve.mesh().position_dof(i), 0) += du;
  return {pcurve.mesh(), std::move(dofs)};
}

struct Chord {
  double t0, t1;
  Vec2 p, q;
  bool box_meets(const Chord& other) const {
    return std::max(p.x(), q.x()) >= std::min(other.p.x(), other.q.x()) &&
           std::max(other.p.x(), other.q.x()) >= std::min(p.x(), q.x()) &&
           std::max(p.y(), q.y()) >= std::min(other.p.y(), other.q.y()) &&
           std::max(other.p.y(), other.q.y()) >= std::min(p.y(), q.y());
  }
};

// One segment of a curve as chords, with their bounding box.
struct SegmentChords {
  Box2 box;
  std::vector<Chord> chords;
  bool box_meets(const SegmentChords& other) const { return box.intersects(other.box); }
};

std::vector<SegmentChords> chords_of_segments(const HermiteCurve& c) {
  constexpr int cuts = 16;
  const auto& u = c.parameters();
  std::vector<SegmentChords> rows;
  for (int s = 0; s < c.segment_count(); ++s) {
    SegmentChords row;
    Vec2 p = drop_z(c.evaluate({s, 0.0}));
    row.box.extend(p);
    for (int k = 0; k < cuts; ++k) {
      const double t0 = u[s] + c.mesh().length(s) * k / cuts,
                   t1 = u[s] + c.mesh().length(s) * (k + 1) / cuts;
      const Vec2 q = drop_z(c.evaluate({s, static_cast<double>(k + 1) / cuts}));
      row.chords.push_back({t0, t1, p, q});
      row.box.extend(q);
      p = q;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

// An intersection of two pcurves: the parameters on both.
struct PcurveIntersection {
  double s, t;
};

// Newton's method, started at the (near) intersection of two chords.
std::optional<PcurveIntersection> intersection_near(const HermiteCurve& a, const Chord& x,
                                                    const HermiteCurve& b, const Chord& y) {
  const Vec2 d = x.q - x.p, e = y.q - y.p, r = y.p - x.p;
  const double det = cross(d, e);
  if (std::abs(det) < 1e-12 * d.norm() * e.norm()) return std::nullopt;
  const double i = cross(r, e) / det, j = cross(r, d) / det;
  if (i < -0.01 || i > 1.01 || j < -0.01 || j > 1.01) return std::nullopt;
  double s = x.t0 + i * (x.t1 - x.t0), t = y.t0 + j * (y.t1 - y.t0);
  for (int step = 0; step < 8; ++step) {
    const Vec2 gap = drop_z(b.evaluate(t)) - drop_z(a.evaluate(s));
    const Vec2 ds = drop_z(a.evaluate(s, 1)), dt = drop_z(b.evaluate(t, 1));
    const double D = cross(ds, dt);
    if (std::abs(D) < 1e-12 * ds.norm() * dt.norm()) break;
    s = std::clamp(s + cross(gap, dt) / D, a.start(), a.end());
    t = std::clamp(t + cross(gap, ds) / D, b.start(), b.end());
  }
  if ((drop_z(b.evaluate(t)) - drop_z(a.evaluate(s))).norm() > 1e-9) return std::nullopt;
  return PcurveIntersection{s, t};
}

std::vector<PcurveIntersection> pcurve_intersections(const HermiteCurve& a, const HermiteCurve& b) {
  std::vector<PcurveIntersection> found;
  const auto known = [&](double s) {
    return std::any_of(found.begin(), found.end(), [&](const PcurveIntersection& m) {
      return (drop_z(a.evaluate(m.s)) - drop_z(a.evaluate(s))).norm() < 1e-7;
    });
  };
  const auto of_a = chords_of_segments(a), of_b = chords_of_segments(b);
  for (const SegmentChords& i : of_a)
    for (const SegmentChords& j : of_b) {
      if (!i.box_meets(j)) continue;
      for (const Chord& x : i.chords)
        for (const Chord& y : j.chords) {
          if (!x.box_meets(y)) continue;
          const auto m = intersection_near(a, x, b, y);
          if (m && !known(m->s)) found.push_back(*m);
        }
    }
  return found;
}

// Intersections on a mesh that may be periodic: also with the periodic copies of the other pcurve.
std::vector<PcurveIntersection> pcurve_intersections(const ParametricMesh& mesh,
                                                     const HermiteCurve& a, const HermiteCurve& b) {
  if (mesh.period() == 0) return pcurve_intersections(a, b);
  const auto u_range = [](const HermiteCurve& c) {
    Vec2 range(c.position(0).x(), c.position(0).x());
    for (const PlanarCubic& arc : planar_cubics(c))
      for (const Vec2& p : arc.b) range = {std::min(range[0], p.x()), std::max(range[1], p.x())};
    return range;
  };
  const Vec2 of_a = u_range(a), of_b = u_range(b);
  const double period = mesh.period();
  std::vector<PcurveIntersection> found;
  for (double k = std::ceil((of_a[0] - of_b[1]) / period - 1e-9);
       of_b[0] + k * period <= of_a[1] + 1e-9 * period; ++k)
    for (const PcurveIntersection& m : pcurve_intersections(a, shifted(b, k * period))) {
      const bool known =
          std::any_of(found.begin(), found.end(), [&](const PcurveIntersection& other) {
            return domain_distance(mesh, drop_z(a.evaluate(m.s)), drop_z(a.evaluate(other.s))) <
                   1e-7;
          });
      if (!known) found.push_back(m);
    }
  return found;
}

class Junctions {
 public:
  Junctions(RegionGeometry& geometry, const DomainInput& task)
      : geometry_(geometry),
        task_(task),
        bounds_(boundary_line_flags(geometry)),
        always_(geometry.embedded.size()) {}

  std::vector<std::vector<double>> find() {
    for (size_t i = 0; i < always_.size(); ++i) {
      if (bounds_[i]) continue;
      if (!geometry_.embedded[i].fitted.closed())
        for (const bool last : {false, true}) move_end(i, last);
      find_crossings(i);
    }
    return std::move(always_);
  }

 private:
  // Inner lines are tested against boundary lines and against earlier inner lines.
  bool is_tested_against(size_t i, size_t j) const { return j != i && (bounds_[j] || j < i); }

  // Moves an end that lies near another line onto that line.
  void move_end(size_t i, bool last) {
    const HermiteCurve& fitted = geometry_.embedded[i].fitted;
    const Vec3 end = fitted.position(last ? fitted.node_count() - 1 : 0);
    for (const EdgeAlignedLine& aligned_line : geometry_.edge_aligned) {
      const auto near = aligned_line.fitted.closest_point(end);
      if (near.distance > task_.gap_tolerance) continue;
      move_to(i, last, aligned_line.fitted.evaluate(near.u),
              edge_aligned_pcurve(*geometry_.mesh, aligned_line).evaluate(near.u));
      return;
    }
    for (size_t j = 0; j < always_.size(); ++j) {
      if (!is_tested_against(i, j)) continue;
      const EmbeddedLine& other = geometry_.embedded[j];
      const auto near = other.fitted.closest_point(end);
      if (near.distance > task_.gap_tolerance) continue;
      move_to(i, last, other.fitted.evaluate(near.u), other.pcurve.evaluate(near.u));
      always_[j].push_back(near.u);
      return;
    }
  }

  void move_to(size_t i, bool last, const Vec3& position, const Vec3& uv) {
    EmbeddedLine& line = geometry_.embedded[i];
    const int node = last ? line.fitted.node_count() - 1 : 0,
              image_node = last ? line.pcurve.node_count() - 1 : 0;
    Points x = line.fitted.dofs(), c = line.pcurve.dofs();
    x.row(line.fitted.mesh().position_dof(node)) = position;
    const Vec2 there =
        geometry_.mesh->image_near(drop_z(uv), drop_z(line.pcurve.position(image_node)));
    c.row(line.pcurve.mesh().position_dof(image_node)) << there.x(), there.y(), 0;
    line.fitted = {line.fitted.mesh(), x};
    line.pcurve = {line.pcurve.mesh(), c};
  }

  void find_crossings(size_t i) {
    const EmbeddedLine& line = geometry_.embedded[i];
    for (const EdgeAlignedLine& aligned_line : geometry_.edge_aligned)
      for (const PcurveIntersection& m : pcurve_intersections(
               *geometry_.mesh, edge_aligned_pcurve(*geometry_.mesh, aligned_line), line.pcurve))
        require_near(line, aligned_line.line.name, aligned_line.fitted.evaluate(m.s),
                     line.fitted.evaluate(m.t));
    for (size_t j = 0; j < always_.size(); ++j) {
      if (!is_tested_against(i, j)) continue;
      const EmbeddedLine& other = geometry_.embedded[j];
      for (const PcurveIntersection& m :
           pcurve_intersections(*geometry_.mesh, other.pcurve, line.pcurve)) {
        require_near(line, other.line.name, other.fitted.evaluate(m.s), line.fitted.evaluate(m.t));
        always_[j].push_back(m.s);
        always_[i].push_back(m.t);
      }
    }
  }

  void require_near(const EmbeddedLine& line, const std::string& other, const Vec3& p,
                    const Vec3& q) const {
    const double away = (p - q).norm();
    if (away > task_.options.tolerance)
      throw InputError("curves '" + other + "' and '" + line.line.name +
                       "' intersect in the parameter domain near " + format_point(p) +
                       ", but are " + format_number(away) + " apart in space, expected at most " +
                       format_number(task_.options.tolerance));
  }

  RegionGeometry& geometry_;
  const DomainInput& task_;
  std::vector<char> bounds_;
  std::vector<std::vector<double>> always_;
};

}  // namespace

std::vector<std::vector<double>> find_junctions(RegionGeometry& geometry, const DomainInput& task) {
  return Junctions(geometry, task).find();
}

namespace {

struct PieceSample {
  int piece;  // of the hole boundary; 0 for samples of an inner line
  double t;
  Vec3 p;
};

std::vector<PieceSample> samples_of(const InputCurve& curve, int piece) {
  constexpr int each = 16, least = 128;
  const std::vector<double> breaks = curve.breaks();
  const int spans = isize(breaks) - 1, count = std::max(each, (least + spans - 1) / spans);
  std::vector<PieceSample> samples;
  for (int i = 0; i < spans; ++i) {
    const double a = breaks[static_cast<size_t>(i)], b = breaks[static_cast<size_t>(i) + 1];
    for (int k = 0; k < count + (i + 1 == spans); ++k) {
      const double t = a + (b - a) * k / count;
      samples.push_back({piece, t, curve.evaluate(t)});
    }
  }
  return samples;
}

// A closed hole boundary, projected along its mean normal.
class HoleBoundary {
 public:
  explicit HoleBoundary(const Outline& loop) : loop_(loop) {
    for (int i = 0; i < isize(loop.segments); ++i) {
      std::vector<PieceSample> s = samples_of(curve(i), i);
      s.pop_back();
      samples_.insert(samples_.end(), s.begin(), s.end());
    }
    Vec3 normal = Vec3::Zero();
    for (size_t i = 0; i < samples_.size(); ++i) {
      centre_ += samples_[i].p / static_cast<double>(samples_.size());
      normal += (samples_[i].p - samples_[0].p).cross(next(i).p - samples_[0].p);
    }
    normal_ = normal.normalized();
    x_ = normal_.unitOrthogonal();
    y_ = normal_.cross(x_);
    for (const PieceSample& s : samples_) {
      flat_.push_back(seen(s.p));
      box_.extend(flat_.back());
      radius_ = std::max(radius_, (s.p - centre_).norm());
    }
  }

  const std::vector<PieceSample>& samples() const { return samples_; }
  const PieceSample& next(size_t i) const { return samples_[(i + 1) % samples_.size()]; }
  const Vec2& flat(size_t i) const { return flat_[i % flat_.size()]; }
  const InputCurve& curve(int piece) const {
    return *loop_.segments[static_cast<size_t>(piece)].segment.curve;
  }
  const std::string& name(int piece) const {
    return loop_.segments[static_cast<size_t>(piece)].segment.name;
  }
  Vec2 seen(const Vec3& p) const { return {x_.dot(p - centre_), y_.dot(p - centre_)}; }
  /// False for points of other parts of the surface that lie in front of the hole or behind it.
  bool is_near(const Vec3& p) const { return std::abs(normal_.dot(p - centre_)) <= radius_; }
  const Eigen::AlignedBox2d& box() const { return box_; }

  bool contains(const Vec3& p) const {
    if (!is_near(p)) return false;
    const Vec2 q = seen(p);
    bool inside = false;
    for (size_t i = 0; i < flat_.size(); ++i) {
      const Vec2 &a = flat(i), &b = flat(i + 1);
      if ((a.y() > q.y()) != (b.y() > q.y()) &&
          q.x() < a.x() + (q.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
        inside = !inside;
    }
    return inside;
  }

 private:
  const Outline& loop_;
  std::vector<PieceSample> samples_;
  std::vector<Vec2> flat_;
  Vec3 centre_ = Vec3::Zero(), normal_ = Vec3::UnitZ(), x_, y_;
  Eigen::AlignedBox2d box_;
  double radius_ = 0;
};

// Minimises the distance of two curves from the start values t and s by Gauss-Newton steps, clamped
// to the parameter intervals.
void to_nearest(const InputCurve& a, double& t, const InputCurve& b, double& s) {
  constexpr int steps = 20;
  for (int k = 0; k < steps; ++k) {
    const Vec3 da = a.evaluate(t, 1), db = b.evaluate(s, 1), gap = b.evaluate(s) - a.evaluate(t);
    Eigen::Matrix2d m;
    m << da.dot(da), -da.dot(db), -da.dot(db), db.dot(db);
    const Vec2 step = solve_symmetric_2x2(m, Vec2(da.dot(gap), -db.dot(gap)));
    if (!step.allFinite()) return;
    t = std::clamp(t + step[0], a.start(), a.end());
    s = std::clamp(s + step[1], b.start(), b.end());
  }
}

// Appends to `cuts` the parameters at which a line crosses a hole boundary.
void add_crossings(const SmoothSegment& line, const std::vector<PieceSample>& samples,
                   const HoleBoundary& boundary, double gap_tolerance, std::vector<double>& cuts) {
  for (size_t i = 0; i + 1 < samples.size(); ++i) {
    if (!boundary.is_near(samples[i].p)) continue;
    const Vec2 a = boundary.seen(samples[i].p), d = boundary.seen(samples[i + 1].p) - a;
    Eigen::AlignedBox2d here(a);
    here.extend(Vec2(a + d));
    if (!here.intersects(boundary.box())) continue;
    for (size_t k = 0; k < boundary.samples().size(); ++k) {
      const Vec2 e = boundary.flat(k + 1) - boundary.flat(k), w = boundary.flat(k) - a;
      const double det = cross(d, e);
      if (det == 0) continue;
      const double f = cross(w, e) / det, g = cross(w, d) / det;
      if (f < 0 || f > 1 || g < 0 || g > 1) continue;
      const PieceSample &from = boundary.samples()[k], &to = boundary.next(k);
      const InputCurve& side = boundary.curve(from.piece);
      double t = samples[i].t + f * (samples[i + 1].t - samples[i].t);
      double s =
          from.t + g * ((to.piece == from.piece && to.t > from.t ? to.t : side.end()) - from.t);
      to_nearest(*line.curve, t, side, s);
      const Vec3 p = line.curve->evaluate(t);
      const double gap = (side.evaluate(s) - p).norm();
      if (gap > gap_tolerance)
        throw InputError("inner curve '" + line.name + "' passes curve '" +
                         boundary.name(from.piece) + "' of a hole at a distance of " +
                         format_number(gap) + " near " + format_point(p) + ", expected at most " +
                         format_number(gap_tolerance) +
                         "; let them meet, or end the inner curve there");
      cuts.push_back(t);
    }
  }
}

// Parameter intervals of a line that lie in no hole.
std::vector<std::pair<double, double>> parts_outside(const SmoothSegment& line,
                                                     const std::vector<HoleBoundary>& boundaries,
                                                     double gap_tolerance) {
  const InputCurve& curve = *line.curve;
  const std::vector<PieceSample> samples = samples_of(curve, 0);
  std::vector<double> cuts = {curve.start(), curve.end()};
  for (const HoleBoundary& boundary : boundaries)
    add_crossings(line, samples, boundary, gap_tolerance, cuts);
  std::sort(cuts.begin(), cuts.end());
  std::vector<std::pair<double, double>> kept;
  for (size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double a = cuts[i], b = cuts[i + 1];
    const auto p = [&](double f) { return curve.evaluate(a + f * (b - a)); };
    const double length = (p(0.5) - p(0)).norm() + (p(1) - p(0.5)).norm();
    if (cuts.size() > 2 && length <= gap_tolerance) continue;  // both ends are at one hole boundary
    const bool inside =
        std::any_of(boundaries.begin(), boundaries.end(),
                    [&](const HoleBoundary& boundary) { return boundary.contains(p(0.5)); });
    if (inside) continue;
    // A line that only touches a hole boundary is not split there.
    if (!kept.empty() && (curve.evaluate(kept.back().second) - p(0)).norm() <= gap_tolerance)
      kept.back().second = b;
    else
      kept.push_back({a, b});
  }
  return kept;
}

}  // namespace

std::vector<SmoothSegment> split_at_holes(const std::vector<SmoothSegment>& inner,
                                          const std::vector<Outline>& holes,
                                          const DomainInput& task) {
  if (holes.empty() || inner.empty()) return inner;
  std::vector<HoleBoundary> boundaries;
  for (const Outline& hole : holes) boundaries.emplace_back(hole);
  std::vector<SmoothSegment> result;
  for (const SmoothSegment& line : inner) {
    if (line.prescribed) {
      result.push_back(line);
      continue;
    }
    const auto kept = parts_outside(line, boundaries, task.gap_tolerance);
    if (kept.empty())
      throw InputError("inner curve '" + line.name +
                       "' lies completely in a hole, expected it on the face");
    const bool whole = kept.size() == 1 && kept[0].first == line.curve->start() &&
                       kept[0].second == line.curve->end();
    for (size_t k = 0; k < kept.size(); ++k) {
      SmoothSegment part = line;
      if (kept.size() > 1) part.name += "." + std::to_string(k + 1);
      if (!whole) part.curve = subcurve(line.curve, kept[k].first, kept[k].second);
      result.push_back(std::move(part));
    }
  }
  return result;
}

}  // namespace batten
