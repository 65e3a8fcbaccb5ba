// SPDX-License-Identifier: MPL-2.0
// Developable domains: unfolds outlines that have neither a polygon nor a simple projection.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/skinning/domains/domain_input.h"
#include "batten/skinning/domains/hole_triangulation.h"
#include "batten/skinning/region/polygon_fit.h"

namespace batten {
namespace {

using std::numbers::pi;
constexpr int kSamplesPerSegment = 4;  // per segment of the pcurve
constexpr int kMaxSegments = 44;       // of the whole outline: 176 samples

// One line of the outline and the nodes that divide its pcurve into segments.
struct LoopSide {
  HermiteCurve curve;
  std::vector<double> nodes;  // parameters of the nodes, ascending
};

// A sampled point of the outline; x relative to its start, over its size.
struct Sample {
  size_t side;
  double t;
  Vec3 x;
};

// Cumulative monitor function of a curve, from its change of direction and its length. The segments
// of the pcurve equidistribute it. `t`: parameters of the values.
std::vector<double> monitor_function(const HermiteCurve& curve, double around,
                                     std::vector<double>& t) {
  constexpr int samples = 24;  // per segment of the curve
  // Length as a fraction of the perimeter.
  constexpr double angle_per_segment = pi / 9, length_per_segment = 1.0 / 14;
  std::vector<double> sum{0};
  t = {curve.start()};
  Vec3 before = curve.evaluate({0, 0.0}, 1).normalized();
  for (int s = 0; s < curve.segment_count(); ++s)
    for (int k = 1; k <= samples; ++k) {
      const CurveMesh::SegmentPoint at{s, static_cast<double>(k) / samples};
      const Vec3 slope = curve.evaluate(at, 1), direction = slope.normalized();
      const double h = curve.mesh().length(s) / samples;
      const double turning_angle =
          std::atan2(before.cross(direction).norm(), before.dot(direction));
      sum.push_back(sum.back() + turning_angle / angle_per_segment +
                    h * slope.norm() / (length_per_segment * around));
      t.push_back(curve.parameters()[s] + h * k);
      before = direction;
    }
  t.back() = curve.end();
  return sum;
}

std::vector<LoopSide> sides_of(const std::vector<EmbeddedLine>& lines) {
  double around = 0;
  for (const EmbeddedLine& line : lines) around += line.fitted.length();
  std::vector<std::vector<double>> sums, t(lines.size());
  double total = 0;
  for (size_t i = 0; i < lines.size(); ++i) {
    sums.push_back(monitor_function(lines[i].fitted, around, t[i]));
    total += sums.back().back();
  }
  const double most = std::max<double>(kMaxSegments - static_cast<double>(lines.size()), 12);
  const double segment_ratio = std::min(1.0, most / total);
  std::vector<LoopSide> sides;
  for (size_t i = 0; i < lines.size(); ++i) {
    const std::vector<double>& sum = sums[i];
    const int least = lines.size() == 1 ? 8 : 1;
    const int count = std::max(least, static_cast<int>(std::ceil(segment_ratio * sum.back())));
    LoopSide side{lines[i].fitted, {t[i].front()}};
    for (int k = 1; k < count; ++k) {
      const double target = sum.back() * k / count;
      const auto above = std::upper_bound(sum.begin(), sum.end(), target) - sum.begin();
      const auto j = static_cast<size_t>(above);
      side.nodes.push_back(round_to_grid(
          t[i][j - 1] + (target - sum[j - 1]) / (sum[j] - sum[j - 1]) * (t[i][j] - t[i][j - 1])));
    }
    side.nodes.push_back(t[i].back());
    sides.push_back(std::move(side));
  }
  return sides;
}

std::vector<Sample> samples_of(const std::vector<LoopSide>& sides, double size) {
  std::vector<Sample> samples;
  const Vec3 origin = sides[0].curve.position(0);
  for (size_t s = 0; s < sides.size(); ++s)
    for (size_t i = 0; i + 1 < sides[s].nodes.size(); ++i)
      for (int k = 0; k < kSamplesPerSegment; ++k) {
        const double a = sides[s].nodes[i], b = sides[s].nodes[i + 1];
        const double t = a + (b - a) * k / kSamplesPerSegment;
        samples.push_back(
            {s, t, round_to_grid(Vec3((sides[s].curve.evaluate(t) - origin) / size))});
      }
  return samples;
}

// Unfolds the triangles into the plane one after the other, each at an edge that it shares with one
// already unfolded.
std::vector<Vec2> unfold(const std::vector<Vec3>& x, const HoleTriangulation& triangulation) {
  std::map<std::pair<int, int>, size_t> beside;  // the triangle to the left of a directed edge
  for (size_t t = 0; t < triangulation.triangles.size(); ++t)
    for (int i = 0; i < 3; ++i)
      beside[{triangulation.triangles[t][i], triangulation.triangles[t][(i + 1) % 3]}] = t;
  std::vector<Vec2> p(x.size(), Vec2::Zero());
  std::vector<char> laid(triangulation.triangles.size(), 0);
  // Unfolds vertex c to the left of the edge from a to b.
  const auto lay = [&](int a, int b, int c) {
    const Vec3 ab = x[b] - x[a], ac = x[c] - x[a];
    const double length = ab.norm();
    const Vec2 u = (p[b] - p[a]).normalized();
    p[c] = p[a] + ac.dot(ab) / length * u + ab.cross(ac).norm() / length * Vec2(-u.y(), u.x());
  };
  const auto& first = triangulation.triangles[0];
  p[first[1]] = Vec2((x[first[1]] - x[first[0]]).norm(), 0);
  lay(first[0], first[1], first[2]);
  std::vector<size_t> stack{0};
  laid[0] = 1;
  while (!stack.empty()) {
    const auto triangle = triangulation.triangles[stack.back()];
    stack.pop_back();
    for (int i = 0; i < 3; ++i) {
      const int a = triangle[i], b = triangle[(i + 1) % 3];
      const auto next = beside.find({b, a});
      if (next == beside.end() || laid[next->second]) continue;
      for (const int c : triangulation.triangles[next->second])
        if (c != a && c != b) lay(b, a, c);
      laid[next->second] = 1;
      stack.push_back(next->second);
    }
  }
  return p;
}

struct FlattenedSamples {
  std::vector<Vec2> p;
  std::vector<TriangulationCorner> corners;  // of the triangulation, in space
};

// The samples in the plane: unfolded, or a relaxed polygon if the unfolding overlaps itself.
FlattenedSamples flatten_samples(const std::vector<Sample>& samples) {
  std::vector<Vec3> x;
  for (const Sample& s : samples) x.push_back(s.x);
  const auto triangulation = developable_triangulation(x);
  if (!triangulation)
    throw InputError("all outline curves lie on one straight line and enclose no area");
  std::vector<Vec2> p = unfold(x, *triangulation);
  const std::vector<TriangulationCorner> corner_data = triangulation_corners(x, *triangulation);
  if (is_simple_and_ccw(p)) return {p, corner_data};
  // The polygon has fewer corners than samples; the samples between them are interpolated.
  constexpr size_t max_corners = 90;
  const size_t n = x.size(), stride = (n + max_corners - 1) / max_corners;
  std::vector<size_t> kept;
  for (size_t i = 0; i < n; i += stride) kept.push_back(i);
  std::vector<double> lengths, interior_angles;
  for (size_t k = 0; k < kept.size(); ++k) {
    const size_t to = k + 1 < kept.size() ? kept[k + 1] : n;
    double length = 0;
    for (size_t i = kept[k]; i < to; ++i) length += (x[(i + 1) % n] - x[i]).norm();
    lengths.push_back(length);
    // Total turning angle around the corner, half the way to its neighbours.
    const size_t half = stride / 2;
    double turning_angle = 0;
    for (size_t j = 0; j < stride; ++j)
      turning_angle += pi - corner_data[(kept[k] + n + j - half) % n].angle;
    interior_angles.push_back(pi - turning_angle);
  }
  const std::vector<Vec2> corners = relax_polygon(lengths, interior_angles);
  for (size_t k = 0; k < kept.size(); ++k) {
    const size_t to = k + 1 < kept.size() ? kept[k + 1] : n;
    const Vec2 &a = corners[k], &b = corners[(k + 1) % corners.size()];
    double before = 0;
    for (size_t i = kept[k]; i < to; ++i) {
      p[i] = a + before / lengths[k] * (b - a);
      before += (x[(i + 1) % n] - x[i]).norm();
    }
  }
  return {p, corner_data};
}

Mat2 rotation(double angle) {
  Mat2 r;
  r << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return r;
}

// Least-squares fit of C1 pcurves to the samples in the plane. Each node has a position and one
// slope, which has length 1 if the pcurve is as fast as the curve. At a corner the outgoing slope
// is the incoming one, rotated by the turning angle.
class PcurveFit {
 public:
  PcurveFit(const std::vector<LoopSide>& sides, const std::vector<double>& turning_angle_at_start,
            double size)
      : sides_(sides), turning_angles_(turning_angle_at_start), size_(size) {
    for (const LoopSide& side : sides) {
      first_.push_back(count_);
      count_ += isize(side.nodes) - 1;
    }
  }

