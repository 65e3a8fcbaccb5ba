#include "batten/fairing/not_a_knot_spline.h"

#include <Eigen/LU>

namespace batten {

Points not_a_knot_slopes(const std::vector<double>& u, const Points& x) {
  const long n = x.rows();
  if (n == 2) return (x.row(1) - x.row(0)).replicate(2, 1) / (u[1] - u[0]);
  MatX A = MatX::Zero(n, n);
  Points b = Points::Zero(n, 3);
  const auto step = [&](long i) {
    return u[static_cast<size_t>(i) + 1] - u[static_cast<size_t>(i)];
  };
  // The second derivative goes on.
  for (long i = 1; i + 1 < n; ++i)
    for (const long s : {i - 1, i}) {
      const double h = step(s);
      A(i, i) += 2 / h;
      A(i, 2 * s + 1 - i) += 1 / h;
      b.row(i) += 3 / (h * h) * (x.row(s + 1) - x.row(s));
    }
  // x_uuu = 6 (m0 + m1)/h² - 12 (x1 - x0)/h³ on segment s.
  const auto add_third = [&](long row, long s, double sign) {
    const double h = step(s);
    A(row, s) += sign * 6 / (h * h);
    A(row, s + 1) += sign * 6 / (h * h);
    b.row(row) += sign * 12 / (h * h * h) * (x.row(s + 1) - x.row(s));
  };
  add_third(0, 0, 1);
  add_third(n - 1, n - 2, 1);
  if (n > 3) {
    add_third(0, 1, -1);
    add_third(n - 1, n - 3, -1);
  }
  return A.partialPivLu().solve(b);
}

}  // namespace batten
