// SPDX-License-Identifier: MPL-2.0
// Linear static analysis of a model as one supported shell.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/analysis/models/shell_definition.h"
#include "batten/analysis/models/shell_ties.h"
#include "batten/analysis/shell_assembler.h"
#include "batten/constraints/constrained_solver.h"

namespace batten {

// Rigid-body modes and mechanisms.

/// Unsupported and nearly unsupported rigid-body modes and mechanisms, in which each region stays
/// rigid. They are described as text: "the whole model can translate along [0, 0, 1]", "face 'lid'
/// can rotate about the axis along … through …".
struct RigidBodyModes {
  /// Motions that nothing resists: constraints and springs resist them less than 1e-5 times as much
  /// as other motions.
  std::vector<std::string> unconstrained;
  /// Motions that are barely resisted: the supports are within 1 % of the shell's size of a
  /// configuration that would not resist these motions, for example three almost collinear points.
  std::vector<std::string> weakly_constrained;
  double smallest_lever =
      0;  ///< smallest RMS lever arm against weakly constrained motions / shell size; 0: none
};

/// Finds the motions that ties and supports do not resist, or hardly resist. Cost: O(constraints +
/// (6 regions)³); models with more than 500 regions are treated as one body.
RigidBodyModes find_rigid_body_modes(const ModelLayout& model, const Points& shape,
                                     const ShellTies& ties);

/// Reaction of a support.
struct SupportReaction {
  std::string support;
  Resultant resultant;         ///< force on the shell, and moment about the origin
  ForceMagnitudes magnitudes;  ///< of the nodal forces
};

/// Assembled system of a shell: constraints and springs of ties and supports, and the 3n×3n
/// stiffness matrix K, which includes the springs.
struct ShellSystem {
  ShellTies ties;
  ShellAssembler assembler;
  SparseMatrix K;
};

/// Linear static analysis of a model: K q = F with the constraints of ties and supports, and one
/// factorization for all loads.
///
///     const ShellModel shell(layout, shape, {{{ShellMaterial::isotropic(210e3, 0.3), 1.5}},
///                                            {LineSupport::clamped("hinges")}});
///     const ShellLocation location = nearest_location(layout, shape, knob);
///     const Points q = shell.solve(point_force(layout, location, push));
///
/// Construction assembles one stiffness matrix and factors up to 3n unknowns; solve() costs one
/// pair of triangular solves.
class ShellModel {
 public:
  /// How the constructor treats an unsupported shell. Refused: throws NoSolutionError. Shifted:
  /// allows it, for vibration analysis. The factored matrix is then K + shift() M (K: stiffness, M:
  /// mass matrix); only natural_modes() takes the shift into account.
  enum class RigidBodyHandling { Refused, Shifted };
  /// Assembles and factors the system. `shape`: absolute dofs of the middle surface.
  /// `backend_factory`: creates the linear solver; empty: SparseCholesky. Throws InputError under
  /// the conditions of triangle_sections() and shell_ties(), ConflictError if supports contradict
  /// each other, NoSolutionError if there are unconstrained motions (the message describes each).
  ShellModel(ModelLayout layout, Points shape, const ShellDefinition& definition,
             RigidBodyHandling free = RigidBodyHandling::Refused,
             const BackendFactory& backend_factory = {});

  /// Updates the shell to another shape, for example while a slider moves. Sections and supports
  /// are unchanged; point supports stay at the same material points. Only the numeric assembly and
  /// factorization are repeated. Throws the same exceptions as the constructor; after an exception,
  /// only update_shape() may be called.
  void update_shape(Points shape) { update_shape(std::move(shape), definition_); }
  /// The same with other sections and supports.
  void update_shape(Points shape, const ShellDefinition& definition);

