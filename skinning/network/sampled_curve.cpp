// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/network/sampled_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"

namespace batten::detail {
namespace {

// Orthonormal directions that are generic: unrelated to the axes and planes along which people
// draw.
const Mat3& directions() {
  static const Mat3 rows = [] {
    const Vec3 a = Vec3(0.537701, 0.810133, 0.233619).normalized();
    const Vec3 b = a.cross(Vec3(-0.311927, 0.271813, 0.902711)).normalized();
    Mat3 m;
    m << a.transpose(), b.transpose(), a.cross(b).transpose();
    return m;
  }();
  return rows;
}

// Bound on the rounding error of points of a curve.
double rounding_error(const ArcLength& arc_length, const Vec3& p) {
  return 1e-9 * arc_length.total() + 64 * std::numeric_limits<double>::epsilon() * p.norm();
}

void require_curve(const CharacterLine& line) {
  if (!line.curve) throw InputError("curve '" + line.name + "' has no geometry");
  const InputCurve& curve = *line.curve;
  const std::vector<double> breaks = curve.breaks();
  if (breaks.size() < 2 || !(breaks.back() > breaks.front()))
    throw InputError("curve '" + line.name + "' has zero length");
  const Vec3 first = curve.evaluate(breaks.front());
  double far = 0;
  for (size_t i = 0; i + 1 < breaks.size(); ++i)
    for (const double f : {0.0, 0.15, 0.3, 0.5, 0.7, 0.85, 1.0}) {
      const double t = f < 1 ? breaks[i] + f * (breaks[i + 1] - breaks[i]) : breaks[i + 1];
      const Vec3 p = curve.evaluate(t), d = curve.evaluate(t, 1);
      if (!p.allFinite() || !d.allFinite() || !(p.norm() < 1e100))
        throw InputError("curve '" + line.name + "' has a point that is not finite");
      far = std::max(far, (p - first).norm());
    }
  if (!(far > 16 * std::numeric_limits<double>::epsilon() * first.norm()))
    throw InputError("curve '" + line.name + "' has zero length");
}

// True if the canonical direction is opposite to that of the curve.
bool runs_backwards(const InputCurve& curve, const ArcLength& arc_length) {
  const double eps = rounding_error(arc_length, curve.evaluate(curve.start()));
  for (const double f : {0.0, 0.25, 0.125, 0.375, 1.0 / 3, 0.05, 0.2, 0.45}) {
    const Vec3 p = curve.evaluate(arc_length.parameter(f * arc_length.total())),
               q = curve.evaluate(arc_length.parameter((1 - f) * arc_length.total()));
    if (const int c = compare(p, q, eps); c != 0) return c > 0;
  }
  return false;
}

// Parameter at which a closed curve lies farthest along the first generic direction.
double canonical_seam(const InputCurve& curve) {
  const Vec3 w = directions().row(0);
  std::vector<double> t;
  const std::vector<double> breaks = curve.breaks();
  const int per_piece = std::max(4, 64 / static_cast<int>(breaks.size() - 1));
  for (size_t i = 0; i + 1 < breaks.size(); ++i)
    for (int k = 0; k < per_piece; ++k)
      t.push_back(breaks[i] + (breaks[i + 1] - breaks[i]) * k / per_piece);
  size_t best = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < t.size(); ++i)
    if (const double along = w.dot(curve.evaluate(t[i])); along > most) {
      most = along;
      best = i;
    }
  const double period = curve.end() - curve.start();
  double low = best > 0 ? t[best - 1] : t.back() - period,
         high = best + 1 < t.size() ? t[best + 1] : curve.start() + period;
  const auto slope = [&](double at) {
    return w.dot(curve.evaluate(at < curve.start() ? at + period : at, 1));
  };
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (slope(middle) > 0 ? low : high) = middle;
  }
  double seam = 0.5 * (low + high);
  if (seam < curve.start()) seam += period;
  // Snaps to the existing seam if the difference is only rounding.
  if (std::min(seam - curve.start(), curve.end() - seam) < 1e-9 * period) seam = curve.start();
  return seam;
}

