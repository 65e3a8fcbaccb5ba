// Measures faces of a STEP file that was read back against their regions. Internal.
#pragma once

#include <TopoDS_Face.hxx>
#include <map>
#include <vector>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "batten/io/step/face_maker.h"
#include "batten/io/step/step_report.h"
#include "batten/io/step/tangent_joins.h"
#include "batten/core/parallel.h"

namespace batten {

/// A face beside a piece of a line, at even places along it.
struct JoinNormals {
  std::string region;
  std::vector<Vec3> of_face;  ///< not normalised; zero where the surfaces meet at an angle
  std::vector<Vec3> of_surface,
      target_normals;  ///< normals of the surface, and those that both faces are to have
};
using FaceNormals = std::map<LineSegmentId, JoinNormals>;

/// Measures a face of the file against the region that it was made of, all of `patch` but its names
/// and poles. Returns its normals along smooth joins; the plan says which piece of a line a stretch is.
FaceNormals measure_face(const TopoDS_Face& face, const FaceMaker& made, const StepPlan& plan,
                         StepPatch& patch);

/// Whether an analytic face is as large as its region, and so the part of its surface that it should be.
bool has_area_of_region(const TopoDS_Face& face, const FaceMaker& made);

/// The same normals of the last fit, before there is a file; before there is a fit those of an analytic face,
/// or of the surface.
FaceNormals normals_of_fit(const FaceMaker& made, const StepPlan& plan);
FaceNormals normals_before_fit(const FaceMaker& made, const StepPlan& plan);

/// The joins between faces, by line. Where a side is no fitted face, the angle is
/// that from the normals that were wanted.
std::vector<StepJoin> joins_between(const std::vector<FaceNormals>& faces, double join_deg);

/// The largest angle across the joins of each face that miss `join_deg`, degrees, as far as a better face
/// could mend it: what the other face alone is off by, farther than that from the wanted normal, does
/// not count. 0: nothing is missed.
std::vector<double> correctable_angles(const std::vector<FaceNormals>& faces, double join_deg);

/// The largest angle of each face from the normals that are wanted along its joins, degrees, wherever the
/// surfaces meet by `join_deg` at most: what it misses alone, however good the other face is.
std::vector<double> angles_from_target(const std::vector<FaceNormals>& faces, double join_deg);


// Points of a region and of a fitted face, at which the two are compared. Internal.

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
