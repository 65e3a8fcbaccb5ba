// SPDX-License-Identifier: MPL-2.0
// Temporal filters for trajectories of handles, applied relative to the parent handles.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/sequence/trajectories/foot_contact.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

// Linear filters of signals over frames.

/// Extension of a signal x_0, x_1, … beyond its ends. The formulas are for the start.
enum class Padding {
  Even,  ///< mirrored at the end point, x_{-j} = x_j
  Odd    ///< mirrored through the end point, x_{-j} = 2 x_0 - x_j: preserves uniform motion
};

/// A symmetric finite impulse response (FIR) filter, which maps a signal x_k to
///
///     y_k = sum x_k + Σ_{j≥1} h_j (x_{k+j} - 2 x_k + x_{k-j})
///
/// with the taps h_j. A constant signal is multiplied by exactly `sum`. Frames are assumed to be
/// equally spaced in time; `sigma` (σ) is in frames. Gaussian kernels are sampled up to 7σ.
class SignalFilter {
 public:
  /// Creates a filter from its taps h_1, h_2, …; a constant signal is multiplied by `sum`.
  SignalFilter(double sum, std::vector<double> taps);

  /// Gaussian low-pass filter with the frequency response exp(-σ²ω²/2), where σ is `sigma` in
  /// frames and ω is in radians per frame. Throws InputError unless 0 < σ ≤ 1e5.
  static SignalFilter low_pass(double sigma);
  /// High-pass filter: the signal minus the result of low_pass(). The frequency response is 1 -
  /// exp(-σ²ω²/2), where σ is `sigma` in frames and ω is in radians per frame. Throws InputError
  /// unless 0 < σ ≤ 1e5.
  static SignalFilter high_pass(double sigma);
  /// Cartoon filter [Wang2006], which maps a signal x to x - amount σ² x ∗ LoG with σ = `sigma` in
  /// frames. It exaggerates motion (follow-through) and adds anticipation. LoG is the second
  /// derivative of the Gaussian, with a central sample such that all samples sum to zero. The
  /// frequency response is 1 + amount σ²ω² exp(-σ²ω²/2); its maximum is 1 + 0.74 amount at ω =
  /// √2/σ. Formula (7) of [Wang2006] has amount = 1/σ². Throws InputError unless 0 < σ ≤ 1e5.
  static SignalFilter cartoon(double sigma, double amount = 1);

  /// Frequency response sum + 2 Σ h_j (cos ωj - 1) of the filter with the taps h_j: the factor by
  /// which the filter multiplies the signal cos(ωk + φ), except near the ends. `omega`: ω in
  /// radians per frame, from 0 to π.
  double response(double omega) const;

  /// Filters a signal with three components, one row per frame. O(frames · taps).
  Points operator()(const Points& signal, Padding padding = Padding::Even) const;
  /// Filters a sequence of rotations R_k with the taps h_j of the filter, using the logarithms of
  /// the rotations relative to frame k:
  ///
  ///     R'_k = R_k^sum exp( Σ_{j≥1} h_j (log R_kᵀR_{k+j} + log R_kᵀR_{k-j}) )
  ///
  /// The logarithms are continuous from frame to frame, starting at frame k (see nearest_log()), so
  /// they do not jump at full turns. For rotations about a common axis, the filter is applied to
  /// the angles. With Padding::Odd, R_{-j} = R_0 R_jᵀ R_0.
  std::vector<Mat3> operator()(const std::vector<Mat3>& rotations,
                               Padding padding = Padding::Even) const;

 private:
  double sum_;
  std::vector<double> taps_;
};

/// Expresses the trajectory of a handle relative to that of its parent handle. The relative centres
/// are Rᵀ (c_child - c_parent), the relative rotations Rᵀ R_child, where R is the rotation of the
/// parent. Throws InputError if the numbers of frames differ.
Trajectory relative(const Trajectory& child, const Trajectory& parent);
/// Composes a trajectory relative to a parent handle with the trajectory of the parent; the inverse
/// of relative().
Trajectory composed(const Trajectory& relative, const Trajectory& parent);

/// A handle whose trajectory is filtered by filtered().
struct FilteredHandle {
  std::string name;
  Trajectory trajectory;
  int parent = -1;  ///< index of the parent handle; -1: the parent is the root
  /// Contacts during which the handle is not filtered.
  std::vector<FootContact> foot_contacts;
};

/// Options of filtered().
struct FilterOptions {
  Padding padding = Padding::Even;
  bool rotations = true;  ///< true: filters centres and rotations; false: centres only
  /// Number of frames before and after a contact over which the filter is blended in.
  int blend = 5;
};

/// Filtered trajectories of the root and of all handles.
struct FilteredTrajectories {
  Trajectory root;
  std::vector<Trajectory> handles;
};

/// Filters the trajectories of a hierarchy of handles. The trajectory of each handle is filtered
/// relative to that of its parent. The results are then composed from the root down, so children
/// follow the filtered motion of their parents. `root`: trajectory of the root of the hierarchy,
/// usually the centroid of the whole mesh (root_trajectory()).
///
/// During foot contacts, a handle keeps its original pose. Over FilterOptions::blend frames before
/// and after a contact, the absolute position and rotation R are blended into the filtered ones
/// (rotation R') with the weight b = 3τ² - 2τ³, where τ increases from 0 at the contact to 1. The
/// blended rotation is R (Rᵀ R')^b.
///
/// Throws InputError if a parent does not exist, parents form a cycle, a handle has a different
/// number of frames than the root, or check() rejects the foot contacts. The message names the
/// handle. O(handles · frames · taps). Reference: [Xu2007], section 6.
FilteredTrajectories filtered(const Trajectory& root, const std::vector<FilteredHandle>& handles,
                              const SignalFilter& filter, const FilterOptions& options = {});

}  // namespace batten
