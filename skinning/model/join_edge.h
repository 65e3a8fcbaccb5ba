// SPDX-License-Identifier: MPL-2.0
// One side of a join line: its path in (u, v), and the dofs that determine the derivatives along
// and across it.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/fem/surface_assembler.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/model/join.h"

namespace batten {

using ConstraintEntries = std::vector<ConstraintSet::Entry>;

// A join line as represented in one region. f is a fraction of the line in [0, 1]; y and t are
// those of join.h.
class JoinEdge {
 public:
  JoinEdge(const ParametricMesh& mesh, TriangleElement kind, const EdgeAlignedLine* aligned_line,
           const EmbeddedLine* line, bool left, const NeighbourEdge* neighbour,
           const TriangleLocator* locator, const DofOffsets& dof_offsets)
      : mesh_(&mesh),
        kind_(kind),
        aligned_line_(aligned_line),
        line_(line),
        neighbour_(neighbour),
        locator_(locator),
        side_sign_(left ? 1 : -1),
        dof_offsets_(dof_offsets) {
    const CharacterLine& character = aligned_line ? aligned_line->line : line->line;
    const HermiteCurve& curve = aligned_line ? aligned_line->fitted : line->fitted;
    start_ = curve.start();
    span_ = curve.end() - start_;
    t_ = character.prescribed
             ? character.prescribed->curve.end() - character.prescribed->curve.start()
             : span_;
    if (!aligned_line) {
      reversed_ = line->opposite_to_prescribed;
      return;
    }
    const Vec2 d = mesh.chain_vector(aligned_line->vertices);
    sigma_ = d.norm() / t_;
    per_t_uv_ = d / t_;
    inward_ = inward(d.normalized());
  }
  bool embedded() const { return !aligned_line_; }
  // The given surface that this side is, or null if the side is a face of the model.
  const NeighbourEdge* neighbour() const { return neighbour_; }
  // y of a given surface: as long as dX/dt.
  Vec3 neighbour_across(double f) const {
    const Vec3 along = slope(f);
    return along.norm() * neighbour_->into(f, along);
  }
  const EdgeAlignedLine& aligned_line() const { return *aligned_line_; }
  double span() const { return t_; }  // range of t over the whole line
  int count() const { return isize(aligned_line_->vertices); }
  int vertex(int k) const { return aligned_line_->vertices[k]; }
  int end_vertex(int end) const { return vertex(end ? count() - 1 : 0); }
  bool closed() const {
    return aligned_line_ ? aligned_line_->vertices.front() == aligned_line_->vertices.back()
                         : line_->fitted.closed();
  }
  double fraction(int k) const { return (aligned_line_->parameters[k] - start_) / span_; }
  // Fractions of its vertices or collocation points, ascending.
  std::vector<double> stations() const {
    std::vector<double> f;
    for (const double p : aligned_line_ ? aligned_line_->parameters : line_->points) {
      const double along = (p - start_) / span_;
      f.push_back(reversed_ ? 1 - along : along);
    }
    std::sort(f.begin(), f.end());
    // A line much shorter than its elements has no collocation points.
    if (f.size() < 2) f = {0, 1};
    return f;
  }
  // dX/dt.
  Vec3 slope(double f) const {
    return (aligned_line_ ? aligned_line_->fitted : line_->fitted).evaluate(parameter(f), 1) *
           per_t();
  }

  Vec3 across(const Points& q, int k) const {
    if (neighbour_) return neighbour_across(fraction(k));
    const int v = 3 * vertex(k);
    return sigma_ * (inward_.x() * q.row(v + 1) + inward_.y() * q.row(v + 2)).transpose();
  }
  // These append factor · y, factor · dx/dt, factor · x at the k-th vertex to `entries`. That of y
  // requires a face of the model.
  void add_across(int k, double factor, ConstraintEntries& entries) const {
    add_gradient(vertex(k), factor * sigma_ * inward_, entries);
  }
  void add_along(int k, double factor, ConstraintEntries& entries) const {
    add_gradient(vertex(k), factor * per_t_uv_, entries);
  }
  int position_dof(int k) const { return dof_offsets_(3 * vertex(k)); }
  void add_position(int k, double factor, ConstraintEntries& entries) const {
    entries.push_back({dof_offsets_(3 * vertex(k)), factor});
  }
  // These append factor · y, factor · dx/dt at the midpoint of the k-th edge, where x is a cubic in
  // t.
  void add_across_middle(int k, double factor, ConstraintEntries& entries) const {
    const int e = aligned_line_->edges[k];
    entries.push_back({dof_offsets_(DofMap(*mesh_).edge(e)),
                       factor * sigma_ * (mesh_->edge_normal(e).dot(inward_) > 0 ? 1 : -1)});
  }
  void add_along_middle(int k, double factor, ConstraintEntries& entries) const {
    const double h = (fraction(k + 1) - fraction(k)) * t_;
    add_position(k, -1.5 * factor / h, entries);
    add_position(k + 1, 1.5 * factor / h, entries);
    add_along(k, -0.25 * factor, entries);
    add_along(k + 1, -0.25 * factor, entries);
  }

