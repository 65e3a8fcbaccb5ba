// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/vertex_constraints.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "batten/analysis/models/line_sides.h"
#include "batten/core/cancellation.h"
#include "batten/core/containers.h"

namespace batten {
namespace {

constexpr double kExact = 0.95;  // ε₀
constexpr double kPenalty = 10;  // α

// A vertex at which constraints meet: its tangent plane, section and element edge.
struct ConstrainedVertex {
  Vec3 u, v, normal;
  double membrane = 0, bending = 0, edge = 0;  // A11 t, D11 t³, h
};

// An equation with vectors as coefficients, as a linear form of displacements and displacement
// gradients of the vertices of its group: per vertex, 3 + 9 numbers.
struct VertexForm {
  VecX form;
  double value = 0;
};
constexpr int kFormSize = 12;

class VertexConstraints {
 public:
  VertexConstraints(const ModelLayout& model, const Points& shape,
                    const std::vector<ShellSection>& sections, ShellTies& ties)
      : model_(model), shape_(shape), sections_(sections), ties_(ties) {}

  void relax() {
    collect();
    for (const auto& [root, rows] : groups()) relax_group(rows);
    if (springs_.empty()) return;
    ConstraintSet kept(ties_.constraints.dof_count(), ConstraintSet::Kind::Coupled);
    const auto& names = ties_.constraints.names();
    for (int i = 0; i < isize(ties_.constraints.constraints()); ++i) {
      const auto& row = ties_.constraints.constraints()[i];
      if (!relaxed_[i]) kept.add(names[row.name], row.entries, row.value);
    }
    for (int i = 0; i < isize(ties_.constraints.coupled_constraints()); ++i) {
      const auto& row = ties_.constraints.coupled_constraints()[i];
      if (!relaxed_[uncoupled_ + i]) kept.add_coupled(names[row.name], row.entries, row.value);
    }
    ties_.constraints = std::move(kept);
    for (const auto& [name, entries, stiffness, value] : springs_)
      ties_.springs.add(name, entries, stiffness, value);
  }

 private:
  struct Row {
    int index;  // of the constraint; coupled ones follow the uncoupled ones
    std::vector<int> vertices;
  };
  struct NewSpring {
    std::string name;
    CoupledEntries entries;
    double stiffness, value;
  };

  // The vertices of an equation; empty if it has dofs of edges, both values and derivatives, or
  // vertices at different positions.
  template <class Entries>
  std::vector<int> vertices_of(const Entries& entries) const {
    std::vector<int> vertices;
    int derivatives = 0;
    for (const auto& e : entries) {
      if (e.dof >= 3 * model_.mesh()->vertex_count()) return {};
      vertices.push_back(e.dof / 3);
      derivatives += e.dof % 3 > 0;
    }
    if (derivatives != 0 && derivatives != isize(entries)) return {};
    vertices = sorted_unique(std::move(vertices));
    constexpr double coincident = 1e-6;
    for (const int v : vertices)
      if ((shape_.row(3 * v) - shape_.row(3 * vertices[0])).norm() > coincident * model_.size())
        return {};
    return vertices;
  }

  void collect() {
    const auto add = [&](int index, const auto& entries) {
      poll_every<4096>(index);
      std::vector<int> vertices = vertices_of(entries);
      if (!vertices.empty()) rows_.push_back({index, std::move(vertices)});
    };
    const ConstraintSet& set = ties_.constraints;
    uncoupled_ = isize(set.constraints());
    relaxed_.resize(set.constraints().size() + set.coupled_constraints().size());
    for (int i = 0; i < uncoupled_; ++i) add(i, set.constraints()[i].entries);
    for (int i = 0; i < isize(set.coupled_constraints()); ++i)
      add(uncoupled_ + i, set.coupled_constraints()[i].entries);
  }

