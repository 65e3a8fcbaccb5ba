// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/triangle_locator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/geometry.h"

namespace batten {
namespace {

// Tolerance: rounding may put a point of a shared edge slightly outside of both triangles.
constexpr double kHair = 1e-13;

}  // namespace

TriangleLocator::TriangleLocator(const ParametricMesh& mesh) : mesh_(mesh) {
  Box2 box(mesh.vertices()[0]);
  throw_if_cancelled();
  for (const auto& triangle : mesh.triangles())
    for (const int v : triangle)
      box.extend(mesh.image_near(mesh.vertices()[v], mesh.vertices()[triangle[0]]));
  low_ = box.min();
  // About two triangles per bucket.
  const Vec2 extent = box.sizes().cwiseMax(1e-300);
  cell_ = std::sqrt(extent.x() * extent.y() * 2 / mesh.triangle_count());
  cell_ = std::max(cell_, extent.maxCoeff() / 4096);
  columns_ = static_cast<int>(extent.x() / cell_) + 1;
  rows_ = static_cast<int>(extent.y() / cell_) + 1;

  std::vector<std::vector<int>> buckets(static_cast<size_t>(columns_) * rows_);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    poll_every<8192>(t);
    corners_.push_back(mesh.shape(t).vertex);
    const Box2 around = bounding_box(corners_.back());
    const Vec2 a = around.min(), b = around.max();
    for (int r = row(a.y()); r <= row(b.y()); ++r)
      for (int c = column(a.x()); c <= column(b.x()); ++c)
        buckets[static_cast<size_t>(r) * columns_ + c].push_back(t);
  }
  start_.push_back(0);
  for (const auto& bucket : buckets) {
    poll_every<32768>(isize(start_) - 1);
    triangles_.insert(triangles_.end(), bucket.begin(), bucket.end());
    start_.push_back(isize(triangles_));
  }
}

int TriangleLocator::column(double u) const {
  return static_cast<int>(std::clamp((u - low_.x()) / cell_, 0.0, columns_ - 1.0));
}
int TriangleLocator::row(double v) const {
  return static_cast<int>(std::clamp((v - low_.y()) / cell_, 0.0, rows_ - 1.0));
}

std::vector<int> TriangleLocator::near(const Vec2& low, const Vec2& high) const {
  std::vector<int> found;
  for (int r = row(low.y()); r <= row(high.y()); ++r)
    for (int c = column(low.x()); c <= column(high.x()); ++c) {
      const size_t bucket = static_cast<size_t>(r) * columns_ + c;
      found.insert(found.end(), triangles_.begin() + start_[bucket],
                   triangles_.begin() + start_[bucket + 1]);
    }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

Location TriangleLocator::locate(const Vec2& uv) const {
  const Vec2 p = mesh_.wrapped(uv);
  Found best = search(p, std::numeric_limits<double>::infinity());
  if (mesh_.period() > 0)
    for (const double shift : {mesh_.period(), -mesh_.period()}) {
      const Found other = search({p.x() + shift, p.y()}, best.distance);
      if (other.where.triangle < 0) continue;
      if (other.distance < best.distance || other.where.triangle < best.where.triangle)
        best = other;
    }
  return best.where;
}

// Lower bound of the distance, reduced by far more than its rounding error.
double TriangleLocator::distance_to_bucket(int row, int column, const Vec2& uv) const {
  const Vec2 corner = low_ + cell_ * Vec2(column, row);
  const Vec2 q = uv.cwiseMax(corner).cwiseMin(corner + Vec2(cell_, cell_));
  constexpr double slack = 1e-9;
  return (1 - slack) * (uv - q).norm() - slack * cell_;
}

bool TriangleLocator::misses(int triangle, const Vec2& uv) const {
  const auto& [a, b, c] = corners_[triangle];
  const Vec2 to_a = a - uv, to_b = b - uv, to_c = c - uv;
  const double of_c = cross(to_a, to_b), of_a = cross(to_b, to_c), of_b = cross(to_c, to_a);
  // The exact test has tolerance kHair; this test is less accurate, so its tolerance is larger.
  return std::min({of_a, of_b, of_c}) < -1e3 * kHair * (of_a + of_b + of_c);
}

TriangleLocator::Found TriangleLocator::search(const Vec2& uv, double nearest) const {
  Location best{-1, Vec3::Zero()};
  const auto look = [&](int t) {
    const TriangleShape shape = mesh_.shape(t);
    Vec3 L = shape.barycentric(uv);
    if (L.minCoeff() >= -kHair) {
      L = L.cwiseMax(0.0);
      best = {t, L / L.sum()};
      return true;
    }
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const Vec2 edge = shape.vertex[k] - shape.vertex[j];
      const double s = std::clamp((uv - shape.vertex[j]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
      const double distance = (shape.vertex[j] + s * edge - uv).norm();
      if (!(distance < nearest)) continue;
      nearest = distance;
      best = {t, Vec3::Zero()};
      best.L[j] = 1 - s;
      best.L[k] = s;
    }
    return false;
  };
  const int c0 = column(uv.x()), r0 = row(uv.y());
  const size_t own = static_cast<size_t>(r0) * columns_ + c0;
  for (int i = start_[own]; i < start_[own + 1]; ++i)
    if (!misses(triangles_[i], uv) && look(triangles_[i])) return {best, 0};
  // Outside of the mesh: search rings of buckets around the point, until nothing nearer can follow.
  for (int ring = 0; ring <= std::max(columns_, rows_); ++ring) {
    if (nearest <= (ring - 1) * cell_) break;
    for (int r = std::max(0, r0 - ring); r <= std::min(rows_ - 1, r0 + ring); ++r) {
      const int step = std::abs(r - r0) == ring ? 1 : 2 * ring;
      for (int c = c0 - ring; c <= std::min(columns_ - 1, c0 + ring); c += step) {
        if (c < 0) continue;
        if (!(distance_to_bucket(r, c, uv) < nearest)) continue;
        const size_t bucket = static_cast<size_t>(r) * columns_ + c;
        for (int i = start_[bucket]; i < start_[bucket + 1]; ++i)
          if (look(triangles_[i])) return {best, 0};
      }
    }
  }
  return {best, nearest};
}

}  // namespace batten
