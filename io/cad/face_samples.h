// Points of a region and of a fitted face, at which the two are compared. Internal.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "batten/core/parallel.h"
#include "batten/io/cad/face_maker.h"

namespace batten {

/// Largest of many values, computed on all threads.
template <class Function>
double largest(size_t count, const Function& value) {
  const int parts = static_cast<int>(std::min<size_t>(count, 64));
  std::vector<double> of(static_cast<size_t>(parts), 0.0);
  parallel_for(parts, [&](int p) {
    for (size_t i = count * p / parts; i < count * (p + 1) / parts; ++i) {
      const double found = value(i);
      of[p] =
          std::max(of[p], std::isfinite(found) ? found : std::numeric_limits<double>::infinity());
    }
  });
  return parts > 0 ? *std::max_element(of.begin(), of.end()) : 0;
}

/// Points of the region's surface, by triangles: n² of each.
std::vector<Vec2> points_of_region(const FaceMaker& made);

/// The knots of a surface in both directions, and which of their cells a border passes through.
class KnotCells {
 public:
  KnotCells(std::vector<double> u, std::vector<double> v)
      : u_(std::move(u)), v_(std::move(v)), passed_((u_.size() - 1) * (v_.size() - 1), 0) {}

  /// A piece of the border, short against the cells.
  void pass(const Vec2& a, const Vec2& b) {
    const auto [i0, i1] = range(u_, a.x(), b.x());
    const auto [j0, j1] = range(v_, a.y(), b.y());
    for (size_t i = i0; i <= i1; ++i)
      for (size_t j = j0; j <= j1; ++j) passed_[i * (v_.size() - 1) + j] = 1;
  }

  /// n² points of each cell that are inside: `near_border` tells of a point in a cell that
  /// the border passes, `elsewhere` of any other; neighbours that the border leaves alone are asked once.
  template <class NearBorder, class Elsewhere>
  std::vector<Vec2> points(const NearBorder& near_border, const Elsewhere& elsewhere) const {
    const int n = u_.size() * v_.size() > 10'000 ? 2 : 3;
    std::vector<Vec2> points;
    for (size_t i = 0; i + 1 < u_.size(); ++i) {
      enum { Unknown, In, Out } state = Unknown;
      for (size_t j = 0; j + 1 < v_.size(); ++j) {
        const bool passed = passed_[i * (v_.size() - 1) + j];
        if (passed)
          state = Unknown;
        else if (state == Unknown)
          state = elsewhere(at(i, j, 0.5, 0.5)) ? In : Out;
        for (int k = 0; k < n * n; ++k) {
          const Vec2 uv = at(i, j, (k / n + 0.5) / n, (k % n + 0.5) / n);
          if (passed ? near_border(uv) : state == In) points.push_back(uv);
        }
      }
    }
    return points;
  }

 private:
  Vec2 at(size_t i, size_t j, double s, double t) const {
    return {(1 - s) * u_[i] + s * u_[i + 1], (1 - t) * v_[j] + t * v_[j + 1]};
  }
  static std::pair<size_t, size_t> range(const std::vector<double>& knots, double a, double b) {
    const auto cell = [&](double x) {
      const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, x);
      return static_cast<size_t>(above - knots.begin()) - 1;
    };
    return {cell(std::min(a, b)), cell(std::max(a, b))};
  }

  std::vector<double> u_, v_;
  std::vector<char> passed_;
};

}  // namespace batten