  // The rows at each place, by their first vertex, in the order of the constraints.
  std::map<int, std::vector<const Row*>> groups() {
    DisjointSets places(static_cast<size_t>(model_.mesh()->vertex_count()));
    for (const Row& row : rows_)
      for (const int v : row.vertices) places.unite(v, row.vertices[0]);
    std::map<int, std::vector<const Row*>> groups;
    for (const Row& row : rows_) groups[places.find(row.vertices[0])].push_back(&row);
    std::erase_if(groups, [](const auto& group) { return group.second.size() < 2; });
    find_triangles(groups);
    return groups;
  }

  void find_triangles(const std::map<int, std::vector<const Row*>>& groups) {
    for (const auto& [root, rows] : groups)
      for (const Row* row : rows)
        for (const int v : row->vertices) triangle_at_[v] = -1;
    const auto& triangles = model_.mesh()->triangles();
    for (int t = 0; t < isize(triangles); ++t)
      for (const int v : triangles[t])
        if (const auto at = triangle_at_.find(v); at != triangle_at_.end()) at->second = t;
  }

  ConstrainedVertex vertex(int v) const {
    ConstrainedVertex at;
    at.u = shape_.row(3 * v + 1);
    at.v = shape_.row(3 * v + 2);
    at.normal = at.u.cross(at.v).normalized();
    const int t = triangle_at_.at(v);
    const ShellSection& section = sections_[sections_.size() == 1 ? 0 : model_.region_of(t)];
    const auto& corners = model_.mesh()->triangles()[t];
    for (int i = 0; i < 3; ++i)
      at.edge = std::max(
          at.edge, (shape_.row(3 * corners[i]) - shape_.row(3 * corners[(i + 1) % 3])).norm());
    at.membrane = section.membrane_stiffness();
    at.bending = section.bending_stiffness();
    return at;
  }

  // The equation as a form of the vertices `places`. Uncoupled: its x equation.
  VertexForm form_of(const Row& row, const std::map<int, int>& places,
                     const std::vector<ConstrainedVertex>& at) const {
    VertexForm result{VecX::Zero(kFormSize * isize(at)), 0};
    const auto add = [&](int dof, const Vec3& coefficient) {
      const int place = places.at(dof / 3);
      const int derivative = dof % 3;
      if (derivative == 0) {
        result.form.segment<3>(kFormSize * place) += coefficient;
        return;
      }
      const Vec3& along = derivative == 1 ? at[place].u : at[place].v;
      for (int c = 0; c < 3; ++c)
        result.form.segment<3>(kFormSize * place + 3 + 3 * c) += coefficient[c] * along;
    };
    const ConstraintSet& set = ties_.constraints;
    if (row.index < uncoupled_) {
      for (const auto& e : set.constraints()[row.index].entries)
        add(e.dof, e.coefficient * Vec3::UnitX());
      result.value = set.constraints()[row.index].value.norm();
    } else {
      const auto& of = set.coupled_constraints()[row.index - uncoupled_];
      for (const auto& e : of.entries) add(e.dof, e.coefficient);
      result.value = of.value;
    }
    return result;
  }

  // The x form of an uncoupled equation, for y or z.
  static VecX for_coordinate(const VecX& x, int c) {
    VecX result = VecX::Zero(x.size());
    for (long k = 0; k < x.size(); k += kFormSize) {
      result[k + c] = x[k];
      result.segment<3>(k + 3 + 3 * c) = x.segment<3>(k + 3);
    }
    return result;
  }

  // Penalty stiffness of a violation that is the form `added` of the vertices.
  static double stiffness_of(const VecX& added, const std::vector<ConstrainedVertex>& at) {
    double sum = 0, all = 0;
    for (int p = 0; p < isize(at); ++p) {
      const ConstrainedVertex& of = at[p];
      Mat3 gradient;
      for (int c = 0; c < 3; ++c)
        gradient.row(c) = added.segment<3>(kFormSize * p + 3 + 3 * c).transpose();
      const double displacement = added.segment<3>(kFormSize * p).squaredNorm(),
                   rotation = (of.normal.transpose() * gradient).squaredNorm(),
                   strain = std::max(0.0, gradient.squaredNorm() - rotation);
      sum += of.membrane * (displacement + strain * of.edge * of.edge) + of.bending * rotation;
      all += displacement + gradient.squaredNorm();
    }
    return all > 0 ? kPenalty * sum / all : 0;
  }

