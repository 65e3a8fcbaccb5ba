// SPDX-License-Identifier: MPL-2.0
// Definition of a deformation problem (constraints, handles, form features), and the input of an
// edit (handle transformations, scales, targets).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// A linear combination of vertex positions (a point or a vector) with constant coefficients.
struct VertexCombination {
  struct Entry {
    int vertex;
    double coefficient;
  };
  std::vector<Entry> entries;

  /// The combination whose value is the mean of the given vertices, for example the centre of a
  /// hole as the mean of its boundary loop.
  static VertexCombination mean_of(const std::vector<int>& vertices);
  /// Value of the linear combination at the vertex positions `points` (n×3).
  Vec3 at(const Points& points) const;
  double sum() const;  ///< sum of the coefficients of the linear combination
};

/// A group of vertices that the user moves by one similarity transformation.
struct Handle {
  std::string name;
  std::vector<int> vertices;
};

/// A group of vertices that keeps its shape exactly, up to one similarity (translation, rotation,
/// and a prescribed scale) from its undeformed shape.
struct FormFeature {
  enum class Kind {
    Free,            ///< translates, and rotates as a whole ([Masuda2006], eq. 11)
    TranslationOnly  ///< translates but does not rotate ([Masuda2006], eq. 12)
  };
  std::string name;
  std::vector<int> vertices;
  Kind kind = Kind::Free;
};

/// Constraint that keeps a point of the mesh (the centre of a hole, for example), or the difference
/// vector of two points, on a plane or line ([Masuda2006], eq. 13 and 14).
struct PointConstraint {
  enum class Kind { OnPlane, OnLine };
  std::string name;
  VertexCombination point;  ///< constrained point (coefficients sum to 1) or vector (sum 0)
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
/// surface with this `width`. Use a FormFeature for a chain that must stay rigid.
struct CharacterChain {
  std::string name;
  std::vector<int> vertices;  ///< three or more vertices, in order along the chain
  bool closed = false;
  double width = 0;  ///< width of a surface strip of equal stiffness, model units, above 0
};

/// Linear constraint on vertex positions: `combination` has the value `target`, or `target` rotated
/// like the surface at the vertex `rotates_with`.
struct LinearConstraint {
  std::string name;
  VertexCombination combination;
  Vec3 target = Vec3::Zero();
  int rotates_with = -1;  ///< vertex whose rotation is applied to `target`; -1: no rotation
  /// Weight of a soft constraint, which adds ½ weight |combination - target|² to the energy; empty:
  /// the constraint is hard.
  std::optional<double> weight = std::nullopt;
  /// Tie between two parts of the mesh: they move as one part, and the vertex of the first entry
  /// rotates like `rotates_with` unless a feature, handle or fixed vertex determines its rotation.
  bool connects = false;
};

/// Definition of a mesh deformation: constraints, handles and form features. It does not change
/// during an edit, so that the linear system is factored only once. All indices are vertex indices,
/// unless stated otherwise.
struct DeformProblem {
  enum class Weighting {
    Area,  ///< equations weighted by √(mixed area of the vertex): independent of the element size
    Uniform  ///< equations without weights, as in [Masuda2006]
  };

  /// Discretization of the bending energy.
  enum class Bending {
    Laplacian,  ///< mean-curvature vectors of the vertices [Masuda2006]. At a boundary they contain
                ///< the slope across it, which resists changes
    Hinges      ///< changes of slope across the edges: natural boundary conditions of a plate, as
                ///< registration to a target needs them. Not affected by isometries of flat meshes
  };

  std::vector<int> fixed;
  std::vector<Handle> handles;
  std::vector<FormFeature> features;
  /// Groups of features that have the same rotation, each as indices into `features`.
  std::vector<std::vector<int>> shared_rotations;
  std::vector<PointConstraint> point_constraints;
  std::vector<CharacterChain> chains;
  std::vector<LinearConstraint> rows;
  /// Region of interest: only these vertices and the vertices of handles move; empty: all vertices
  /// may move. The deformed region joins the rest of the mesh smoothly, since the energy includes
  /// the curvature at two rings of fixed vertices around the region.
  std::optional<std::vector<int>> region;
  Weighting weighting = Weighting::Area;
  Bending bending = Bending::Laplacian;
};

/// Transformation of one handle: p = about + scale · R (p⁰ - about) + translation, where p⁰ is the
/// undeformed position of a vertex and R the rotation by `rotation_vector`.
struct HandleTransform {
  Vec3 about = Vec3::Zero();
  /// Rotation of the handle: unit axis times angle in radians. The angle may exceed a full turn.
  Vec3 rotation_vector = Vec3::Zero();
  Vec3 translation = Vec3::Zero();
  double scale = 1;  ///< scale factor, above 0
  /// Transformed position of a handle vertex whose undeformed position is p.
  Vec3 operator()(const Vec3& p) const;
};

/// The input of an edit: handle transformations, scales and targets. It may change at every mouse
/// event without a new factorization.
struct DeformEdit {
  std::vector<HandleTransform> handles;  ///< transformation of each handle of the problem
  std::vector<double> feature_scales;    ///< scale factor of each feature, above 0; empty: all 1
  /// One point on the plane or line of each point constraint, or one vector in the plane or on the
  /// line if the constraint applies to a vector. Empty: the constrained points and vectors of the
  /// undeformed mesh.
  std::vector<Vec3> constraint_origins;
  /// Target of each constraint in DeformProblem::rows; empty: the targets in
  /// LinearConstraint::target.
  std::vector<Vec3> targets;
};

/// Rates of the numbers of a DeformEdit, or the derivatives of a function with respect to them.
struct DeformEditRates {
  struct Handle {
    Vec3 translation = Vec3::Zero();
    Vec3 rotation_vector = Vec3::Zero();  ///< in radians
    double scale = 0;
  };
  /// Zero rates for all numbers of the edits of a problem.
  explicit DeformEditRates(const DeformProblem& problem);

  std::vector<Handle> handles;           ///< one for each handle of the problem
  std::vector<double> feature_scales;    ///< one for each feature
  std::vector<Vec3> constraint_origins;  ///< one for each point constraint
  std::vector<Vec3> targets;             ///< one for each constraint in DeformProblem::rows
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

/// Checks a deformation problem of a mesh with `vertex_count` vertices. Throws InputError if a
/// vertex or feature index is out of range, a handle or feature is empty, a name is missing or
/// repeated among objects of the same type, the coefficients of a point constraint sum neither to 1
/// nor to 0, the direction of a point constraint has length zero, or the problem has no fixed
/// vertex, handle or region of interest. The message names the object.
void check(const DeformProblem& problem, int vertex_count);
/// Checks an edit of a deformation problem. Throws InputError if entries are missing, a value is
/// not finite or above 1e100, or a scale is not above 0. The message names the object.
void check(const DeformProblem& problem, const DeformEdit& edit);
/// Checks that rates belong to a problem. Throws InputError if a number of them is wrong, or if one
/// is not finite.
void check(const DeformProblem& problem, const DeformEditRates& rates);

}  // namespace batten