  std::vector<HermiteCurve> fit(const std::vector<Sample>& samples, const std::vector<Vec2>& p) {
    const long unknowns = 4L * count_;
    MatX H = MatX::Zero(unknowns, unknowns);
    VecX g = VecX::Zero(unknowns);
    for (size_t i = 0; i < samples.size(); ++i) {
      const Sample& s = samples[i];
      const size_t segment = segment_of(s);
      add(s.side, segment, s.t, p[i], weight(s.side, segment), H, g);
    }
    for (size_t s = 0; s < sides_.size(); ++s) {
      const size_t last = sides_[s].nodes.size() - 1;
      for (size_t k = 1; k < last; ++k) penalize_curvature_jump(s, k - 1, k, H);
      if (sides_[s].curve.closed()) penalize_curvature_jump(s, last - 1, 0, H);
    }
    const VecX q = solve_symmetric(H, g);
    std::vector<HermiteCurve> pcurves;
    for (size_t s = 0; s < sides_.size(); ++s) pcurves.push_back(pcurve(s, q));
    return pcurves;
  }

 private:
  size_t segment_of(const Sample& s) const {
    const std::vector<double>& nodes = sides_[s.side].nodes;
    const auto above = std::upper_bound(nodes.begin(), nodes.end(), s.t) - nodes.begin();
    return std::min(static_cast<size_t>(above) - 1, nodes.size() - 2);
  }
  // Weight of one sample: proportional to the arc length of its segment.
  double weight(size_t side, size_t segment) const {
    const std::vector<double>& nodes = sides_[side].nodes;
    return (nodes[segment + 1] - nodes[segment]) *
           sides_[side].curve.evaluate(0.5 * (nodes[segment] + nodes[segment + 1]), 1).norm();
  }
  int node(size_t side, size_t k) const { return (first_[side] + static_cast<int>(k)) % count_; }
  // Map from a node's slope to dc/dt: scaled by the curve's speed, and rotated by the turning angle
  // if it leaves a corner.
  Mat2 slope_map(size_t side, size_t k, bool leaving) const {
    const HermiteCurve& curve = sides_[side].curve;
    const double t = sides_[side].nodes[k];
    const bool last = k + 1 == sides_[side].nodes.size();
    const double speed =
        (last ? curve.evaluate({curve.segment_count() - 1, 1.0}, 1) : curve.evaluate(t, 1)).norm() /
        size_;
    return speed * (leaving && k == 0 ? rotation(turning_angles_[side]) : Mat2(Mat2::Identity()));
  }

