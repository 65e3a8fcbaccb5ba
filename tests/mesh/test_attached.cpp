// SPDX-License-Identifier: MPL-2.0
// Entities attached to shells: solids, spiders, RBE3, beams, bushes.
#include <algorithm>
#include <numbers>

#include "batten/core/geometry.h"
#include "batten/mesh/attached/attachment.h"
#include "batten/mesh/element_quality.h"
#include "batten/tests/support/catch.h"

using namespace batten;
using Kind = NonShellElement::Kind;

namespace {

Points points_of(const std::vector<Vec3>& list) {
  Points points(static_cast<long>(list.size()), 3);
  for (size_t i = 0; i < list.size(); ++i) points.row(static_cast<long>(i)) = list[i].transpose();
  return points;
}

/// A plate of n × n shell elements at z = 0 and two layers of bricks below.
struct LayeredPlate {
  explicit LayeredPlate(int n) : side(n) {
    std::vector<Vec3> list;
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) list.emplace_back(i, j, -0.5 * k);
    points = points_of(list);
    placed.assign(list.size(), 0);
    std::fill(placed.begin(), placed.begin() + n * n, 1);
    rotations.assign(list.size(), Mat3::Identity());
    for (int k = 0; k < 2; ++k)
      for (int j = 0; j + 1 < n; ++j)
        for (int i = 0; i + 1 < n; ++i) {
          NonShellElement e{Kind::Solid, "CHEXA", static_cast<long>(elements.size()) + 1, {}, {}};
          for (const int layer : {k + 1, k})
            for (const auto& [a, b] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}})
              e.nodes.push_back(layer * n * n + (j + b) * n + i + a);
          elements.push_back(e);
        }
  }
  int side;
  Points points;
  std::vector<char> placed;
  std::vector<Mat3> rotations;
  std::vector<NonShellElement> elements;
};

struct Rigid {
  Vec3 log, translation;
  Vec3 operator()(const Vec3& p) const { return rotated(log, p) + translation; }
  Mat3 matrix() const {
    Mat3 R;
    for (int c = 0; c < 3; ++c) R.col(c) = rotated(log, Vec3::Unit(c));
    return R;
  }
};

const Rigid kMotion{to_rotation_vector({1, 2, -1}, 2.2), {3, -1, 0.5}};

void move(const Rigid& motion, const Points& before, Points& after, const std::vector<char>& placed,
          std::vector<Mat3>& rotations) {
  for (long v = 0; v < before.rows(); ++v)
    if (placed[static_cast<size_t>(v)]) {
      after.row(v) = motion(before.row(v).transpose()).transpose();
      rotations[static_cast<size_t>(v)] = motion.matrix();
    }
}

double off(const Rigid& motion, const Points& before, const Points& after) {
  double worst = 0;
  for (long v = 0; v < before.rows(); ++v)
    worst = std::max(
        worst,
        (after.row(v).transpose() - motion(before.row(v).transpose())).cwiseAbs().maxCoeff());
  return worst;
}

}  // namespace

TEST_CASE("attachments to a rigid motion move rigidly: solids, spiders, means, chains of bars",
          "[mesh][attached]") {
  LayeredPlate layered(5);
  const auto first = static_cast<int>(layered.points.rows());
  // A spider's centre, the node of an RBE3, a chain of two bars, a brick's node with a point mass.
  layered.points.conservativeResize(first + 4, 3);
  layered.points.bottomRows(4) << 1, 1, 3, 2, 3, -4, 5, 5, 1, 7, 6, 2;
  layered.placed.resize(layered.points.rows(), 0);
  layered.rotations.resize(layered.points.rows(), Mat3::Identity());
  layered.elements.push_back({Kind::Rigid, "RBE2", 900, {first, 0, 1, 6}, {}});
  layered.elements.push_back(
      {Kind::Interpolation, "RBE3", 901, {first + 1, 30, 31, 37}, {1, 2, 0.5}});
  layered.elements.push_back({Kind::Beam, "CBAR", 902, {24, first + 2}, {}});
  layered.elements.push_back({Kind::Beam, "CBAR", 903, {first + 2, first + 3}, {}});
  layered.elements.push_back({Kind::Mass, "CONM2", 904, {first + 3}, {}});
  Points after = layered.points;
  move(kMotion, layered.points, after, layered.placed, layered.rotations);
  const auto followed = propagate_to_attached(layered.points, after, layered.placed,
                                              layered.rotations, layered.elements, {});
  CHECK(followed.size() == 54);
  CHECK(off(kMotion, layered.points, after) < 1e-12);
  CHECK(inverted_solids(layered.elements, layered.points, after).empty());
}