  /// Displacement dofs (n×3) under the load F (n×3). Throws InputError if F has the wrong size.
  Points solve(const Points& F) const;
  /// Reactions of the supports for the displacement q under the load F, one entry per support name.
  /// They balance the load F to rounding. A reaction consists of the Lagrange multipliers λ of the
  /// constraints, from K q - F = Cᵀ λ (C: coefficients of the constraints), and the forces of the
  /// springs.
  std::vector<SupportReaction> reactions(const Points& q, const Points& F) const;
  /// Resultant of the forces of the ties between faces for the displacement q under the load F: zero
  /// if the faces meet exactly. Across a gap of width g between two faces, a tie that transmits the
  /// force f adds a moment of at most f g.
  Resultant tie_resultant(const Points& q, const Points& F) const;
  /// Assembles the system for another shape on the same layout, with other sections and supports:
  /// one stiffness matrix, no factorization. Throws NoSolutionError if there are unconstrained
  /// motions, and InputError if this shell has a shift().
  ShellSystem assemble_system(const Points& shape, const ShellDefinition& definition) const;
  ShellSystem assemble_system(const Points& shape) const {
    return assemble_system(shape, definition_);
  }
  /// Displacement dofs (n×3) of another system under the load F (n×3), by the conjugate gradient
  /// method with the factorization of this shell (ConstrainedSolver::solve_similar()).
  ///
  /// `reduction`: that of the constraints in similar.ties. `start`: displacement of this shell, or of
  /// another similar one. The error in the energy norm is below 1e-8 √(2E), with the strain energy E
  /// of `start` in the other system, without springs. Returns nullopt if the systems differ too much.
  std::optional<Points> solve(const ShellSystem& similar, const AffineReduction& reduction,
                              const Points& F, const Points& start) const;
  /// First-order change of the goal functional Gᵀu if the system changes to `other` and the load to
  /// `other_F`:
  ///
  ///     aᵀ (δF - δK u) + λ(u)ᵀ δC a + λ(a)ᵀ δC u,      u = solve(F),  a = adjoint(G)
  ///
  /// with the Lagrange multipliers λ of the constraints and their coefficients C. Throws InputError
  /// unless `other` has as many constraints as this shell. G: the goal as a load vector. For a displacement, it is a unit point_force(); for the compliance, it is F, and
  /// the result does not include the change of G itself. Cost: a few sparse products.
  double goal_change(const Points& u, const Points& F, const Points& a, const Points& G,
                     const ShellSystem& other, const Points& other_F) const;
  /// Adjoint solution (n×3): displacement under the load G, with zero prescribed displacements.
  Points adjoint(const Points& G) const;
  /// Strain energy of the shell and its stiffeners for the displacement q (n×3), excluding the energy
  /// of springs.
  double energy(const Points& q) const;
  /// mass_matrix(), and the geometric stiffness of shell and stiffeners under a displacement q, of one
  /// coordinate, n×n.
  SparseMatrix mass() const;
  SparseMatrix geometric_stiffness(const Points& q, const ShellTemperature& temperature = {}) const;

  const ModelLayout& layout() const { return layout_; }
  const Points& shape() const { return shape_; }
  const ShellDefinition& definition() const { return definition_; }
  const ShellAssembler& assembler() const { return assembler_; }
  /// Shell section (material and thickness) of a region.
  const ShellSection& section(int region) const {
    const auto& sections = definition_.sections;
    return sections[sections.size() == 1 ? 0 : static_cast<size_t>(region)];
  }
  const Stiffeners& stiffeners() const { return stiffeners_; }
  const ConstrainedSolver& solver() const { return solver_; }
  /// Constraints of ties and supports.
  const ConstraintSet& constraints() const { return ties_.constraints; }
  /// Unconstrained and weakly constrained motions of the shell. shift(): factor of the mass matrix
  /// that was added to K because of unconstrained motions; 0: none.
  const RigidBodyModes& rigid_body_modes() const { return rigid_body_modes_; }
  double shift() const { return shift_; }
  /// Number of free unknowns of the factored system.
  int unknowns() const { return solver_.reduction().free_count(); }

 private:
  /// Calls visit(name, entries, factor) for the force factor · entries of each constraint and spring.
  template <class Visit>
  void for_each_constraint_force(const Points& q, const Points& F, const Visit& visit) const;
  // Stiffness matrix of the shell, including the springs of ties and supports.
  SparseMatrix stiffness();
  // Forces that the constraints exert on the dofs: K q - F, including the load of the springs.
  Points residual_forces(const Points& q, const Points& F) const;

  ModelLayout layout_;
  Points shape_;
  ShellDefinition definition_;
  RigidBodyHandling rigid_body_handling_;
  std::vector<ShellSection> sections_;  // one for all, or one per triangle
  std::vector<std::string> supports_;
  RigidBodyModes rigid_body_modes_;
  double shift_ = 0;
  Stiffeners stiffeners_;
  ShellTies ties_;
  ShellAssembler assembler_;
  ConstrainedSolver solver_;
};

}  // namespace batten