std::vector<SampledCurve> cut_line(const CharacterLine& line, int index, double corner_angle) {
  require_curve(line);
  const auto given_arc_length = ArcLength(line.curve);
  if (!(given_arc_length.total() > 0) || !std::isfinite(given_arc_length.total()))
    throw InputError("curve '" + line.name + "' has zero length");
  const auto whole =
      std::make_shared<TrimmedCurve>(line.curve, line.curve->start(), line.curve->end(),
                                     runs_backwards(*line.curve, given_arc_length));
  const double a = whole->start(), b = whole->end();
  const bool closed = (whole->evaluate(a, 0) - whole->evaluate(b, 0)).norm() <=
                      1e-9 * given_arc_length.total() + 64 *
                                                            std::numeric_limits<double>::epsilon() *
                                                            whole->evaluate(a, 0).norm();
  std::vector<double> cuts;
  const std::vector<double> breaks = whole->breaks(), corners = whole->corners();
  for (size_t i = 1; i + 1 < breaks.size(); ++i)
    if (degrees_between(tangent(*whole, breaks[i], -1), tangent(*whole, breaks[i], 1)) >
            corner_angle ||
        std::binary_search(corners.begin(), corners.end(), breaks[i]))
      cuts.push_back(breaks[i]);
  const std::vector<double> given = line.curve->corners();
  const bool corner_at_seam = !given.empty() && given.front() == line.curve->start();
  const bool smooth_seam =
      closed && !corner_at_seam &&
      degrees_between(tangent(*whole, b, -1), tangent(*whole, a, 1)) <= corner_angle;

  std::vector<SampledCurve> sampled_curves;
  const auto add = [&](double from, double to, bool corner_before, bool corner_after) {
    SampledCurve sampled_curve;
    sampled_curve.line = index;
    sampled_curve.curve = whole->part(from, to, false);
    sampled_curve.corner = {corner_before, corner_after};
    sampled_curves.push_back(std::move(sampled_curve));
  };
  if (smooth_seam && cuts.empty()) {
    const double seam = canonical_seam(*whole);
    add(seam, seam + (b - a), false, false);
    sampled_curves[0].closed = true;
  } else if (smooth_seam) {
    for (size_t i = 0; i + 1 < cuts.size(); ++i) add(cuts[i], cuts[i + 1], true, true);
    add(cuts.back(), cuts.front() + (b - a), true, true);
  } else {
    cuts.insert(cuts.begin(), a);
    cuts.push_back(b);
    for (size_t i = 0; i + 1 < cuts.size(); ++i)
      add(cuts[i], cuts[i + 1], i > 0 || closed, i + 2 < cuts.size() || closed);
  }
  return sampled_curves;
}

// A sample of a curve: parameter, arc length from the start, and point.
struct CurveSample {
  double t, s;
  Vec3 x;
};

CurveSample sample_at(const SampledCurve& sampled_curve, double t) {
  return {t, sampled_curve.arc_length->length_at(t), sampled_curve.point(t)};
}

// Appends samples after a up to b, dense enough for the chords to approximate the curve.
void trace(SampledCurve& sampled_curve, const CurveSample& a, const CurveSample& b, int depth) {
  const Vec3 chord = b.x - a.x;
  const double length = chord.norm();
  double sag = 0;
  for (const double f : {0.25, 0.5, 0.75}) {
    const Vec3 p = sampled_curve.point(a.t + f * (b.t - a.t));
    const double along =
        length > 0 ? std::clamp((p - a.x).dot(chord) / (length * length), 0.0, 1.0) : 0;
    sag = std::max(sag, (p - a.x - along * chord).norm());
  }
  constexpr double kMaxSagRatio = 0.05;  // of the chord length
  constexpr double kMaxLengthRatio =
      1.1;  // times the chord: a longer curve leaves it between the samples
  constexpr int kDeepest = 12;
  if (depth < kDeepest &&
      (sag > kMaxSagRatio * length || b.s - a.s > kMaxLengthRatio * length ||
       length > 0.25 * sampled_curve.length) &&
      b.s - a.s > 1e-5 * sampled_curve.length) {
    const CurveSample middle = sample_at(sampled_curve, 0.5 * (a.t + b.t));
    trace(sampled_curve, a, middle, depth + 1);
    trace(sampled_curve, middle, b, depth + 1);
    return;
  }
  sampled_curve.t.push_back(b.t);
  sampled_curve.s.push_back(b.s);
  sampled_curve.x.push_back(b.x);
  sampled_curve.sag.push_back(1.5 * sag);
}

