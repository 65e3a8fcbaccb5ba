// SPDX-License-Identifier: MPL-2.0
#include "batten/tests/support/solver_matrices.h"

#include <cmath>
#include <numbers>

#include "batten/constraints/affine_reduction.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/clamped_boundary.h"
#include "batten/tests/support/sampling.h"

namespace batten_test {

HoledSheet holed_sheet(int vertices) {
  using std::numbers::pi;
  constexpr double width = 5, depth = 4, radius = 0.22;  // one hole in every unit square
  constexpr double kept = 1 - pi * radius * radius;
  const double h = std::sqrt(width * depth * kept / vertices);
  const int nu = static_cast<int>(std::round(width / h)),
            nv = static_cast<int>(std::round(depth / h));
  // Square grid with alternating diagonals, without the vertices inside holes.
  Random random(5);
  std::vector<int> number((nu + 1) * (nv + 1), -1);
  std::vector<Vec3> points;
  std::vector<char> held, rim;
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i <= nu; ++i) {
      const auto jitter = [&](bool inner) { return inner ? 0.2 * random() : 0.0; };
      const double u = width * (i + jitter(i > 0 && i < nu)) / nu,
                   v = depth * (j + jitter(j > 0 && j < nv)) / nv;
      const double from_hole =
          std::hypot(u - std::floor(u) - 0.5, v - std::floor(v) - 0.5) - radius;
      if (from_hole < 0) continue;
      number[j * (nu + 1) + i] = static_cast<int>(points.size());
      points.emplace_back(u, v, 0.3 * std::sin(u) * std::cos(1.3 * v));
      held.push_back(i < 2 || j < 2 || i > nu - 2 || j > nv - 2);
      rim.push_back(from_hole < 1.2 * width / nu);
    }
  const auto n = static_cast<int>(points.size());
  std::vector<Triplet> weights;  // of the integrated cotangent Laplacian
  std::vector<double> area(n, 0);
  const auto triangle = [&](int a, int b, int c) {
    if (a < 0 || b < 0 || c < 0) return;
    const int corner[3] = {a, b, c};
    const double twice = (points[b] - points[a]).cross(points[c] - points[a]).norm();
    for (int k = 0; k < 3; ++k) {
      const int o = corner[k], p = corner[(k + 1) % 3], q = corner[(k + 2) % 3];
      const double half_cot = 0.5 * (points[p] - points[o]).dot(points[q] - points[o]) / twice;
      for (const auto& [r, s] : {std::pair{p, q}, std::pair{q, p}}) {
        weights.emplace_back(r, r, half_cot);
        weights.emplace_back(r, s, -half_cot);
      }
      area[o] += twice / 6;
    }
  };
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      const int a = number[j * (nu + 1) + i], b = number[j * (nu + 1) + i + 1],
                c = number[(j + 1) * (nu + 1) + i + 1], d = number[(j + 1) * (nu + 1) + i];
      if ((i + j) % 2) {
        triangle(a, b, c);
        triangle(a, c, d);
      } else {
        triangle(a, b, d);
        triangle(b, c, d);
      }
    }

  HoledSheet sheet;
  std::vector<int> column(n, -1);
  int columns = 0;
  for (int i = 0; i < n; ++i)
    if (!held[i] && area[i] > 0) {
      column[i] = columns++;
      sheet.rim.push_back(rim[i]);
    }
  std::vector<Triplet> entries;
  for (const Triplet& w : weights)
    if (area[w.row()] > 0 && column[w.col()] >= 0)
      entries.emplace_back(w.row(), column[w.col()], w.value() / std::sqrt(area[w.row()]));
  sheet.rows.resize(n, columns);
  sheet.rows.setFromTriplets(entries.begin(), entries.end());
  const SparseMatrix normal = sheet.rows.transpose() * sheet.rows;
  sheet.normal = normal.triangularView<Eigen::Lower>();
  sheet.shape.resize(columns, 3);
  for (int i = 0; i < n; ++i)
    if (column[i] >= 0) sheet.shape.row(column[i]) = points[i];
  return sheet;
}

BendingMatrix clamped_bending(int n) {
  const ParametricMesh mesh = ParametricMesh::unit_square(n);
  const SurfaceAssembler assembler(mesh, TriangleElement::HCT);
  const AffineReduction reduction(clamped_boundary(mesh));
  return {reduction.reduce(assembler.stiffness(SurfaceStiffness::isotropic(0, 1))),
          reduction.ordering_of_free(nested_dissection_order(mesh))};
}

