// The regions of a model as one shell that is held and can be solved.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/models/shell_definition.h"
#include "batten/analysis/shell_assembler.h"
#include "batten/constraints/constrained_solver.h"
#include "batten/analysis/models/shell_ties.h"

namespace batten {

// The motions that supports leave to a shell, or nearly so.

/// Motions in which each region stays rigid, in words: "all of it can slide along [0, 0, 1]", "region
/// 'lid' can turn about the axis along … through …".
struct RigidBodyModes {
  /// Nothing resists these: rows and springs do by less than 1e-5 of what they do to others.
  std::vector<std::string> unconstrained;
  /// These are resisted, but by supports that lie within a hundredth of the shell's size of where they
  /// would not be: three points almost in one line.
  std::vector<std::string> weakly_constrained;
  double smallest_lever =
      0;  ///< the smallest lever of them, over the shell's size (root of mean square)
};

/// O(rows + (6 regions)³); models of more than 500 regions are looked at as one body.
RigidBodyModes find_rigid_body_modes(const ModelLayout& model, const Points& shape,
                                     const ShellTies& ties);


/// What a support does to the shell.
struct SupportReaction {
  std::string support;
  Resultant resultant;  ///< on the shell; moment about the origin
};

/// K with its springs, 3n×3n, and what ties and holds, of one shape.
struct ShellSystem {
  ShellTies ties;
  SparseMatrix K;
};

/// Linear statics of a model: K q = F under the rows of its joins and supports, one factor for all
/// loads.
///
///     const ShellModel shell(layout, shape, {{{ShellMaterial::isotropic(210e3, 0.3), 1.5}},
///                                            {LineSupport::clamped("hinges")}});
///     const Points q = shell.solve(point_force(layout, nearest_location(layout, shape, knob), push));
///
/// Costs one stiffness and one factor of up to 3n unknowns; solve() one pair of triangular solves.
class ShellModel {
 public:
  /// `shape`: absolute dofs of the middle surface. Throws InputError: what triangle_sections() and
  /// shell_ties() throw; ConflictError: supports
  /// that contradict each other; NoSolutionError: motions that nothing resists, each named.
  ///
  /// Free::Shifted takes a shell that is not held, for its vibrations: its stiffness is K + shift() M,
  /// and no other function knows of that.
  enum class RigidBodyHandling { Refused, Shifted };
  /// `backend_factory`: what factors its systems; empty: SparseCholesky.
  ShellModel(ModelLayout layout, Points shape, const ShellDefinition& definition,
             RigidBodyHandling free = RigidBodyHandling::Refused,
             const BackendFactory& backend_factory = {});

  /// The same shell in another shape, while a slider moves: sections and supports stay, supports at
  /// points at their places of the material. Costs the numbers of a stiffness and of a factor; their
  /// patterns are kept. Throws as the constructor; after a throw only move() may be called.
  void update_shape(Points shape);

  /// The displacement, n×3. Throws InputError for a load of another size.
  Points solve(const Points& F) const;
  /// What every support does to the shell, each name once. Their sum balances the load to
  /// rounding: λ of its rows, from K q - F = Cᵀ λ, and the pull of its springs.
  std::vector<SupportReaction> reactions(const Points& q, const Points& F) const;
  /// The system of another shape on the same layout: one stiffness, no factor.
  ShellSystem assemble_system(const Points& shape) const;
  /// By how much Gᵀu changes when the system becomes `other`, and the load other_F: to first order,
  ///
  ///     aᵀ (δF - δK u) + λ(u)ᵀ δC a + λ(a)ᵀ δC u,      u = solve(F),  a = adjoint(G)
  ///
  /// with λ the multipliers of the rows. G: a goal, as a load (point_force() of 1 for a displacement,
  /// F for the compliance, without δF in it). Costs a few sparse products.
  double goal_change(const Points& u, const Points& F, const Points& a, const Points& G,
                     const ShellSystem& other, const Points& other_F) const;
  /// K a = G under supports that do not move.
  Points adjoint(const Points& G) const;
  /// ½ qᵀ K q, without what springs of embedded lines hold
  double energy(const Points& q) const;

  const ModelLayout& layout() const { return layout_; }
  const Points& shape() const { return shape_; }
  const ShellAssembler& assembler() const { return assembler_; }
  const ShellSection& section(int region) const {
    const auto& sections = definition_.sections;
    return sections[sections.size() == 1 ? 0 : static_cast<size_t>(region)];
  }
  const ConstrainedSolver& solver() const { return solver_; }
  /// Motions that nothing resists, or little; and what was added of the mass because of the first.
  const RigidBodyModes& rigid_body_modes() const { return rigid_body_modes_; }
  double shift() const { return shift_; }
  /// Free unknowns of the system that is solved.
  int unknowns() const { return solver_.reduction().free_count(); }

 private:
  // Of ties_ and assembler_.
  SparseMatrix stiffness();
  // K q - F with the springs' own load: what rows do.
  Points residual_forces(const Points& q, const Points& F) const;

  ModelLayout layout_;
  Points shape_;
  ShellDefinition definition_;
  RigidBodyHandling rigid_body_handling_;
  std::vector<ShellSection> sections_;  // one, or one for each triangle
  std::vector<std::string> supports_;
  RigidBodyModes rigid_body_modes_;
  double shift_ = 0;
  ShellTies ties_;
  ShellAssembler assembler_;
  ConstrainedSolver solver_;
};

}  // namespace batten
