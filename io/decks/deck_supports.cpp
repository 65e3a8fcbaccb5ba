// SPDX-License-Identifier: MPL-2.0
#include "batten/io/decks/deck_supports.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "batten/core/errors.h"
#include "batten/io/decks/ccx_text.h"

namespace batten {
namespace {

using Support = ShellDeck::Support;
constexpr double kSame = 1e-6;  // sines and cosines that count as 0

bool along_an_axis(const Vec3& d) { return d.cwiseAbs().maxCoeff() > (1 - kSame) * d.norm(); }

// Whether a row of *BOUNDARY for each component describes the support.
bool along_the_axes(const Support& support) {
  return !support.axes && support.rotations != Support::Rotations::Tangent &&
         std::all_of(support.directions.begin(), support.directions.end(), along_an_axis) &&
         std::all_of(support.rotation_axes.begin(), support.rotation_axes.end(), along_an_axis);
}

std::set<int> nodes_of(const std::vector<const SkinnedRegion*>& regions, const ModelElements& model,
                       const DeckDiscretization& elements, const Support& support) {
  std::set<int> nodes;
  if (support.point) {
    nodes.insert(nearest_node(elements.positions, *support.point));
    return nodes;
  }
  const auto add = [&](int node) {
    if (!support.box || support.box->contains(elements.positions[node])) nodes.insert(node);
  };
  for (const auto& line : model.lines)
    if (line.name == support.line)
      for (const int node : elements.nodes_on(line.edges)) add(node);
  for (size_t r = 0; r < regions.size() && support.line.empty(); ++r)
    if (support.region.empty() || regions[r]->name == support.region)
      for (const auto& element : elements.by_region[r])
        for (const int node : element) add(node);
  if (nodes.empty())
    throw InputError("stress deck: found a support without nodes, expected a larger box");
  return nodes;
}

// Orthogonal projection onto the span of some vectors.
Mat3 projection(const std::vector<Vec3>& vectors) {
  Mat3 sum = Mat3::Zero();
  for (const Vec3& d : vectors) sum += d.normalized() * d.normalized().transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> own(sum);
  Mat3 P = Mat3::Zero();
  for (int k = 0; k < 3; ++k)
    if (own.eigenvalues()[k] > kSame)
      P += own.eigenvectors().col(k) * own.eigenvectors().col(k).transpose();
  return P;
}

// The direction of a span of dimension 1, the normal of one of dimension 2; otherwise none.
std::optional<Vec3> axis_of(const Mat3& P) {
  const int dimension = static_cast<int>(std::lround(P.trace()));
  if (dimension == 0 || dimension == 3) return std::nullopt;
  const Mat3 onto = dimension == 1 ? P : Mat3(Mat3::Identity() - P);
  int longest;
  onto.colwise().norm().maxCoeff(&longest);
  return onto.col(longest).normalized();
}

// Axes in which the conditions on displacements and rotations concern single components.
std::optional<Mat3> common_axes(const std::vector<Vec3>& directions,
                                const std::vector<Vec3>& rotations) {
  std::vector<Vec3> axes;
  for (const auto* of : {&directions, &rotations})
    if (const auto axis = axis_of(projection(*of))) axes.push_back(*axis);
  if (std::all_of(axes.begin(), axes.end(), along_an_axis)) return Mat3::Identity();
  if (axes.size() == 2 && axes[0].cross(axes[1]).norm() < kSame) axes.pop_back();
  const Vec3 first = axes[0];
  const Vec3 second = axes.size() == 2 ? axes[1] : first.unitOrthogonal();
  if (std::abs(first.dot(second)) > kSame) return std::nullopt;
  Mat3 columns;
  columns << first, second, first.cross(second);
  return columns;
}

void write_row(std::ostream& out, const std::string& of, int component, double value) {
  out << of << ',' << component << ',' << component;
  if (value != 0) out << ',' << ccx_number(value);
  out << '\n';
}

void write_set(std::ostream& out, const std::string& name, const std::vector<int>& nodes) {
  out << "*NSET,NSET=" << name << '\n';
  write_ccx_ids(out, nodes);
}

}  // namespace

DeckSupports::DeckSupports(const std::vector<const SkinnedRegion*>& regions,
                           const ModelElements& model, const DeckDiscretization& elements,
                           const ShellDeck& deck, const std::vector<std::string>& line_sets)
    : load_factor_(deck.load_factor) {
  std::vector<std::set<int>> supported;
  for (const Support& support : deck.supports) {
    supported.push_back(nodes_of(regions, model, elements, support));
    if (!along_the_axes(support))
      for (const int node : supported.back()) nodes_.try_emplace(node);
  }
  for (size_t k = 0; k < deck.supports.size(); ++k) {
    const Support& support = deck.supports[k];
    const std::map<int, Vec3> tangents = support.rotations == Support::Rotations::Tangent
                                             ? elements.tangents(model, support.line)
                                             : std::map<int, Vec3>();
    Set set{"SUPPORT_" + std::to_string(k + 1), {}, &support};
    for (const int node : supported[k]) {
      const auto found = nodes_.find(node);
      if (found == nodes_.end()) {
        set.nodes.push_back(node);
        continue;
      }
      Node& of = found->second;
      const Mat3 axes = support.axes ? support.axes(elements.positions[node]) : Mat3::Identity();
      for (const Vec3& d : support.directions) {
        of.directions.emplace_back(axes * d);
        of.values.push_back(deck.load_factor * d.dot(support.displacement));
      }
      for (const Vec3& r : support.rotation_axes) of.rotations.emplace_back(axes * r);
      if (const auto tangent = tangents.find(node); tangent != tangents.end())
        of.rotations.push_back(tangent->second);
    }
    if (set.nodes.empty()) continue;
    const bool whole =
        !support.line.empty() && !support.box && set.nodes.size() == supported[k].size();
    for (size_t l = 0; l < model.lines.size() && whole; ++l)
      if (model.lines[l].name == support.line) set = {line_sets[l], {}, &support};
    sets_.push_back(set);
  }
  find_axes();
}

void DeckSupports::find_axes() {
  for (auto& [node, of] : nodes_) {
    const auto axes = common_axes(of.directions, of.rotations);
    if (!axes)
      throw DeckLimitError(
          "found supports in directions that are neither parallel nor perpendicular, "
          "which a CalculiX deck cannot contain");
    of.axes = *axes;
  }
}

Vec3 DeckSupports::local(int node, const Vec3& v) const {
  const auto found = nodes_.find(node);
  return found == nodes_.end() ? v : Vec3(found->second.axes.transpose() * v);
}

void DeckSupports::write_sets(std::ostream& out) const {
  for (const Set& set : sets_)
    if (!set.nodes.empty()) write_set(out, set.name, set.nodes);
  std::vector<std::pair<Mat3, std::vector<int>>> systems;
  for (const auto& [node, of] : nodes_) {
    if (of.axes.isIdentity(0)) continue;
    const auto same = std::find_if(systems.begin(), systems.end(), [&](const auto& system) {
      return (system.first - of.axes).cwiseAbs().maxCoeff() < 1e-14;
    });
    if (same == systems.end())
      systems.push_back({of.axes, {node}});
    else
      same->second.push_back(node);
  }
  for (size_t k = 0; k < systems.size(); ++k) {
    const std::string name = "SYSTEM_" + std::to_string(k + 1);
    write_set(out, name, systems[k].second);
    out << "*TRANSFORM,NSET=" << name << ",TYPE=R\n"
        << ccx_vector(systems[k].first.col(0)) << ',' << ccx_vector(systems[k].first.col(1))
        << '\n';
  }
}

void DeckSupports::write_boundary(std::ostream& out) const {
  for (const Set& set : sets_) {
    const Support& support = *set.support;
    const Mat3 held = projection(support.directions), turns = projection(support.rotation_axes);
    if (held.isIdentity(kSame) && support.displacement.isZero(0) &&
        (turns.isZero(0) || turns.isIdentity(kSame))) {
      out << set.name << ",1," << (turns.isZero(0) ? 3 : 6) << '\n';
      continue;
    }
    for (int c = 0; c < 3; ++c)
      if (held(c, c) > 0.5) write_row(out, set.name, c + 1, load_factor_ * support.displacement[c]);
    if (turns.isIdentity(kSame))
      out << set.name << ",4,6\n";
    else
      for (int c = 0; c < 3; ++c)
        if (turns(c, c) > 0.5) write_row(out, set.name, c + 4, 0);
  }
  for (const auto& [node, of] : nodes_) {
    const Mat3 held = projection(of.directions), turns = projection(of.rotations);
    Eigen::Matrix<double, Eigen::Dynamic, 3> rows(static_cast<long>(of.directions.size()), 3);
    VecX values(rows.rows());
    for (long k = 0; k < rows.rows(); ++k) {
      rows.row(k) = of.directions[static_cast<size_t>(k)].transpose();
      values[k] = of.values[static_cast<size_t>(k)];
    }
    const Vec3 moved = rows.rows() == 0 || values.isZero(0)
                           ? Vec3::Zero()
                           : Vec3(rows.completeOrthogonalDecomposition().solve(values));
    for (int c = 0; c < 3; ++c) {
      const Vec3 axis = of.axes.col(c);
      if ((held * axis).norm() > 0.5)
        write_row(out, std::to_string(node + 1), c + 1, axis.dot(moved));
    }
    for (int c = 0; c < 3; ++c)
      if ((turns * of.axes.col(c)).norm() > 0.5) write_row(out, std::to_string(node + 1), c + 4, 0);
  }
}

}  // namespace batten
