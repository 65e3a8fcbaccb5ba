// What a frame of a sequence holds, and what is told of it.
#pragma once

#include <optional>
#include <vector>

#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

/// What all frames of an edit hold. Numbers are nodes of the mesh, in every frame the same.
struct FrameConstraints {
  std::vector<int> fixed;                ///< nodes that stay where the frame has them
  std::vector<Handle> handles;           ///< parts whose places are told, frame by frame
  std::vector<FormFeature> features;     ///< parts that keep their shape exactly and go along
  std::optional<double> penalty_weight;  ///< λ: handles are drawn to their places by this weight
                                         ///< instead of being held there; above 0
  /// Nodes or means of nodes on a plane, or on a line such as a screen ray. Held exactly. The points
  /// of a plane or line are told frame by frame.
  std::vector<PointConstraint> point_constraints;
  bool preserve_volume = false;  ///< the closed surface encloses as much as in the frame
};

struct FrameOptions {
  enum class Weights {
    Uniform,   ///< w_ij = 1, as in the paper: one matrix for all frames
    Cotangent  ///< of the first frame, at least a tenth of their mean
  } weights = Weights::Uniform;
  int max_iterations = 100;
  double tolerance = 1e-5;  ///< of the mesh's size: rounds end when no node moves by more
};

/// Where a handle is in one frame.
struct HandlePose {
  RigidMotion motion;          ///< from where the frame has it to where it should be
  bool free_rotation = false;  ///< only the place of its centroid counts; the turn is found, from
                               ///< that of the motion on
};

/// What is told of one frame.
struct FrameTargets {
  std::vector<HandlePose> handles;       ///< one for each handle
  std::vector<Vec3> constraint_origins;  ///< a point of each plane or line
};

/// A frame after an edit.
struct FrameShape {
  Points positions;             ///< nodes × 3
  std::vector<Mat3> rotations;  ///< R_i of every node
};

}  // namespace batten