void trace(SampledCurve& sampled_curve) {
  sampled_curve.arc_length = std::make_shared<ArcLength>(sampled_curve.curve);
  sampled_curve.length = sampled_curve.arc_length->total();
  const std::vector<double> breaks = sampled_curve.curve->breaks();
  CurveSample from = sample_at(sampled_curve, breaks.front());
  sampled_curve.t = {from.t};
  sampled_curve.s = {from.s};
  sampled_curve.x = {from.x};
  for (size_t i = 1; i < breaks.size(); ++i) {
    const CurveSample to = sample_at(sampled_curve, breaks[i]);
    trace(sampled_curve, from, to, 0);
    from = to;
  }
}

// Moves input curves that equal another one in every point to its list of duplicates.
void unite_equal(const std::vector<CharacterLine>& lines,
                 std::vector<std::vector<SampledCurve>>& of_line, SampledCurves& all) {
  std::map<std::vector<double>, std::vector<int>> alike;
  for (int i = 0; i < isize(lines); ++i) {
    std::vector<double> points;
    for (const SampledCurve& sampled_curve : of_line[i])
      for (const Vec3& p : sampled_curve.x) points.insert(points.end(), p.begin(), p.end());
    alike[std::move(points)].push_back(i);
  }
  all.duplicates.resize(lines.size());
  for (auto& [points, members] : alike) {
    std::sort(members.begin(), members.end(),
              [&](int i, int j) { return lines[i].name < lines[j].name; });
    for (size_t k = 1; k < members.size(); ++k) {
      all.duplicates[members[0]].push_back(members[k]);
      of_line[members[k]].clear();
    }
  }
}

}  // namespace

TrimmedCurve::TrimmedCurve(std::shared_ptr<const InputCurve> whole, double from, double to,
                           bool backwards)
    : whole_(std::move(whole)),
      given_breaks_(std::make_shared<const std::vector<double>>(whole_->breaks())),
      given_corners_(std::make_shared<const std::vector<double>>(whole_->corners())),
      from_(from),
      to_(to),
      backwards_(backwards) {}

Vec3 TrimmedCurve::evaluate(double t, int order) const {
  const double sliver = 1e-12 * (to_ - from_);
  double u = backwards_ ? -t : t;
  if (order > 0) u = std::clamp(u, from_ + sliver, to_ - sliver);
  if (u > whole_->end() && to_ > whole_->end()) u -= whole_->end() - whole_->start();
  return backwards_ && order == 1 ? Vec3(-whole_->evaluate(u, 1)) : whole_->evaluate(u, order);
}

std::vector<double> TrimmedCurve::corners() const {
  const std::vector<double>& given = *given_corners_;
  std::vector<double> inside(std::upper_bound(given.begin(), given.end(), from_),
                             std::lower_bound(given.begin(), given.end(), to_));
  if (backwards_) {
    std::reverse(inside.begin(), inside.end());
    for (double& c : inside) c = -c;
  }
  return inside;
}

