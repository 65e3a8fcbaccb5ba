// SPDX-License-Identifier: MPL-2.0
// Assembled systems of a sculpting session: loads and constraints attached to the surface, and the
// matrices made from them. Everything is shared and, apart from working storage, immutable.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "batten/constraints/reusable_factorization.h"
#include "batten/constraints/schur_complement_constraints.h"
#include "batten/fem/display_points.h"
#include "batten/fem/pressure_operator.h"
#include "batten/fem/surface_assembler.h"
#include "batten/fem/triangle_locator.h"
#include "batten/sculpting/session/operation.h"
#include "batten/sculpting/session/session_options.h"
#include "batten/sculpting/session/session_results.h"
#include "batten/skinning/model/model_layout.h"

namespace batten::detail {

// Fraction of the size up to which a goal may differ from what the other constraints prescribe:
// rounding of coordinates in single precision, or with six digits.
inline constexpr double kRoundingTolerance = 1e-6;

/// Data that depends on the mesh only.
struct MeshData {
  explicit MeshData(const ModelLayout& layout);
  int dofs() const { return assembler.dofs().count(); }
  // Computed on first use.
  const SparseMatrix& mass() const;
  const PressureOperator& pressure() const;
  Location at(const ModelPoint& point) const;
  const TriangleLocator& locator(int region) const { return *locators[region]; }
  size_t bytes() const;

  std::shared_ptr<const ParametricMesh> mesh;  ///< mesh of the whole model
  std::shared_ptr<const Trim> trim;
  std::vector<std::shared_ptr<const ParametricMesh>> region_meshes;
  TriangleElement kind;
  SurfaceAssembler assembler;
  std::vector<std::unique_ptr<TriangleLocator>> locators;  ///< one locator per region
  std::vector<int> first_triangle;  ///< index of the first triangle of each region
  VecX domain_scale;                ///< ModelLayout::domain_scale
  DofVertices vertices;
  VecX ones;                  ///< per dof: 1 for positions, 0 for derivatives
  VecX displacement_weights;  ///< displacement_weights() of the mesh
 private:
  mutable SparseMatrix mass_;
  mutable std::unique_ptr<PressureOperator> pressure_;
};

// Items attached to the surface. `foot_points`: locations in the domain. `on`: dofs of the shape
// from which areas, normals and the surface area are taken; null if not needed.
using SharedPoints = std::shared_ptr<const Points>;
struct AttachedLoad {
  Load load;
  std::vector<ModelPoint> foot_points;
  SharedPoints on;
};
struct AttachedStiffnessField {
  StiffnessField weight;
  SharedPoints on;
};
struct AttachedConstraint {
  Constraint constraint;
  ModelPoint foot_point;
  SharedPoints on;
};
struct AttachedOffset {
  LineOffset move;
  HermiteCurve displacement;  ///< displacement for the value 1, over the parameters of the line
};

/// Everything that acts on one layout.
struct SessionDefinition {
  std::shared_ptr<const ModelLayout> layout;
  LoadUnits units = LoadUnits::Relative;
  bool fix_corners_only = false;
  FactorReuse factor_reuse = FactorReuse::many;
  ModelScale scale() const { return {units, layout->size()}; }
  /// Shapes are relative to this point, which stays the same when lines move.
  Vec3 origin = Vec3::Zero();
  std::vector<std::shared_ptr<const AttachedLoad>> loads;
  std::vector<std::shared_ptr<const AttachedStiffnessField>> weights;
  std::vector<std::shared_ptr<const AttachedConstraint>> constraints;
  std::vector<std::shared_ptr<const AttachedOffset>> moves;
};

// Attach one item to a surface (absolute coordinates). They throw InputError.
AttachedLoad attach(const Load& load, const SessionDefinition& on, const Surface& surface);
AttachedStiffnessField attach(const StiffnessField& weight, const SessionDefinition& on,
                              const Surface& surface);
AttachedConstraint attach(const Constraint& constraint, const SessionDefinition& on,
                          const Surface& surface);
AttachedOffset attach(const LineOffset& move, const SessionDefinition& on, const Surface& surface);

inline Surface surface_on(const SessionDefinition& def, const Points& dofs) {
  return def.layout->surface(dofs);
}
inline bool everywhere(const Area& area) {
  return std::holds_alternative<Area::Everywhere>(area.where) && area.regions.empty();
}

/// a + factor · b, on the union of both node sets.
HermiteCurve sum(const HermiteCurve& a, const HermiteCurve& b, double factor);

/// One load assembled on one mesh, for the value 1.
struct AssembledLoad {
  Points F;      ///< load vector of linear loads, n×3; empty for other loads
  MatX reduced;  ///< load vector reduced to the free unknowns, DᵀF
  VecX weights;  ///< area weights of pressure, one per triangle; empty: 1 everywhere
  double scale = 1;
};
/// One stiffness field assembled on one mesh, for the value 1.
struct AssembledStiffnessField {
  VecX weights;
  std::vector<Vec2> directions;  ///< direction in (u, v) per triangle; empty: isotropic
};

/// Constraints and springs that are imposed by a Schur complement instead of the reduction.
struct AuxiliaryConstraints {
  struct Source {
    enum Kind { Zero, Goal, Spring } kind = Zero;  ///< what determines the right-hand side
    /// Goal: index of the parameter that holds the goal; Spring: index of the parameter of its
    /// load.
    int parameter = -1;
    int coordinate = 0;  ///< Goal, Spring: 0 … 2; -1: along the direction of the constraint
    int load = -1, spring = -1;
  };
  /// Columns of A and constraints that belong to one constraint or load.
  struct Block {
    const void* owner;
    std::string name;
    int first_point, end_point, first_row, end_row;
  };
  SparseMatrix A;  ///< n × points: functionals on the dofs
  std::vector<SchurComplementConstraints::Constraint> rows;
  std::vector<Source> sources;
  std::vector<Block> blocks;
  const std::string& name_of(int row) const;
};

/// Bit set of the parts of a system on which a parameter acts.
enum Role : unsigned {
  kNothing = 0,
  kLinear = 1,
  kPressure = 2,
  kSpring = 4,
  kRhs = 8,
  kGoal = 16,
  kMatrix = 32
};

/// A rest shape and the constraints under which it was computed. Dofs are relative to the
/// definition's origin.
struct RestConfiguration {
  Points dofs;   ///< dofs of the rest shape; no rows: there is none
  Points first;  ///< the first rest shape on this mesh
  ConstraintSet rows;
};

/// A definition and everything assembled from it on its mesh.
struct SessionSystem {
  SessionDefinition def;
  std::shared_ptr<const MeshData> parts;  ///< null: without_recomputable()
  // Constraints of lines.
  std::shared_ptr<const ConstraintSet> line_rows;  ///< coordinates are relative to `origin`
  std::shared_ptr<const AffineReduction> reduction;
  MatX base_rhs;  ///< right-hand sides without offsets, constraints × 3
  std::vector<std::shared_ptr<const MatX>> offset_rhs;  ///< one matrix per offset, for the value 1
  // Loads and constraints.
  std::vector<std::shared_ptr<const AssembledLoad>> loads;
  std::vector<std::shared_ptr<const AssembledStiffnessField>> weights;
  std::shared_ptr<const AuxiliaryConstraints> auxiliary;
  // Parameter index of each load, stiffness field and offset, and of alpha and beta (uu, uv, vv).
  std::vector<int> load_parameter, weight_parameter, move_parameter;
  std::array<int, 3> alpha, beta;
  std::vector<unsigned> roles;  ///< Role bits of each parameter
  // Factored systems; their values belong to matrix_values.
  std::shared_ptr<ReusableFactorization> statics, dynamics;
  std::shared_ptr<SchurComplementConstraints> coupling, dynamics_coupling;
  std::shared_ptr<const AuxiliaryConstraints> coupled_rows,
      dynamics_constraints;           ///< auxiliary constraints for which the couplings were
                                      ///< computed
  std::vector<double> matrix_values;  ///< all parameter values for which `statics` was computed
  Motion motion;                      ///< motion for which `dynamics` was computed
  /// Foot points of each load's point cloud; empty for other loads.
  std::vector<std::vector<ModelPoint>> scan_foot_points;
  std::vector<std::vector<char>> scan_used;       ///< per point of a point cloud: 1 if it pulls
  /// Load that belongs to the matrix at matrix_values: Σ k N p of the point clouds, and the
  /// penalty on angles at given surfaces (JoinPenalty::load).
  Points matrix_load;
  MatX matrix_load_reduced;                       ///< reduced load Dᵀ matrix_load
  std::shared_ptr<const RestConfiguration> rest;  ///< current rest shape; null: not computed
  Points rest_load;                               ///< load K x_rest; no rows: no rest shape
  MatX rest_reduced;                              ///< reduced load Dᵀ rest_load

