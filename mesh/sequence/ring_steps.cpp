#include "batten/mesh/sequence/ring_steps.h"

#include <cmath>

#include "batten/core/chunks.h"
#include "batten/core/simd.h"
#include "batten/mesh/rotation_batch.h"
#include "batten/mesh/rotation_of_faces.h"

namespace batten {
namespace {

constexpr int kLanes = RotationBatch::kLanes, kChunk = 512;

struct Rings {
  const int *start, *neighbour;
  const double *weight, *rest, *now;
};

/// M of up to eight rings from `first` on, and Σ w (|e|² + |e⁰|²) of each.
BATTEN_CLONES void look_at_rings(const Rings& rings, int first, int count, double (*M)[kLanes],
                                 double* squares) {
  for (int l = 0; l < count; ++l) {
    const int i = first + l;
    const double *p = rings.rest + 3L * i, *v = rings.now + 3L * i;
    double m[9] = {}, sum = 0;
    for (int k = rings.start[i]; k < rings.start[i + 1]; ++k) {
      const long j = 3L * rings.neighbour[k];
      const double w = rings.weight[k];
      const double a = rings.rest[j] - p[0], b = rings.rest[j + 1] - p[1],
                   c = rings.rest[j + 2] - p[2];
      const double x = rings.now[j] - v[0], y = rings.now[j + 1] - v[1],
                   z = rings.now[j + 2] - v[2];
      sum += w * (a * a + b * b + c * c + (x * x + y * y + z * z));
      const double wx = w * x, wy = w * y, wz = w * z;
      m[0] += wx * a, m[1] += wx * b, m[2] += wx * c;
      m[3] += wy * a, m[4] += wy * b, m[5] += wy * c;
      m[6] += wz * a, m[7] += wz * b, m[8] += wz * c;
    }
    for (int k = 0; k < 9; ++k) M[k][l] = m[k];
    squares[l] = sum;
  }
}

BATTEN_CLONES void load_rings(const Rings& rings, const double* turns, int first, int last,
                              double* loads) {
  for (int i = first; i < last; ++i) {
    const double *p = rings.rest + 3L * i, *R = turns + 9L * i;
    double sum[3] = {};
    for (int k = rings.start[i]; k < rings.start[i + 1]; ++k) {
      const int j = rings.neighbour[k];
      const double w = rings.weight[k], *S = turns + 9L * j, *q = rings.rest + 3L * j;
      const double a = w * (p[0] - q[0]), b = w * (p[1] - q[1]), c = w * (p[2] - q[2]);
      // Columns of Mat3 follow each other.
      sum[0] += (0.5 * (R[0] + S[0]) - 1) * a + 0.5 * ((R[3] + S[3]) * b + (R[6] + S[6]) * c);
      sum[1] += (0.5 * (R[4] + S[4]) - 1) * b + 0.5 * ((R[1] + S[1]) * a + (R[7] + S[7]) * c);
      sum[2] += (0.5 * (R[8] + S[8]) - 1) * c + 0.5 * ((R[2] + S[2]) * a + (R[5] + S[5]) * b);
    }
    for (int c = 0; c < 3; ++c) loads[3L * i + c] = sum[c];
  }
}

/// Whether all edges of a ring lie on one line, before or after: M has no second direction.
bool on_one_line(const Mat3& M) {
  const double flat = M.col(0).cross(M.col(1)).squaredNorm() +
                      M.col(1).cross(M.col(2)).squaredNorm() +
                      M.col(2).cross(M.col(0)).squaredNorm();  // Σ σ_i² σ_j²
  const double square = M.squaredNorm();
  return flat <= 1e-20 * square * square;
}

}  // namespace

double turn_rings(const RingGraph& graph, const RowPoints& rest, const RowPoints& now,
                  const std::vector<char>& kept, std::vector<Mat3>& turns,
                  std::vector<double>& parts) {
  const Rings rings{graph.start.data(), graph.neighbour.data(), graph.weight.data(), rest.data(),
                    now.data()};
  parts.assign(graph.nodes / kChunk + 1, 0);
  in_chunks<kChunk>(graph.nodes, [&](long begin, long end) {
    double energy = 0;
    RotationBatch M, R;
    double squares[kLanes];
    for (long first = begin; first < end; first += kLanes) {
      const int count = static_cast<int>(std::min<long>(kLanes, end - first));
      for (auto& entry : M.a)
        for (double& lane : entry) lane = 0;
      M.a[0][0] = 1;  // lanes past the end hold something regular
      look_at_rings(rings, static_cast<int>(first), count, M.a, squares);
      rotation_parts(M, R);
      for (int l = 0; l < count; ++l) {
        const long i = first + l;
        const Mat3 m = M.get(l);
        if (kept.empty() || !kept[i])
          turns[i] = on_one_line(m) ? rotation_part(m * turns[i].transpose()) * turns[i] : R.get(l);
        energy += squares[l] - 2 * turns[i].cwiseProduct(m).sum();
      }
    }
    parts[begin / kChunk] = energy;
  });
  double total = 0;
  for (const double part : parts) total += part;
  return total;
}

void ring_loads(const RingGraph& graph, const RowPoints& rest, const std::vector<Mat3>& turns,
                RowPoints& loads) {
  const Rings rings{graph.start.data(), graph.neighbour.data(), graph.weight.data(), rest.data(),
                    nullptr};
  const double* R = graph.nodes > 0 ? turns.front().data() : nullptr;
  in_chunks<kChunk>(graph.nodes, [&](long first, long last) {
    load_rings(rings, R, static_cast<int>(first), static_cast<int>(last), loads.data());
  });
}

}  // namespace batten
