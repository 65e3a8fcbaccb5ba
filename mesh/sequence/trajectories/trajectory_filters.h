// Trajectories of handles filtered over time, each relative to what it hangs on.
#pragma once

#include <string>
#include <vector>

#include "batten/mesh/sequence/trajectories/foot_contact.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"
#include "batten/core/eigen.h"

namespace batten {

// Linear filters of signals over frames.

/// What lies beyond the ends of a signal.
enum class Padding {
  Even,  ///< x_{-j} = x_j
  Odd    ///< x_{-j} = 2 x_0 - x_j: even motion stays even motion
};

/// A symmetric filter of finite length, as differences, so that constants come out as `sum` times
/// what they were, to the last bit:
///
///     y_k = sum x_k + Σ_{j≥1} h_j (x_{k+j} - 2 x_k + x_{k-j})
///
/// Frames are taken as even in time; sigma is in frames. Kernels are sampled, to 7 sigma.
class SignalFilter {
 public:
  SignalFilter(double sum, std::vector<double> taps);  ///< taps: h_1, h_2, …

  /// Gaussian; response exp(-σ²ω²/2). Throws InputError, as the next two do, unless 0 < σ ≤ 1e5.
  static SignalFilter low_pass(double sigma);
  /// Signal minus low pass; response 1 - exp(-σ²ω²/2).
  static SignalFilter high_pass(double sigma);
  /// x - amount σ² x ∗ LoG, LoG the second derivative of the Gaussian, its middle set so that it
  /// sums to zero: what follows is overdone, and what comes is announced. Response 1 + amount σ²ω²
  /// exp(-σ²ω²/2), at most 1 + 0.74 amount, at ω = √2/σ. Formula (7) has the amount 1/σ². Source:
  /// Wang, Drucker, Agrawala, Cohen 2006.
  static SignalFilter cartoon(double sigma, double amount = 1);

  /// By what it multiplies cos(ωk + φ) away from ends: sum + 2 Σ h_j (cos ωj - 1). ω in radians a
  /// frame, up to π.
  double response(double omega) const;

  /// The signal, one row a frame, filtered. O(frames · taps).
  Points operator()(const Points& signal, Padding padding = Padding::Even) const;
  /// Rotations by logarithms relative to the frame itself,
  ///
  ///     R'_k = R_k^sum exp( Σ_{j≥1} h_j (log R_kᵀR_{k+j} + log R_kᵀR_{k-j}) )
  ///
  /// followed outwards from it (`nearest_log`), so that full turns are no places apart; about one
  /// axis these are the filtered angles. Turned over, R_{-j} = R_0 R_jᵀ R_0.
  std::vector<Mat3> operator()(const std::vector<Mat3>& rotations,
                               Padding padding = Padding::Even) const;

 private:
  double sum_;
  std::vector<double> taps_;
};


/// A trajectory as seen from another one: centres Rᵀ (c - c_parent), turns Rᵀ R_child, R the
/// parent's rotation; and back. Throws InputError on different numbers of frames.
Trajectory relative(const Trajectory& child, const Trajectory& parent);
Trajectory composed(const Trajectory& relative, const Trajectory& parent);

/// A handle that is filtered.
struct FilteredHandle {
  std::string name;
  Trajectory trajectory;
  int parent = -1;  ///< another handle that it hangs on; -1: the root
  std::vector<FootContact> foot_contacts;
};

struct FilterOptions {
  Padding padding = Padding::Even;
  bool rotations = true;  ///< rotations are filtered too
  int blend = 5;          ///< frames beside a footprint over which filtering sets in
};

/// The root and the handles, all filtered.
struct FilteredTrajectories {
  Trajectory root;
  std::vector<Trajectory> handles;
};

/// Filters the root (the whole mesh's centroid; without rotations of its own where its turns are
/// the identity) and each handle relative to its parent, and puts them together again from the root
/// down: a child goes along with what the filter did to its parent.
///
/// In footprints a handle is where it was; for `blend` frames beside them its absolute place and
/// rotation go over to the filtered ones by b = 3τ² - 2τ³ (rotations: R (Rᵀ R')^b).
///
/// Throws InputError that names the handle: a parent that is none, handles that hang on each other
/// in a circle, other numbers of frames than the root, footprints that check() refuses. O(handles ·
/// frames · taps). Source: Xu et al. 2007, section 6.
FilteredTrajectories filtered(const Trajectory& root, const std::vector<FilteredHandle>& handles,
                              const SignalFilter& filter, const FilterOptions& options = {});

}  // namespace batten
