// An animated glTF scene as frames.
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/io/sequences/gltf_animation.h"
#include "batten/io/sequences/gltf_surface.h"
#include "batten/io/sequences/sequence_readers.h"

namespace batten {
namespace {

constexpr double kMostFrames = 1e6;

/// Classes of vertices that lie at one place in all frames that were seen.
class Seams {
 public:
  explicit Seams(const Points& first) {
    const double size = (first.colwise().maxCoeff() - first.colwise().minCoeff()).norm();
    within_ = kWeldTolerance * size;
    leader_.resize(static_cast<size_t>(first.rows()));
    std::unordered_multimap<std::size_t, int> cells;
    for (int v = 0; v < first.rows(); ++v) {
      leader_[v] = v;
      const Vec3 p = first.row(v).transpose();
      // A neighbour within reach lies in one of the eight cells around the nearest corner.
      for (int corner = 0; corner < 8 && leader_[v] == v; ++corner) {
        const auto [begin, end] = cells.equal_range(
            key(p + within_ * Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)));
        for (auto at = begin; at != end; ++at)
          if ((first.row(at->second) - first.row(v)).norm() <= within_) {
            leader_[v] = at->second;
            break;
          }
      }
      if (leader_[v] == v) cells.emplace(key(p), v);
    }
  }

  /// Parts vertices that lie apart in this frame.
  void see(const Points& frame) {
    std::unordered_map<int, std::vector<int>> parted;  // new leaders by their old one
    for (int v = 0; v < frame.rows(); ++v) {
      const int leader = leader_[v];
      const auto near = [&](int other) {
        return (frame.row(v) - frame.row(other)).norm() <= within_;
      };
      if (leader == v || near(leader)) continue;
      std::vector<int>& others = parted[leader];
      const auto found = std::find_if(others.begin(), others.end(), near);
      leader_[v] = found == others.end() ? v : *found;
      if (found == others.end()) others.push_back(v);
    }
  }

  const std::vector<int>& leader() const { return leader_; }

 private:
  /// Cells four times as wide as what is near.
  std::size_t key(const Vec3& p) const {
    std::size_t hash = 0;
    for (int c = 0; c < 3; ++c) {
      const double cell = within_ > 0 ? std::floor(p[c] / (4 * within_)) : p[c];
      hash = hash * 0x9E3779B97F4A7C15u + std::hash<double>()(cell + 0.0);
      hash ^= hash >> 31;
    }
    return hash;
  }

  double within_ = 0;
  std::vector<int> leader_;
};

std::vector<double> sample_times(const std::vector<double>& keys, double rate,
                                 const GltfDocument& document) {
  if (rate == 0) return keys;
  if (!(rate > 0) || !std::isfinite(rate))
    document.fail("found " + format_number(rate) + " frames a second, expected a rate above 0");
  // Times have single precision: a last frame that is missed by that is there.
  const double begin = keys.front(), end = keys.back(),
               count = std::floor((end - begin) * rate * (1 + 1e-6) + 1e-4) + 1;
  if (!(count <= kMostFrames))
    document.fail("found an animation of " + format_number(end - begin) + " s, which has " +
                  format_number(count) + " frames, expected " + format_number(kMostFrames) +
                  " at most");
  std::vector<double> times;
  for (int k = 0; k < static_cast<int>(count); ++k) times.push_back(begin + k / rate);
  return times;
}

}  // namespace

MeshSequence read_gltf_sequence(const std::filesystem::path& path, const SequenceOptions& options,
                                const Progress& progress) {
  progress.update("reading the scene", 0);
  const GltfDocument document(path);
  const GltfNodes nodes(document);
  const GltfSurface surface(document, nodes);
  const GltfAnimation animation(document, options.animation);
  const std::vector<double> times =
      sample_times(animation.keys(), options.frames_per_second, document);
  const FrameRange range = frame_range(options, isize(times), path.string());
  const auto frame = [&](int k) {
    std::vector<GltfNode> moment = nodes.nodes;
    animation.apply(times[static_cast<size_t>(k)], moment);
    Points points = surface.at(moment);
    if (!points.allFinite())
      document.fail("frame " + std::to_string(k + 1) + " has coordinates that are not finite");
    return points;
  };

  // Nodes of the sequence, in the order in which the file has them first.
  std::vector<int> vertices, node_of(static_cast<size_t>(surface.vertex_count()));
  if (options.weld_seams) {
    Seams seams(frame(0));
    for (int k = 1; k < isize(times); ++k) {
      progress.update("finding seams", static_cast<double>(k) / isize(times));
      seams.see(frame(k));
    }
    for (int v = 0; v < surface.vertex_count(); ++v) {
      const int leader = seams.leader()[v];
      if (leader == v) vertices.push_back(v);
      node_of[v] = leader == v ? isize(vertices) - 1 : node_of[leader];
    }
  } else {
    for (int v = 0; v < surface.vertex_count(); ++v) {
      vertices.push_back(v);
      node_of[v] = v;
    }
  }

  MeshSequence sequence;
  sequence.shells.points.resize(isize(vertices), 3);
  for (const auto& [a, b, c] : surface.triangles())
    sequence.shells.add_face(std::array<int, 3>{node_of[a], node_of[b], node_of[c]});
  for (int k = range.first; k < range.first + range.count; ++k) {
    progress.update("reading frames", static_cast<double>(k - range.first) / range.count);
    sequence.frames.push_back(frame(k)(vertices, Eigen::all));
    sequence.times.push_back(times[static_cast<size_t>(k)]);
  }
  return sequence;
}

}  // namespace batten