std::vector<double> TrimmedCurve::breaks() const {
  const double sliver = 1e-12 * (to_ - from_);
  const std::vector<double>& given = *given_breaks_;
  const auto first = std::upper_bound(given.begin(), given.end(), from_ + sliver),
             last = std::lower_bound(first, given.end(), to_ - sliver);
  std::vector<double> all = {from_};
  all.insert(all.end(), first, last);
  const double period = whole_->end() - whole_->start();
  for (size_t i = 1; i < given.size() && given[i] + period < to_ - sliver; ++i)
    if (to_ > whole_->end()) all.push_back(given[i] + period);
  all.push_back(to_);
  if (backwards_) {
    std::reverse(all.begin(), all.end());
    for (double& b : all) b = -b;
  }
  return all;
}

std::shared_ptr<const TrimmedCurve> TrimmedCurve::part(double a, double b, bool back) const {
  double from = backwards_ ? -b : a, to = backwards_ ? -a : b;
  // A reversed part across the seam starts below the curve's start: shift by one period.
  const double period = whole_->end() - whole_->start();
  if (from < whole_->start()) from += period, to += period;
  if (from >= whole_->end()) from -= period, to -= period;
  auto part = std::make_shared<TrimmedCurve>(*this);
  part->from_ = from;
  part->to_ = to;
  part->backwards_ = backwards_ != back;
  return part;
}

double SampledCurve::between(double s0, double s1) const {
  const double d = std::abs(s0 - s1);
  return closed ? std::min(d, length - d) : d;
}

double SampledCurve::closest_parameter(const Vec3& p, double t, double low, double high) const {
  t = std::clamp(t, low, high);
  double best = t, nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 40; ++k) {
    const Vec3 d = point(t) - p, d1 = curve->evaluate(t, 1);
    const double distance = d.norm(), g = d.dot(d1), speed_squared = d1.squaredNorm();
    if (distance < nearest) {
      nearest = distance;
      best = t;
    } else if (k > 0) {  // farther than the best point: halve the step
      if (std::abs(t - best) <= 1e-8 * (curve->end() - curve->start())) break;
      t = 0.5 * (t + best);
      continue;
    }
    if (!(speed_squared > 0)) break;
    const double slope =
        std::max(speed_squared + d.dot(curve->evaluate(t, 2)), 0.25 * speed_squared);
    const double next = std::clamp(t - g / slope, low, high);
    if (std::abs(next - t) <= 1e-15 * (curve->end() - curve->start())) break;
    t = next;
  }
  // Close to the minimum, distances differ only by rounding, but the derivative still locates it:
  // Newton.
  t = best;
  for (int k = 0; k < 3; ++k) {
    const Vec3 d = point(t) - p, d1 = curve->evaluate(t, 1);
    const double slope = d1.squaredNorm() + d.dot(curve->evaluate(t, 2)),
                 next = std::clamp(t - d.dot(d1) / slope, low, high);
    if (!(slope > 0) || !(std::abs(next - t) <= 1e-6 * (curve->end() - curve->start()))) break;
    if (next == t) break;
    t = next;
  }
  return t;
}

Vec3 tangent(const InputCurve& curve, double t, int side) {
  const double range = curve.end() - curve.start();
  const double near = std::clamp(t + side * 1e-9 * range, curve.start(), curve.end());
  const Vec3 d = curve.evaluate(near, 1);
  const double other = side > 0 ? std::min(t + 1e-4 * range, curve.end())
                                : std::max(t - 1e-4 * range, curve.start());
  const Vec3 chord = side * (curve.evaluate(other) - curve.evaluate(t));
  // If the derivative vanishes at t, it is also unreliable 1e-9 away from it.
  if (d.norm() * std::abs(other - t) > 1e-3 * chord.norm() && d.norm() > 0) return d.normalized();
  return chord.norm() > 0 ? Vec3(chord.normalized()) : Vec3(Vec3::UnitX());
}

int compare(const Vec3& p, const Vec3& q, double eps) {
  const Vec3 d = directions() * (p - q);
  for (int i = 0; i < 3; ++i)
    if (std::abs(d[i]) > eps) return d[i] > 0 ? 1 : -1;
  return 0;
}