TEST_CASE("solids under a bent plate bend with it", "[mesh][attached]") {
  const LayeredPlate layered(9);
  Points after = layered.points;
  std::vector<Mat3> rotations = layered.rotations;
  const double radius = 8;  // of the plate; the solids are inside
  for (int v = 0; v < 81; ++v) {
    const double angle = (layered.points(v, 0) - 4) / radius;
    after.row(v) =
        Vec3(radius * std::sin(angle), layered.points(v, 1), radius * std::cos(angle) - radius);
    rotations[v] = Eigen::AngleAxisd(angle, Vec3::UnitY()).matrix();
  }
  propagate_to_attached(layered.points, after, layered.placed, rotations, layered.elements, {});
  CHECK(inverted_solids(layered.elements, layered.points, after).empty());
  // The layers keep their thickness.
  for (int v = 0; v < 81; ++v)
    for (int k = 0; k < 2; ++k) {
      const double thick = (after.row(v + 81 * k) - after.row(v + 81 * (k + 1))).norm();
      CHECK(thick == Approx(0.5).epsilon(0.1));
    }
  // Only the middle is lifted, by half an element: the quality stays good.
  after = layered.points;
  for (int v = 0; v < 81; ++v)
    after(v, 2) +=
        0.25 * std::exp(-((layered.points.row(v) - layered.points.row(40)).squaredNorm()) / 4);
  propagate_to_attached(layered.points, after, layered.placed, layered.rotations, layered.elements,
                        {});
  CHECK(inverted_solids(layered.elements, layered.points, after).empty());
  CHECK(after(40 + 162, 2) > -1 + 0.1);
}

TEST_CASE("a spider stays concentric with a rotating ring, a mean has its weights",
          "[mesh][attached]") {
  std::vector<Vec3> list{{1, 2, 0}};
  for (int i = 0; i < 12; ++i) {
    const double a = i * std::numbers::pi / 6;
    list.emplace_back(1 + 3 * std::cos(a), 2 + 3 * std::sin(a), 0);
  }
  const Points before = points_of(list);
  std::vector<char> placed(13, 1);
  placed[0] = 0;
  std::vector<int> nodes(13);
  for (int i = 0; i < 13; ++i) nodes[i] = i;
  std::vector<Mat3> rotations(13, Mat3::Identity());
  Points after = before;
  move(kMotion, before, after, placed, rotations);
  const std::vector<NonShellElement> spider{{Kind::Rigid, "RBE2", 1, nodes, {}}};
  propagate_to_attached(before, after, placed, rotations, spider, {});
  for (int i = 1; i < 13; ++i) CHECK(std::abs((after.row(i) - after.row(0)).norm() - 3) < 1e-13);

  // Two groups that move apart: the RBE3 moves by the weighted mean.
  after = before;
  for (int i = 1; i < 13; ++i) after(i, 2) += 5;
  after(1, 2) += 1;
  after(7, 2) += 1;
  std::vector<double> weights(12, 0);
  weights[0] = weights[6] = 3;  // opposite nodes, lifted by 6
  weights[3] = weights[9] = 1;  // opposite nodes, lifted by 5
  propagate_to_attached(
      before, after, placed, rotations,
      std::vector<NonShellElement>{{Kind::Interpolation, "RBE3", 2, nodes, weights}}, {});
  CHECK(after(0, 2) == Approx(5.75));
}

TEST_CASE("one node carries by its own rotation, nodes on a line by theirs about it",
          "[mesh][attached]") {
  const Points before = points_of({{0, 0, 0}, {1, 0, 0}, {0, 2, 0}});
  Points after = before;
  after.row(0) = Vec3(5, 0, 0);
  const Mat3 rotation = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()).matrix();
  const std::vector<NonShellElement> bar{{Kind::Rigid, "RBAR", 1, {0, 1, 2}, {}}};
  propagate_to_attached(before, after, {1, 0, 0}, {rotation, Mat3::Identity(), Mat3::Identity()},
                        bar, {});
  CHECK((after.row(1).transpose() - Vec3(5, 1, 0)).norm() < 1e-14);
  CHECK((after.row(2).transpose() - Vec3(3, 0, 0)).norm() < 1e-14);
  // Two nodes fixed, rotation about the line between them.
  const Mat3 about = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()).matrix();
  after = before;
  after.row(1) = Vec3(1 + 1e-9, 0, 0);  // almost fixed
  propagate_to_attached(before, after, {1, 1, 0}, {about, about, Mat3::Identity()}, bar, {});
  CHECK((after.row(2).transpose() - Vec3(0, 0, 2)).norm() < 1e-8);
}

