#include "batten/apps/commands/meshes/feature_relations.h"

#include <algorithm>
#include <cmath>

#include "batten/apps/commands/runs/run_support.h"
#include "batten/core/isize.h"

namespace batten {
namespace {

using Kind = RelationSpec::Kind;

/// How far features may be from what a relation keeps, over the distance of their centres.
constexpr double kNear = 1e-3;

void add_to(VertexCombination& sum, const VertexCombination& point, double factor) {
  for (const auto& e : point.entries) sum.entries.push_back({e.vertex, factor * e.coefficient});
}

class Relation {
 public:
  Relation(const DeformScene& scene, const RelationSpec& rule, VertexSelector& select,
           const TriangleMesh& mesh, SharedConstraints& shared)
      : scene_(scene), rule_(rule), select_(select), mesh_(mesh), shared_(shared) {
    find_features();
  }

  void add() {
    if (rule_.kind == Kind::Parallel || rule_.kind == Kind::Coaxial)
      shared_.shared_rotations.push_back(features_);
    if (rule_.kind == Kind::Coaxial) expect_one_axis();
    if (rule_.kind == Kind::Coaxial || rule_.kind == Kind::Distance) keep_differences();
    if (rule_.kind == Kind::Spacing) keep_steps();
    if (rule_.kind == Kind::Symmetric) keep_mirror_images();
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError(scene_.at(rule_.location) + "the relation '" + rule_.name + "': found " +
                     found + ", expected " + expected);
  }

  const std::string& name(size_t i) const { return shared_.features[features_[i]].name; }
  Vec3 at(size_t i) const { return centres_[i].at(mesh_.points()); }

  void find_features() {
    std::vector<std::string> names;
    for (const auto& f : shared_.features) names.push_back(f.name);
    for (const LocatedString& word : rule_.of) {
      bool any = false;
      for (int f = 0; f < isize(names); ++f)
        if (matches_wildcard(word.text, names[f])) {
          any = true;
          if (std::find(features_.begin(), features_.end(), f) == features_.end())
            features_.push_back(f);
        }
      if (!any)
        throw InputError(scene_.at(word.location) + "found '" + word.text +
                         "', expected a feature: " + comma_separated(names) +
                         did_you_mean(word.text, names));
    }
    const size_t least = rule_.kind == Kind::Spacing ? 3 : 2;
    if (features_.size() < least || (rule_.kind == Kind::Symmetric && features_.size() > 2))
      fail(std::to_string(features_.size()) + " features",
           rule_.kind == Kind::Symmetric ? "two" : std::to_string(least) + " or more");
    for (const int f : features_) centres_.push_back(shared_.centres[f]);
  }

  /// Axes are known of holes.
  void expect_one_axis() const {
    for (size_t i = 1; i < features_.size(); ++i) {
      const DetectedFeature* hole = select_.proposal(name(0));
      if (!hole) return;
      const Vec3 apart = at(i) - at(0);
      const double off = hole->measure.axis.cross(apart).norm();
      if (off > kNear * std::max(apart.norm(), hole->measure.radius))
        fail("the centre of '" + name(i) + "' " + format_number(off) + " beside the axis of '" +
                 name(0) + "'",
             "one axis; kind = \"distance\" keeps centres apart");
    }
  }

  void add_row(size_t i, VertexCombination combination) {
    LinearConstraint row;
    row.name = rule_.name + ", " + name(i);
    row.target = combination.at(mesh_.points());
    row.combination = std::move(combination);
    row.rotates_with = shared_.features[features_[0]].vertices[0];
    shared_.rows.push_back(std::move(row));
  }

  void keep_differences() {
    for (size_t i = 1; i < features_.size(); ++i) {
      VertexCombination apart = centres_[i];
      add_to(apart, centres_[0], -1);
      add_row(i, std::move(apart));
    }
  }

  void keep_steps() {
    for (size_t i = 1; i + 1 < features_.size(); ++i) {
      const Vec3 before = at(i) - at(i - 1), after = at(i + 1) - at(i);
      if ((after - before).norm() > kNear * before.norm())
        fail("steps of " + format_number(before.norm()) + " and " + format_number(after.norm()) +
                 " around '" + name(i) + "'",
             "even steps on a straight line, features in their order");
      VertexCombination change = centres_[i + 1];
      add_to(change, centres_[i], -2);
      add_to(change, centres_[i - 1], 1);
      add_row(i, std::move(change));
    }
  }

  void keep_mirror_images() {
    const Vec3 normal = rule_.plane->first.normalized(), apart = at(1) - at(0);
    const double off = std::max(normal.cross(apart).norm(),
                                std::abs(normal.dot((at(0) + at(1)) / 2 - rule_.plane->second)));
    if (off > kNear * apart.norm())
      fail("centres that are " + format_number(off) + " from being mirror images", "mirror images");
    VertexCombination middle, vector = centres_[1];
    add_to(middle, centres_[0], 0.5);
    add_to(middle, centres_[1], 0.5);
    add_to(vector, centres_[0], -1);
    shared_.point_constraints.push_back(
        {rule_.name + ", middle", std::move(middle), PointConstraint::Kind::OnPlane, normal});
    shared_.through.push_back(rule_.plane->second);
    shared_.point_constraints.push_back(
        {rule_.name + ", across", std::move(vector), PointConstraint::Kind::OnLine, normal});
    shared_.through.push_back(Vec3(Vec3::Zero()));
  }

  const DeformScene& scene_;
  const RelationSpec& rule_;
  VertexSelector& select_;
  const TriangleMesh& mesh_;
  SharedConstraints& shared_;
  std::vector<int> features_;
  std::vector<VertexCombination> centres_;
};

}  // namespace

VertexCombination centre_of(const FormFeature& feature, VertexSelector& select,
                            const TriangleMesh& mesh) {
  const DetectedFeature* p = select.proposal(feature.name);
  return VertexCombination::mean_of(p ? mesh.topology().nodes_of(p->loop) : feature.vertices);
}

void gather_relations(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh,
                      SharedConstraints& shared) {
  for (const RelationSpec& rule : scene.relations)
    Relation(scene, rule, select, mesh, shared).add();
}

}  // namespace batten