std::array<long long, 3> sort_key(const Vec3& p, const Vec3& origin, double size) {
  const Vec3 d = directions() * (p - origin) / size;
  constexpr double kGrid = 1 << 26;
  return {std::llround(d[0] * kGrid), std::llround(d[1] * kGrid), std::llround(d[2] * kGrid)};
}

SampledCurves make_sampled_curves(const std::vector<CharacterLine>& lines, double corner_angle) {
  if (lines.empty()) throw InputError("found no curves, expected one or more");
  std::set<std::string> names;
  for (const auto& line : lines)
    if (!names.insert(line.name).second)
      throw InputError("two curves of the network have the name '" + line.name + "'");

  std::vector<std::vector<SampledCurve>> of_line(lines.size());
  parallel_for(isize(lines), [&](int i) {
    of_line[i] = cut_line(lines[i], i, corner_angle);
    for (SampledCurve& sampled_curve : of_line[i]) trace(sampled_curve);
  });
  SampledCurves all;
  unite_equal(lines, of_line, all);
  Box3 box;
  for (auto& sampled_curves : of_line)
    for (const auto& sampled_curve : sampled_curves) box.extend(bounding_box(sampled_curve.x));
  all.origin = box.center();
  all.size = box.diagonal().norm();

  struct Entry {
    std::array<long long, 3> start, end, middle;
    const std::string* name;
    int number;  // index along its input curve
    SampledCurve* sampled_curve;
  };
  std::vector<Entry> entries;
  for (auto& sampled_curves : of_line)
    for (size_t k = 0; k < sampled_curves.size(); ++k) {
      SampledCurve& s = sampled_curves[k];
      const auto key = [&](const Vec3& p) { return sort_key(p, all.origin, all.size); };
      entries.push_back({key(s.x.front()), key(s.x.back()),
                         key(s.point(s.arc_length->parameter(0.5 * s.length))), &lines[s.line].name,
                         static_cast<int>(k), &s});
    }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.start, a.end, a.middle, *a.name, a.number) <
           std::tie(b.start, b.end, b.middle, *b.name, b.number);
  });
  std::vector<std::vector<int>> position(lines.size());
  for (size_t i = 0; i < lines.size(); ++i) position[i].resize(of_line[i].size());
  for (const Entry& entry : entries) {
    position[entry.sampled_curve->line][entry.number] = isize(all.sampled_curves);
    all.sampled_curves.push_back(std::move(*entry.sampled_curve));
  }
  for (const auto& sampled_curves : position)
    for (size_t k = 0; k < sampled_curves.size(); ++k) {
      const int here = sampled_curves[k], next = sampled_curves[(k + 1) % sampled_curves.size()];
      if (!all.sampled_curves[here].closed && all.sampled_curves[here].corner[1])
        all.corners.push_back({std::pair{here, 1}, std::pair{next, 0}});
    }
  std::sort(all.corners.begin(), all.corners.end());
  return all;
}

namespace {

// Final Newton steps: close to the minimum, distances differ only by rounding, but the derivatives
// still locate it. Skipped if the curves run parallel.
void polish(const SampledCurve& a, const std::array<double, 2>& range_a, double& ta,
            const SampledCurve& b, const std::array<double, 2>& range_b, double& tb) {
  for (int step = 0; step < 3; ++step) {
    const Vec3 d = a.point(ta) - b.point(tb);
    const Vec3 da = a.curve->evaluate(ta, 1), db = b.curve->evaluate(tb, 1);
    const double haa = da.squaredNorm() + d.dot(a.curve->evaluate(ta, 2)),
                 hbb = db.squaredNorm() - d.dot(b.curve->evaluate(tb, 2)), hab = -da.dot(db),
                 det = haa * hbb - hab * hab;
    const double ga = da.dot(d), gb = -db.dot(d);
    const bool at_a = ta <= range_a[0] || ta >= range_a[1],
               at_b = tb <= range_b[0] || tb >= range_b[1];
    double move_a = 0, move_b = 0;
    if (at_a && at_b) return;
    if (at_a && hbb > 0)
      move_b = -gb / hbb;
    else if (at_b && haa > 0)
      move_a = -ga / haa;
    else if (!at_a && !at_b && haa > 0 && det > 1e-8 * haa * hbb)
      move_a = -(hbb * ga - hab * gb) / det, move_b = -(haa * gb - hab * ga) / det;
    constexpr double kSmall = 1e-6;
    if (!(std::abs(move_a) <= kSmall * (a.t.back() - a.t.front())) ||
        !(std::abs(move_b) <= kSmall * (b.t.back() - b.t.front())))
      return;
    ta = std::clamp(ta + move_a, range_a[0], range_a[1]);
    tb = std::clamp(tb + move_b, range_b[0], range_b[1]);
  }
}

}  // namespace