  // Removes the parts along the first `count` vectors of an orthonormal basis.
  static void project_off(const std::vector<VertexForm>& basis, size_t count, VertexForm& form) {
    for (size_t k = 0; k < count; ++k) {
      const double along = basis[k].form.dot(form.form);
      form.form -= along * basis[k].form;
      form.value -= along * basis[k].value;
    }
  }

  // How much a tie adds to those before it: a tie to one more of several faces has at least 1/√2 of
  // its length.
  static double tie_independence(double length, int faces) {
    constexpr int two = 2;
    return faces > two ? std::min(1.0, std::sqrt(2.0) * length) : length;
  }

  void relax_group(const std::vector<const Row*>& rows) {
    std::map<int, int> places;
    for (const Row* row : rows)
      for (const int v : row->vertices) places.emplace(v, 0);
    std::vector<ConstrainedVertex> at;
    for (auto& [v, place] : places) {
      place = isize(at);
      at.push_back(vertex(v));
    }
    std::vector<VertexForm> basis;  // orthonormal
    size_t ties = 0;                // basis vectors of ties
    double largest_value = 0;
    for (const Row* row : rows) {
      const bool is_tie = row->vertices.size() > 1;
      VertexForm form = form_of(*row, places, at);
      const double norm = form.form.norm();
      if (!(norm > 0) || !std::isfinite(norm)) continue;
      form.form /= norm;
      form.value /= norm;
      VertexForm added = form;
      for (int round = 0; round < 2; ++round) project_off(basis, basis.size(), added);
      const double length = added.form.norm();
      // A support of one face is half a support of two faces that a tie equates.
      VertexForm of_all_faces = form;
      project_off(basis, is_tie ? 0 : ties, of_all_faces);
      const double epsilon =
          is_tie ? tie_independence(length, isize(at)) : length / of_all_faces.form.norm();
      largest_value = std::max(largest_value, std::abs(form.value));
      constexpr double rounding = 1e-9;
      const bool contradicts = std::abs(added.value) > std::max(length, rounding) * largest_value;
      if (epsilon < kExact && !contradicts) {
        const double ratio = epsilon / kExact;
        add_spring(*row, norm, stiffness_of(added.form, at) / (1 - ratio * ratio));
      } else if (length > 0) {
        basis.push_back({added.form / length, added.value / length});
        for (int c = 1; c < 3 && row->index < uncoupled_; ++c)
          basis.push_back({for_coordinate(basis[basis.size() - c].form, c), 0});
        if (is_tie) ties = basis.size();
      }
    }
  }

  // Springs on the violation of an equation whose form has the given norm.
  void add_spring(const Row& row, double norm, double stiffness) {
    relaxed_[row.index] = true;
    const ConstraintSet& set = ties_.constraints;
    if (row.index >= uncoupled_) {
      const auto& of = set.coupled_constraints()[row.index - uncoupled_];
      springs_.push_back({set.names()[of.name], of.entries, stiffness / (norm * norm), of.value});
      return;
    }
    const auto& of = set.constraints()[row.index];
    for (int c = 0; c < 3; ++c) {
      CoupledEntries entries;
      for (const auto& e : of.entries) entries.push_back({e.dof, e.coefficient * Vec3::Unit(c)});
      springs_.push_back(
          {set.names()[of.name], std::move(entries), stiffness / (norm * norm), of.value[c]});
    }
  }

  const ModelLayout& model_;
  const Points& shape_;
  const std::vector<ShellSection>& sections_;
  ShellTies& ties_;
  int uncoupled_ = 0;
  std::vector<Row> rows_;
  std::vector<bool> relaxed_;
  std::map<int, int> triangle_at_;  // one triangle at each vertex of a group
  std::vector<NewSpring> springs_;
};

}  // namespace

void relax_dependent_constraints(const ModelLayout& model, const Points& shape,
                                 const std::vector<ShellSection>& sections, ShellTies& ties) {
  VertexConstraints(model, shape, sections, ties).relax();
}

}  // namespace batten