SparseMatrix badly_scaled(const SparseMatrix& A, double digits) {
  const VecX s =
      (digits * std::log(10.0) * random_columns(A.rows(), 1, 3).col(0).array()).exp().matrix();
  return s.asDiagonal() * A * s.asDiagonal();
}

SparseMatrix disconnected(const SparseMatrix& A, const SparseMatrix& B) {
  std::vector<Triplet> entries;
  for (const auto& [part, start] : {std::pair{&A, 0L}, std::pair{&B, A.rows()}})
    for (int c = 0; c < part->outerSize(); ++c)
      for (SparseMatrix::InnerIterator e(*part, c); e; ++e)
        entries.emplace_back(start + e.row(), start + e.col(), e.value());
  SparseMatrix both(A.rows() + B.rows(), A.rows() + B.rows());
  both.setFromTriplets(entries.begin(), entries.end());
  return both;
}

namespace {

// (-1, 2, -1) with n unknowns, the first and last fixed.
SparseMatrix chain(int n) {
  std::vector<Triplet> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 2.0);
    if (i > 0) entries.emplace_back(i, i - 1, -1.0);
  }
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

SparseMatrix dense(int n) {
  const MatX B = random_columns(n, n);
  const MatX A = MatX(B.transpose() * B) + n * MatX::Identity(n, n);
  return SparseMatrix(MatX(A.triangularView<Eigen::Lower>()).sparseView());
}

SparseMatrix random_diagonal(int n) {
  const VecX d = random_columns(n, 1).col(0).array() + 1.5;
  return SparseMatrix(d.asDiagonal());
}

// 500 chains of 1 to 12 unknowns.
SparseMatrix many_chains() {
  std::vector<Triplet> entries;
  int start = 0;
  for (int part = 0; part < 500; ++part) {
    const int n = 1 + part % 12;
    const SparseMatrix A = chain(n);
    for (int c = 0; c < n; ++c)
      for (SparseMatrix::InnerIterator e(A, c); e; ++e)
        entries.emplace_back(start + e.row(), start + e.col(), e.value());
    start += n;
  }
  SparseMatrix A(start, start);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

}  // namespace

std::vector<NamedMatrix> twenty_matrices() {
  const auto alone = [](const std::string& name, std::function<SparseMatrix()> make) {
    return NamedMatrix{name, [make] { return BendingMatrix{make(), {}}; }};
  };
  std::vector<NamedMatrix> all;
  for (const auto& [name, n] :
       {std::pair{"3k", 3300}, {"14k", 14600}, {"101k", 103000}, {"303k", 306500}})
    all.push_back(alone(std::string("sheet ") + name, [n = n] { return holed_sheet(n).normal; }));
  for (const int n : {32, 48, 64, 96, 128})
    all.push_back({"bending " + std::to_string(n) + "²", [n] { return clamped_bending(n); }});
  all.push_back(
      alone("sheet 3k scaled 1e±3", [] { return badly_scaled(holed_sheet(3300).normal, 3); }));
  all.push_back(
      alone("sheet 14k scaled 1e±6", [] { return badly_scaled(holed_sheet(14600).normal, 6); }));
  all.push_back({"bending 32² scaled 1e±6", [] {
                   BendingMatrix bending = clamped_bending(32);
                   return BendingMatrix{badly_scaled(bending.K, 6), bending.order};
                 }});
  for (const int n : {1, 2, 3})
    all.push_back(alone("n = " + std::to_string(n), [n] { return chain(n); }));
  all.push_back(alone("disconnected sheets", [] {
    return disconnected(holed_sheet(3300).normal, holed_sheet(2000).normal);
  }));
  all.push_back(alone("500 small parts", many_chains));
  all.push_back(alone("diagonal", [] { return random_diagonal(20000); }));
  all.push_back(alone("chain", [] { return chain(50000); }));
  all.push_back(alone("dense", [] { return dense(400); }));
  return all;
}

double backward_error(const SparseMatrix& A, const MatX& x, const MatX& b) {
  const MatX residual = A.selfadjointView<Eigen::Lower>() * x - b;
  return residual.cwiseAbs().maxCoeff() / (A.coeffs().abs().maxCoeff() * x.cwiseAbs().maxCoeff());
}

MatX random_columns(long n, long columns, unsigned seed) {
  Random random(seed);
  return MatX::NullaryExpr(n, columns, [&] { return random(); });
}

}  // namespace batten_test