  void add(size_t side, size_t segment, double t, const Vec2& p, double w, MatX& H, VecX& g) const {
    const std::vector<double>& nodes = sides_[side].nodes;
    const double h = nodes[segment + 1] - nodes[segment];
    const double s = (t - nodes[segment]) / h;
    const double f[4] = {1 - s * s * (3 - 2 * s), h * s * (1 - s) * (1 - s), s * s * (3 - 2 * s),
                         -h * s * s * (1 - s)};
    Eigen::Matrix<double, 2, 8> N;
    N << f[0] * Mat2::Identity(), f[1] * slope_map(side, segment, true), f[2] * Mat2::Identity(),
        f[3] * slope_map(side, segment + 1, false);
    const long at[2] = {4L * node(side, segment), 4L * node(side, segment + 1)};
    for (int a = 0; a < 2; ++a) {
      g.segment<4>(at[a]) += w * N.middleCols<4>(4 * a).transpose() * p;
      for (int b = 0; b < 2; ++b)
        H.block<4, 4>(at[a], at[b]) +=
            w * N.middleCols<4>(4 * a).transpose() * N.middleCols<4>(4 * b);
    }
  }

  // Penalty on jumps of the second derivative between segments, because the unfolded points
  // oscillate slightly to the left and right, as the triangles do.
  void penalize_curvature_jump(size_t side, size_t before, size_t after, MatX& H) const {
    constexpr double weight_of_jump = 0.3;
    const std::vector<double>& nodes = sides_[side].nodes;
    const double h1 = nodes[before + 1] - nodes[before], h2 = nodes[after + 1] - nodes[after];
    // c'' h² of a cubic is 6 p0 - 6 p1 + 2 h d0 + 4 h d1 at its end; mirrored at its start.
    const double h = 0.5 * (h1 + h2), a = h * h / (h1 * h1), b = h * h / (h2 * h2);
    const Mat2 I = Mat2::Identity();
    Eigen::Matrix<double, 2, 12> jump;
    jump << 6 * a * I, 2 * a * h1 * slope_map(side, before, true), (6 * b - 6 * a) * I,
        (4 * a * h1 + 4 * b * h2) * slope_map(side, after == 0 ? before + 1 : after, false),
        -6 * b * I, 2 * b * h2 * slope_map(side, after + 1, false);
    jump /= 6;
    const long at[3] = {4L * node(side, before), 4L * node(side, before + 1),
                        4L * node(side, after + 1)};
    const double w = weight_of_jump * 0.5 * (weight(side, before) + weight(side, after));
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        H.block<4, 4>(at[i], at[j]) +=
            w * jump.middleCols<4>(4 * i).transpose() * jump.middleCols<4>(4 * j);
  }

