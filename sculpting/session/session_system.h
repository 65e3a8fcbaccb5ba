// Inside of a sculpting session: what acts on the surface, placed in its domain, and the systems
// that are made of it. Everything is shared and, but for working storage, immutable.
#pragma once

#include <memory>
#include <set>
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

/// All that depends on the mesh alone.
struct MeshData {
  explicit MeshData(const ModelLayout& layout);
  int dofs() const { return assembler.dofs().count(); }
  // These two are made when they are asked for.
  const SparseMatrix& mass() const;
  const PressureOperator& pressure() const;
  Location at(const ModelPoint& point) const;
  const TriangleLocator& locator(int region) const { return *locators[region]; }
  size_t bytes() const;

  std::shared_ptr<const ParametricMesh> mesh;  ///< of the model
  std::shared_ptr<const Trim> trim;
  std::vector<std::shared_ptr<const ParametricMesh>> region_meshes;
  TriangleElement kind;
  SurfaceAssembler assembler;
  std::vector<std::unique_ptr<TriangleLocator>> locators;  ///< of each region
  std::vector<int> first_triangle;                         ///< of each region
  VecX domain_scale;                                       ///< ModelLayout::domain_scale
  DofVertices vertices;
  VecX ones;  ///< 1 at position dofs
 private:
  mutable SparseMatrix mass_;
  mutable std::unique_ptr<PressureOperator> pressure_;
};

// What acts, placed on the surface: `foot_points` are places of the domain; `on` are the dofs of the shape
// that areas, normals and the surface's area are taken from, null where none are needed.
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
  HermiteCurve displacement;  ///< for the value 1, over the line's parameters
};

/// All that acts, on one layout.
struct SessionDefinition {
  std::shared_ptr<const ModelLayout> layout;
  LoadUnits units = LoadUnits::Relative;
  bool fix_corners_only = false;
  FactorReuse factor_reuse = FactorReuse::many;
  ModelScale scale() const { return {units, layout->size()}; }
  Vec3 origin = Vec3::Zero();  ///< shapes are kept relative to this point, also when lines move
  std::vector<std::shared_ptr<const AttachedLoad>> loads;
  std::vector<std::shared_ptr<const AttachedStiffnessField>> weights;
  std::vector<std::shared_ptr<const AttachedConstraint>> constraints;
  std::vector<std::shared_ptr<const AttachedOffset>> moves;
};

// Each places one thing on a surface (absolute coordinates). They throw InputError.
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

/// Returns a + factor · b, with the nodes of both.
HermiteCurve sum(const HermiteCurve& a, const HermiteCurve& b, double factor);

/// What one load is on one mesh, for the value 1.
struct AssembledLoad {
  Points F;      ///< load vector of linear loads, n×3; empty otherwise
  MatX reduced;  ///< DᵀF
  VecX weights;  ///< of pressure: one for each triangle; empty: 1 everywhere
  double scale = 1;
};
/// What one weight field is on one mesh, for the value 1.
struct AssembledStiffnessField {
  VecX weights;
  std::vector<Vec2> directions;  ///< empty: all directions
};

/// The rows that stand beside the reduction: those of constraints and springs.
struct AuxiliaryConstraints {
  struct Source {
    enum Kind { Zero, Goal, Spring } kind = Zero;  ///< what the right-hand side comes from
    int parameter = -1;  ///< Goal: the parameter that is the goal; Spring: that of its load
    int coordinate = 0;  ///< Goal, Spring: 0 … 2; -1: along the row's direction
    int load = -1, spring = -1;
  };
  /// The columns of A and the rows that one constraint or load has.
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

/// Which part of a system a parameter acts on; a sum of these.
enum Role : unsigned {
  kNothing = 0,
  kLinear = 1,
  kPressure = 2,
  kSpring = 4,
  kRhs = 8,
  kGoal = 16,
  kMatrix = 32
};

/// A rest shape and the rows that it was made under. Dofs are relative to the definition's origin.
struct RestConfiguration {
  Points dofs;   ///< no rows: there is none
  Points first;  ///< the first one on this mesh
  ConstraintSet rows;
};

/// A definition, and all that is made of it on its mesh.
struct SessionSystem {
  SessionDefinition def;
  std::shared_ptr<const MeshData> parts;
  // Lines.
  std::shared_ptr<const ConstraintSet> line_rows;  ///< relative to `origin`
  std::shared_ptr<const AffineReduction> reduction;
  MatX base_rhs;  ///< right-hand sides without moves, rows × 3
  std::vector<std::shared_ptr<const MatX>> offset_rhs;  ///< of each move, for the value 1
  // What acts.
  std::vector<std::shared_ptr<const AssembledLoad>> loads;
  std::vector<std::shared_ptr<const AssembledStiffnessField>> weights;
  std::shared_ptr<const AuxiliaryConstraints> auxiliary;
  // The parameter of each load, weight field and move, and those of alpha and beta (uu, uv, vv).
  std::vector<int> load_parameter, weight_parameter, move_parameter;
  std::array<int, 3> alpha, beta;
  std::vector<unsigned> roles;  ///< Role of each parameter
  // Systems; their numbers belong to matrix_values.
  std::shared_ptr<ReusableFactorization> statics, dynamics;
  std::shared_ptr<SchurComplementConstraints> coupling, dynamics_coupling;
  std::shared_ptr<const AuxiliaryConstraints> coupled_rows,
      dynamics_constraints;           ///< rows of the couplings
  std::vector<double> matrix_values;  ///< of all parameters, when statics was made
  Motion motion;                      ///< of `dynamics`
  std::vector<std::vector<ModelPoint>> scan_foot_points;  ///< of each load; empty but for scans
  std::vector<std::vector<char>> scan_used;               ///< whether each point of a scan pulls
  Points point_cloud_load;                               ///< Σ k N p of the scans at matrix_values
  MatX point_cloud_reduced;                              ///< Dᵀ point_cloud_load
  std::shared_ptr<const RestConfiguration> rest;  ///< null: not made
  Points rest_load;                               ///< K rest; no rows: none
  MatX rest_reduced;                              ///< Dᵀ rest_load

  const ModelLayout& layout() const { return *def.layout; }
  const Vec3& origin() const { return def.origin; }
  int dofs() const { return parts->dofs(); }
};

// Parts of build(): each makes one thing that acts for a system of which mesh and lines are there.
AssembledLoad assembled(const AttachedLoad& placed, const SessionSystem& system);
AssembledStiffnessField assembled(const AttachedStiffnessField& placed,
                                  const SessionSystem& system);
AuxiliaryConstraints build_auxiliary_constraints(const SessionSystem& system,
                                                 const Parameters& parameters);
/// Returns the right-hand sides of all rows of lines for this curve on one line and zero on all
/// others.
MatX line_curve_rhs(const SessionSystem& system, const std::string& name,
                    const HermiteCurve& curve);

/// Builds what differs from `older` (null: everything), but no matrix and no factor; those of
/// `older` are kept when they fit. Throws InputError, ConflictError.
std::shared_ptr<SessionSystem> build(SessionDefinition def, const Parameters& parameters,
                                     const SessionSystem* older);

/// Returns the bytes of all parts of a system that are not in `seen`, and adds them to it.
size_t bytes_of(const SessionSystem& system, std::set<const void*>& seen);

}  // namespace batten::detail
