// SPDX-License-Identifier: MPL-2.0
// Stress analysis in memory: a simply supported square plate under pressure, compared with theory.
#include <batten/batten.h>

#include <cmath>
#include <cstdio>

int main(int, char**) {
  const double a = 1000, t = 10, q = 0.01, young = 210e3, nu = 0.3;  // mm, N, N/mm²
  const batten::Model plate = batten::skin({{"rim", {{0, 0, 0}, {a, 0, 0}, {a, a, 0}, {0, a, 0}, {0, 0, 0}}}});
  const batten::Stress stress = batten::stress(plate, {.young = young,
                                                       .poisson = nu,
                                                       .thickness = t,
                                                       .supports = {{.curve = "rim", .type = "pinned"}},
                                                       .loads = {{.pressure = -q}}});
  // Navier's series: w = 0.00406 q a⁴ / D in the middle [Timoshenko1959].
  const double theory = 0.00406 * q * std::pow(a, 4) / (young * std::pow(t, 3) / (12 * (1 - nu * nu)));
  const double middle = stress.at({a / 2, a / 2, 0}).displacement.norm();
  std::printf("deflection %.4f mm, in theory %.4f mm; von Mises stress %.2f N/mm²\n", middle, theory,
              stress.max_von_mises());
  return std::abs(middle / theory - 1) < 0.01 ? 0 : 1;
}
