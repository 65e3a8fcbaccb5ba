// SPDX-License-Identifier: MPL-2.0
// Rotation parts (polar decomposition) of many matrices at once: the same as one at a time.

#include "batten/core/eigen.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/random_motion.h"

using namespace batten;
using namespace batten_test;

namespace {

/// P diag(s) Qᵀ with random rotations P and Q.
Mat3 with_singular_values(Random& random, const Vec3& s) {
  return random_rotation_matrix(random) * s.asDiagonal() *
         random_rotation_matrix(random).transpose();
}

/// σ2 + σ3, or σ2 - σ3 of a matrix with a reflection, relative to |M|: how well M determines its
/// rotation.
double gap_of(const Mat3& M) {
  const Vec3 s = svd(M).values;
  return M.norm() > 0 ? (s[1] + (M.determinant() < 0 ? -s[2] : s[2])) / M.norm() : 0;
}

struct Errors {
  double rotation = 0, length = 0, share = 0;

  static void count(double& largest, double error) {
    if (!(error <= largest)) largest = error;  // also detects NaN
  }
  void add(const Mat3& M, const Mat3& R) {
    const double scale = M.cwiseAbs().maxCoeff(), gap = gap_of(scale > 0 ? M / scale : M);
    const Mat3 one = nearest_rotation(M);
    count(rotation, gap * (R - one).norm());
    count(length, (R.transpose() * R - Mat3::Identity()).norm());
    count(length, std::abs(R.determinant() - 1));
    if (scale > 0) count(share, std::abs((R - one).cwiseProduct(M / scale).sum()));
  }
};

Errors of_all(const std::vector<Mat3>& matrices) {
  Errors errors;
  for (size_t first = 0; first < matrices.size(); first += RotationBatch::kLanes) {
    RotationBatch M, R;
    for (int l = 0; l < RotationBatch::kLanes; ++l)
      M.set(l, matrices[std::min(first + l, matrices.size() - 1)]);
    nearest_rotations(M, R);
    for (int l = 0; l < RotationBatch::kLanes; ++l) errors.add(M.get(l), R.get(l));
  }
  return errors;
}

void check_all(const std::vector<Mat3>& matrices, const std::string& kind) {
  const Errors e = of_all(matrices);
  INFO(kind << ": rotation " << e.rotation << ", lengths " << e.length << ", share " << e.share);
  CHECK(e.rotation < 5e-15);
  CHECK(e.length < 1e-14);
  CHECK(e.share < 1e-14);
}

}  // namespace

TEST_CASE("rotation parts of a batch are those of its matrices", "[mesh][rotations]") {
  Random random(31);
  std::vector<Mat3> plain, flat, mirrored, lines, nearly, scaled;
  for (int k = 0; k < 20000; ++k) {
    Mat3 M;
    for (int c = 0; c < 3; ++c) M.col(c) = random.point();
    plain.push_back(M);
    const Vec3 s(random.between(0.5, 1), random.between(0.2, 0.5), random.between(0, 0.2));
    flat.push_back(with_singular_values(random, {s[0], s[1], 0}));
    mirrored.push_back(with_singular_values(random, {s[0], s[1], -s[2]}));
    lines.push_back(random.point() * random.point().transpose());
    nearly.push_back(
        with_singular_values(random, {s[0], std::pow(10, random.between(-18, 0)),
                                      std::pow(10, random.between(-18, 0)) * random()}));
    scaled.push_back(std::pow(10, random.between(-150, 150)) * M);
  }
  check_all(plain, "plain");
  check_all(flat, "flat");
  check_all(mirrored, "mirrored");
  check_all(lines, "of rank 1");
  check_all(nearly, "nearly of a lower rank");
  check_all(scaled, "of any size");
}

TEST_CASE("batches contain matrices without a unique rotation, and sizes past squares",
          "[mesh][rotations]") {
  RotationBatch M, R;
  const Mat3 rotation = rotation_matrix(Vec3(0.1, 0.4, -0.2));
  const std::vector<Mat3> matrices = {
      Mat3::Zero(),       Mat3::Identity(),
      -Mat3::Identity(),  1e-200 * rotation,
      1e200 * rotation,   rotation,
      -1e-160 * rotation, Vec3::UnitX() * Vec3::UnitY().transpose()};
  for (int l = 0; l < RotationBatch::kLanes; ++l) M.set(l, matrices[l]);
  nearest_rotations(M, R);
  for (int l = 0; l < RotationBatch::kLanes; ++l) {
    INFO("lane " << l << "\n" << R.get(l));
    CHECK((R.get(l) - nearest_rotation(matrices[l])).norm() < 1e-14);
    CHECK(R.get(l).determinant() == Approx(1).epsilon(1e-14));
  }
  CHECK(R.get(0) == Mat3::Identity());
}

TEST_CASE("lanes of a batch know nothing of each other", "[mesh][rotations]") {
  Random random(32);
  for (int k = 0; k < 500; ++k) {
    Mat3 M;
    for (int c = 0; c < 3; ++c) M.col(c) = random.point();
    if (k % 3 == 0) M.col(2).setZero();
    RotationBatch alone, among, R, S;
    for (int l = 0; l < RotationBatch::kLanes; ++l) {
      alone.set(l, M);
      among.set(l, l % 3 == 0   ? Mat3::Zero().eval()
                   : l % 3 == 1 ? random_rotation_matrix(random)
                                : Mat3(M * l));
    }
    const int lane = k % RotationBatch::kLanes;
    among.set(lane, M);
    nearest_rotations(alone, R);
    nearest_rotations(among, S);
    CHECK(S.get(lane) == R.get(0));
  }
}