double chord_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1, double& s,
                      double& t) {
  const Vec3 da = a1 - a0, db = b1 - b0, r = a0 - b0;
  const double a = da.squaredNorm(), e = db.squaredNorm(), f = db.dot(r), c = da.dot(r),
               b = da.dot(db), det = a * e - b * b;
  s = det > 1e-14 * a * e ? std::clamp((b * f - c * e) / det, 0.0, 1.0) : 0.5;
  t = e > 0 ? std::clamp((b * s + f) / e, 0.0, 1.0) : 0.5;
  s = a > 0 ? std::clamp((b * t - c) / a, 0.0, 1.0) : 0.5;
  t = e > 0 ? std::clamp((b * s + f) / e, 0.0, 1.0) : 0.5;
  return (a0 + s * da - b0 - t * db).norm();
}

std::array<double, 2> bracket(const SampledCurve& sampled_curve, int segment) {
  const double a = sampled_curve.t[segment], b = sampled_curve.t[segment + 1],
               more = 0.25 * (b - a);
  return {std::max(a - more, sampled_curve.t.front()), std::min(b + more, sampled_curve.t.back())};
}

double nearest(const SampledCurve& a, const std::array<double, 2>& range_a, double& ta,
               const SampledCurve& b, const std::array<double, 2>& range_b, double& tb) {
  double damping = 1e-9;
  Vec3 d = a.point(ta) - b.point(tb);
  for (int step = 0; step < 30; ++step) {
    const Vec3 da = a.curve->evaluate(ta, 1), db = b.curve->evaluate(tb, 1);
    const double ga = da.dot(d), gb = -db.dot(d);
    const bool fixed_a = (ta <= range_a[0] && ga > 0) || (ta >= range_a[1] && ga < 0),
               fixed_b = (tb <= range_b[0] && gb > 0) || (tb >= range_b[1] && gb < 0);
    if (fixed_a && fixed_b) break;
    const double haa = da.squaredNorm() * (1 + damping), hbb = db.squaredNorm() * (1 + damping),
                 hab = -da.dot(db), det = haa * hbb - hab * hab;
    if (!(haa > 0) || !(hbb > 0)) break;
    double move_a = 0, move_b = 0;
    if (fixed_a)
      move_b = -gb / hbb;
    else if (fixed_b)
      move_a = -ga / haa;
    else
      move_a = -(hbb * ga - hab * gb) / det, move_b = -(haa * gb - hab * ga) / det;
    const double next_a = std::clamp(ta + move_a, range_a[0], range_a[1]),
                 next_b = std::clamp(tb + move_b, range_b[0], range_b[1]);
    const Vec3 next = a.point(next_a) - b.point(next_b);
    if (!(next.norm() <= d.norm())) {
      damping = std::max(10 * damping, 1e-3);
      if (damping > 1e6) break;
      continue;
    }
    const bool settled = std::abs(next_a - ta) <= 1e-15 * (a.t.back() - a.t.front()) &&
                         std::abs(next_b - tb) <= 1e-15 * (b.t.back() - b.t.front());
    ta = next_a;
    tb = next_b;
    d = next;
    damping *= 0.1;
    if (settled) break;
  }
  polish(a, range_a, ta, b, range_b, tb);
  return (a.point(ta) - b.point(tb)).norm();
}

}  // namespace batten::detail
