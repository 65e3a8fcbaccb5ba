// Inside of FrameSolver: what a frame is solved with, and the state of the frame under way. Internal.
#pragma once

#include <array>
#include <vector>

#include "batten/constraints/coupling.h"
#include "batten/core/sparse_cholesky.h"
#include "batten/mesh/regions/deform_estimate.h"
#include "batten/mesh/regions/mixing.h"
#include "batten/mesh/sequence/frame_problem.h"
#include "batten/mesh/sequence/frame_unknowns.h"
#include "batten/mesh/sequence/ring_steps.h"

namespace batten {

struct FrameSolverData {
  FrameSolverData(const TriangleMesh& mesh, FrameHolds given, const FrameOptions& opts);

  // Once (frame_set_up.cpp).
  void set_triangles(const TriangleMesh& mesh);
  void factorize();
  // 1 on a handle, 0 on what else is held, harmonic between: how much of its turn a node takes.
  void share_turns();
  void couple_guides();

  // A frame's beginning (frame_solver.cpp).
  void begin(const Points& frame, const FramePlaces& given);
  void start_from_handles();
  void start_from(const Points& start);
  // Of parts that turn by themselves the mean of their nodes' turns; then where the parts stand.
  void take_part_turns();

  // Rounds (frame_rounds.cpp).
  // In the linear step: there each edge counts once, in E twice.
  double half_softness() const { return 0.5 * holds.softness.value_or(0); }
  bool turns_by_itself(size_t part) const;
  // How far the nodes of a part stand from where its unknown alone, or the frame, has them.
  void set_offsets(size_t k);
  void set_guides();
  void place_nodes();
  void place_at(MatX& other);
  // The exact minimum over the rotation of a part whose centre and surroundings stand still.
  void turn_part(size_t k);
  Vec3 target(const FrameUnknowns::Drawn& d) const;
  void turn_drawn_handles();
  /// Positions from y, then the best turns; returns the energy.
  double settle();
  void give_parts_turns();
  /// The best positions for the turns, into `right`.
  void solve_positions();
  // Along z = K⁻¹ ∂V, with ∂V of the shape before, so that at rest E has its least value among the
  // shapes of this volume; in the first round of where the linear step went.
  void reach_volume();
  /// One round; returns the energy, which is not above the one before.
  double go_on(double before);
  void rounds(int most);
  void finish() { shape.positions = now; }

  FrameHolds holds;
  FrameOptions options;
  double size;
  RingGraph graph;
  FrameUnknowns unknowns;
  SparseCholesky factor;
  MatX share;  // nodes × handles
  Coupling guides;
  std::vector<Coupling::Row> guide_rows;
  VecX guide_right;
  std::vector<std::array<int, 3>> triangles;  // for the volume
  double volume = 0;

  FramePlaces places;
  RowPoints rest, now, offset, loads, gradient;  // of nodes
  MatX y, right, mixed, along;                   // of unknowns
  Mixing mixing;
  std::vector<Mat3> part_turns, handle_turns;
  std::vector<Mat3> turns_before, part_turns_before, handle_turns_before;
  std::vector<Vec3> part_rest, part_place, handle_rest;
  std::vector<char> keeps_turn;  // nodes whose R_i is that of their part
  std::vector<double> chunk_sums;
  bool begun = false;
  FrameShape shape;
  EstimateReport report;
};

}  // namespace batten