  // Point in (u, v) at a fraction of an embedded line.
  Vec2 pcurve(double f) const {
    return drop_z(line_->pcurve.evaluate(line_->pcurve.mesh().wrapped(parameter(f))));
  }
  // Location in the mesh at a fraction of the line.
  Location where(double f) const {
    const double p = parameter(f);
    if (line_) {
      const Vec3 c = line_->pcurve.evaluate(line_->pcurve.mesh().wrapped(p));
      return locator_->locate({c.x(), c.y()});
    }
    const auto& at = aligned_line_->parameters;
    const auto above = std::upper_bound(at.begin() + 1, at.end() - 1, p);
    const auto k = static_cast<size_t>(above - at.begin()) - 1;
    const auto& e = mesh_->edges()[aligned_line_->edges[k]];
    const int t = e.triangle[0], i = e.local[0];
    const bool next = mesh_->triangles()[t][(i + 1) % 3] == aligned_line_->vertices[k];
    const int first = next ? (i + 1) % 3 : (i + 2) % 3;
    Location found{t, Vec3::Zero()};
    found.L[3 - i - first] = std::clamp((p - at[k]) / (at[k + 1] - at[k]), 0.0, 1.0);
    found.L[first] = 1 - found.L[3 - i - first];
    return found;
  }
  // Directions in (u, v) with y = grad x · across_uv(f) and dx/dt = grad x · along_uv(f).
  Vec2 across_uv(double f) const {
    if (aligned_line_) return sigma_ * inward_;
    return inward(along_uv(f));
  }
  Vec2 along_uv(double f) const {
    if (aligned_line_) return per_t_uv_;
    return drop_z(line_->pcurve.evaluate(line_->pcurve.mesh().wrapped(parameter(f)), 1) * per_t());
  }
  // The derivative of along_uv(f) with respect to t.
  Vec2 along_uv_rate(double f) const {
    if (aligned_line_) return Vec2::Zero();
    return drop_z(line_->pcurve.evaluate(line_->pcurve.mesh().wrapped(parameter(f)), 2) * per_t() *
                  per_t());
  }
  Vec3 across_at(const Points& q, double f) const {
    if (neighbour_) return neighbour_across(f);
    const Location at = where(f);
    const Tabulation N = functions(at);
    const auto dofs = DofMap(*mesh_).triangle(*mesh_, at.triangle);
    const Vec2 d = across_uv(f);
    Vec3 y = Vec3::Zero();
    for (int m = 0; m < 12; ++m)
      y += (d.x() * N(m, kU) + d.y() * N(m, kV)) * q.row(dofs[m]).transpose();
    return y;
  }
  // Appends across · y + along · dx/dt + position · x at a fraction of the line.
  void add_at(double f, double across, double along, double position,
              ConstraintEntries& entries) const {
    const Location at = where(f);
    const Tabulation N = functions(at);
    const auto dofs = DofMap(*mesh_).triangle(*mesh_, at.triangle);
    const Vec2 d = across * across_uv(f) + along * along_uv(f);
    for (int m = 0; m < 12; ++m)
      entries.push_back(
          {dof_offsets_(dofs[m]), d.x() * N(m, kU) + d.y() * N(m, kV) + position * N(m, kW)});
  }

 private:
  double parameter(double f) const { return start_ + (reversed_ ? 1 - f : f) * span_; }
  double per_t() const { return (reversed_ ? -1 : 1) * span_ / t_; }
  Tabulation functions(const Location& at) const {
    return C1Triangle(kind_, mesh_->shape(at.triangle)).evaluate(at.L);
  }
  void add_gradient(int v, const Vec2& d, ConstraintEntries& entries) const {
    entries.push_back({dof_offsets_(3 * v + 1), d.x()});
    entries.push_back({dof_offsets_(3 * v + 2), d.y()});
  }
  Vec2 inward(const Vec2& along) const { return side_sign_ * Vec2(-along.y(), along.x()); }

