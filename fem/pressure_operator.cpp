// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/pressure_operator.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <numeric>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/core/simd.h"
#include "batten/elements/reference_triangle.h"

namespace batten {
namespace {

constexpr int kPairs = 55;  // b < c of the dofs 1 … 11
constexpr int kTensor = 12 * kPairs;
constexpr int kPartSize = 256;  // triangles
using Lanes = double __attribute__((vector_size(32)));

void fill_tensor(TriangleElement kind, const TriangleRule& rule, double* T) {
  std::fill_n(T, kTensor, 0.0);
  for (long p = 0; p < rule.weights.size(); ++p) {
    const ReferenceTabulation N = reference_functions(kind, rule.L.row(p).transpose());
    double* row = T;
    for (int b = 1; b < 12; ++b)
      for (int c = b + 1; c < 12; ++c, row += 12) {
        const double cross = N(b, 1) * N(c, 2) - N(b, 2) * N(c, 1);
        // Weights sum to 1; the area of the reference triangle in (L1, L2) is 1/2.
        for (int a = 0; a < 12; ++a) row[a] += 0.5 * rule.weights[p] * cross * N(a, 0);
      }
  }
}

const double* reference_tensor(TriangleElement kind) {
  static const std::vector<double> hct = [] {
    std::vector<double> T(kTensor);
    fill_tensor(TriangleElement::HCT, split_triangle_rule(8), T.data());
    return T;
  }();
  static const std::vector<double> z12 = [] {
    std::vector<double> T(kTensor);
    fill_tensor(TriangleElement::Z12, six_duffy_rule(14), T.data());
    return T;
  }();
  return kind == TriangleElement::HCT ? hct.data() : z12.data();
}

// Adds the forces of four triangles to F. Positions x and forces F have three numbers per dof.
BATTEN_CLONES void add_forces(const double* numbers, const int* dof, const double* weights,
                              int count, const double* T, const double* x, double* F) {
  constexpr int lanes = 4;
  Lanes q[12][3], cross[kPairs][3], f[12][3];
  const Lanes* P = reinterpret_cast<const Lanes*>(numbers);
  for (int a = 0; a < 12; ++a)
    for (int c = 0; c < 3; ++c)
      for (int l = 0; l < lanes; ++l) q[a][c][l] = x[3 * dof[lanes * a + l] + c];
  for (int c = 0; c < 3; ++c) {
    q[3][c] -= q[0][c];
    q[6][c] -= q[0][c];
    q[0][c] -= q[0][c];
  }
  // q becomes q̂ = P q.
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < 3; ++c) {
      const Lanes d = q[3 * i + 1][c], e = q[3 * i + 2][c];
      q[3 * i + 1][c] = P[4 * i] * d + P[4 * i + 1] * e;
      q[3 * i + 2][c] = P[4 * i + 2] * d + P[4 * i + 3] * e;
    }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    for (int c = 0; c < 3; ++c)
      q[9 + i][c] =
          P[12 + i] * q[9 + i][c] + P[15 + i] * (1.5 * (q[3 * k][c] - q[3 * j][c]) -
                                                 0.25 * (q[3 * j + 1][c] - q[3 * k + 2][c]));
  }
  int pair = 0;
  for (int b = 1; b < 12; ++b)
    for (int c = b + 1; c < 12; ++c, ++pair) {
      cross[pair][0] = q[b][1] * q[c][2] - q[b][2] * q[c][1];
      cross[pair][1] = q[b][2] * q[c][0] - q[b][0] * q[c][2];
      cross[pair][2] = q[b][0] * q[c][1] - q[b][1] * q[c][0];
    }
  const Lanes weight = *reinterpret_cast<const Lanes*>(weights);
  for (int block = 0; block < 12; block += 4) {
    Lanes sum[4][3] = {};
    for (int p = 0; p < kPairs; ++p)
      for (int a = 0; a < 4; ++a)
        for (int c = 0; c < 3; ++c) sum[a][c] += T[12 * p + block + a] * cross[p][c];
    for (int a = 0; a < 4; ++a)
      for (int c = 0; c < 3; ++c) f[block + a][c] = weight * sum[a][c];
  }
  // f becomes Pᵀ f.
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    for (int c = 0; c < 3; ++c) {
      const Lanes slanted = P[15 + i] * f[9 + i][c];
      f[3 * k][c] += 1.5 * slanted;
      f[3 * j][c] -= 1.5 * slanted;
      f[3 * j + 1][c] -= 0.25 * slanted;
      f[3 * k + 2][c] += 0.25 * slanted;
      f[9 + i][c] *= P[12 + i];
    }
  }
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < 3; ++c) {
      const Lanes d = f[3 * i + 1][c], e = f[3 * i + 2][c];
      f[3 * i + 1][c] = P[4 * i] * d + P[4 * i + 2] * e;
      f[3 * i + 2][c] = P[4 * i + 1] * d + P[4 * i + 3] * e;
    }
  for (int l = 0; l < count; ++l)
    for (int a = 0; a < 12; ++a)
      for (int c = 0; c < 3; ++c) F[3 * dof[lanes * a + l] + c] += f[a][c][l];
}

