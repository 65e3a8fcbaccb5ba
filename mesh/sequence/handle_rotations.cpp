#include "batten/mesh/sequence/handle_rotations.h"

#include "batten/core/parallel_chunks.h"
#include "batten/core/rotations.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {

Vec3 centre_of(const std::vector<int>& nodes, const RowPoints& p) {
  Vec3 sum = Vec3::Zero();
  for (const int v : nodes) sum += p.row(v).transpose();
  return nodes.empty() ? sum : sum / static_cast<double>(nodes.size());
}

Mat3 best_rotation(const std::vector<int>& nodes, const RowPoints& rest, const Vec3& from,
                   const RowPoints& now, const Vec3& to, const Mat3& before) {
  Mat3 M = Mat3::Zero();
  for (const int v : nodes)
    M += (now.row(v).transpose() - to) * (rest.row(v).transpose() - from).transpose();
  return nearest_rotation(M * before.transpose()) * before;
}

void spread_rotations(const MatX& handle_weights, const std::vector<HandlePose>& handles,
                      std::vector<Mat3>& rotations) {
  std::vector<Vec3> logs;
  for (const auto& pose : handles) logs.push_back(to_rotation_vector(pose.motion.rotation));
  parallel_for_each<512>(static_cast<int>(handle_weights.rows()), [&](int v) {
    Vec3 log = Vec3::Zero();
    for (size_t h = 0; h < logs.size(); ++h)
      log += handle_weights(v, static_cast<long>(h)) * logs[h];
    rotations[v] = rotation_matrix(log);
  });
}

}  // namespace batten
