// Inside of rings: a rim with its lines.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "batten/skinning/domains/domain_task.h"

namespace batten {

/// Returns the part of x in [0, 1).
inline double fraction_of(double x) {
  x -= std::floor(x);
  return x < 1 ? x : 0;
}

/// A closed curve that has its seam at another of its points.
class Reseamed final : public InputCurve {
 public:
  Reseamed(std::shared_ptr<const InputCurve> whole, double seam)
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
    const auto given = whole_->breaks();
    for (const double b : given)
      if (b > seam_) all.push_back(b - seam_);
    for (const double b : given)
      if (b > whole_->start() && b < seam_) all.push_back(b - seam_ + period_);
    all.push_back(period_);
    return all;
  }

 private:
  std::shared_ptr<const InputCurve> whole_;
  double seam_, before_, period_;
};

/// A rim and where its lines lie on it, in the direction of u.
struct Rim {
  Outline outline;
  std::vector<ArcLength> arcs;
  double length = 0;
  struct Place {
    double from, share;   // of the rim's length; from in [0, 1)
    HermiteCurve fitted;  // along the rim
  };
  std::vector<Place> places;  // of each line

  explicit Rim(Outline loop) : outline(std::move(loop)) {
    for (const auto& p : outline.pieces) {
      arcs.emplace_back(p.stretch.curve);
      length += arcs.back().total();
    }
    // Slopes of given curves go on from one to the next over their own parameters.
    std::vector<double> before = {0};
    for (size_t i = 0; i < arcs.size(); ++i)
      before.push_back(before.back() +
                       (given() ? given(i).end() - given(i).start() : arcs[i].total()));
    for (size_t i = 0; i < arcs.size(); ++i) {
      const auto share = [&](double part) {
        return given() ? part / before.back() : rounded(part / length);
      };
      const double from = share(before[i]);
      places.push_back({from, share(before[i + 1]) - from, {}});
    }
  }
  bool given() const { return outline.pieces[0].stretch.given != nullptr; }
  const HermiteCurve& given(size_t i) const { return outline.pieces[i].stretch.given->curve; }
  bool one_line() const { return places.size() == 1; }

  struct Point {
    Vec3 x, tangent;
  };
  Point point(double fraction) const {
    double s = fraction_of(fraction) * length;
    size_t i = 0;
    for (; i + 1 < arcs.size() && s > arcs[i].total(); ++i) s -= arcs[i].total();
    const double t = arcs[i].parameter(s);
    const InputCurve& curve = *outline.pieces[i].stretch.curve;
    return {curve.evaluate(t), curve.evaluate(t, 1).normalized()};
  }

  // Returns a rim of one line with its seam at another place.
  Rim cut_at(double fraction) const {
    Outline cut = outline;
    auto& piece = cut.pieces[0];
    const double t = arcs[0].parameter(fraction_of(fraction) * length);
    if (t > piece.stretch.curve->start() && t < piece.stretch.curve->end()) {
      piece.stretch.curve = std::make_shared<Reseamed>(piece.stretch.curve, t);
      piece.start = piece.stretch.curve->evaluate(0);
    }
    return Rim(std::move(cut));
  }
};

}  // namespace batten
