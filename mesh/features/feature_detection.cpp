// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/features/feature_detection.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/mesh/features/feature_cut.h"
#include "batten/mesh/selection.h"

namespace batten {
namespace {

// Index 0, 1, … of the connected group of each triangle; -1 for triangles that are not members.
// Groups are numbered by their lowest triangles.
struct TriangleGroups {
  std::vector<int> of;
  int count = 0;
};

template <class Member, class Joined>
TriangleGroups groups_of(const MeshTopology& topology, const Member& member, const Joined& joined) {
  TriangleGroups groups{std::vector<int>(topology.triangle_count(), -1)};
  std::vector<int> stack;
  for (int seed = 0; seed < topology.triangle_count(); ++seed) {
    if (groups.of[seed] >= 0 || !member(seed)) continue;
    groups.of[seed] = groups.count;
    stack.push_back(seed);
    while (!stack.empty()) {
      const int t = stack.back();
      stack.pop_back();
      for (int c = 0; c < 3; ++c) {
        const int other = topology.across(t, c);
        if (other < 0 || groups.of[other] >= 0 || !member(other)) continue;
        if (!joined(topology.edges_of(t)[c])) continue;
        groups.of[other] = groups.count;
        stack.push_back(other);
      }
    }
    ++groups.count;
  }
  return groups;
}

// The triangle that traverses a → b, or -1.
int triangle_along(const MeshTopology& topology, int a, int b) {
  for (const int t : topology.triangles_of(a))
    for (int c = 0; c < 3; ++c)
      if (topology.triangles()[t][c] == a && topology.triangles()[t][(c + 1) % 3] == b) return t;
  return -1;
}

class FeatureDetector {
 public:
  FeatureDetector(const TriangleMesh& mesh, const FeatureDetectionOptions& options)
      : mesh_(mesh), topology_(mesh.topology()), options_(options) {
    if (!(options.crease_degrees > 0 && options.crease_degrees < 180))
      throw InputError("found a crease angle of " + format_number(options.crease_degrees) +
                       " degrees, expected more than 0 and less than 180");
    find_creases();
    find_outer_loops();
  }

  std::vector<DetectedFeature> detect() {
    const std::vector<EnclosedPatch> enclosed = enclosed_patches();
    std::vector<DetectedFeature> result;
    const auto& loops = topology_.boundary_loops();
    for (size_t i = 0; i < loops.size(); ++i)
      if (options_.outer_loops || !outer_[i]) {
        result.push_back(hole(loops[i], enclosed));
        result.back().name = "hole-" + std::to_string(result.size());
      }
    const size_t holes = result.size();
    for (const EnclosedPatch& patch : enclosed) {
      const bool is_flange =
          std::any_of(result.begin(), result.begin() + holes, [&](const auto& h) {
            return h.flange_ends_at_crease &&
                   std::includes(h.vertices.begin(), h.vertices.end(), patch.vertices.begin(),
                                 patch.vertices.end());
          });
      if (is_flange || patch.triangles < options_.min_triangles) continue;
      result.push_back({DetectedFeature::Kind::Crease,
                        "crease-" + std::to_string(result.size() - holes + 1), patch.vertices,
                        patch.crease, measure_hole(mesh_.points(), patch.crease), true});
    }
    return result;
  }

 private:
  // A region surrounded by the panel along one closed chain.
  struct EnclosedPatch {
    std::vector<int> vertices, crease;
    int triangles;
  };

  void find_creases() {
    const double angle = options_.crease_degrees * std::numbers::pi / 180;
    area_.resize(mesh_.triangle_count());
    std::vector<Vec3> normal(mesh_.triangle_count());
    for (int t = 0; t < mesh_.triangle_count(); ++t) {
      normal[t] = mesh_.area_vector(t);
      area_[t] = 0.5 * normal[t].norm();
    }
    for (const auto& e : topology_.edges())
      crease_.push_back(e.left >= 0 && e.right >= 0 &&
                        std::atan2(normal[e.left].cross(normal[e.right]).norm(),
                                   normal[e.left].dot(normal[e.right])) > angle);
  }

