#include "batten/fairing/input_curve.h"

#include "batten/core/errors.h"
#include "batten/core/format.h"

namespace batten {
namespace {

class Hermite final : public InputCurve {
 public:
  explicit Hermite(HermiteCurve curve) : curve_(std::move(curve)) {}
  double start() const override { return curve_.start(); }
  double end() const override { return curve_.end(); }
  Vec3 evaluate(double t, int order) const override {
    // Not around the seam of a closed curve.
    if (t >= curve_.end()) return curve_.evaluate({curve_.segment_count() - 1, 1}, order);
    return curve_.evaluate(t, order);
  }
  std::vector<double> breaks() const override { return curve_.parameters(); }
  std::vector<double> corners() const override {
    std::vector<double> all;
    for (const int node : curve_.mesh().corners())
      all.push_back(curve_.parameters()[static_cast<size_t>(node)]);
    return all;
  }
  bool piecewise_cubic() const override { return true; }

 private:
  HermiteCurve curve_;
};

class FormulaCurve final : public InputCurve {
 public:
  FormulaCurve(double start, double end, std::function<Vec3(double, int)> formula)
      : start_(start), end_(end), formula_(std::move(formula)) {}
  double start() const override { return start_; }
  double end() const override { return end_; }
  Vec3 evaluate(double t, int order) const override { return formula_(t, order); }

 private:
  double start_, end_;
  std::function<Vec3(double, int)> formula_;
};

class BezierCurve final : public InputCurve {
 public:
  BezierCurve(const Vec3& p0, const Vec3& p1, const Vec3& p2, const Vec3& p3)
      : c_{p0, 3 * (p1 - p0), 3 * (p2 - 2 * p1 + p0), p3 - 3 * p2 + 3 * p1 - p0} {}
  double start() const override { return 0; }
  double end() const override { return 1; }
  Vec3 evaluate(double t, int order) const override {
    switch (order) {
      case 0:
        return c_[0] + t * (c_[1] + t * (c_[2] + t * c_[3]));
      case 1:
        return c_[1] + t * (2 * c_[2] + 3 * t * c_[3]);
      default:
        return 2 * c_[2] + 6 * t * c_[3];
    }
  }
  bool piecewise_cubic() const override { return true; }

 private:
  Vec3 c_[4];
};

}  // namespace

std::shared_ptr<const InputCurve> curve_from_hermite(HermiteCurve curve) {
  return std::make_shared<Hermite>(std::move(curve));
}

std::shared_ptr<const InputCurve> curve_from_formula(double start, double end,
                                                     std::function<Vec3(double, int)> formula) {
  if (!(end > start)) throw InputError("a formula curve needs start < end");
  return std::make_shared<FormulaCurve>(start, end, std::move(formula));
}

std::shared_ptr<const InputCurve> bezier_curve(const Vec3& p0, const Vec3& p1, const Vec3& p2,
                                               const Vec3& p3) {
  return std::make_shared<BezierCurve>(p0, p1, p2, p3);
}

}  // namespace batten
