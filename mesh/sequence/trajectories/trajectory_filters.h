// Temporal filters for handle trajectories, applied relative to the parent of each handle.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/sequence/trajectories/foot_contact.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

// Linear filters of signals over frames.

/// Extension of a signal beyond its ends.
enum class Padding {
  Even,  ///< x_{-j} = x_j
  Odd    ///< x_{-j} = 2 x_0 - x_j: uniform motion is preserved
};

/// A symmetric finite impulse response (FIR) filter. It is written with differences, so that a
/// constant signal is multiplied by exactly `sum`:
///
///     y_k = sum x_k + Σ_{j≥1} h_j (x_{k+j} - 2 x_k + x_{k-j})
///
/// Frames count as equally spaced in time; sigma is in frames. Kernels are sampled up to 7 sigma.
class SignalFilter {
 public:
  SignalFilter(double sum, std::vector<double> taps);  ///< taps: h_1, h_2, …

  /// Gaussian low-pass filter; response exp(-σ²ω²/2). Throws InputError unless 0 < σ ≤ 1e5, like
  /// high_pass() and cartoon().
  static SignalFilter low_pass(double sigma);
  /// Signal minus low_pass(); response 1 - exp(-σ²ω²/2).
  static SignalFilter high_pass(double sigma);
  /// Cartoon filter [Wang2006], x - amount σ² x ∗ LoG: it exaggerates motion (follow-through) and
  /// adds anticipation. LoG is the second derivative of the Gaussian; its central sample is set so
  /// that it sums to zero. Response 1 + amount σ²ω² exp(-σ²ω²/2), at most 1 + 0.74 amount, at ω =
  /// √2/σ. The amount in formula (7) of the paper is 1/σ².
  static SignalFilter cartoon(double sigma, double amount = 1);

  /// Frequency response: the factor of cos(ωk + φ) away from the ends, sum + 2 Σ h_j (cos ωj - 1).
  /// ω in radians per frame, up to π.
  double response(double omega) const;

  /// Filters a signal with one row per frame. O(frames · taps).
  Points operator()(const Points& signal, Padding padding = Padding::Even) const;
  /// Filters rotations by logarithms relative to each frame,
  ///
  ///     R'_k = R_k^sum exp( Σ_{j≥1} h_j (log R_kᵀR_{k+j} + log R_kᵀR_{k-j}) )
  ///
  /// The logarithms are followed outwards from frame k (see nearest_log()), so full turns cause no
  /// jumps. For rotations about one axis this filters the angles. With odd padding, R_{-j} = R_0
  /// R_jᵀ R_0.
  std::vector<Mat3> operator()(const std::vector<Mat3>& rotations,
                               Padding padding = Padding::Even) const;

 private:
  double sum_;
  std::vector<double> taps_;
};

/// Expresses a trajectory relative to its parent: centres Rᵀ (c - c_parent), rotations Rᵀ R_child,
/// with R the rotation of the parent. Throws InputError if the numbers of frames differ.
Trajectory relative(const Trajectory& child, const Trajectory& parent);
/// The inverse of relative(): composes a relative trajectory with its parent.
Trajectory composed(const Trajectory& relative, const Trajectory& parent);

/// A handle to be filtered.
struct FilteredHandle {
  std::string name;
  Trajectory trajectory;
  int parent = -1;  ///< index of the parent handle; -1: the root
  /// Contacts during which the handle is not filtered.
  std::vector<FootContact> foot_contacts;
};

/// Options of filtered().
struct FilterOptions {
  Padding padding = Padding::Even;
  bool rotations = true;  ///< filter rotations as well as centres
  int blend = 5;          ///< number of frames beside a contact over which the filter is blended in
};

/// Filtered trajectories of the root and of all handles.
struct FilteredTrajectories {
  Trajectory root;
  std::vector<Trajectory> handles;
};

/// Filters the trajectories of a hierarchy of handles. The root is the centroid of the whole mesh;
/// it is filtered without rotation if its rotations are the identity. Each handle is filtered
/// relative to its parent and then recomposed from the root down, so children follow the filtered
/// motion of their parents.
///
/// During foot contacts a handle keeps its original pose. Over `blend` frames beside them, absolute
/// position and rotation are blended to the filtered ones by b = 3τ² - 2τ³ (rotations: R (Rᵀ
/// R')^b).
///
/// Throws InputError, naming the handle: a parent that does not exist, a cycle of parents, a number
/// of frames that differs from the root, foot contacts that check() rejects. O(handles · frames ·
/// taps). Source: [Xu2007], section 6.
FilteredTrajectories filtered(const Trajectory& root, const std::vector<FilteredHandle>& handles,
                              const SignalFilter& filter, const FilterOptions& options = {});

}  // namespace batten
