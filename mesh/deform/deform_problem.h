// What a deformation holds, moves and keeps: the part that is factored once.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// A fixed linear combination Σ a_m p_m of vertex positions.
struct VertexCombination {
  struct Entry {
    int vertex;
    double coefficient;
  };
  std::vector<Entry> entries;

  /// The mean of vertices: a hole's centre from its rim.
  static VertexCombination mean_of(const std::vector<int>& vertices);
  Vec3 at(const Points& points) const;
  double sum() const;  ///< Σ a_m
};

/// Vertices that the user moves by one similarity.
struct Handle {
  std::string name;
  std::vector<int> vertices;
};

/// Vertices that keep their shape exactly, up to one similarity p_i = s R p_i⁰ + t.
struct FormFeature {
  enum class Kind {
    Free,            ///< turns with the rotation field, one rotation for all its vertices (eq. 11)
    TranslationOnly  ///< moves, does not turn (eq. 12)
  };
  std::string name;
  std::vector<int> vertices;
  Kind kind = Kind::Free;
};

/// A point of the mesh (a hole's centre) that stays on a plane or a line (eq. 13, 14); or a vector
/// between such points, which stays on one through the origin.
struct PointConstraint {
  enum class Kind { OnPlane, OnLine };
  std::string name;
  VertexCombination point;  ///< coefficients sum to 1; of a vector to 0
  Kind kind = Kind::OnPlane;
  Vec3 direction = Vec3::UnitZ();  ///< normal of the plane, or direction of the line
};

/// A line of vertices that keeps its own shape in the soft sense: its curvature vectors
///
///     κ_k = [ (p_{k+1} - p_k)/l_k - (p_k - p_{k-1})/l_{k-1} ] / a_k,    a_k = (l_k + l_{k-1})/2
///
/// turn with the rotation field, weighted by √(a_k width): it resists like a strip of the surface
/// of that width. A line that should stay rigid is a FormFeature.
struct CharacterChain {
  std::string name;
  std::vector<int> vertices;  ///< three or more, in their order
  bool closed = false;
  double width = 0;  ///< model units
};

/// Σ a_m p_m = target, or R(q_v) target when it turns with the field at a vertex.
struct LinearConstraint {
  std::string name;
  VertexCombination combination;
  Vec3 target = Vec3::Zero();
  int rotates_with = -1;         ///< vertex, or -1
  std::optional<double> weight;  ///< soft: adds ½ weight |…|² to the energy; none: hard
};

struct DeformProblem {
  enum class Weighting {
    Area,  ///< rows times √A_i: AᵀA is the bilaplacian ¼ L_c M⁻¹ L_c, independent of the mesh
    Uniform  ///< rows as they are, as in the paper
  };

  std::vector<int> fixed;
  std::vector<Handle> handles;
  std::vector<FormFeature> features;
  /// Features that turn alike, by their numbers: one rotation for all of a list.
  std::vector<std::vector<int>> shared_rotations;
  std::vector<PointConstraint> point_constraints;
  std::vector<CharacterChain> chains;
  std::vector<LinearConstraint> rows;
  /// Region of interest: only these vertices move, and those of handles. None: all. At its edge the
  /// shape joins smoothly: the two rings of vertices outside are held and their curvature counts.
  std::optional<std::vector<int>> region;
  Weighting weighting = Weighting::Area;
};

/// How one handle moves: p = about + s R(turn) (p⁰ - about) + shift.
struct HandleTransform {
  Vec3 about = Vec3::Zero();
  Vec3 rotation_vector =
      Vec3::Zero();  ///< logarithm of the unit quaternion (core/rotations.h): not reduced
  Vec3 translation = Vec3::Zero();
  double scale = 1;  ///< above 0
  Vec3 operator()(const Vec3& p) const;
};

/// What may change from one event of the mouse to the next, without a new factor.
struct DeformEdit {
  std::vector<HandleTransform> handles;  ///< one for each handle
  std::vector<double> feature_scales;    ///< s_f, one for each feature, above 0; empty: all 1
  std::vector<Vec3>
      constraint_origins;     ///< a point of each plane or line; empty: where the points are now;
                              ///< of vectors, the vector
  std::vector<Vec3> targets;  ///< right-hand side of each row; empty: as in the problem
};

/// The problem with fixed vertices, handles, features and region as whole nodes: what holds or moves
/// one vertex of a node holds or moves all (MeshTopology::expand_to_nodes).
DeformProblem expand_to_nodes(DeformProblem problem, const MeshTopology& topology);

/// Throw InputError on what no deformer can take, with the name of the part: vertices out of range,
/// an empty handle or feature, no name or one twice within its kind, a guided point whose
/// coefficients do not sum to 1 or 0, a number of no feature, a direction of length zero, nothing fixed and no handle; numbers
/// that are missing, not finite or above 1e100, a scale not above 0.
void check(const DeformProblem& problem, int vertex_count);
void check(const DeformProblem& problem, const DeformEdit& edit);

}  // namespace batten