  const ParametricMesh* mesh_;
  TriangleElement kind_;
  const EdgeAlignedLine* aligned_line_;
  const EmbeddedLine* line_;
  const NeighbourEdge* neighbour_;
  const TriangleLocator* locator_;
  double side_sign_, start_ = 0, span_ = 1, t_ = 1, sigma_ = 1;
  bool reversed_ = false;
  Vec2 inward_ = Vec2::Zero(), per_t_uv_ = Vec2::Zero();
  DofOffsets dof_offsets_;
};

// Creates the sides of join lines, with one locator per region that needs one.
class JoinEdgeFactory {
 public:
  explicit JoinEdgeFactory(const std::vector<const RegionLayout*>& regions) {
    for (const RegionLayout* r : regions)
      items_.push_back(
          r ? Item{r->mesh().get(), r->element(), &r->edge_aligned(), &r->embedded(), {}, {}}
            : Item{});
  }
  JoinEdgeFactory(const std::vector<const RegionLayout*>& regions,
                  const std::vector<DofOffsets>& dof_offsets)
      : JoinEdgeFactory(regions) {
    for (size_t r = 0; r < items_.size(); ++r) items_[r].dof_offsets = dof_offsets[r];
  }
  explicit JoinEdgeFactory(const std::vector<const SkinnedRegion*>& regions) {
    for (const SkinnedRegion* r : regions)
      items_.push_back(
          r ? Item{&r->surface.mesh(), r->surface.kind(), &r->edge_aligned, &r->embedded, {}, {}}
            : Item{});
  }
  JoinEdge operator()(const JoinSide& j) {
    Item& item = items_[j.region];
    if (j.embedded && !item.locator) item.locator = std::make_unique<TriangleLocator>(*item.mesh);
    const auto i = static_cast<size_t>(j.line);
    return {*item.mesh,
            item.kind,
            j.embedded ? nullptr : &(*item.edge_aligned)[i],
            j.embedded ? &(*item.lines)[i] : nullptr,
            j.left,
            j.neighbour.get(),
            item.locator.get(),
            item.dof_offsets};
  }

 private:
  struct Item {
    const ParametricMesh* mesh = nullptr;
    TriangleElement kind = TriangleElement::HCT;
    const std::vector<EdgeAlignedLine>* edge_aligned = nullptr;
    const std::vector<EmbeddedLine>* lines = nullptr;
    std::unique_ptr<TriangleLocator> locator;
    DofOffsets dof_offsets;
  };
  std::vector<Item> items_;
};

// An equation Σ coefficient · q + constant = 0 for the dofs q, the same for x, y and z but for the
// constant. It collects terms of both sides of a join; those of given surfaces are constant.
class JoinRow {
 public:
  // These add factor · y or factor · dx/dt of a side at the k-th vertex or the midpoint of the k-th
  // edge of a mesh-aligned line.
  void across(const JoinEdge& side, int k, double factor) {
    if (side.neighbour())
      constant_ += factor * side.neighbour_across(side.fraction(k));
    else
      side.add_across(k, factor, entries_);
  }
  void along(const JoinEdge& side, int k, double factor) { side.add_along(k, factor, entries_); }
  void across_middle(const JoinEdge& side, int k, double factor) {
    if (side.neighbour())
      constant_ += factor * side.neighbour_across(0.5 * (side.fraction(k) + side.fraction(k + 1)));
    else
      side.add_across_middle(k, factor, entries_);
  }
  void along_middle(const JoinEdge& side, int k, double factor) {
    side.add_along_middle(k, factor, entries_);
  }
  // Adds across · y + along · dx/dt of a side at a fraction of the line.
  void at(const JoinEdge& side, double f, double across, double along) {
    if (side.neighbour()) {
      constant_ += across * side.neighbour_across(f);
      across = 0;
    }
    if (across != 0 || along != 0) side.add_at(f, across, along, 0, entries_);
  }
  // Adds factor · x of a face of the model at a fraction of the line.
  void position(const JoinEdge& side, double f, double factor) {
    side.add_at(f, 0, 0, factor, entries_);
  }
  // Multiplies the equation by a factor.
  void scale(double factor) {
    for (auto& e : entries_) e.coefficient *= factor;
    constant_ *= factor;
  }
  // The entries, one per dof, ascending.
  ConstraintEntries entries() const {
    std::map<int, double> sum;
    for (const auto& e : entries_) sum[e.dof] += e.coefficient;
    ConstraintEntries all;
    for (const auto& [dof, coefficient] : sum) all.push_back({dof, coefficient});
    return all;
  }
  const Vec3& constant() const { return constant_; }
  void add_to(ConstraintSet& set, const std::string& name) const {
    set.add(name, entries(), -constant_);
  }

 private:
  ConstraintEntries entries_;
  Vec3 constant_ = Vec3::Zero();
};

// A Gauss point of a hat function over fractions of a line, with the hat's weight. `fraction`:
// position within `interval`, in [0, 1].
struct HatQuadraturePoint {
  double f, weight;
  size_t interval;
  double fraction;
};
// Hat functions over the fractions `at`. `with_ends`: include those of the first and the last
// fraction.
std::vector<std::vector<HatQuadraturePoint>> hats(const std::vector<double>& at, bool closed,
                                                  const std::array<bool, 2>& with_ends);
// Fractions over whose hats two sides, at least one of them embedded, are tied on the average.
std::vector<double> tie_stations(const JoinEdge& a, const JoinEdge& b);

inline double lerp(double a, double b, double f) { return a + f * (b - a); }

}  // namespace batten
