// Inside of FrameSolver: what a frame is solved with, and the state of the frame under way. Internal.
#pragma once

#include <array>
#include <vector>

#include "batten/constraints/schur_complement_constraints.h"
#include "batten/core/sparse_cholesky.h"
#include "batten/core/anderson_accelerator.h"
#include "batten/mesh/regions/iterative_deformer.h"
#include "batten/mesh/sequence/frame_constraints.h"
#include "batten/mesh/sequence/frame_unknowns.h"
#include "batten/mesh/sequence/local_global_steps.h"

namespace batten {

struct FrameSolverData {
  FrameSolverData(const TriangleMesh& mesh, FrameConstraints given, const FrameOptions& opts);

  // Once (frame_set_up.cpp).
  void set_triangles(const TriangleMesh& mesh);
  void factorize();
  // 1 on a handle, 0 on what else is held, harmonic between: how much of its turn a node takes.
  void compute_handle_weights();
  void couple_point_constraints();

  // A frame's beginning (frame_solver.cpp).
  void begin(const Points& frame, const FrameTargets& given);
  void start_from_handles();
  void start_from(const Points& start);
  // Of parts that turn by themselves the mean of their nodes' turns; then where the parts stand.
  void init_part_rotations();

  // Rounds (frame_rounds.cpp).
  // In the linear step: there each edge counts once, in E twice.
  double half_penalty_weight() const { return 0.5 * constraints.penalty_weight.value_or(0); }
  bool rotates_freely(size_t part) const;
  // How far the nodes of a part stand from where its unknown alone, or the frame, has them.
  void set_offsets(size_t k);
  void set_point_constraints();
  void update_positions();
  void update_positions_at(MatX& other);
  // The exact minimum over the rotation of a part whose centre and surroundings stand still.
  void fit_part_rotation(size_t k);
  Vec3 target(const FrameUnknowns::PenalizedNode& d) const;
  void rotate_penalized_handles();
  /// Positions from y, then the best turns; returns the energy.
  double update_rotations();
  void assign_part_rotations();
  /// The best positions for the turns, into `rhs`.
  void global_step();
  // Along z = K⁻¹ ∂V, with ∂V of the shape before, so that at rest E has its least value among the
  // shapes of this volume; in the first round of where the linear step went.
  void restore_volume();
  /// One round; returns the energy, which is not above the one before.
  double iterate(double before);
  void iterations(int most);
  void finish() { shape.positions = now; }

  FrameConstraints constraints;
  FrameOptions options;
  double size;
  NodeGraph graph;
  FrameUnknowns unknowns;
  SparseCholesky factor;
  MatX handle_weights;  // nodes × handles
  SchurComplementConstraints constraint_origins;
  std::vector<SchurComplementConstraints::Constraint> point_equations;
  VecX point_equation_rhs;
  std::vector<std::array<int, 3>> triangles;  // for the volume
  double volume = 0;

  FrameTargets targets;
  RowPoints rest, now, offset, loads, gradient;  // of nodes
  MatX y, rhs, accelerated, volume_direction;    // of unknowns
  AndersonAccelerator accelerator{1e-5};
  std::vector<Mat3> part_rotations, handle_rotations;
  std::vector<Mat3> rotations_before, part_rotations_before, handle_rotations_before;
  std::vector<Vec3> part_rest, part_position, handle_rest;
  std::vector<char> rotation_from_part;  // nodes whose R_i is that of their part
  std::vector<double> chunk_sums;
  bool begun = false;
  FrameShape shape;
  IterationReport report;
};

}  // namespace batten