  // Finds the longest loop of each manifold patch (the first of equally long ones). A non-manifold
  // loop may be the outline of a patch, but never a hole.
  void find_outer_loops() {
    const auto& loops = topology_.boundary_loops();
    outer_.assign(loops.size(), 0);
    std::map<int, const std::vector<int>*> longest;
    for (const auto* all : {&loops, &topology_.non_manifold_loops()})
      for (const auto& loop : *all) {
        const auto [at, is_new] = longest.emplace(topology_.component()[loop.front()], &loop);
        if (!is_new && mesh_.length(loop) > mesh_.length(*at->second)) at->second = &loop;
      }
    for (const auto& [sheet, loop] : longest) {
      outlines_.push_back(loop);
      if (loop >= loops.data() && loop < loops.data() + loops.size())
        outer_[static_cast<size_t>(loop - loops.data())] = 1;
    }
  }

  DetectedFeature hole(const std::vector<int>& loop,
                       const std::vector<EnclosedPatch>& enclosed) const {
    DetectedFeature p{DetectedFeature::Kind::Hole,        {},  {}, loop,
                      measure_hole(mesh_.points(), loop), true};
    const Selection near = grown(topology_, loop, options_.flange_rings);
    p.vertices = enclosed_around(loop, near, enclosed);
    if (p.vertices.empty()) p.vertices = flange_around(loop, near);
    if (!p.vertices.empty()) return p;
    p.flange_ends_at_crease = false;
    p.vertices = options_.flange_width > 0
                     ? vertices_within(mesh_, loop, options_.flange_width)
                     : vertices_of_triangles(topology_, triangles_touching(topology_, loop));
    return p;
  }

  // Vertices of the first enclosed region around a loop that lies within `near` and contains no
  // other hole, or empty.
  Selection enclosed_around(const std::vector<int>& loop, const Selection& near,
                            const std::vector<EnclosedPatch>& enclosed) const {
    for (const EnclosedPatch& patch : enclosed) {
      const auto& v = patch.vertices;
      if (!std::binary_search(v.begin(), v.end(), loop.front()) ||
          !std::includes(near.begin(), near.end(), v.begin(), v.end()))
        continue;
      const auto other_hole = [&](const std::vector<int>& other) {
        return other != loop && std::all_of(other.begin(), other.end(), [&](int i) {
                 return std::binary_search(v.begin(), v.end(), i);
               });
      };
      const auto& loops = topology_.boundary_loops();
      if (std::none_of(loops.begin(), loops.end(), other_hole)) return v;
    }
    return {};
  }

  // Everything between a loop and the first closed crease around it, or empty.
  Selection flange_around(const std::vector<int>& loop, const Selection& near) const {
    const std::vector<int> ring = triangles_touching(topology_, loop);
    Selection sorted_loop = loop;
    std::sort(sorted_loop.begin(), sorted_loop.end());
    const auto on_loop = [&](int v) {
      return std::binary_search(sorted_loop.begin(), sorted_loop.end(), v);
    };

    std::vector<int> stack;
    std::set<int> reached;
    for (size_t i = 0; i < loop.size(); ++i) {
      const int t = triangle_along(topology_, loop[i], loop[(i + 1) % loop.size()]);
      if (reached.insert(t).second) stack.push_back(t);
    }
    while (!stack.empty()) {
      const int t = stack.back();
      stack.pop_back();
      for (const int v : topology_.triangles()[t])
        if (!std::binary_search(near.begin(), near.end(), v)) return {};
      for (int c = 0; c < 3; ++c) {
        const int other = topology_.across(t, c);
        if (other < 0) {
          if (!on_loop(topology_.triangles()[t][(c + 1) % 3])) return {};  // another boundary
        } else if (!crease_[topology_.edges_of(t)[c]] && reached.insert(other).second) {
          stack.push_back(other);
        }
      }
    }
    for (const int t : ring)
      if (!reached.count(t)) return {};
    return vertices_of_triangles(topology_, {reached.begin(), reached.end()});
  }

