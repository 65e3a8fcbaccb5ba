#include "batten/mesh/sequence/handle_turns.h"

#include "batten/core/chunks.h"
#include "batten/core/rotations.h"
#include "batten/mesh/rotation_of_faces.h"

namespace batten {

Vec3 centre_of(const std::vector<int>& nodes, const RowPoints& p) {
  Vec3 sum = Vec3::Zero();
  for (const int v : nodes) sum += p.row(v).transpose();
  return nodes.empty() ? sum : sum / static_cast<double>(nodes.size());
}

Mat3 best_turn(const std::vector<int>& nodes, const RowPoints& rest, const Vec3& from,
               const RowPoints& now, const Vec3& to, const Mat3& before) {
  Mat3 M = Mat3::Zero();
  for (const int v : nodes)
    M += (now.row(v).transpose() - to) * (rest.row(v).transpose() - from).transpose();
  return rotation_part(M * before.transpose()) * before;
}

void spread_turns(const MatX& share, const std::vector<HandlePlace>& handles,
                  std::vector<Mat3>& turns) {
  std::vector<Vec3> logs;
  for (const auto& place : handles) logs.push_back(rotation_log(place.motion.turn));
  for_each_in_chunks<512>(static_cast<int>(share.rows()), [&](int v) {
    Vec3 log = Vec3::Zero();
    for (size_t h = 0; h < logs.size(); ++h) log += share(v, static_cast<long>(h)) * logs[h];
    turns[v] = rotation_matrix(log);
  });
}

}  // namespace batten