// Morton code: interleaves the bits of x and y, so that points with similar codes are close
// together.
uint64_t morton_code(uint32_t x, uint32_t y) {
  uint64_t sum = 0;
  for (int bit = 0; bit < 16; ++bit)
    sum |= (static_cast<uint64_t>(x >> bit & 1) << (2 * bit)) |
           (static_cast<uint64_t>(y >> bit & 1) << (2 * bit + 1));
  return sum;
}

std::vector<int> morton_order(const ParametricMesh& mesh) {
  const int n = mesh.triangle_count();
  const Box2 box = bounding_box(mesh.vertices());
  const double scale = 65535 / box.sizes().maxCoeff();
  std::vector<uint64_t> key(n);
  for (int t = 0; t < n; ++t) {
    poll_every<8192>(t);
    const Vec2 centre = mesh.wrapped(mesh.shape(t).point(Vec3::Constant(1.0 / 3)));
    const Vec2 cell = (scale * (centre - box.min())).cwiseMax(0.0).cwiseMin(65535.0);
    key[t] = morton_code(static_cast<uint32_t>(cell.x()), static_cast<uint32_t>(cell.y()));
  }
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return key[a] != key[b] ? key[a] < key[b] : a < b; });
  return order;
}

}  // namespace

// Groups triangles into batches and parts.
class PressureOperator::PartBuilder {
 public:
  PartBuilder(PressureOperator& made, const ParametricMesh& mesh)
      : made_(made), mesh_(mesh), dofs_(mesh), local_(made.dofs_, -1) {}

  void add_parts(const std::vector<int>& triangles, size_t size, int lanes) {
    for (size_t i = 0; i < triangles.size(); i += size) {
      throw_if_cancelled();
      add_part(triangles, i, std::min(i + size, triangles.size()), lanes);
    }
  }

 private:
  void add_part(const std::vector<int>& triangles, size_t first, size_t end, int lanes) {
    Part part;
    part.first_batch = isize(made_.batches_);
    part.first_dof = isize(made_.dof_);
    for (size_t i = first; i < end; i += lanes) {
      Batch batch{};
      batch.count = static_cast<int>(std::min<size_t>(lanes, end - i));
      batch.tensor = lanes == 1 ? static_cast<int>(i) : -1;
      for (int l = 0; l < kLanes; ++l)
        fill_lane(batch, l, triangles[i + (l < batch.count ? l : 0)], part.first_dof);
      made_.batches_.push_back(batch);
    }
    part.end_batch = isize(made_.batches_);
    part.end_dof = isize(made_.dof_);
    for (int d = part.first_dof; d < part.end_dof; ++d) local_[made_.dof_[d]] = -1;
    made_.parts_.push_back(part);
  }

  void fill_lane(Batch& batch, int l, int t, int first_dof) {
    batch.triangle[l] = t;
    const DofTransformCoefficients P(mesh_.shape(t));
    for (int k = 0; k < 3; ++k) {
      for (int g = 0; g < 4; ++g) batch.numbers[kLanes * (4 * k + g) + l] = P.gradient[k][g];
      batch.numbers[kLanes * (12 + k) + l] = P.altitude[k];
      batch.numbers[kLanes * (15 + k) + l] = P.slant[k];
    }
    const auto dof = dofs_.triangle(mesh_, t);
    for (int a = 0; a < 12; ++a) {
      if (local_[dof[a]] < 0) {
        local_[dof[a]] = isize(made_.dof_) - first_dof;
        made_.dof_.push_back(dof[a]);
      }
      batch.dof[kLanes * a + l] = local_[dof[a]];
    }
  }

  PressureOperator& made_;
  const ParametricMesh& mesh_;
  DofMap dofs_;
  std::vector<int> local_;  // local index of each global dof in the part, or -1
};

