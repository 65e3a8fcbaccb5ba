// Definition of a deformation problem (constraints, handles, form features) and of an edit that
// drives it.
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

  /// The mean of some vertices, such as the centre of a hole from its boundary loop.
  static VertexCombination mean_of(const std::vector<int>& vertices);
  /// Value of the combination for given vertex positions (n×3).
  Vec3 at(const Points& points) const;
  double sum() const;  ///< Σ a_m
};

/// Vertices that the user moves together by one similarity transformation.
struct Handle {
  std::string name;
  std::vector<int> vertices;
};

/// Vertices that keep their shape exactly, up to one similarity p_i = s R p_i⁰ + t. Equation
/// numbers: [Masuda2006].
struct FormFeature {
  enum class Kind {
    Free,  ///< rotates with the rotation field; one rotation for all its vertices (eq. 11)
    TranslationOnly  ///< translates but does not rotate (eq. 12)
  };
  std::string name;
  std::vector<int> vertices;
  Kind kind = Kind::Free;
};

/// Keeps a point of the mesh (the centre of a hole) on a plane or a line (eq. 13, 14 in
/// [Masuda2006]). A difference of points (a vector) is kept on a plane or line of directions.
struct PointConstraint {
  enum class Kind { OnPlane, OnLine };
  std::string name;
  VertexCombination point;  ///< coefficients sum to 1 for a point, to 0 for a vector
  Kind kind = Kind::OnPlane;
  /// Normal of the plane, or direction of the line; any length above 0.
  Vec3 direction = Vec3::UnitZ();
};

/// A chain of vertices that keeps its shape approximately (soft). Its curvature vectors
///
///     κ_k = [ (p_{k+1} - p_k)/l_k - (p_k - p_{k-1})/l_{k-1} ] / a_k,    a_k = (l_k + l_{k-1})/2
///
/// rotate with the rotation field and are weighted by √(a_k width). The chain resists bending like
/// a strip of the surface of that width. Use a FormFeature for a chain that must stay rigid.
struct CharacterChain {
  std::string name;
  std::vector<int> vertices;  ///< three or more, in their order along the chain
  bool closed = false;
  double width = 0;  ///< above 0, in model units
};

/// Linear constraint Σ a_m p_m = target; or = R(q_v) target if it rotates with the field at a
/// vertex v.
struct LinearConstraint {
  std::string name;
  VertexCombination combination;
  Vec3 target = Vec3::Zero();
  int rotates_with = -1;         ///< vertex v, or -1: does not rotate
  std::optional<double> weight;  ///< set: soft, adds ½ weight |…|² to the energy; empty: hard
};

/// Everything about a deformation that does not change during an edit; the system is factored once
/// for it. All indices are vertices, unless stated otherwise.
struct DeformProblem {
  enum class Weighting {
    Area,    ///< rows times √A_i: AᵀA is the bilaplacian ¼ L_c M⁻¹ L_c, mesh-independent
    Uniform  ///< unweighted rows, as in the paper
  };

  std::vector<int> fixed;
  std::vector<Handle> handles;
  std::vector<FormFeature> features;
  /// Groups of features that share one rotation, as indices into `features`.
  std::vector<std::vector<int>> shared_rotations;
  std::vector<PointConstraint> point_constraints;
  std::vector<CharacterChain> chains;
  std::vector<LinearConstraint> rows;
  /// Region of interest: only these vertices and those of handles move. Empty: all vertices move.
  /// The shape joins smoothly at the border of the region: the two rings of vertices outside are
  /// fixed, but their curvature counts.
  std::optional<std::vector<int>> region;
  Weighting weighting = Weighting::Area;
};

/// Transformation of one handle: p = about + s R(rotation_vector) (p⁰ - about) + translation.
struct HandleTransform {
  Vec3 about = Vec3::Zero();
  /// Axis · angle in radians (core/geometry.h); not reduced to less than a full turn.
  Vec3 rotation_vector = Vec3::Zero();
  Vec3 translation = Vec3::Zero();
  double scale = 1;  ///< scale s, above 0
  /// Position of a handle vertex that is at p in the undeformed mesh.
  Vec3 operator()(const Vec3& p) const;
};

/// The data that may change at every mouse event without a new factorization.
struct DeformEdit {
  std::vector<HandleTransform> handles;  ///< one per handle
  std::vector<double> feature_scales;    ///< s_f, one per feature, above 0; empty: all 1
  /// One point on the plane or line of each point constraint, and the vector of each constraint that
  /// prescribes a vector. If empty, planes and lines pass through the undeformed constrained points.
  std::vector<Vec3> constraint_origins;
  /// right-hand side of each linear constraint; empty: as in the problem.
  std::vector<Vec3> targets;
};

/// Hard constraints that move each vertex to its target, such as the vertices of a chain to points
/// of a curve. They are named "NAME, vertex 1" and so on. Throws InputError if the numbers of
/// vertices and targets differ.
std::vector<LinearConstraint> position_constraints(const std::string& name,
                                                   const std::vector<int>& vertices,
                                                   const std::vector<Vec3>& targets);

/// Extends fixed vertices, handles, features and region to all coincident vertices of their nodes,
/// see MeshTopology::expand_to_nodes(). Whatever fixes or moves one vertex of a node then applies
/// to all.
DeformProblem expand_to_nodes(DeformProblem problem, const MeshTopology& topology);

/// Checks the problem. Throws InputError, naming the object: vertices out of range, an empty handle
/// or feature, a missing or repeated name within its kind, a point constraint whose coefficients
/// sum neither to 1 nor to 0, a feature index out of range, a direction of length zero, no fixed
/// vertex, handle or region.
void check(const DeformProblem& problem, int vertex_count);
/// Checks an edit. Throws InputError, naming the object: missing entries, values that are not
/// finite or above 1e100, a scale not above 0.
void check(const DeformProblem& problem, const DeformEdit& edit);

}  // namespace batten
