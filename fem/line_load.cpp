#include "batten/fem/line_load.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/plane.h"

namespace batten {
namespace {

// Which cubic of which element a parameter of the line is on.
struct Cubic {
  int triangle, sub;
  bool operator==(const Cubic&) const = default;
};

}  // namespace

VecX line_load(const ParametricMesh& mesh, TriangleElement kind, const TriangleLocator& locator,
               const HermiteCurve& image, const HermiteCurve& curve) {
  if (image.start() != curve.start() || image.end() != curve.end())
    throw InputError("a line over [" + number(curve.start()) + ", " + number(curve.end()) +
                     "] with an image over [" + number(image.start()) + ", " + number(image.end()) +
                     "]");
  const auto cubic_at = [&](double t) {
    const Location on = locator.locate(flat(image.evaluate(t)));
    int sub = 0;
    if (kind == TriangleElement::HCT) on.L.minCoeff(&sub);
    return Cubic{on.triangle, sub};
  };

  std::vector<double> samples = image.parameters();
  samples.insert(samples.end(), curve.parameters().begin(), curve.parameters().end());
  std::sort(samples.begin(), samples.end());
  samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
  std::vector<double> cuts{samples.front()};
  for (size_t i = 0; i + 1 < samples.size(); ++i) {
    // Short steps: half of the element that the line is in.
    double t = samples[i];
    Cubic here = cubic_at(t);
    while (t < samples[i + 1]) {
      const double h = std::sqrt(2 * mesh.shape(here.triangle).area),
                   speed = flat(image.evaluate(t, 1)).norm(), rest = samples[i + 1] - t;
      const double steps = std::max(1.0, std::ceil(2 * speed * rest / h));
      double next = steps == 1 ? samples[i + 1] : t + rest / steps;
      Cubic there = cubic_at(next);
      if (!(there == here)) {
        double low = t, high = next;
        for (int step = 0; step < 60 && high - low > 1e-13 * (image.end() - image.start());
             ++step) {
          const double middle = 0.5 * (low + high);
          (cubic_at(middle) == here ? low : high) = middle;
        }
        if (high < next) {
          next = high;
          there = cubic_at(next);
        }
      }
      cuts.push_back(next);
      t = next;
      here = there;
    }
  }

  static const SegmentRule gauss = gauss_legendre(6);
  const DofMap dofs(mesh);
  VecX F = VecX::Zero(dofs.count());
  // Near a vertex, the rational functions of Z12 are not smooth at the element's own scale.
  const int parts = kind == TriangleElement::HCT ? 1 : 8;
  for (size_t i = 0; i + 1 < cuts.size(); ++i)
    for (long g = 0; g < parts * gauss.s.size(); ++g) {
      const double length = (cuts[i + 1] - cuts[i]) / parts,
                   t = cuts[i] + (g / gauss.s.size() + gauss.s[g % gauss.s.size()]) * length;
      const Location on = locator.locate(flat(image.evaluate(t)));
      const Vec12 N = C1Triangle(kind, mesh.shape(on.triangle)).evaluate(on.L).col(kW);
      const double weight =
          gauss.weights[g % gauss.s.size()] * length * curve.evaluate(t, 1).norm();
      const auto dof = dofs.triangle(mesh, on.triangle);
      for (int a = 0; a < 12; ++a) F[dof[a]] += weight * N[a];
    }
  return F;
}

}  // namespace batten
