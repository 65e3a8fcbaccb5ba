#include "batten/mesh/sequence/local_global_steps.h"

#include <cmath>

#include "batten/core/parallel_chunks.h"
#include "batten/core/simd.h"
#include "batten/mesh/rotation_batch.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

constexpr int kLanes = RotationBatch::kLanes, kChunk = 512;

struct RingArrays {
  const int *start, *neighbour;
  const double *weight, *rest, *now;
};

/// M of up to eight rings from `first` on, and Σ w (|e|² + |e⁰|²) of each.
BATTEN_CLONES void local_step_chunk(const RingArrays& ring_arrays, int first, int count,
                                    double (*M)[kLanes], double* squares) {
  for (int l = 0; l < count; ++l) {
    const int i = first + l;
    const double *p = ring_arrays.rest + 3L * i, *v = ring_arrays.now + 3L * i;
    double m[9] = {}, sum = 0;
    for (int k = ring_arrays.start[i]; k < ring_arrays.start[i + 1]; ++k) {
      const long j = 3L * ring_arrays.neighbour[k];
      const double w = ring_arrays.weight[k];
      const double a = ring_arrays.rest[j] - p[0], b = ring_arrays.rest[j + 1] - p[1],
                   c = ring_arrays.rest[j + 2] - p[2];
      const double x = ring_arrays.now[j] - v[0], y = ring_arrays.now[j + 1] - v[1],
                   z = ring_arrays.now[j + 2] - v[2];
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

BATTEN_CLONES void global_step_rhs_chunk(const RingArrays& ring_arrays, const double* rotations,
                                         int first, int last, double* loads) {
  for (int i = first; i < last; ++i) {
    const double *p = ring_arrays.rest + 3L * i, *R = rotations + 9L * i;
    double sum[3] = {};
    for (int k = ring_arrays.start[i]; k < ring_arrays.start[i + 1]; ++k) {
      const int j = ring_arrays.neighbour[k];
      const double w = ring_arrays.weight[k], *S = rotations + 9L * j,
                   *q = ring_arrays.rest + 3L * j;
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

double local_step(const NodeGraph& graph, const RowPoints& rest, const RowPoints& now,
                  const std::vector<char>& is_prescribed, std::vector<Mat3>& rotations,
                  std::vector<double>& parts) {
  const RingArrays ring_arrays{graph.start.data(), graph.neighbour.data(), graph.weight.data(),
                               rest.data(), now.data()};
  parts.assign(graph.nodes / kChunk + 1, 0);
  parallel_chunks<kChunk>(graph.nodes, [&](long begin, long end) {
    double energy = 0;
    RotationBatch M, R;
    double squares[kLanes];
    for (long first = begin; first < end; first += kLanes) {
      const int count = static_cast<int>(std::min<long>(kLanes, end - first));
      for (auto& entry : M.a)
        for (double& lane : entry) lane = 0;
      M.a[0][0] = 1;  // lanes past the end hold something regular
      local_step_chunk(ring_arrays, static_cast<int>(first), count, M.a, squares);
      nearest_rotations(M, R);
      for (int l = 0; l < count; ++l) {
        const long i = first + l;
        const Mat3 m = M.get(l);
        if (is_prescribed.empty() || !is_prescribed[i])
          rotations[i] = on_one_line(m)
                             ? nearest_rotation(m * rotations[i].transpose()) * rotations[i]
                             : R.get(l);
        energy += squares[l] - 2 * rotations[i].cwiseProduct(m).sum();
      }
    }
    parts[begin / kChunk] = energy;
  });
  double total = 0;
  for (const double part : parts) total += part;
  return total;
}

void global_step_rhs(const NodeGraph& graph, const RowPoints& rest,
                     const std::vector<Mat3>& rotations, RowPoints& loads) {
  const RingArrays ring_arrays{graph.start.data(), graph.neighbour.data(), graph.weight.data(),
                               rest.data(), nullptr};
  const double* R = graph.nodes > 0 ? rotations.front().data() : nullptr;
  parallel_chunks<kChunk>(graph.nodes, [&](long first, long last) {
    global_step_rhs_chunk(ring_arrays, R, static_cast<int>(first), static_cast<int>(last),
                          loads.data());
  });
}

}  // namespace batten
