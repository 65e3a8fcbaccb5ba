// SPDX-License-Identifier: MPL-2.0
// Nodes that are tied to surfaces: adhesives, spot welds.
#pragma once

#include <array>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// A node that follows a point of a triangle: the closest one in the undeformed mesh.
struct TiedNode {
  int node;
  std::array<int, 3> corners;
  Vec3 weights;  ///< barycentric coordinates of the point
  double distance;
  int triangle;
  int tie;  ///< index of the SurfaceTie

  /// The point of the surface, for the positions of all nodes (n×3).
  Vec3 foot(const Points& points) const;
};

/// The closest points of all ties of a mesh.
///
/// - Nodes beyond the reach of their tie are not tied. If no node of their part is tied, notes() lists
///   them.
/// - If two parts are tied to each other in both directions, only the first direction counts.
/// - Beams and springs that stand between two surfaces to which both of their ends are tied are
///   welds.
/// - If a solid is tied to two parts (adhesive), the second part is tied to the first one.
class SurfaceTies {
 public:
  /// `elements`: other elements of the mesh; `face_of_triangle`: see PreparedMesh. O(nodes · log
  /// triangles).
  SurfaceTies(std::span<const SurfaceTie> ties, std::span<const NonShellElement> elements,
              const TriangleMesh& mesh, std::span<const int> face_of_triangle);

  /// The nodes of all ties of kind Tie.
  const std::vector<TiedNode>& nodes() const { return nodes_; }
  /// The welds as rigid features.
  const std::vector<FormFeature>& welds() const { return welds_; }
  /// Name of a tie.
  const std::string& name(int tie) const { return names_[tie]; }
  /// Sentences about nodes that are too far from their surfaces.
  const std::vector<std::string>& notes() const { return notes_; }

  /// Soft constraints that keep each tied node of a shell at its distance from its point of the
  /// surface:
  ///
  ///     p - Σ w_i p_i = R (p⁰ - Σ w_i p_i⁰)
  ///
  /// with the rotation R of the closest corner. They are a thousand times stiffer than the curvature
  /// equations, and never contradict other constraints. `points`: positions before the edit.
  std::vector<LinearConstraint> constraints(const TriangleMesh& mesh, const Points& points,
                                            DeformProblem::Weighting weighting) const;

 private:
  class Search;
  void attach(const SurfaceTie& tie, int index, const Search& search);
  void find_welds(std::span<const NonShellElement> elements, const TriangleMesh& mesh,
                  const Search& search);
  void tie_through_solids(std::span<const NonShellElement> elements, const Search& search);
  std::vector<int> index_of_nodes(int count) const;

  std::set<std::pair<int, int>> directions_;  // of pairs of tied parts
  std::vector<TiedNode> nodes_;
  std::vector<FormFeature> welds_;
  std::vector<std::string> names_, notes_;
};

}  // namespace batten
