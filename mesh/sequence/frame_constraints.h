// SPDX-License-Identifier: MPL-2.0
// Constraints, options and targets for the deformation of single frames of a sequence.
#pragma once

#include <optional>
#include <vector>

#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

/// Constraints common to all frames of a sequence edit. All indices are node indices of the mesh.
struct FrameConstraints {
  std::vector<int> fixed;       ///< nodes that keep their original position in every frame
  std::vector<Handle> handles;  ///< groups of nodes whose poses are prescribed per frame
  /// Groups of nodes that keep their shape exactly and follow the surface rigidly.
  std::vector<FormFeature> features;
  /// Penalty weight of handles as soft constraints, above 0; empty: hard constraints.
  std::optional<double> penalty_weight;
  /// Points that stay exactly on a plane or a line (a viewing ray, for example). Each point is a
  /// node or the mean of several nodes. The origins of planes and lines are prescribed per frame.
  std::vector<PointConstraint> point_constraints;
  /// True: the edited surface, which must be closed, encloses the volume of the original frame.
  bool preserve_volume = false;
};

/// Options of FrameSolver.
struct FrameOptions {
  enum class Weights {
    Uniform,  ///< weight 1 for all edges, as in [Xu2007]
    /// Cotangent weights of the mesh given at construction; values below 0.1 of the mean weight are
    /// raised to 0.1 of the mean weight.
    Cotangent
  } weights = Weights::Uniform;
  int max_iterations = 100;
  /// The iteration stops when the largest displacement of a node in an iteration, relative to the
  /// mesh size, is below this value.
  double tolerance = 1e-5;
};

/// Prescribed pose of a handle in one frame.
struct HandlePose {
  RigidMotion motion;  ///< motion of the handle from its original pose in the frame
  /// True: only the position of the centroid is prescribed; the rotation is an unknown, with the
  /// rotation of `motion` as initial value.
  bool free_rotation = false;
};

/// Prescribed handle poses and constraint origins of one frame.
struct FrameTargets {
  std::vector<HandlePose> handles;  ///< pose of each handle in FrameConstraints::handles
  /// One point on the plane or line of each point constraint; empty: the original positions of the
  /// constrained points in the frame.
  std::vector<Vec3> constraint_origins;
};

/// Shape of a frame after an edit.
struct FrameShape {
  Points positions;             ///< node positions, nodes × 3
  std::vector<Mat3> rotations;  ///< rotation of the one-ring of each node from the original frame
};

}  // namespace batten
