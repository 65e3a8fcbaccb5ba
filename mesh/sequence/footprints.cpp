#include "batten/mesh/sequence/footprints.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/mesh/rotation_of_faces.h"

namespace batten {
namespace {

/// "frames 3-8".
std::string frames_of(const Footprint& f) {
  return "frames " + std::to_string(f.first + 1) + "-" + std::to_string(f.last + 1);
}

Mat3 mean(const std::vector<Mat3>& turns) {
  return mean_rotation(turns, std::vector<double>(turns.size(), 1.0));
}

/// From each frame the last one of an interval that still counts as one place.
std::vector<int> reach(const Points& c, const FootprintOptions& options) {
  const int n = static_cast<int>(c.rows());
  std::vector<int> last(n);
  for (int first = 0, end = 0; first < n; ++first) {
    end = std::max(end, first);
    for (; end + 1 < n && (c.row(end + 1) - c.row(end)).norm() <= options.speed; ++end) {
      bool near = true;
      for (int k = first; k <= end && near; ++k)
        near = (c.row(end + 1) - c.row(k)).norm() <= options.within;
      if (!near) break;
    }
    last[first] = end;
  }
  return last;
}

Footprint footprint_of(const Trajectory& t, int first, int last) {
  Footprint f{first, last, t.centres.middleRows(first, last - first + 1).colwise().mean(), {}};
  f.turn = mean({t.turns.begin() + first, t.turns.begin() + last + 1});
  return f;
}

}  // namespace

std::vector<int> lowest_vertices(const std::vector<Points>& frames,
                                 const std::vector<int>& vertices, const Vec3& up, double share) {
  if (vertices.empty() || frames.empty()) throw InputError("lowest of no vertices");
  std::vector<double> height(vertices.size(), 0);
  for (size_t k = 0; k < frames.size(); ++k)
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i] < 0 || vertices[i] >= frames[k].rows())
        throw InputError("frame " + std::to_string(k + 1) + " has no vertex " +
                         std::to_string(vertices[i] + 1));
      height[i] += frames[k].row(vertices[i]).dot(up);
    }
  std::vector<size_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return height[a] < height[b]; });
  const double count = std::ceil(share * static_cast<double>(vertices.size()) - 1e-9);
  order.resize(
      static_cast<size_t>(std::clamp<double>(count, 1, static_cast<double>(order.size()))));
  std::vector<int> lowest;
  for (const size_t i : order) lowest.push_back(vertices[i]);
  std::sort(lowest.begin(), lowest.end());
  return lowest;
}

std::vector<Footprint> find_footprints(const Trajectory& trajectory,
                                       const FootprintOptions& options) {
  if (!(options.within > 0) || !(options.speed > 0) || options.frames < 1)
    throw InputError("footprints: `within`, `speed` and `frames` must be above 0");
  const std::vector<int> last = reach(trajectory.centres, options);
  std::vector<Footprint> found;
  std::vector<std::pair<int, int>> open = {{0, trajectory.frame_count() - 1}};
  while (!open.empty()) {
    const auto [from, to] = open.back();
    open.pop_back();
    int first = from, longest = 0;
    for (int k = from; k <= to; ++k)
      if (const int length = std::min(last[k], to) - k + 1; length > longest) {
        first = k;
        longest = length;
      }
    if (longest < options.frames) continue;
    found.push_back(footprint_of(trajectory, first, first + longest - 1));
    open.push_back({from, first - 1});
    open.push_back({first + longest, to});
  }
  std::sort(found.begin(), found.end(),
            [](const Footprint& a, const Footprint& b) { return a.first < b.first; });
  return found;
}

Footprint moved(const RigidMotion& motion, const Footprint& footprint) {
  Footprint result = footprint;
  result.at = motion(footprint.at);
  result.turn = motion.turn * footprint.turn;
  return result;
}

Footprint projected(const Footprint& footprint, const Terrain& terrain, const Standing& standing,
                    const std::string& name) {
  const std::optional<Terrain::Place> place = terrain.place(footprint.at);
  if (!place)
    throw InputError(name + ": the footprint of " + frames_of(footprint) +
                     " has no terrain above or below it");
  Footprint result = footprint;
  const Vec3 direction = standing.turns ? place->normal : terrain.up();
  result.at = place->at + standing.clearance * direction;
  result.turn = Eigen::Quaterniond::FromTwoVectors(terrain.up(), direction) * footprint.turn;
  return result;
}

std::vector<Footprint> averaged(const std::vector<Footprint>& footprints,
                                const std::vector<RigidMotion>& motions) {
  std::vector<Footprint> result;
  for (const Footprint& f : footprints) {
    check({f}, count_of(motions), "averaged");
    Vec3 at = Vec3::Zero();
    std::vector<Mat3> turns;
    for (int k = f.first; k <= f.last; ++k) {
      at += motions[k](f.at) / (f.last - f.first + 1);
      turns.push_back(motions[k].turn);
    }
    result.push_back({f.first, f.last, at, mean(turns) * f.turn});
  }
  return result;
}

void check(const std::vector<Footprint>& footprints, int frames, const std::string& name) {
  double size = 0;
  for (const Footprint& f : footprints) {
    if (f.last < f.first)
      throw InputError(name + ": the footprint of " + frames_of(f) + " ends before it begins");
    if (f.first < 0 || f.last >= frames)
      throw InputError(name + ": the footprint of " + frames_of(f) + " is not in the frames 1-" +
                       std::to_string(frames));
    size = std::max(size, f.at.cwiseAbs().maxCoeff());
  }
  for (size_t i = 0; i < footprints.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      const Footprint &a = footprints[j], &b = footprints[i];
      if (a.last < b.first || b.last < a.first) continue;
      const double apart = (a.at - b.at).norm();
      const std::string overlap =
          name + ": the footprints of " + frames_of(a) + " and " + frames_of(b) + " overlap ";
      if (apart > 1e-9 * size)
        throw InputError(overlap + "at places that are " + number(apart) + " apart");
      if ((a.turn - b.turn).norm() > 1e-9) throw InputError(overlap + "with different rotations");
    }
}

std::vector<HandleKeyframe> keyframes_of(const std::vector<Footprint>& from,
                                         const std::vector<Footprint>& to, int frames,
                                         const std::string& name) {
  check(to, frames, name);
  if (from.size() != to.size())
    throw InputError(name + ": " + std::to_string(to.size()) + " footprints after an edit, " +
                     std::to_string(from.size()) + " before it");
  std::map<int, RigidMotion> motions;
  for (size_t i = 0; i < to.size(); ++i) {
    const Footprint &a = from[i], &b = to[i];
    if (a.first != b.first || a.last != b.last)
      throw InputError(name + ": a footprint of " + frames_of(a) + " became one of " +
                       frames_of(b));
    for (int k = b.first; k <= b.last; ++k)
      motions.emplace(k, RigidMotion::about(a.at, b.turn * a.turn.transpose(), b.at));
  }
  std::vector<HandleKeyframe> keyframes;
  for (const auto& [frame, motion] : motions) keyframes.push_back({frame, motion});
  return keyframes;
}

}  // namespace batten