  // Regions that the panel surrounds, sorted by the lowest vertices of their creases.
  std::vector<EnclosedPatch> enclosed_patches() const {
    std::vector<EnclosedPatch> result;
    const TriangleGroups patches = groups_of(
        topology_, [](int) { return true; }, [&](int e) { return !crease_[e]; });
    std::vector<double> patch_area(patches.count, 0), part_area(topology_.component_count(), 0);
    for (int t = 0; t < mesh_.triangle_count(); ++t) {
      patch_area[patches.of[t]] += area_[t];
      part_area[part_of(t)] += area_[t];
    }
    std::vector<char> panel(patches.count, 0);
    for (const std::vector<int>* outline : outlines_) add_patches_at(*outline, patches, panel);

    for (;;) {
      const TriangleGroups groups = groups_of(
          topology_, [&](int t) { return !panel[patches.of[t]]; }, [](int) { return true; });
      std::vector<std::vector<int>> members(groups.count);
      for (int t = 0; t < mesh_.triangle_count(); ++t)
        if (groups.of[t] >= 0) members[groups.of[t]].push_back(t);
      bool panel_grew = false;  // first add the panel inside flanges
      for (const auto& group : members) {
        double area = 0;
        for (const int t : group) area += area_[t];
        if (area <= 0.5 * part_area[part_of(group[0])]) continue;
        int largest = patches.of[group[0]];
        for (const int t : group)
          if (patch_area[patches.of[t]] > patch_area[largest]) largest = patches.of[t];
        panel[largest] = 1;
        panel_grew = true;
      }
      if (panel_grew) continue;
      std::vector<char> inside(mesh_.triangle_count());
      for (int t = 0; t < mesh_.triangle_count(); ++t) inside[t] = groups.of[t] >= 0;
      add_surrounded(groups, inside, members, result);
      if (!options_.nested || groups.count == 0) break;
      grow_panel(patches, inside, panel);
    }
    std::stable_sort(result.begin(), result.end(),
                     [](const EnclosedPatch& a, const EnclosedPatch& b) {
                       return a.crease.front() < b.crease.front();
                     });
    return result;
  }

  // Adds the regions that are bounded by exactly one closed crease.
  void add_surrounded(const TriangleGroups& groups, const std::vector<char>& inside,
                      const std::vector<std::vector<int>>& members,
                      std::vector<EnclosedPatch>& result) const {
    const auto chains = border_chains(topology_, inside);
    std::vector<const BorderChain*> around(groups.count, nullptr);
    std::vector<int> chain_count(groups.count, 0);
    for (const BorderChain& chain : chains) {
      const int group = groups.of[triangle_along(topology_, chain.vertices[1], chain.vertices[0])];
      around[group] = &chain;
      ++chain_count[group];
    }
    for (int g = 0; g < groups.count; ++g)
      if (chain_count[g] == 1 && around[g]->closed)
        result.push_back(
            {vertices_of_triangles(topology_, members[g]), around[g]->vertices, isize(members[g])});
  }

  // Moves on to the next creases inwards: patches that touch the panel become panel.
  void grow_panel(const TriangleGroups& patches, const std::vector<char>& inside,
                  std::vector<char>& panel) const {
    std::vector<char> outermost(patches.count, 0);
    for (int t = 0; t < mesh_.triangle_count(); ++t)
      for (int c = 0; c < 3; ++c) {
        const int other = topology_.across(t, c);
        if (inside[t] && (other < 0 || !inside[other])) outermost[patches.of[t]] = 1;
      }
    for (int i = 0; i < patches.count; ++i) panel[i] |= outermost[i];
  }

  int part_of(int triangle) const {
    return topology_.component()[topology_.triangles()[triangle][0]];
  }

  void add_patches_at(const std::vector<int>& loop, const TriangleGroups& patches,
                      std::vector<char>& panel) const {
    for (size_t i = 0; i < loop.size(); ++i)
      panel[patches.of[triangle_along(topology_, loop[i], loop[(i + 1) % loop.size()])]] = 1;
  }

