// Inside of rings: a rim with its lines.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "batten/skinning/domains/domain_input.h"

namespace batten {

/// Returns the part of x in [0, 1).
inline double fractional_part(double x) {
  x -= std::floor(x);
  return x < 1 ? x : 0;
}

/// A closed curve that has its seam at another of its points.
class RotatedSeamCurve final : public InputCurve {
 public:
  RotatedSeamCurve(std::shared_ptr<const InputCurve> whole, double seam)
      : whole_(std::move(whole)),
        seam_(seam),
        before_(whole_->end() - seam),
        period_(whole_->end() - whole_->start()) {}
  double start() const override { return 0; }
  double end() const override { return period_; }
  Vec3 evaluate(double t, int order) const override {
    return whole_->evaluate(t < before_ ? seam_ + t : seam_ + t - period_, order);
  }
  std::vector<double> breaks() const override {
    std::vector<double> all = {0};
    const auto prescribed = whole_->breaks();
    for (const double b : prescribed)
      if (b > seam_) all.push_back(b - seam_);
    for (const double b : prescribed)
      if (b > whole_->start() && b < seam_) all.push_back(b - seam_ + period_);
    all.push_back(period_);
    return all;
  }

 private:
  std::shared_ptr<const InputCurve> whole_;
  double seam_, before_, period_;
};

/// A rim and where its lines lie on it, in the direction of u.
struct BoundaryCircle {
  Outline outline;
  std::vector<ArcLength> arcs;
  double length = 0;
  struct Span {
    double from, length_fraction;  // of the rim's length; from in [0, 1)
    HermiteCurve fitted;           // along the rim
  };
  std::vector<Span> spans;  // of each line

  explicit BoundaryCircle(Outline loop) : outline(std::move(loop)) {
    for (const auto& p : outline.segments) {
      arcs.emplace_back(p.segment.curve);
      length += arcs.back().total();
    }
    // Slopes of given curves go on from one to the next over their own parameters.
    std::vector<double> before = {0};
    for (size_t i = 0; i < arcs.size(); ++i)
      before.push_back(before.back() + (prescribed() ? prescribed(i).end() - prescribed(i).start()
                                                     : arcs[i].total()));
    for (size_t i = 0; i < arcs.size(); ++i) {
      const auto length_fraction = [&](double part) {
        return prescribed() ? part / before.back() : round_to_grid(part / length);
      };
      const double from = length_fraction(before[i]);
      spans.push_back({from, length_fraction(before[i + 1]) - from, {}});
    }
  }
  bool prescribed() const { return outline.segments[0].segment.prescribed != nullptr; }
  const HermiteCurve& prescribed(size_t i) const {
    return outline.segments[i].segment.prescribed->curve;
  }
  bool is_single_line() const { return spans.size() == 1; }

  struct Point {
    Vec3 x, tangent;
  };
  Point point(double fraction) const {
    double s = fractional_part(fraction) * length;
    size_t i = 0;
    for (; i + 1 < arcs.size() && s > arcs[i].total(); ++i) s -= arcs[i].total();
    const double t = arcs[i].parameter(s);
    const InputCurve& curve = *outline.segments[i].segment.curve;
    return {curve.evaluate(t), curve.evaluate(t, 1).normalized()};
  }

  // Returns a rim of one line with its seam at another place.
  BoundaryCircle with_seam_at(double fraction) const {
    Outline cut = outline;
    auto& piece = cut.segments[0];
    const double t = arcs[0].parameter(fractional_part(fraction) * length);
    if (t > piece.segment.curve->start() && t < piece.segment.curve->end()) {
      piece.segment.curve = std::make_shared<RotatedSeamCurve>(piece.segment.curve, t);
      piece.start = piece.segment.curve->evaluate(0);
    }
    return BoundaryCircle(std::move(cut));
  }
};

}  // namespace batten
