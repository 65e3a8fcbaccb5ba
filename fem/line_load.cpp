#include "batten/fem/line_load.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/planar_geometry.h"

namespace batten {
namespace {

// Which cubic of which element a parameter of the line is on.
struct Cubic {
  int triangle, sub;
  bool operator==(const Cubic&) const = default;
};

// The cubics that a line with this image passes through.
class ElementCrossings {
 public:
  ElementCrossings(const ParametricMesh& mesh, TriangleElement kind, const TriangleLocator& locator,
                   const HermiteCurve& pcurve)
      : mesh_(mesh), kind_(kind), locator_(locator), pcurve_(pcurve) {}

  /// From sample to sample, and where the cubic changes.
  std::vector<double> cut(const std::vector<double>& samples) const {
    std::vector<double> cuts{samples.front()};
    for (size_t i = 0; i + 1 < samples.size(); ++i) {
      double t = samples[i];
      Cubic here = at(t);
      while (t < samples[i + 1]) {
        double next = step_towards(samples[i + 1], t, here);
        Cubic there = at(next);
        if (!(there == here)) {
          const double left = bisect_end_of(here, t, next);
          if (left < next) {
            next = left;
            there = at(next);
          }
        }
        cuts.push_back(next);
        t = next;
        here = there;
      }
    }
    return cuts;
  }

 private:
  Cubic at(double t) const {
    const Location on = locator_.locate(drop_z(pcurve_.evaluate(t)));
    int sub = 0;
    if (kind_ == TriangleElement::HCT) on.L.minCoeff(&sub);
    return {on.triangle, sub};
  }

  /// Short steps: half of the element that the line is in.
  double step_towards(double end, double t, const Cubic& here) const {
    const double h = std::sqrt(2 * mesh_.shape(here.triangle).area),
                 speed = drop_z(pcurve_.evaluate(t, 1)).norm(), rest = end - t;
    const double steps = std::max(1.0, std::ceil(2 * speed * rest / h));
    return steps == 1 ? end : t + rest / steps;
  }

  double bisect_end_of(const Cubic& here, double low, double high) const {
    for (int step = 0; step < 60 && high - low > 1e-13 * (pcurve_.end() - pcurve_.start());
         ++step) {
      const double middle = 0.5 * (low + high);
      (at(middle) == here ? low : high) = middle;
    }
    return high;
  }

  const ParametricMesh& mesh_;
  TriangleElement kind_;
  const TriangleLocator& locator_;
  const HermiteCurve& pcurve_;
};

std::vector<double> merged_parameters(const HermiteCurve& pcurve, const HermiteCurve& curve) {
  std::vector<double> samples = pcurve.parameters();
  samples.insert(samples.end(), curve.parameters().begin(), curve.parameters().end());
  std::sort(samples.begin(), samples.end());
  samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
  return samples;
}

}  // namespace

VecX line_load(const ParametricMesh& mesh, TriangleElement kind, const TriangleLocator& locator,
               const HermiteCurve& pcurve, const HermiteCurve& curve) {
  if (pcurve.start() != curve.start() || pcurve.end() != curve.end())
    throw InputError("a line over [" + format_number(curve.start()) + ", " +
                     format_number(curve.end()) + "] with an image over [" +
                     format_number(pcurve.start()) + ", " + format_number(pcurve.end()) + "]");
  const std::vector<double> cuts =
      ElementCrossings(mesh, kind, locator, pcurve).cut(merged_parameters(pcurve, curve));

  static const SegmentRule gauss = gauss_legendre(6);
  const DofMap dofs(mesh);
  VecX F = VecX::Zero(dofs.count());
  // Near a vertex, the rational functions of Z12 are not smooth at the element's own scale.
  const int parts = kind == TriangleElement::HCT ? 1 : 8;
  for (size_t i = 0; i + 1 < cuts.size(); ++i)
    for (long g = 0; g < parts * gauss.s.size(); ++g) {
      const double length = (cuts[i + 1] - cuts[i]) / parts,
                   t = cuts[i] + (g / gauss.s.size() + gauss.s[g % gauss.s.size()]) * length;
      const Location on = locator.locate(drop_z(pcurve.evaluate(t)));
      const Vec12 N = C1Triangle(kind, mesh.shape(on.triangle)).evaluate(on.L).col(kW);
      const double weight =
          gauss.weights[g % gauss.s.size()] * length * curve.evaluate(t, 1).norm();
      const auto dof = dofs.triangle(mesh, on.triangle);
      for (int a = 0; a < 12; ++a) F[dof[a]] += weight * N[a];
    }
  return F;
}

}  // namespace batten
