#include "batten/mesh/sequence/mesh_sequence.h"

#include <cmath>

#include "batten/core/errors.h"

namespace batten {

void check(const MeshSequence& sequence, const std::string& name) {
  if (sequence.frames.empty()) throw InputError(name + ": no frames");
  const auto frame = [&](size_t k) { return name + ": frame " + std::to_string(k + 1); };
  for (size_t k = 0; k < sequence.frames.size(); ++k) {
    const Points& p = sequence.frames[k];
    if (p.rows() != sequence.node_count())
      throw InputError(frame(k) + " has " + std::to_string(p.rows()) + " nodes, expected " +
                       std::to_string(sequence.node_count()) + " as in the first");
    for (long v = 0; v < p.rows(); ++v)
      if (!p.row(v).allFinite() || !(p.row(v).cwiseAbs().maxCoeff() < 1e100))
        throw InputError(frame(k) + ": node " + std::to_string(v + 1) +
                         " has a coordinate that is not finite, or above 1e100");
  }
  if (sequence.times.size() != sequence.frames.size())
    throw InputError(name + ": " + std::to_string(sequence.times.size()) + " times for " +
                     std::to_string(sequence.frames.size()) + " frames");
  for (size_t k = 0; k < sequence.times.size(); ++k)
    if (!std::isfinite(sequence.times[k]) ||
        (k > 0 && !(sequence.times[k] > sequence.times[k - 1])))
      throw InputError(frame(k) + " has a time that is not after the one before");
}

double size_of(const MeshSequence& sequence) {
  if (sequence.frames.empty() || sequence.node_count() == 0) return 0;
  const Points& p = sequence.frames.front();
  return (p.colwise().maxCoeff() - p.colwise().minCoeff()).norm();
}

std::vector<double> second_differences(const std::vector<Points>& frames) {
  std::vector<double> largest(frames.size(), 0);
  for (size_t k = 1; k + 1 < frames.size(); ++k)
    if (frames[k].rows() > 0)
      largest[k] = (frames[k + 1] - 2 * frames[k] + frames[k - 1]).rowwise().norm().maxCoeff();
  return largest;
}

}  // namespace batten