PressureOperator::PressureOperator(const ParametricMesh& mesh, TriangleElement kind,
                                   std::shared_ptr<const Trim> trim)
    : dofs_(DofMap(mesh).count()),
      triangles_(mesh.triangle_count()),
      reference_(reference_tensor(kind)) {
  std::vector<int> whole, cut;
  for (const int t : morton_order(mesh)) {
    const Trim::Side side = trim ? trim->side(t) : Trim::Side::Inside;
    if (side != Trim::Side::Outside) (side == Trim::Side::Cut ? cut : whole).push_back(t);
  }
  tensors_.resize(kTensor * cut.size());
  const auto fill = [&](int c) {
    fill_tensor(kind, trim->rule(cut[c], 7), &tensors_[static_cast<size_t>(c) * kTensor]);
  };
  parallel_for(isize(cut), fill);

  PartBuilder parts(*this, mesh);
  parts.add_parts(whole, kPartSize, kLanes);
  parts.add_parts(cut, kPartSize / 4, 1);
  build_dof_lists();
}

void PressureOperator::build_dof_lists() {
  start_.assign(dofs_ + 1, 0);
  for (const int d : dof_) ++start_[d + 1];
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  local_dofs_.resize(dof_.size());
  std::vector<int> next(start_.begin(), start_.end() - 1);
  for (size_t i = 0; i < dof_.size(); ++i) local_dofs_[next[dof_[i]]++] = static_cast<int>(i);
  positions_.resize(3 * dof_.size());
  forces_.resize(3 * dof_.size());
}

void PressureOperator::check(const Points& x, const VecX& weights) const {
  if (x.rows() != dofs_)
    throw InputError("found " + std::to_string(x.rows()) + " dofs of a surface, expected " +
                     std::to_string(dofs_) + " of its mesh");
  if (weights.size() != 0 && weights.size() != triangles_)
    throw InputError("found " + std::to_string(weights.size()) + " pressure factors for " +
                     std::to_string(triangles_) + " triangles, expected one for each");
}

void PressureOperator::part_forces(const Part& part, const Points& x, const VecX& weights) const {
  double* positions = &positions_[3 * static_cast<size_t>(part.first_dof)];
  double* forces = &forces_[3 * static_cast<size_t>(part.first_dof)];
  const int count = part.end_dof - part.first_dof;
  for (int d = 0; d < count; ++d)
    for (int c = 0; c < 3; ++c) positions[3 * d + c] = x(dof_[part.first_dof + d], c);
  std::fill_n(forces, 3 * count, 0.0);
  alignas(32) double weight[kLanes] = {1, 1, 1, 1};
  for (int b = part.first_batch; b < part.end_batch; ++b) {
    const Batch& batch = batches_[b];
    if (weights.size() > 0) {
      bool any = false;
      for (int l = 0; l < kLanes; ++l) {
        weight[l] = weights[batch.triangle[l]];
        any = any || weight[l] != 0;
      }
      if (!any) continue;
    }
    const double* tensor =
        batch.tensor < 0 ? reference_ : &tensors_[static_cast<size_t>(batch.tensor) * kTensor];
    add_forces(batch.numbers, batch.dof, weight, batch.count, tensor, positions, forces);
  }
}

void PressureOperator::forces(const Points& x, const VecX& weights) const {
  check(x, weights);
  const auto work = [&](int part) { part_forces(parts_[part], x, weights); };
  parallel_for(isize(parts_), std::ref(work));
}

void PressureOperator::add(const Points& x, const VecX& weights, double value, Points& F) const {
  if (F.rows() != dofs_)
    throw InputError("found a load vector of " + std::to_string(F.rows()) + " dofs, expected " +
                     std::to_string(dofs_));
  forces(x, weights);
  parallel_for_each<4096>(dofs_, [&](int d) {
    if (start_[d] == start_[d + 1]) return;
    Vec3 sum = Vec3::Zero();
    for (int i = start_[d]; i < start_[d + 1]; ++i)
      sum += Eigen::Map<const Vec3>(&forces_[3 * static_cast<size_t>(local_dofs_[i])]);
    F.row(d) += value * sum;
  });
}

double PressureOperator::volume(const Points& x, const VecX& weights) const {
  forces(x, weights);
  double sum = 0;
  for (size_t i = 0; i < positions_.size(); ++i) sum += positions_[i] * forces_[i];
  return sum / 3;
}

}  // namespace batten