TEST_CASE("unmoved nodes keep every digit, and fixed ones stay", "[mesh][attached]") {
  LayeredPlate layered(5);
  layered.points.array() += 1.0 / 3;
  Points after = layered.points;
  CHECK(propagate_to_attached(layered.points, after, layered.placed, layered.rotations,
                              layered.elements, {})
            .empty());
  CHECK(after == layered.points);
  move(kMotion, layered.points, after, layered.placed, layered.rotations);
  AttachmentOptions stay;
  stay.rule_of_kind.fill(AttachmentRule::Stay);
  CHECK(propagate_to_attached(layered.points, after, layered.placed, layered.rotations,
                              layered.elements, stay)
            .empty());
  CHECK(after.bottomRows(50) == layered.points.bottomRows(50));
  CHECK(!inverted_solids(layered.elements, layered.points, after).empty());
}

TEST_CASE("connections that keep their shape", "[mesh][attached]") {
  // 0 … 3 have faces; 4, 5 are centres of spiders with a bolt between them; 6 is connected by a
  // bar.
  const std::vector<NonShellElement> elements{
      {Kind::Rigid, "RBE2", 1, {4, 0, 1}, {}}, {Kind::Rigid, "RBE2", 2, {5, 2, 3}, {}},
      {Kind::Beam, "CBAR", 3, {4, 5}, {}},     {Kind::Beam, "CBAR", 4, {0, 6}, {}},
      {Kind::Bush, "CELAS2", 5, {1, 2}, {}},   {Kind::Bush, "CELAS2", 6, {2, 1}, {}},
      {Kind::Beam, "CBAR", 7, {0, 3}, {}},     {Kind::Mass, "CONM2", 8, {6}, {}},
      {Kind::Bush, "CBUSH", 9, {6, 0}, {}}};
  const std::vector<char> has_face{1, 1, 1, 1, 0, 0, 0};
  std::vector<std::string> names;
  for (const FormFeature& f : connections(elements, has_face, {})) names.push_back(f.name);
  CHECK(names == std::vector<std::string>{"RBE2 1", "RBE2 2", "CBAR 3", "CELAS2 5"});
  AttachmentOptions none;
  none.rule_of_kind.fill(AttachmentRule::Stay);
  CHECK(connections(elements, has_face, none).empty());
}

TEST_CASE("solids turned inside out are found whichever way they are numbered",
          "[mesh][attached]") {
  const Points before = points_of(
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}});
  const std::vector<NonShellElement> solids{{Kind::Solid, "CHEXA", 1, {0, 1, 2, 3, 4, 5, 6, 7}, {}},
                                            {Kind::Solid, "CHEXA", 2, {4, 5, 6, 7, 0, 1, 2, 3}, {}},
                                            {Kind::Solid, "CTETRA", 3, {0, 1, 3, 4}, {}},
                                            {Kind::Solid, "CPENTA", 4, {0, 1, 2, 4, 5, 6}, {}},
                                            {Kind::Solid, "CPYRAM", 5, {0, 1, 2, 3, 6}, {}},
                                            {Kind::Beam, "CBAR", 6, {0, 6}, {}}};
  CHECK(inverted_solids(solids, before, before).empty());
  Points mirrored = before;
  mirrored.col(0) *= -1;
  CHECK(inverted_solids(solids, before, mirrored) == std::vector<int>{0, 1, 2, 3, 4});
  Points pushed = before;
  pushed.row(4) = Vec3(0, 0, -0.1);  // through the floor
  CHECK(inverted_solids(solids, before, pushed) == std::vector<int>{0, 1, 2, 3});
  pushed.row(4) = Vec3(0, 0, 0.1);
  CHECK(inverted_solids(solids, before, pushed).empty());
}
