// SPDX-License-Identifier: MPL-2.0
#include "batten/elements/quadrature.h"

#include <cmath>
#include <numbers>

#include "batten/core/errors.h"

namespace batten {
namespace {

// One orbit of a symmetric rule: the centroid (one point), {a, a, 1-2a} (three points) or {a, b,
// 1-a-b} (six points). Rules use closed forms if they exist, otherwise the values of
// [Dunavant1985].
struct Orbit {
  double weight, a, b;
};

TriangleRule from_orbits(std::initializer_list<Orbit> orbits) {
  std::vector<Vec3> points;
  std::vector<double> weights;
  const auto add = [&](double weight, double x, double y) {
    points.emplace_back(x, y, 1 - x - y);
    weights.push_back(weight);
  };
  for (const auto& o : orbits) {
    const double c = 1 - o.a - o.b;
    if (o.a == o.b && std::abs(o.a - c) < 1e-12) {
      add(o.weight, 1.0 / 3, 1.0 / 3);
    } else if (o.a == o.b) {
      add(o.weight, c, o.a);
      add(o.weight, o.a, c);
      add(o.weight, o.a, o.a);
    } else {
      add(o.weight, o.a, o.b);
      add(o.weight, o.b, o.a);
      add(o.weight, o.a, c);
      add(o.weight, c, o.a);
      add(o.weight, o.b, c);
      add(o.weight, c, o.b);
    }
  }
  TriangleRule rule{Points(points.size(), 3), VecX(points.size())};
  for (size_t i = 0; i < points.size(); ++i) {
    rule.L.row(static_cast<long>(i)) = points[i];
    rule.weights[static_cast<long>(i)] = weights[i];
  }
  rule.weights /= rule.weights.sum();
  return rule;
}

}  // namespace

SegmentRule gauss_legendre(int n) {
  if (n < 1)
    throw InputError("found a Gauss rule with " + std::to_string(n) +
                     " points, expected 1 or more");
  SegmentRule rule{VecX(n), VecX(n)};
  for (int i = 0; i < n; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
    double slope = 0;
    for (int step = 0; step < 100; ++step) {
      double p0 = 1, p1 = x;
      for (int k = 2; k <= n; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      slope = n * (x * p1 - p0) / (x * x - 1);
      const double dx = p1 / slope;
      x -= dx;
      if (std::abs(dx) < 1e-16) break;
    }
    rule.s[i] = 0.5 * (1 + x);
    rule.weights[i] = 1 / ((1 - x * x) * slope * slope);
  }
  return rule;
}

TriangleRule symmetric_triangle_rule(int degree) {
  constexpr double third = 1.0 / 3;
  switch (degree) {
    case 0:
    case 1:
      return from_orbits({{1, third, third}});
    case 2:
      return from_orbits({{third, 1.0 / 6, 1.0 / 6}});
    case 3:
    case 4: {
      // Closed form: a = (8 - √10 ± √(38 - 44 √(2/5)))/18.
      const double r = std::sqrt(38 - 44 * std::sqrt(0.4)),
                   q = std::sqrt(213125 - 53320 * std::sqrt(10.0));
      const double a = (8 - std::sqrt(10.0) + r) / 18, b = (8 - std::sqrt(10.0) - r) / 18;
      return from_orbits({{(620 + q) / 3720, a, a}, {(620 - q) / 3720, b, b}});
    }
    case 5: {
      const double r = std::sqrt(15.0);
      return from_orbits({{9.0 / 40, third, third},
                          {(155 + r) / 1200, (6 + r) / 21, (6 + r) / 21},
                          {(155 - r) / 1200, (6 - r) / 21, (6 - r) / 21}});
    }
    case 6:
      return from_orbits({{0.116786275726379366, 0.249286745170910421, 0.249286745170910421},
                          {0.050844906370206817, 0.063089014491502227, 0.063089014491502227},
                          {0.082851075618373575, 0.053145049844816947, 0.310352451033784405}});
    case 7:
    case 8:
      return from_orbits({{0.144315607677787168, third, third},
                          {0.095091634267284625, 0.459292588292723156, 0.459292588292723156},
                          {0.103217370534718250, 0.170569307751760207, 0.170569307751760207},
                          {0.032458497623198080, 0.050547228317030975, 0.050547228317030975},
                          {0.027230314174434994, 0.008394777409957605, 0.263112829634638113}});
    default:
      throw InputError("found a symmetric triangle rule of degree " + std::to_string(degree) +
                       ", expected 0 to 8; use six_duffy for higher degrees");
  }
}

TriangleRule split_triangle_rule(int degree) {
  const TriangleRule whole = symmetric_triangle_rule(degree);
  const long n = whole.weights.size();
  TriangleRule rule{Points(3 * n, 3), VecX(3 * n)};
  for (int s = 0; s < 3; ++s)
    for (long p = 0; p < n; ++p) {
      const double to_centroid = whole.L(p, 2) / 3;
      Vec3 L;
      L[s] = to_centroid;
      L[(s + 1) % 3] = whole.L(p, 0) + to_centroid;
      L[(s + 2) % 3] = whole.L(p, 1) + to_centroid;
      rule.L.row(s * n + p) = L;
      rule.weights[s * n + p] = whole.weights[p] / 3;
    }
  return rule;
}

TriangleRule six_duffy_rule(int m) {
  const SegmentRule g = gauss_legendre(m);
  TriangleRule rule{Points(6 * m * m, 3), VecX(6 * m * m)};
  const Vec3 centroid = Vec3::Constant(1.0 / 3);
  long row = 0;
  for (int i = 0; i < 3; ++i)
    for (int side = 1; side <= 2; ++side) {
      const Vec3 corner = Vec3::Unit(i), mid = 0.5 * (Vec3::Unit(i) + Vec3::Unit((i + side) % 3));
      for (int a = 0; a < m; ++a)
        for (int b = 0; b < m; ++b, ++row) {
          const double r = g.s[a], t = g.s[b];
          rule.L.row(row) = (1 - r) * corner + r * (1 - t) * mid + r * t * centroid;
          rule.weights[row] = 2 * r * g.weights[a] * g.weights[b] / 6;
        }
    }
  return rule;
}

}  // namespace batten
