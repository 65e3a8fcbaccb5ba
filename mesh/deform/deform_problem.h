// Definition of a deformation problem (constraints, handles, form features), and the input of an
// edit (handle transformations, scales, targets).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// A linear combination Σ a_m p_m of vertex positions p_m with constant coefficients a_m.
struct VertexCombination {
  struct Entry {
    int vertex;
    double coefficient;
  };
  std::vector<Entry> entries;

  /// The mean of the given vertices, for example the centre of a hole from its boundary loop.
  static VertexCombination mean_of(const std::vector<int>& vertices);
  /// Value of the combination for given vertex positions (n×3).
  Vec3 at(const Points& points) const;
  double sum() const;  ///< sum of the coefficients
};

/// A group of vertices that the user moves by one similarity transformation.
struct Handle {
  std::string name;
  std::vector<int> vertices;
};

/// A group of vertices that keeps its shape exactly, up to one similarity p_i = s R p_i⁰ + t of the
/// undeformed positions p_i⁰. Equation numbers refer to [Masuda2006].
struct FormFeature {
  enum class Kind {
    Free,            ///< rotates as a whole with the rotation field of the deformation (eq. 11)
    TranslationOnly  ///< translates but does not rotate (eq. 12)
  };
  std::string name;
  std::vector<int> vertices;
  Kind kind = Kind::Free;
};

/// Constraint that keeps a point of the mesh (the centre of a hole, for example) on a plane or line
/// ([Masuda2006], eq. 13 and 14). It can also keep a vector, the difference of two points, in a
/// plane or on a line.
struct PointConstraint {
  enum class Kind { OnPlane, OnLine };
  std::string name;
  VertexCombination point;  ///< sum of the coefficients: 1 for a point, 0 for a vector
  Kind kind = Kind::OnPlane;
  /// Normal of the plane, or direction of the line; its length must be above 0.
  Vec3 direction = Vec3::UnitZ();
};

/// A chain of vertices that keeps its shape approximately (soft constraint). The curvature vectors
///
///     κ_k = [ (p_{k+1} - p_k)/l_k - (p_k - p_{k-1})/l_{k-1} ] / a_k,    a_k = (l_k + l_{k-1})/2
///
/// at its vertices p_k, with the edge lengths l_k, rotate with the rotation field of the
/// deformation and are weighted by √(a_k width). The chain resists bending like a strip of the
/// surface of this width. Use a FormFeature for a chain that must stay rigid.
struct CharacterChain {
  std::string name;
  std::vector<int> vertices;  ///< three or more, in order along the chain
  bool closed = false;
  double width = 0;  ///< width of the strip, model units, above 0
};

/// Linear constraint Σ a_m p_m = target on vertex positions, or Σ a_m p_m = R target, where R is
/// the rotation at a vertex v (see `rotates_with`).
struct LinearConstraint {
  std::string name;
  VertexCombination combination;
  Vec3 target = Vec3::Zero();
  int rotates_with = -1;  ///< vertex v whose rotation is applied to the target; -1: no rotation
  /// Weight of a soft constraint, which adds ½ weight |Σ a_m p_m - target|² to the energy; empty:
  /// the constraint is hard.
  std::optional<double> weight;
};

/// The part of a deformation that does not change during an edit, so that the system is factored
/// only once. All indices are vertex indices, unless stated otherwise.
struct DeformProblem {
  enum class Weighting {
    Area,    ///< equation of vertex i times √A_i (mixed area): independent of the mesh size
    Uniform  ///< no weights, as in [Masuda2006]
  };

  std::vector<int> fixed;
  std::vector<Handle> handles;
  std::vector<FormFeature> features;
  /// Groups of features that have the same rotation, each as indices into `features`.
  std::vector<std::vector<int>> shared_rotations;
  std::vector<PointConstraint> point_constraints;
  std::vector<CharacterChain> chains;
  std::vector<LinearConstraint> rows;
  /// Region of interest: only these vertices and those of handles move; empty: all vertices may
  /// move. The deformed region joins the rest of the mesh smoothly, since the energy includes the
  /// curvature at the two fixed rings of vertices around the region.
  std::optional<std::vector<int>> region;
  Weighting weighting = Weighting::Area;
};

/// Transformation of one handle: p = about + scale · R (p⁰ - about) + translation, where p⁰ is the
/// undeformed position of a vertex and R the rotation by `rotation_vector`.
struct HandleTransform {
  Vec3 about = Vec3::Zero();
  /// Unit axis times angle in radians (core/geometry.h). The angle may exceed a full turn.
  Vec3 rotation_vector = Vec3::Zero();
  Vec3 translation = Vec3::Zero();
  double scale = 1;  ///< scale factor, above 0
  /// Transformed position of a handle vertex whose undeformed position is p.
  Vec3 operator()(const Vec3& p) const;
};

/// The input of an edit, which may change at every mouse event without a new factorization.
struct DeformEdit {
  std::vector<HandleTransform> handles;  ///< one per handle of the problem
  std::vector<double> feature_scales;    ///< scale of each feature, above 0; empty: all 1
  /// One point on the plane or line of each point constraint, or one vector in the plane or on the
  /// line if the constraint applies to a vector. Empty: the undeformed points and vectors.
  std::vector<Vec3> constraint_origins;
  /// Target of each linear constraint; empty: the targets of the problem.
  std::vector<Vec3> targets;
};

/// Creates hard constraints that move each vertex to its target, for example the vertices of a
/// chain to points of a curve. The constraints are named "NAME, vertex 1" and so on. Throws
/// InputError if the numbers of vertices and targets differ.
std::vector<LinearConstraint> position_constraints(const std::string& name,
                                                   const std::vector<int>& vertices,
                                                   const std::vector<Vec3>& targets);

/// Extends the fixed vertices, handles, features and region of interest of a problem to all
/// coincident vertices of their nodes (see MeshTopology::expand_to_nodes()), so that the vertices
/// of a node are always fixed or moved together.
DeformProblem expand_to_nodes(DeformProblem problem, const MeshTopology& topology);

/// Checks a problem. Throws InputError if a vertex or feature index is out of range, a handle or
/// feature is empty, a name is missing or repeated among objects of the same type, the coefficients
/// of a point constraint sum neither to 1 nor to 0, a direction has length zero, or the problem has
/// no fixed vertex, handle or region of interest. The message names the object.
void check(const DeformProblem& problem, int vertex_count);
/// Checks an edit of a problem. Throws InputError if entries are missing, a value is not finite or
/// above 1e100, or a scale is not above 0. The message names the object.
void check(const DeformProblem& problem, const DeformEdit& edit);

}  // namespace batten
