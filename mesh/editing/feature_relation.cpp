// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/editing/feature_relation.h"

#include <algorithm>
#include <cmath>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

/// Tolerance of relations in the initial shape, relative to the distance of the centres.
constexpr double kRelationTolerance = 1e-3;

void add_to(VertexCombination& sum, const VertexCombination& point, double factor) {
  for (const auto& e : point.entries) sum.entries.push_back({e.vertex, factor * e.coefficient});
}

class RelationBuilder {
 public:
  RelationBuilder(const FeatureRelation& relation, std::span<const FormFeature> features,
                  std::span<const VertexCombination> centres, const Points& points)
      : relation_(relation), features_(features), centres_(centres), points_(points) {
    check_features();
  }

  RelationConstraints constraints() {
    const Kind kind = relation_.kind;
    if (kind == Kind::Parallel || kind == Kind::Coaxial)
      result_.shared_rotations.push_back(relation_.features);
    if (kind == Kind::Coaxial) expect_one_axis();
    if (kind == Kind::Coaxial || kind == Kind::Distance) keep_differences();
    if (kind == Kind::Spacing) keep_steps();
    if (kind == Kind::Symmetric) keep_mirror_images();
    return std::move(result_);
  }

 private:
  using Kind = FeatureRelation::Kind;

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError("the relation '" + relation_.name + "': found " + found + ", expected " +
                     expected);
  }

  size_t count() const { return relation_.features.size(); }
  const std::string& name(size_t i) const { return features_[relation_.features[i]].name; }
  const VertexCombination& centre(size_t i) const { return centres_[relation_.features[i]]; }
  Vec3 at(size_t i) const { return centre(i).at(points_); }

  void check_features() const {
    const bool symmetric = relation_.kind == Kind::Symmetric;
    const size_t least = relation_.kind == Kind::Spacing ? 3 : 2;
    if (count() < least || (symmetric && count() > 2))
      fail(std::to_string(count()) + " features",
           symmetric ? "two" : std::to_string(least) + " or more");
    const int known = std::min(isize(features_), isize(centres_));
    for (const int f : relation_.features)
      if (f < 0 || f >= known)
        fail("feature " + std::to_string(f), "one of 0 to " + std::to_string(known - 1));
    if (symmetric && !relation_.plane) fail("no plane", "the plane of symmetry");
  }

  /// Checks that the centres are on the axis of a hole; only holes have a known axis.
  void expect_one_axis() const {
    if (!relation_.hole) return;
    for (size_t i = 1; i < count(); ++i) {
      const Vec3 apart = at(i) - at(0);
      const double off = relation_.hole->axis.cross(apart).norm();
      if (off > kRelationTolerance * std::max(apart.norm(), relation_.hole->radius))
        fail("the centre of '" + name(i) + "' at a distance of " + format_number(off) +
                 " from the axis of '" + name(0) + "'",
             "centres on a common axis; the type \"distance\" keeps the centres at their distance");
    }
  }

  void add_row(size_t i, VertexCombination combination) {
    LinearConstraint row;
    row.name = relation_.name + ", " + name(i);
    row.target = combination.at(points_);
    row.combination = std::move(combination);
    row.rotates_with = features_[relation_.features[0]].vertices[0];
    result_.rows.push_back(std::move(row));
  }

  void keep_differences() {
    for (size_t i = 1; i < count(); ++i) {
      VertexCombination apart = centre(i);
      add_to(apart, centre(0), -1);
      add_row(i, std::move(apart));
    }
  }

  void keep_steps() {
    for (size_t i = 1; i + 1 < count(); ++i) {
      const Vec3 before = at(i) - at(i - 1), after = at(i + 1) - at(i);
      if ((after - before).norm() > kRelationTolerance * before.norm())
        fail("spacings of " + format_number(before.norm()) + " and " + format_number(after.norm()) +
                 " before and after '" + name(i) + "'",
             "equal spacings on a straight line, with the features in their order");
      VertexCombination change = centre(i + 1);
      add_to(change, centre(i), -2);
      add_to(change, centre(i - 1), 1);
      add_row(i, std::move(change));
    }
  }

  void keep_mirror_images() {
    const Vec3 normal = relation_.plane->first.normalized(), apart = at(1) - at(0);
    const double off =
        std::max(normal.cross(apart).norm(),
                 std::abs(normal.dot((at(0) + at(1)) / 2 - relation_.plane->second)));
    if (off > kRelationTolerance * apart.norm())
      fail("centres that deviate by " + format_number(off) + " from mirror images",
           "centres that are mirror images in the plane");
    VertexCombination middle, vector = centre(1);
    add_to(middle, centre(0), 0.5);
    add_to(middle, centre(1), 0.5);
    add_to(vector, centre(0), -1);
    result_.point_constraints.push_back(
        {relation_.name + ", middle", std::move(middle), PointConstraint::Kind::OnPlane, normal});
    result_.constraint_origins.push_back(relation_.plane->second);
    result_.point_constraints.push_back(
        {relation_.name + ", across", std::move(vector), PointConstraint::Kind::OnLine, normal});
    result_.constraint_origins.emplace_back(Vec3::Zero());
  }

  const FeatureRelation& relation_;
  std::span<const FormFeature> features_;
  std::span<const VertexCombination> centres_;
  const Points& points_;
  RelationConstraints result_;
};

}  // namespace

RelationConstraints relation_constraints(const FeatureRelation& relation,
                                         std::span<const FormFeature> features,
                                         std::span<const VertexCombination> centres,
                                         const Points& points) {
  return RelationBuilder(relation, features, centres, points).constraints();
}

}  // namespace batten
