// Linear static analysis of a model as one supported shell.
#pragma once

#include <string>
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
  /// Motions that nothing resists: the resistance of constraints and springs is less than 1e-5 of
  /// that to other motions.
  std::vector<std::string> unconstrained;
  /// Motions that are barely resisted: the supports lie within 1 % of the shell's size of a
  /// configuration that would not resist them, for example three almost collinear points.
  std::vector<std::string> weakly_constrained;
  double smallest_lever =
      0;  ///< smallest lever arm (RMS) of these motions, relative to the size of the shell
};

/// Finds the motions that ties and supports do not resist. Cost: O(constraints + (6 regions)³);
/// models with more than 500 regions are treated as one body.
RigidBodyModes find_rigid_body_modes(const ModelLayout& model, const Points& shape,
                                     const ShellTies& ties);

/// Reaction of a support.
struct SupportReaction {
  std::string support;
  Resultant resultant;  ///< acts on the shell; moment about the origin
};

/// Assembled system of one shape: ties and supports, and the stiffness K with springs, 3n×3n.
struct ShellSystem {
  ShellTies ties;
  SparseMatrix K;
};

/// Linear static analysis of a model: K q = F with the constraints of ties and supports, and one
/// factorization for all loads.
///
///     const ShellModel shell(layout, shape, {{{ShellMaterial::isotropic(210e3, 0.3), 1.5}},
///                                            {LineSupport::clamped("hinges")}});
///     const Points q = shell.solve(point_force(layout, nearest_location(layout, shape, knob), push));
///
/// Construction assembles one stiffness matrix and factors up to 3n unknowns; solve() costs one
/// pair of triangular solves.
class ShellModel {
 public:
  /// Handling of rigid-body modes. Refused: the constructor throws. Shifted: allows an unsupported
  /// shell, for its vibrations; the factored stiffness is K + shift() M, and no other function
  /// takes this into account.
  enum class RigidBodyHandling { Refused, Shifted };
  /// Assembles and factors the system. `shape`: absolute dofs of the middle surface.
  /// `backend_factory`: creates the linear solver; empty: SparseCholesky. Throws InputError as
  /// triangle_sections() and shell_ties() do, ConflictError if supports contradict each other,
  /// NoSolutionError if there are unconstrained motions (the message names each).
  ShellModel(ModelLayout layout, Points shape, const ShellDefinition& definition,
             RigidBodyHandling free = RigidBodyHandling::Refused,
             const BackendFactory& backend_factory = {});

  /// Updates the shell to another shape, for example while a slider moves. Sections and supports
  /// are unchanged; point supports stay at the same material points. Only the numeric assembly and
  /// factorization are repeated. Throws as the constructor does; after an exception, only
  /// update_shape() may be called.
  void update_shape(Points shape);

  /// Displacement q (n×3) for the load F. Throws InputError for a load of the wrong size.
  Points solve(const Points& F) const;
  /// Reaction of every support, each name once. They balance the load to rounding. A reaction
  /// consists of the Lagrange multipliers λ of the constraints, from K q - F = Cᵀ λ, and the forces
  /// of the springs.
  std::vector<SupportReaction> reactions(const Points& q, const Points& F) const;
  /// Assembles the system for another shape on the same layout: one stiffness matrix, no
  /// factorization.
  ShellSystem assemble_system(const Points& shape) const;
  /// First-order change of the goal functional Gᵀu if the system becomes `other` and the load
  /// `other_F`:
  ///
  ///     aᵀ (δF - δK u) + λ(u)ᵀ δC a + λ(a)ᵀ δC u,      u = solve(F),  a = adjoint(G)
  ///
  /// with the Lagrange multipliers λ of the constraints C. G: the goal as a load vector
  /// (point_force() of 1 for a displacement; F for the compliance, without its change δF). Cost: a
  /// few sparse products.
  double goal_change(const Points& u, const Points& F, const Points& a, const Points& G,
                     const ShellSystem& other, const Points& other_F) const;
  /// Adjoint solution: K a = G with homogeneous supports.
  Points adjoint(const Points& G) const;
  /// Strain energy ½ qᵀ K q, without the energy in springs along embedded curves.
  double energy(const Points& q) const;

  const ModelLayout& layout() const { return layout_; }
  const Points& shape() const { return shape_; }
  const ShellDefinition& definition() const { return definition_; }
  const ShellAssembler& assembler() const { return assembler_; }
  /// Section of a region.
  const ShellSection& section(int region) const {
    const auto& sections = definition_.sections;
    return sections[sections.size() == 1 ? 0 : static_cast<size_t>(region)];
  }
  const ConstrainedSolver& solver() const { return solver_; }
  /// Unsupported and nearly unsupported motions, and the factor of the mass matrix that was added
  /// because of the former (0: none).
  const RigidBodyModes& rigid_body_modes() const { return rigid_body_modes_; }
  double shift() const { return shift_; }
  /// Number of free unknowns of the factored system.
  int unknowns() const { return solver_.reduction().free_count(); }

 private:
  // Stiffness of assembler_ with the springs of ties_.
  SparseMatrix stiffness();
  // K q - F including the load of the springs: the forces of the constraints.
  Points residual_forces(const Points& q, const Points& F) const;

  ModelLayout layout_;
  Points shape_;
  ShellDefinition definition_;
  RigidBodyHandling rigid_body_handling_;
  std::vector<ShellSection> sections_;  // one for all, or one per triangle
  std::vector<std::string> supports_;
  RigidBodyModes rigid_body_modes_;
  double shift_ = 0;
  ShellTies ties_;
  ShellAssembler assembler_;
  ConstrainedSolver solver_;
};

}  // namespace batten
