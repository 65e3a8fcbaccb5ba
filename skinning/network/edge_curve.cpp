#include "batten/skinning/network/edge_curve.h"

#include <algorithm>
#include <cmath>

namespace batten::detail {
namespace {

constexpr double kGrid = 1 << 30;  // parameters are multiples of 1/kGrid

/// The input, drawn to its nodes and turned to their tangents.
class DisplacedCurve final : public InputCurve {
 public:
  DisplacedCurve(const EdgeCurveInput& plan, double tolerance)
      : input_(plan.input), arc_length_(plan.input), length_(arc_length_.total()) {
    const double a = input_->start(), b = input_->end();
    shift_ = {plan.start - input_->evaluate(a, 0), plan.end - input_->evaluate(b, 0)};
    tangent_change_ = {plan.start_tangent - tangent(*input_, a, 1),
                       plan.end_tangent - tangent(*input_, b, -1)};
    for (int e = 0; e < 2; ++e) {
      // s (1 - s/R)² is 4/27 R at most.
      const double most = 0.5 * tolerance * 27 / 4, amount = tangent_change_[e].norm();
      reach_[e] = amount * length_ > most ? most / amount : length_;
    }
  }
  bool changes(double size) const {
    const double moved = std::max(shift_[0].norm(), shift_[1].norm());
    // Directions are looked up a little beside the ends, and differ that much on any curve.
    return moved > 1e-13 * size ||
           std::max(tangent_change_[0].norm(), tangent_change_[1].norm()) > 1e-7;
  }
  double start() const override { return input_->start(); }
  double end() const override { return input_->end(); }
  std::vector<double> breaks() const override { return input_->breaks(); }
  Vec3 evaluate(double t, int order) const override {
    const double s = arc_length_.length_at(t), f = s / length_, h = f * f * (3 - 2 * f),
                 dh = 6 * f * (1 - f) / length_;
    if (order == 0)
      return input_->evaluate(t, 0) + (1 - h) * shift_[0] + h * shift_[1] +
             tangent_correction(s, reach_[0], 0) * tangent_change_[0] -
             tangent_correction(length_ - s, reach_[1], 0) * tangent_change_[1];
    const Vec3 along = input_->evaluate(t, 1);  // derivatives of higher order are not asked for
    return along +
           along.norm() * (dh * (shift_[1] - shift_[0]) +
                           tangent_correction(s, reach_[0], 1) * tangent_change_[0] +
                           tangent_correction(length_ - s, reach_[1], 1) * tangent_change_[1]);
  }

 private:
  static double tangent_correction(double s, double reach, int order) {
    const double f = s / reach, rest = 1 - f;
    if (f >= 1) return 0;
    return order == 0 ? s * rest * rest : rest * (1 - 3 * f);
  }

  std::shared_ptr<const InputCurve> input_;
  ArcLength arc_length_;
  double length_;
  std::array<Vec3, 2> shift_, tangent_change_;
  std::array<double, 2> reach_{};
};

class Interpolation {
 public:
  Interpolation(const EdgeCurveInput& plan, std::shared_ptr<const InputCurve> curve, double size,
                double fit)
      : plan_(plan),
        curve_(std::move(curve)),
        arc_length_(curve_),
        breaks_(curve_->breaks()),
        size_(size),
        fit_(fit) {}

  EdgeCurve run() {
    const double whole = std::max(1.0, std::round(arc_length_.total() / size_ * kGrid)) / kGrid;
    while (deepest_ > 0 && whole / (1L << deepest_) < 64 / kGrid) --deepest_;
    Node first{0, plan_.start, plan_.start_tangent}, last{1, plan_.end, plan_.end_tangent};
    nodes_ = {first};
    halve(first, last, 0);
    const auto n = static_cast<long>(nodes_.size());
    std::vector<double> u;
    Points x(n, 3), slope(n, 3);
    for (long i = 0; i < n; ++i) {
      u.push_back(std::round(nodes_[i].fraction * whole * kGrid) / kGrid);
      x.row(i) = nodes_[i].x;
      slope.row(i) = size_ * nodes_[i].tangent;
    }
    u.back() = whole;
    HermiteCurve result(std::move(u), x, slope);
    return {std::move(result), arc_length_.total(), deviation_};
  }

 private:
  struct Node {
    double fraction;  // of the length
    Vec3 x, tangent;
  };

  // In the middle of both sides where the direction jumps, so that it is the same backwards.
  Vec3 tangent_at(double t) const {
    const double range = curve_->end() - curve_->start();
    const auto near = std::lower_bound(breaks_.begin(), breaks_.end(), t - 1e-8 * range);
    const bool at_break = near != breaks_.end() && *near < t + 1e-8 * range;
    const Vec3 d = curve_->evaluate(t, 1);
    if (!at_break && d.norm() > 1e-6 * arc_length_.total() / range) return d.normalized();
    const double where = at_break ? *near : t;
    const Vec3 mean = tangent(*curve_, where, -1) + tangent(*curve_, where, 1);
    return mean.norm() > 0 ? Vec3(mean.normalized()) : tangent(*curve_, where, 1);
  }

  Node node_at(double fraction) const {
    const double t = arc_length_.parameter(fraction * arc_length_.total());
    return {fraction, curve_->evaluate(t, 0), tangent_at(t)};
  }

  void halve(const Node& a, const Node& b, int depth) {
    const double h = (b.fraction - a.fraction) * arc_length_.total();
    double off = 0, from_input = 0;
    for (const double s : {0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9}) {
      const double t =
          arc_length_.parameter((a.fraction + s * (b.fraction - a.fraction)) * arc_length_.total());
      const double r = 1 - s, r2 = r * r, s2 = s * s;
      const Vec3 p = (r2 * (1 + 2 * s)) * a.x + (s2 * (1 + 2 * r)) * b.x +
                     h * ((s * r2) * a.tangent - (s2 * r) * b.tangent);
      off = std::max(off, (p - curve_->evaluate(t, 0)).norm());
      from_input = std::max(from_input, (p - plan_.input->evaluate(t, 0)).norm());
    }
    constexpr double kSafetyFactor = 0.9;  // a peak may lie between the points that were looked at
    if (off <= kSafetyFactor * fit_ || depth >= deepest_) {
      nodes_.push_back(b);
      const double at_end =
          (b.x - plan_.input->evaluate(arc_length_.parameter(b.fraction * arc_length_.total()), 0))
              .norm();
      deviation_ = std::max({deviation_, from_input, at_end});
      return;
    }
    const Node middle = node_at(0.5 * (a.fraction + b.fraction));
    halve(a, middle, depth + 1);
    halve(middle, b, depth + 1);
  }

  const EdgeCurveInput& plan_;
  std::shared_ptr<const InputCurve> curve_;
  ArcLength arc_length_;
  std::vector<double> breaks_;
  double size_, fit_;
  int deepest_ = 14;
  std::vector<Node> nodes_;
  double deviation_ = 0;
};

}  // namespace

EdgeCurve make_edge_curve(const EdgeCurveInput& plan, double size, double tolerance, double fit) {
  const auto drawn = std::make_shared<DisplacedCurve>(plan, tolerance);
  std::shared_ptr<const InputCurve> curve = plan.input;
  if (drawn->changes(size)) curve = drawn;
  EdgeCurve shape = Interpolation(plan, curve, size, fit).run();
  shape.deviation =
      std::max(shape.deviation, (plan.start - plan.input->evaluate(plan.input->start(), 0)).norm());
  return shape;
}

}  // namespace batten::detail
