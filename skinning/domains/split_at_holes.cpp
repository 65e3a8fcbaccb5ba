#include "batten/skinning/domains/split_at_holes.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/core/isize.h"
#include "batten/core/planar_geometry.h"

namespace batten {
namespace {

struct Sample {
  int piece;  // of the rim; 0 on a line
  double t;
  Vec3 p;
};

std::vector<Sample> samples_of(const InputCurve& curve, int piece) {
  constexpr int each = 16, least = 128;
  const std::vector<double> breaks = curve.breaks();
  const int spans = isize(breaks) - 1, count = std::max(each, (least + spans - 1) / spans);
  std::vector<Sample> samples;
  for (int i = 0; i < spans; ++i) {
    const double a = breaks[static_cast<size_t>(i)], b = breaks[static_cast<size_t>(i) + 1];
    for (int k = 0; k < count + (i + 1 == spans); ++k) {
      const double t = a + (b - a) * k / count;
      samples.push_back({piece, t, curve.evaluate(t)});
    }
  }
  return samples;
}

// A hole's rim, closed, seen along its mean normal.
class HoleBoundary {
 public:
  explicit HoleBoundary(const Outline& loop) : loop_(loop) {
    for (int i = 0; i < isize(loop.segments); ++i) {
      std::vector<Sample> s = samples_of(curve(i), i);
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
    for (const Sample& s : samples_) {
      flat_.push_back(seen(s.p));
      box_.extend(flat_.back());
      radius_ = std::max(radius_, (s.p - centre_).norm());
    }
  }

  const std::vector<Sample>& samples() const { return samples_; }
  const Sample& next(size_t i) const { return samples_[(i + 1) % samples_.size()]; }
  const Vec2& flat(size_t i) const { return flat_[i % flat_.size()]; }
  const InputCurve& curve(int piece) const {
    return *loop_.segments[static_cast<size_t>(piece)].segment.curve;
  }
  const std::string& name(int piece) const {
    return loop_.segments[static_cast<size_t>(piece)].segment.name;
  }
  Vec2 seen(const Vec3& p) const { return {x_.dot(p - centre_), y_.dot(p - centre_)}; }
  /// Other sheets of a surface may lie behind a hole.
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
  std::vector<Sample> samples_;
  std::vector<Vec2> flat_;
  Vec3 centre_ = Vec3::Zero(), normal_ = Vec3::UnitZ(), x_, y_;
  Eigen::AlignedBox2d box_;
  double radius_ = 0;
};

// Where two curves are nearest, from t and s on: Gauss-Newton steps, inside of the intervals.
void to_nearest(const InputCurve& a, double& t, const InputCurve& b, double& s) {
  constexpr int steps = 20;
  for (int k = 0; k < steps; ++k) {
    const Vec3 da = a.evaluate(t, 1), db = b.evaluate(s, 1), gap = b.evaluate(s) - a.evaluate(t);
    Eigen::Matrix2d m;
    m << da.dot(da), -da.dot(db), -da.dot(db), db.dot(db);
    const Vec2 step = m.ldlt().solve(Vec2(da.dot(gap), -db.dot(gap)));
    if (!step.allFinite()) return;
    t = std::clamp(t + step[0], a.start(), a.end());
    s = std::clamp(s + step[1], b.start(), b.end());
  }
}

// Where a line crosses a rim, parameters of the line.
void add_crossings(const SmoothSegment& line, const std::vector<Sample>& samples,
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
      const Sample &from = boundary.samples()[k], &to = boundary.next(k);
      const InputCurve& side = boundary.curve(from.piece);
      double t = samples[i].t + f * (samples[i + 1].t - samples[i].t);
      double s =
          from.t + g * ((to.piece == from.piece && to.t > from.t ? to.t : side.end()) - from.t);
      to_nearest(*line.curve, t, side, s);
      const Vec3 p = line.curve->evaluate(t);
      const double gap = (side.evaluate(s) - p).norm();
      if (gap > gap_tolerance)
        throw InputError("inner line '" + line.name + "' passes the hole's line '" +
                         boundary.name(from.piece) + "' at a distance of " + format_number(gap) +
                         " near " + format_point(p) + "; expected that they meet within " +
                         format_number(gap_tolerance) +
                         " (the tolerance): move one onto the other, or end the inner line there");
      cuts.push_back(t);
    }
  }
}

// The parts of a line that are in no hole, from and to.
std::vector<std::pair<double, double>> parts_outside(const SmoothSegment& line,
                                                     const std::vector<HoleBoundary>& boundaries,
                                                     double gap_tolerance) {
  const InputCurve& curve = *line.curve;
  const std::vector<Sample> samples = samples_of(curve, 0);
  std::vector<double> cuts = {curve.start(), curve.end()};
  for (const HoleBoundary& boundary : boundaries)
    add_crossings(line, samples, boundary, gap_tolerance, cuts);
  std::sort(cuts.begin(), cuts.end());
  std::vector<std::pair<double, double>> kept;
  for (size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double a = cuts[i], b = cuts[i + 1];
    const auto p = [&](double f) { return curve.evaluate(a + f * (b - a)); };
    const double length = (p(0.5) - p(0)).norm() + (p(1) - p(0.5)).norm();
    if (cuts.size() > 2 && length <= gap_tolerance) continue;  // both ends are at one rim
    const bool inside =
        std::any_of(boundaries.begin(), boundaries.end(),
                    [&](const HoleBoundary& boundary) { return boundary.contains(p(0.5)); });
    if (inside) continue;
    // A line that touches a rim is not cut there.
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
      throw InputError("inner line '" + line.name +
                       "' lies in a hole from end to end: expected one on the surface");
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
