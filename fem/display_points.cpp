// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/display_points.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/core/simd.h"

namespace batten {
namespace {

constexpr int chunk = 4096;  // locations or rows per task

int parts_of(int count) { return (count + chunk - 1) / chunk; }

void require_inside(const Location& where, int place, int triangles) {
  const auto refuse = [&](const std::string& why) {
    throw InputError("display point " + std::to_string(place) + ": " + why);
  };
  if (where.triangle < 0 || where.triangle >= triangles)
    refuse("found triangle " + std::to_string(where.triangle) + ", expected 0 to " +
           std::to_string(triangles - 1));
  constexpr double rounding = 1e-9;
  if (!where.L.allFinite() || where.L.minCoeff() < -rounding ||
      std::abs(where.L.sum() - 1) > rounding)
    refuse("found barycentric coordinates " + format_number(where.L[0]) + ", " +
           format_number(where.L[1]) + ", " + format_number(where.L[2]) +
           ", expected a point inside of its triangle");
}

using Vector = double __attribute__((vector_size(32)));  // x, y, z, 0

struct Task {
  const int* numbers;
  const float* coefficients;
  const double* rows;  // 4 numbers each
  Vec3 shift;
  float *points, *normals;
};

// Evaluates locations from … to-1 of a group.
template <int vertices, int edges>
BATTEN_INLINE void evaluate_group(const Task& task, int from, int to) {
  constexpr int numbers = 1 + vertices + edges, parts = 3 * vertices - 1 + edges;
  const auto* rows = reinterpret_cast<const Vector*>(task.rows);
  const Vector shift = {task.shift.x(), task.shift.y(), task.shift.z(), 0};
  for (int p = from; p < to; ++p) {
    const int* number = task.numbers + static_cast<long>(numbers) * p;
    const float* c = task.coefficients + static_cast<long>(3 * parts) * p;
    const Vector first = rows[number[1]];
    Vector x = first + shift, x_u{}, x_v{};
    const auto add = [&](const Vector& q) __attribute__((always_inline)) {
      x += static_cast<double>(c[0]) * q;
      x_u += static_cast<double>(c[1]) * q;
      x_v += static_cast<double>(c[2]) * q;
      c += 3;
    };
    for (int i = 1; i < vertices; ++i) add(rows[number[1 + i]] - first);
    for (int i = 0; i < vertices; ++i) {
      add(rows[number[1 + i] + 1]);
      add(rows[number[1 + i] + 2]);
    }
    for (int i = 0; i < edges; ++i) add(rows[number[1 + vertices + i]]);

    const double a[3] = {x_u[1] * x_v[2] - x_u[2] * x_v[1], x_u[2] * x_v[0] - x_u[0] * x_v[2],
                         x_u[0] * x_v[1] - x_u[1] * x_v[0]};
    const double square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    const double uu = x_u[0] * x_u[0] + x_u[1] * x_u[1] + x_u[2] * x_u[2],
                 vv = x_v[0] * x_v[0] + x_v[1] * x_v[1] + x_v[2] * x_v[2];
    const double scale = square > 1e-12 * uu * vv ? 1 / std::sqrt(square) : 0;
    const long target = 3L * number[0];
    for (int k = 0; k < 3; ++k) {
      task.points[target + k] = static_cast<float>(x[k]);
      task.normals[target + k] = static_cast<float>(scale * a[k]);
    }
  }
}

BATTEN_CLONES void evaluate_vertices(const Task& task, int from, int to) {
  evaluate_group<1, 0>(task, from, to);
}
BATTEN_CLONES void evaluate_edges(const Task& task, int from, int to) {
  evaluate_group<2, 1>(task, from, to);
}
BATTEN_CLONES void evaluate_inside(const Task& task, int from, int to) {
  evaluate_group<3, 3>(task, from, to);
}

}  // namespace

DisplayPoints::DisplayPoints(const ParametricMesh& mesh, TriangleElement kind,
                             const std::vector<Location>& where)
    : count_(isize(where)), dof_count_(DofMap(mesh).count()) {
  const DofMap dofs(mesh);
  for (int p = 0; p < count_; ++p) {
    poll_every<4096>(p);
    const auto& [t, L] = where[p];
    require_inside(where[p], p, mesh.triangle_count());
    // Barycentric coordinates that are exactly 0 identify a vertex or an edge. Dofs that are left
    // out there have zero coefficients (c1_triangle.h).
    std::array<int, 3> ends{};
    int count = 0;
    for (int i = 0; i < 3; ++i)
      if (L[i] != 0) ends[count++] = i;
    Group& group = groups_[count - 1];
    ++group.count;
    group.numbers.push_back(p);
    for (int i = 0; i < count; ++i)
      group.numbers.push_back(dofs.vertex(mesh.triangles()[t][ends[i]]));
    std::vector<int> local;  // edges whose normal derivative contributes
    if (count == 2) local = {3 - ends[0] - ends[1]};
    if (count == 3) local = {0, 1, 2};
    for (const int e : local) group.numbers.push_back(dofs.edge(mesh.edges_of(t)[e]));

    const Tabulation N = C1Triangle(kind, mesh.shape(t)).evaluate(L);
    const auto add = [&](int a) {
      for (const Derivative d : {kW, kU, kV})
        group.coefficients.push_back(static_cast<float>(N(a, d)));
    };
    for (int i = 1; i < count; ++i) add(3 * ends[i]);
    for (int i = 0; i < count; ++i)
      for (const int slope : {1, 2}) add(3 * ends[i] + slope);
    for (const int e : local) add(9 + e);
  }
  rows_.resize(static_cast<size_t>(dof_count_));
}

void DisplayPoints::evaluate(const Points& x, const Vec3& shift, float* points,
                             float* normals) const {
  if (x.rows() != dof_count_)
    throw InputError("display points: found " + std::to_string(x.rows()) + " dofs, expected " +
                     std::to_string(dof_count_) + " of the mesh");
  const auto interleave = [&](int part) {
    const int to = std::min(dof_count_, (part + 1) * chunk);
    for (int i = part * chunk; i < to; ++i) rows_[i] = {{x(i, 0), x(i, 1), x(i, 2), 0}};
  };
  parallel_for(parts_of(dof_count_), std::ref(interleave));

  using Evaluate = void (*)(const Task&, int, int);
  constexpr Evaluate evaluate_kind[] = {evaluate_vertices, evaluate_edges, evaluate_inside};
  const auto evaluate_part = [&](int part) {
    for (size_t g = 0; g < groups_.size(); ++g) {
      const Group& group = groups_[g];
      const int parts = parts_of(group.count);
      if (part < parts) {
        const Task task{group.numbers.data(),
                        group.coefficients.data(),
                        rows_.front().xyz0,
                        shift,
                        points,
                        normals};
        evaluate_kind[g](task, part * chunk, std::min(group.count, (part + 1) * chunk));
        return;
      }
      part -= parts;
    }
  };
  int parts = 0;
  for (const Group& group : groups_) parts += parts_of(group.count);
  parallel_for(parts, std::ref(evaluate_part));
}

}  // namespace batten
