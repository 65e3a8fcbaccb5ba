// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/surface_model.h"

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "batten/core/containers.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/network/curve_network.h"

namespace batten {

std::vector<const SkinnedRegion*> SurfaceModel::skinned() const {
  std::vector<const SkinnedRegion*> all;
  for (const ModelRegion& region : regions)
    if (region.skinned) all.push_back(&*region.skinned);
  return all;
}

double cone_volume(const SkinnedRegion& face, const Vec3& apex) {
  const Surface& s = face.surface;
  VecX ones = VecX::Zero(s.dof_map().count());
  for (int v = 0; v < s.mesh().vertex_count(); ++v) ones[s.dof_map().vertex(v)] = 1;
  const Points about = s.dofs() - ones * apex.transpose();
  const SurfaceAssembler assembler(s.mesh(), s.kind(), s.trim());
  return about.cwiseProduct(assembler.pressure_load(about)).sum() / 3;
}

namespace {

using Curves = std::map<std::string, HermiteCurve>;

/// The curves of all lines of the regions, by name.
Curves curves_of_regions(const SurfaceModel& model) {
  Curves curves;
  for (const SkinnedRegion* region : model.skinned()) {
    for (const EdgeAlignedLine& aligned_line : region->edge_aligned)
      curves.try_emplace(aligned_line.line.name, aligned_line.fitted);
    for (const EmbeddedLine& line : region->embedded)
      curves.try_emplace(line.line.name, line.fitted);
  }
  return curves;
}

Vec3 start_of(const HermiteCurve& curve) { return curve.position(0); }
Vec3 end_of(const HermiteCurve& curve) { return curve.evaluate(curve.end()); }
Vec3 last_slope(const HermiteCurve& curve) {
  return curve.slope_in(curve.closed() ? 0 : curve.node_count() - 1);
}

bool parallel(const Vec3& a, const Vec3& b) {
  constexpr double radians = 1e-6;
  return a.dot(b) > 0 && a.cross(b).norm() <= radians * a.norm() * b.norm();
}

/// A sequence of curves, each of which begins at the end of the previous one, as one curve. It is
/// C1 up to rounding of the slopes.
class Chain {
 public:
  explicit Chain(const HermiteCurve& first) { add(first); }

  /// True if the curve continues the chain at its end, in the same direction.
  bool continues(const HermiteCurve& next) const {
    return (start_of(next) - points_.back()).norm() <= merge_tolerance() &&
           parallel(slopes_.back(), next.slope_out(0));
  }
  void add(const HermiteCurve& next) {
    const double factor = points_.empty() ? 1 : next.slope_out(0).norm() / slopes_.back().norm();
    const double shift = points_.empty() ? next.start() : u_.back() - factor * next.start();
    const int nodes = next.closed() ? next.node_count() + 1 : next.node_count();
    for (int i = points_.empty() ? 0 : 1; i < nodes; ++i) {
      u_.push_back(shift + factor * next.parameters()[i]);
      points_.push_back(next.position(i % next.node_count()));
      slopes_.push_back(next.slope_out(i % next.node_count()) / factor);
    }
    if (!next.closed()) slopes_.back() = last_slope(next) / factor;
  }
  /// A chain that returns to its beginning in the same direction gives a closed curve.
  HermiteCurve curve() const {
    const bool closed = u_.size() > 2 &&
                        (points_.back() - points_.front()).norm() <= merge_tolerance() &&
                        parallel(slopes_.back(), slopes_.front()) &&
                        std::abs(slopes_.back().norm() / slopes_.front().norm() - 1) < 1e-6;
    const CurveMesh mesh(u_, closed);
    Points dofs(mesh.dof_count(), 3);
    for (int i = 0; i < mesh.node_count(); ++i) {
      dofs.row(mesh.position_dof(i)) = points_[i].transpose();
      dofs.row(mesh.slope_out(i)) = slopes_[i].transpose();
    }
    return {mesh, dofs};
  }

 private:
  double merge_tolerance() const {
    return 1e-9 * (u_.back() - u_.front()) * slopes_.front().norm();
  }
  std::vector<double> u_;
  std::vector<Vec3> points_, slopes_;
};

/// The curve of an edge in the direction of its line, taken from a region if it belongs to one.
HermiteCurve edge_along_line(const NetworkEdge& edge, const Curves& of_regions) {
  const auto found = of_regions.find(edge.name);
  if (found == of_regions.end()) return edge.reversed ? edge.curve.backwards() : edge.curve;
  // Regions store it in the direction of their loops. An edge that is a closed curve has no
  // preferred direction.
  const HermiteCurve& own = found->second;
  const bool turned =
      (start_of(own) - start_of(edge.curve)).norm() > (start_of(own) - end_of(edge.curve)).norm();
  return turned != edge.reversed ? own.backwards() : own;
}

}  // namespace

std::vector<CubicSpline> model_curves(const SurfaceModel& model, const CurveNetwork* network) {
  const Curves of_regions = curves_of_regions(model);
  std::vector<CubicSpline> splines;
  const auto add = [&](const std::string& name, const HermiteCurve& curve) {
    for (CubicSpline& spline : cubic_splines(name, curve)) splines.push_back(std::move(spline));
  };
  if (!network) {
    for (const auto& [name, curve] : of_regions) add(name, curve);
    return splines;
  }
  for (int l = 0; l < isize(network->lines()); ++l) {
    const std::string& name = network->lines()[l].name;
    std::vector<Chain> chains;
    std::vector<std::array<int, 2>> numbers;  // first and last edge number of each chain
    int number = 0;
    for (const int a : network->edges_of(name)) {
      const NetworkEdge& edge = network->edges()[a];
      ++number;
      if (edge.line != l) continue;  // belongs to another line
      const HermiteCurve curve = edge_along_line(edge, of_regions);
      if (!chains.empty() && chains.back().continues(curve)) {
        chains.back().add(curve);
        numbers.back()[1] = number;
      } else {
        chains.emplace_back(curve);
        numbers.push_back({number, number});
      }
    }
    for (size_t k = 0; k < chains.size(); ++k) {
      const auto [first, last] = numbers[k];
      const std::string part =
          "." + std::to_string(first) + (last > first ? "-" + std::to_string(last) : std::string());
      add(name + (chains.size() > 1 ? part : std::string()), chains[k].curve());
    }
  }
  return splines;
}

}  // namespace batten
