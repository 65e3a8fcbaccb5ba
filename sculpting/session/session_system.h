// Inside of a sculpting session: what acts on the surface, placed in its domain, and the systems
// that are made of it. Everything is shared and, but for working storage, immutable.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "batten/constraints/coupling.h"
#include "batten/constraints/live_system.h"
#include "batten/fem/assembly.h"
#include "batten/fem/display_points.h"
#include "batten/fem/pressure_operator.h"
#include "batten/fem/triangle_locator.h"
#include "batten/sculpting/session/operation.h"
#include "batten/sculpting/session/results.h"
#include "batten/sculpting/session/session_options.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/model/model_scale.h"

namespace batten::live {

/// All that depends on the mesh alone.
struct MeshParts {
  explicit MeshParts(const ModelLayout& layout);
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

// What acts, placed on the surface: `feet` are places of the domain; `on` are the dofs of the shape
// that areas, normals and the surface's area are taken from, null where none are needed.
using SharedPoints = std::shared_ptr<const Points>;
struct PlacedLoad {
  Load load;
  std::vector<ModelPoint> feet;
  SharedPoints on;
};
struct PlacedWeight {
  WeightField weight;
  SharedPoints on;
};
struct PlacedConstraint {
  Constraint constraint;
  ModelPoint foot;
  SharedPoints on;
};
struct PlacedMove {
  LineMove move;
  HermiteCurve displacement;  ///< for the value 1, over the line's parameters
};

/// All that acts, on one layout.
struct Definition {
  std::shared_ptr<const ModelLayout> layout;
  LoadUnits units = LoadUnits::Relative;
  bool hold_corners = false;
  Expected expected = Expected::many_factors;
  ModelScale scale() const { return {units, layout->size()}; }
  Vec3 origin = Vec3::Zero();  ///< shapes are kept relative to this point, also when lines move
  std::vector<std::shared_ptr<const PlacedLoad>> loads;
  std::vector<std::shared_ptr<const PlacedWeight>> weights;
  std::vector<std::shared_ptr<const PlacedConstraint>> constraints;
  std::vector<std::shared_ptr<const PlacedMove>> moves;
};

// Each places one thing on a surface (absolute coordinates). They throw InputError.
PlacedLoad place(const Load& load, const Definition& on, const Surface& surface);
PlacedWeight place(const WeightField& weight, const Definition& on, const Surface& surface);
PlacedConstraint place(const Constraint& constraint, const Definition& on, const Surface& surface);
PlacedMove place(const LineMove& move, const Definition& on, const Surface& surface);

inline Surface surface_on(const Definition& def, const Points& dofs) {
  return def.layout->surface(dofs);
}
inline bool everywhere(const Area& area) {
  return std::holds_alternative<Area::Everywhere>(area.where) && area.regions.empty();
}

/// Returns a + factor · b, with the nodes of both.
HermiteCurve sum(const HermiteCurve& a, const HermiteCurve& b, double factor);

/// What one load is on one mesh, for the value 1.
struct BuiltLoad {
  Points F;      ///< load vector of linear loads, n×3; empty otherwise
  MatX reduced;  ///< DᵀF
  VecX weights;  ///< of pressure: one for each triangle; empty: 1 everywhere
  double scale = 1;
};
/// What one weight field is on one mesh, for the value 1.
struct BuiltWeight {
  VecX weights;
  std::vector<Vec2> directions;  ///< empty: all directions
};

/// The rows that stand beside the reduction: those of constraints and springs.
struct LooseRows {
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
  std::vector<Coupling::Row> rows;
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
  kRight = 8,
  kGoal = 16,
  kMatrix = 32
};

/// A rest shape and the rows that it was made under. Dofs are relative to the definition's origin.
struct Rest {
  Points dofs;   ///< no rows: there is none
  Points first;  ///< the first one on this mesh
  ConstraintSet rows;
};

/// A definition, and all that is made of it on its mesh.
struct System {
  Definition def;
  std::shared_ptr<const MeshParts> parts;
  // Lines.
  std::shared_ptr<const ConstraintSet> line_rows;  ///< relative to `origin`
  std::shared_ptr<const AffineReduction> reduction;
  MatX base_right;  ///< right-hand sides without moves, rows × 3
  std::vector<std::shared_ptr<const MatX>> move_right;  ///< of each move, for the value 1
  // What acts.
  std::vector<std::shared_ptr<const BuiltLoad>> loads;
  std::vector<std::shared_ptr<const BuiltWeight>> weights;
  std::shared_ptr<const LooseRows> loose;
  // The parameter of each load, weight field and move, and those of alpha and beta (uu, uv, vv).
  std::vector<int> load_parameter, weight_parameter, move_parameter;
  std::array<int, 3> alpha, beta;
  std::vector<unsigned> roles;  ///< Role of each parameter
  // Systems; their numbers belong to matrix_values.
  std::shared_ptr<LiveSystem> statics, moving;
  std::shared_ptr<Coupling> coupling, moving_coupling;
  std::shared_ptr<const LooseRows> coupled_rows, moving_rows;  ///< rows of the couplings
  std::vector<double> matrix_values;               ///< of all parameters, when statics was made
  Motion motion;                                   ///< of `moving`
  std::vector<std::vector<ModelPoint>> scan_feet;  ///< of each load; empty but for scans
  std::vector<std::vector<char>> scan_used;        ///< whether each point of a scan pulls
  Points scan_load;                                ///< Σ k N p of the scans at matrix_values
  MatX scan_reduced;                               ///< Dᵀ scan_load
  std::shared_ptr<const Rest> rest;                ///< null: not made
  Points rest_load;                                ///< K rest; no rows: none
  MatX rest_reduced;                               ///< Dᵀ rest_load

  const ModelLayout& layout() const { return *def.layout; }
  const Vec3& origin() const { return def.origin; }
  int dofs() const { return parts->dofs(); }
};

// Parts of build(): each makes one thing that acts for a system of which mesh and lines are there.
BuiltLoad built(const PlacedLoad& placed, const System& system);
BuiltWeight built(const PlacedWeight& placed, const System& system);
LooseRows loose_rows(const System& system, const Parameters& parameters);
/// Returns the right-hand sides of all rows of lines for this curve on one line and zero on all
/// others.
MatX right_of_line(const System& system, const std::string& name, const HermiteCurve& curve);

/// Builds what differs from `older` (null: everything), but no matrix and no factor; those of
/// `older` are kept when they fit. Throws InputError, ConflictError.
std::shared_ptr<System> build(Definition def, const Parameters& parameters, const System* older);

/// Returns the bytes of all parts of a system that are not in `seen`, and adds them to it.
size_t bytes_of(const System& system, std::set<const void*>& seen);

}  // namespace batten::live
