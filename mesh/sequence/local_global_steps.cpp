// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/local_global_steps.h"

#include <algorithm>
#include <cmath>

#include "batten/core/parallel.h"
#include "batten/core/simd.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

constexpr int kLanes = RotationBatch::kLanes, kNodesPerChunk = 512;

struct RingArrays {
  const int *start, *neighbour;
  const double *weight, *rest, *now;
};

/// M of up to eight rings, starting at node `first`, and Σ w (|e|² + |e⁰|²) of each.
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
      // Mat3 is stored by columns.
      sum[0] += (0.5 * (R[0] + S[0]) - 1) * a + 0.5 * ((R[3] + S[3]) * b + (R[6] + S[6]) * c);
      sum[1] += (0.5 * (R[4] + S[4]) - 1) * b + 0.5 * ((R[1] + S[1]) * a + (R[7] + S[7]) * c);
      sum[2] += (0.5 * (R[8] + S[8]) - 1) * c + 0.5 * ((R[2] + S[2]) * a + (R[5] + S[5]) * b);
    }
    for (int c = 0; c < 3; ++c) loads[3L * i + c] = sum[c];
  }
}

/// True if all edges of a ring are collinear, before or after: M has rank 1.
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
  parts.assign(graph.nodes / kNodesPerChunk + 1, 0);
  parallel_chunks<kNodesPerChunk>(graph.nodes, [&](long begin, long end) {
    double energy = 0;
    RotationBatch M, R;
    double squares[kLanes];
    for (long first = begin; first < end; first += kLanes) {
      const int count = static_cast<int>(std::min<long>(kLanes, end - first));
      for (auto& entry : M.a)
        for (double& lane : entry) lane = 0;
      M.a[0][0] = 1;  // unused lanes get a regular matrix
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
    parts[begin / kNodesPerChunk] = energy;
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
  parallel_chunks<kNodesPerChunk>(graph.nodes, [&](long first, long last) {
    global_step_rhs_chunk(ring_arrays, R, static_cast<int>(first), static_cast<int>(last),
                          loads.data());
  });
}

NodeGraph node_graph(const MeshTopology& topology, const std::vector<double>& weights) {
  NodeGraph graph;
  graph.nodes = topology.node_count();
  for (size_t e = 0; e < topology.edges().size(); ++e) {
    const auto& edge = topology.edges()[e];
    const int a = topology.node_of(edge.low), b = topology.node_of(edge.high);
    graph.edges.push_back({std::min(a, b), std::max(a, b), weights.empty() ? 1.0 : weights[e]});
  }
  std::sort(graph.edges.begin(), graph.edges.end(),
            [](const auto& e, const auto& f) { return std::pair(e.a, e.b) < std::pair(f.a, f.b); });
  size_t kept = 0;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const auto edge = graph.edges[e];
    if (kept > 0 && graph.edges[kept - 1].a == edge.a && graph.edges[kept - 1].b == edge.b) {
      if (!weights.empty()) graph.edges[kept - 1].weight += edge.weight;
    } else {
      graph.edges[kept++] = edge;
    }
  }
  graph.edges.resize(kept);
  graph.start.assign(graph.nodes + 1, 0);
  for (const auto& e : graph.edges) ++graph.start[e.a + 1], ++graph.start[e.b + 1];
  for (int i = 0; i < graph.nodes; ++i) graph.start[i + 1] += graph.start[i];
  graph.neighbour.resize(graph.start.back());
  graph.weight.resize(graph.start.back());
  std::vector<int> next(graph.start.begin(), graph.start.end() - 1);
  const auto add = [&](int from, int to, double w) {
    graph.neighbour[next[from]] = to;
    graph.weight[next[from]++] = w;
  };
  // Edges are sorted by (a, b), so neighbours ascend if the lower ones are entered first.
  for (const auto& e : graph.edges) add(e.b, e.a, e.weight);
  for (const auto& e : graph.edges) add(e.a, e.b, e.weight);
  return graph;
}

std::vector<Triplet> laplacian_entries(const NodeGraph& graph) {
  std::vector<Triplet> entries;
  entries.reserve(3 * graph.edges.size());
  for (const auto& e : graph.edges) {
    entries.emplace_back(e.a, e.a, e.weight);
    entries.emplace_back(e.b, e.b, e.weight);
    entries.emplace_back(e.b, e.a, -e.weight);
  }
  return entries;
}

namespace {

Vec3 at(const RowPoints& p, int v) { return p.row(v).transpose(); }

}  // namespace

double enclosed_volume(const std::vector<std::array<int, 3>>& triangles, const RowPoints& p) {
  if (triangles.empty()) return 0;
  const Vec3 from = at(p, triangles.front()[0]);  // relative to a node: far from the origin digits
                                                  // would be lost
  double sum = 0;
  for (const auto& t : triangles)
    sum += (at(p, t[0]) - from).dot((at(p, t[1]) - from).cross(at(p, t[2]) - from));
  return sum / 6;
}

void volume_gradient(const std::vector<std::array<int, 3>>& triangles, const RowPoints& p,
                     RowPoints& gradient) {
  gradient.setZero(p.rows(), 3);
  for (const auto& t : triangles) {
    // A third of the area vector: its sum over a closed fan does not depend on the origin.
    const Vec3 contribution = (at(p, t[1]) - at(p, t[0])).cross(at(p, t[2]) - at(p, t[0])) / 6;
    for (const int v : t) gradient.row(v) += contribution.transpose();
  }
}

}  // namespace batten