  const TriangleMesh& mesh_;
  const MeshTopology& topology_;
  const FeatureDetectionOptions& options_;
  std::vector<double> area_;                       // per triangle
  std::vector<char> crease_, outer_;               // per edge; per boundary loop
  std::vector<const std::vector<int>*> outlines_;  // longest loop of each patch that has a boundary
};

}  // namespace

std::vector<DetectedFeature> detect_features(const TriangleMesh& mesh,
                                             const FeatureDetectionOptions& options) {
  return FeatureDetector(mesh, options).detect();
}

namespace {

struct Circle {
  Vec2 centre = Vec2::Zero();
  double radius = 0;
};

using PlanePoints = Eigen::Matrix<double, Eigen::Dynamic, 2>;

// Algebraic fit: |x|² = 2 m·x + c with R² = c + |m|².
Circle algebraic_circle(const PlanePoints& x) {
  MatX A(x.rows(), 3);
  A << 2 * x, VecX::Ones(x.rows());
  const VecX squares = x.rowwise().squaredNorm();
  const Vec3 s = least_squares(A, squares);
  return {s.head<2>(), std::sqrt(std::max(0.0, s[2] + s.head<2>().squaredNorm()))};
}

VecX radii(const PlanePoints& x, const Vec2& centre) {
  return (x.rowwise() - centre.transpose()).rowwise().norm();
}

// Geometric fit: least squares of the distances by Gauss-Newton. Steps that do not reduce the sum
// are halved.
Circle geometric_circle(const PlanePoints& x, Circle circle) {
  const auto cost = [&](const Circle& c) {
    return (radii(x, c.centre).array() - c.radius).square().sum();
  };
  double best = cost(circle);
  for (int iteration = 0; iteration < 50; ++iteration) {
    const VecX r = radii(x, circle.centre);
    if (!(r.minCoeff() > 0)) break;
    MatX A(x.rows(), 3);
    A.leftCols<2>() = (x.rowwise() - circle.centre.transpose()).array().colwise() / r.array();
    A.col(2).setOnes();
    const Vec3 step = least_squares(A, (r.array() - circle.radius).matrix());
    double length = 1;
    Circle next;
    double next_cost;
    do {
      next = {circle.centre + length * step.head<2>(), circle.radius + length * step[2]};
      next_cost = cost(next);
      length /= 2;
    } while (!(next_cost <= best) && length > 1e-3);
    if (!(next_cost < best)) break;
    circle = next;
    best = next_cost;
  }
  return circle;
}

}  // namespace

HoleMeasure measure_hole(const Points& points, const std::vector<int>& loop,
                         double circular_tolerance) {
  const int n = isize(loop);
  if (n < 3)
    throw InputError("a hole has " + std::to_string(n) + " vertices, expected three or more");
  Points p(n, 3);
  for (int i = 0; i < n; ++i) {
    if (loop[i] < 0 || loop[i] >= points.rows())
      throw InputError("found vertex " + std::to_string(loop[i]) + " of a hole, expected 0 to " +
                       std::to_string(points.rows() - 1));
    p.row(i) = points.row(loop[i]);
  }
  if (!p.allFinite()) throw InputError("a hole has a coordinate that is not finite");

  const Eigen::RowVector3d centroid = p.colwise().mean();
  p.rowwise() -= centroid;
  HoleMeasure hole;
  hole.perimeter = 0;
  Vec3 twice_area_vector = Vec3::Zero();
  for (int i = 0; i < n; ++i) {
    const Vec3 a = p.row(i), b = p.row((i + 1) % n);
    hole.perimeter += (b - a).norm();
    twice_area_vector += a.cross(b);
  }
  const double scale = p.cwiseAbs().maxCoeff();
  const Mat3 frame = thin_svd(p / (scale > 0 ? scale : 1)).V;
  hole.axis = frame.col(2).dot(twice_area_vector) > 0 ? Vec3(-frame.col(2)) : Vec3(frame.col(2));
  hole.flatness = (p * hole.axis).cwiseAbs().maxCoeff();

  const PlanePoints x = p * frame.leftCols<2>() / (scale > 0 ? scale : 1);
  const Circle circle = geometric_circle(x, algebraic_circle(x));
  hole.centre = centroid.transpose() + frame.leftCols<2>() * (scale * circle.centre);
  hole.radius = scale * circle.radius;
  hole.roundness = scale * (radii(x, circle.centre).array() - circle.radius).abs().maxCoeff();
  const double enclosed = 0.5 * std::abs(hole.axis.dot(twice_area_vector));
  hole.equivalent_radius = std::sqrt(enclosed / std::numbers::pi);
  hole.circular = n >= 5 && enclosed >= 0.5 * std::numbers::pi * hole.radius * hole.radius &&
                  hole.radius > 0 && hole.roundness <= circular_tolerance * hole.radius;
  return hole;
}

}  // namespace batten