  const ModelLayout& layout() const { return *def.layout; }
  const Vec3& origin() const { return def.origin; }
  int dofs() const { return parts->dofs(); }
};

// Steps of build(): each assembles one item for a system whose mesh and lines exist.
AssembledLoad assembled(const AttachedLoad& placed, const SessionSystem& system);
AssembledStiffnessField assembled(const AttachedStiffnessField& placed,
                                  const SessionSystem& system);
AuxiliaryConstraints build_auxiliary_constraints(const SessionSystem& system,
                                                 const Parameters& parameters);
/// Right-hand sides of all line constraints if line `name` is this curve and all other lines are
/// zero.
MatX line_curve_rhs(const SessionSystem& system, const std::string& name,
                    const HermiteCurve& curve);

/// Builds what differs from `older` (null: everything), except matrices and factors; those of
/// `older` are reused if they fit. Throws InputError and ConflictError.
std::shared_ptr<SessionSystem> build(SessionDefinition def, const Parameters& parameters,
                                     const SessionSystem* older);

// Memory of a system, and states of the undo history that are completed when they are needed.

/// A copy of a system that shares only immutable parts with it, and has no factors.
std::shared_ptr<SessionSystem> without_factors(const SessionSystem& system);
/// A copy of a system without all that completed() computes again: `parts` is null.
std::shared_ptr<SessionSystem> without_recomputable(const SessionSystem& system);
/// Completes a copy of without_recomputable(), to the same bits, except the factors:
/// SessionEngine::prepare_matrix() computes them. What is the same in `other` is shared with it.
/// Cost: nothing that depends on the mesh if `other` has the same layout.
std::shared_ptr<SessionSystem> completed(const SessionSystem& incomplete,
                                         const Parameters& parameters, const SessionSystem& other);

/// Calls visit(address, bytes) for the parts that systems share, also for repeated ones.
void visit_shared_parts(const SessionSystem& system,
                        const std::function<void(const void*, size_t)>& visit);
/// Memory in bytes of a system without the parts that it shares.
size_t own_bytes(const SessionSystem& system);

}  // namespace batten::detail

namespace batten {

// Norm for the convergence test.

/// Diagonal weights that turn changes of dofs into lengths: |Δq| times its weight is a length in
/// model units.
///
/// The weight is 1 for positions. For slopes it is √(2 area) of the largest triangle of the domain
/// that has the dof. It is 0 for dofs that belong only to triangles of which less than a twentieth
/// lies inside the trim: rounding moves these, and they change nothing visible.
VecX displacement_weights(const ParametricMesh& mesh, const Trim* trim);

}  // namespace batten
