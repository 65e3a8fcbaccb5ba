#include "batten/mesh/sequence/root_motion.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/mesh/sequence/rigid_motion.h"

namespace batten {
double stance_speed(const std::vector<Points>& frames, const std::vector<std::vector<int>>& feet,
                    const Vec3& direction, const Vec3& up) {
  if (frames.size() < 2) throw InputError("a walk of fewer than two frames");
  if (feet.empty()) throw InputError("a walk without feet has no speed of its own");
  std::vector<double> backwards;
  for (size_t k = 0; k + 1 < frames.size(); ++k) {
    double lowest = std::numeric_limits<double>::infinity(), step = 0;
    for (const auto& foot : feet) {
      const Vec3 a = centroid(frames[k], foot), b = centroid(frames[k + 1], foot);
      if ((a + b).dot(up) >= lowest) continue;
      lowest = (a + b).dot(up);
      step = (a - b).dot(direction);
    }
    backwards.push_back(step);
  }
  const auto middle = backwards.begin() + static_cast<long>(backwards.size() / 2);
  std::nth_element(backwards.begin(), middle, backwards.end());
  return *middle;
}

MeshSequence with_root_motion(const MeshSequence& sequence, int cycles, const Vec3& direction,
                              double speed) {
  const int count = sequence.frame_count();
  if (cycles < 1) throw InputError("fewer than one cycle");
  if (count < 2) throw InputError("a walk of fewer than two frames");
  const double apart =
      (sequence.frames.back() - sequence.frames.front()).rowwise().norm().maxCoeff();
  const int cycle = apart < 1e-6 * size_of(sequence) ? count - 1 : count;
  const double step = (sequence.times.back() - sequence.times.front()) / (count - 1);
  MeshSequence result;
  result.shells = sequence.shells;
  const int all = cycle < count ? cycles * cycle + 1 : cycles * cycle;
  for (int k = 0; k < all; ++k) {
    const Points& p = sequence.frames[k % cycle];
    result.frames.push_back(p.rowwise() + k * speed * direction.transpose());
    result.times.push_back(k < count ? sequence.times[k] : result.times.back() + step);
  }
  return result;
}

}  // namespace batten
