// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/harmonic_response.h"

#include <algorithm>
#include <numbers>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {

HarmonicResponse::HarmonicResponse(const ShellModes& modes, const Points& F, double damping)
    : frequencies_(modes.frequencies), loads_(modes.frequencies.size()), damping_(damping) {
  if (!(damping >= 0 && damping < 1))
    throw InputError("damping: found " + format_number(damping) +
                     ", expected a damping ratio from 0 to below 1");
  if (modes.rigid_body_count > 0)
    throw InputError("found a shell with rigid-body modes, expected one with supports");
  for (long k = 0; k < loads_.size(); ++k)
    loads_[k] = modes.shapes[static_cast<size_t>(k)].cwiseProduct(F).sum();
}

Eigen::Vector3cd HarmonicResponse::at(double frequency, const Vec3& static_displacement,
                                      const std::vector<Vec3>& shapes) const {
  const double full = 2 * std::numbers::pi, w = full * frequency;
  Eigen::Vector3cd u = static_displacement.cast<std::complex<double>>();
  for (long k = 0; k < loads_.size(); ++k) {
    const double own = full * frequencies_[k];
    const std::complex<double> dynamic(own * own - w * w, 2 * damping_ * own * w);
    const std::complex<double> factor = loads_[k] * (1.0 / dynamic - 1 / (own * own));
    u += factor * shapes[static_cast<size_t>(k)].cast<std::complex<double>>();
  }
  return u;
}

ShellModes modes_up_to(const ShellModel& shell, double frequency) {
  constexpr int first = 10;
  const int most = shell.unknowns() / 2 - 1;
  for (int count = first;; count *= 2) {
    const int few = std::min(count, most);
    ShellModes modes = natural_modes(shell, few);
    if (modes.frequencies[modes.frequencies.size() - 1] > frequency || few == most) return modes;
  }
}

}  // namespace batten
