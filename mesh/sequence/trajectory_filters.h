// Trajectories of handles filtered over time, each relative to what it hangs on.
#pragma once

#include <string>
#include <vector>

#include "batten/mesh/sequence/foot_contact.h"
#include "batten/mesh/sequence/rigid_motion.h"
#include "batten/mesh/sequence/signal_filter.h"

namespace batten {

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
