// Constraints, options and targets for the deformation of single frames of a sequence.
#pragma once

#include <optional>
#include <vector>

#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

/// Constraints common to all frames of an edit. Indices are nodes of the mesh, the same in every
/// frame.
struct FrameConstraints {
  std::vector<int> fixed;       ///< nodes that keep the position they have in the frame
  std::vector<Handle> handles;  ///< groups of nodes whose poses are prescribed per frame
  /// Groups of nodes that keep their shape exactly and move along.
  std::vector<FormFeature> features;
  /// λ > 0: handles are soft constraints with this penalty weight; empty: they are hard
  /// constraints.
  std::optional<double> penalty_weight;
  /// Points that stay exactly on a plane or a line (such as a viewing ray). A point is a node or a
  /// mean of nodes. The origins of planes and lines are prescribed per frame.
  std::vector<PointConstraint> point_constraints;
  /// Keep the enclosed volume of the frame; the surface must be closed.
  bool preserve_volume = false;
};

/// Options of FrameSolver.
struct FrameOptions {
  enum class Weights {
    Uniform,  ///< w_ij = 1, as in the paper; one matrix for all frames
    /// Cotangents of the mesh given at construction, raised to at least 0.1 of their mean.
    Cotangent
  } weights = Weights::Uniform;
  int max_iterations = 100;
  /// The iteration stops when no node moves by more, relative to the mesh size.
  double tolerance = 1e-5;
};

/// Prescribed pose of a handle in one frame.
struct HandlePose {
  RigidMotion motion;  ///< from the position in the frame to the prescribed one
  /// Only the position of the centroid is prescribed; the rotation is found, starting from that of
  /// `motion`.
  bool free_rotation = false;
};

/// Prescribed handle poses and constraint origins of one frame.
struct FrameTargets {
  std::vector<HandlePose> handles;  ///< one per handle
  /// a point of each plane or line; empty: the constrained points in the frame.
  std::vector<Vec3> constraint_origins;
};

/// Shape of a frame after an edit.
struct FrameShape {
  Points positions;             ///< nodes × 3
  std::vector<Mat3> rotations;  ///< R_i of every node
};

}  // namespace batten