  HermiteCurve pcurve(size_t side, const VecX& q) const {
    const std::vector<double>& nodes = sides_[side].nodes;
    const auto n = static_cast<long>(nodes.size());
    const double span = nodes.back() - nodes.front();
    Points x(n, 3), d(n, 3);
    for (long k = 0; k < n; ++k) {
      const auto at = static_cast<size_t>(k);
      const Vec2 position = q.segment<2>(4L * node(side, at));
      const Vec2 slope = slope_map(side, at, true) * q.segment<2>(4L * node(side, at) + 2);
      x.row(k) << round_to_grid(position.x()), round_to_grid(position.y()), 0;
      d.row(k) = round_slope_to_grid({slope.x(), slope.y(), 0}, span);
    }
    if (!sides_[side].curve.closed()) return {nodes, x, d};
    Points dofs(2 * (n - 1), 3);
    for (long k = 0; k + 1 < n; ++k) {
      dofs.row(2 * k) = x.row(k);
      dofs.row(2 * k + 1) = d.row(k);
    }
    return {CurveMesh(nodes, true), dofs};
  }

  const std::vector<LoopSide>& sides_;
  const std::vector<double>& turning_angles_;
  double size_;
  std::vector<int> first_;  // first node of each side
  int count_ = 0;
};

bool simple(const std::vector<HermiteCurve>& pcurves) {
  constexpr int cuts = 8;
  std::vector<Vec2> p;
  for (const HermiteCurve& pcurve : pcurves)
    for (int s = 0; s < pcurve.segment_count(); ++s)
      for (int k = 0; k < cuts; ++k) {
        const Vec3 c = pcurve.evaluate({s, static_cast<double>(k) / cuts});
        p.emplace_back(c.x(), c.y());
      }
  return is_simple_and_ccw(p);
}

}  // namespace

RegionGeometry make_developable_geometry(const Outline& loop, const DomainInput& task) {
  RegionGeometry geometry;
  warn_about_rounded_kinks(loop, task.options.corner_angle, geometry.warnings);
  geometry.embedded = fit_loop_lines(loop, task);
  for (const EmbeddedLine& line : geometry.embedded)
    if (line.line.mesh_alignment == CharacterLine::MeshAlignment::EdgeAligned)
      throw InputError("curve '" + line.line.name +
                       "' has alignment = \"aligned\", but curves of a developable domain are "
                       "always embedded");
  const std::vector<LoopSide> sides = sides_of(geometry.embedded);
  const std::vector<Sample> samples = samples_of(sides, task.size);
  const FlattenedSamples flat = flatten_samples(samples);
  std::vector<Vec2> p = flat.p;

  // u along the first line, the mean of the samples at the origin.
  const size_t first_end =
      static_cast<size_t>(kSamplesPerSegment) * (sides.size() == 1 ? 1 : sides[0].nodes.size() - 1);
  const Vec2 u = (p[first_end % p.size()] - p[0]).normalized();
  const Vec2 middle =
      std::accumulate(p.begin(), p.end(), Vec2(Vec2::Zero())) / static_cast<double>(p.size());
  for (Vec2& x : p) x = Vec2(u.dot(x - middle), cross(u, Vec2(x - middle)));

  // Corner angles are those between the lines in space; the triangulation decides to which side
  // they turn.
  std::vector<double> turning_angle(sides.size(), 0);
  size_t sample = 0;
  for (size_t s = 0; s < sides.size(); ++s) {
    if (loop.is_corner(s)) {
      const LoopVertex vertex = loop_vertex_at(loop, s);
      const double in_space = std::atan2(vertex.incoming.cross(vertex.outgoing).norm(),
                                         vertex.incoming.dot(vertex.outgoing));
      const bool left = turns_left(vertex.incoming, vertex.outgoing, flat.corners[sample]);
      turning_angle[s] = left ? in_space : -in_space;
    }
    sample += static_cast<size_t>(kSamplesPerSegment) * (sides[s].nodes.size() - 1);
  }
  const std::vector<HermiteCurve> pcurves =
      PcurveFit(sides, turning_angle, task.size).fit(samples, p);
  if (!simple(pcurves))
    throw InputError("the outline with curve '" + geometry.embedded[0].line.name +
                     "' intersects itself when it is flattened; divide the face with another "
                     "curve");

  geometry.boundary.resize(1);
  for (size_t s = 0; s < sides.size(); ++s) {
    geometry.embedded[s].pcurve = pcurves[s];
    geometry.boundary[0].push_back({BoundarySegment::Kind::Embedded, static_cast<int>(s)});
    if (!loop.is_corner(s)) continue;
    constexpr double degrees = 180 / pi;
    const double angle = degrees * (pi - turning_angle[s]);
    const Vec3 c = pcurves[s].position(0);
    geometry.corners.push_back({Vec2(c.x(), c.y()), angle, angle});
  }
  geometry.mesh = make_grid_mesh(DomainLoops({pcurves}), task);
  return geometry;
}

}  // namespace batten
