// SPDX-License-Identifier: MPL-2.0
// Measures the faces of a STEP file that was read back against their model faces.
#pragma once

#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "batten/core/parallel.h"
#include "batten/io/step/face_maker.h"
#include "batten/io/step/step_report.h"
#include "batten/io/step/tangent_joins.h"

namespace batten {

/// Normals of one face along a piece of a curve, at evenly spaced parameters.
struct JoinNormals {
  std::string region;
  std::vector<Vec3> of_face;  ///< not normalised; zero where the surfaces meet at an angle
  std::vector<Vec3> of_surface,
      target_normals;  ///< unit normals of the surface, and the common target normals of both faces
};
/// The normals of one face along its smooth joins, by piece of curve.
using FaceNormals = std::map<LineSegmentId, JoinNormals>;

/// Measures a face of the file against the model face it was made from. Sets all of `patch` except
/// names and poles. Returns the normals of the face along smooth joins. `plan` identifies the
/// pieces of curves.
FaceNormals measure_face(const TopoDS_Face& face, const FaceMaker& made, const StepPlan& plan,
                         StepPatch& patch);

/// True if the area of an analytic face equals that of its model face within 1 %. Otherwise the
/// face is the wrong part of its surface.
bool has_area_of_region(const TopoDS_Face& face, const FaceMaker& made);

/// As measure_face(), but returns the normals of the last fit, before a file exists.
/// normals_before_fit() returns those of an analytic face, or of the model face's surface, before
/// there is a fit.
FaceNormals normals_of_fit(const FaceMaker& made, const StepPlan& plan);
FaceNormals normals_before_fit(const FaceMaker& made, const StepPlan& plan);

/// The joins between faces, by curve. If one side has no fitted face, the angle is measured from
/// the target normals.
std::vector<StepJoin> joins_between(const std::vector<FaceNormals>& faces, double join_deg);

/// For each face, the largest angle at smooth joins that exceeds `join_deg` and that a better face
/// could reduce, in degrees. Errors of the other face alone (farther than `join_deg` from its
/// target normal) do not count. 0 if there is none.
std::vector<double> correctable_angles(const std::vector<FaceNormals>& faces, double join_deg);

/// For each face, the largest angle between its normals and the target normals along its joins, in
/// degrees. Points where the surfaces meet by more than `join_deg` are skipped. This is the error
/// of the face alone, whatever the other face does.
std::vector<double> angles_from_target(const std::vector<FaceNormals>& faces, double join_deg);

// Sample points at which a model face and its fitted face are compared.

/// The maximum of value(0) … value(count - 1), computed on all threads; non-finite values count as
/// infinity. 0 if count is 0.
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

/// Sample points of the model face's surface in (u, v): about n²/2 per triangle, those inside the
/// boundary.
std::vector<Vec2> points_of_region(const FaceMaker& made);

/// The grid of knot cells of a spline surface, with the cells that the boundary passes through.
class KnotCells {
 public:
  KnotCells(std::vector<double> u, std::vector<double> v)
      : u_(std::move(u)), v_(std::move(v)), passed_((u_.size() - 1) * (v_.size() - 1), 0) {}

  /// Marks the cells in the bounding box of a boundary piece, which must be short compared with the
  /// cells.
  void pass(const Vec2& a, const Vec2& b) {
    const auto [i0, i1] = range(u_, a.x(), b.x());
    const auto [j0, j1] = range(v_, a.y(), b.y());
    for (size_t i = i0; i <= i1; ++i)
      for (size_t j = j0; j <= j1; ++j) passed_[i * (v_.size() - 1) + j] = 1;
  }

  /// Sample points inside the boundary, n² per cell. `near_border` decides for each point in a
  /// marked cell, `elsewhere` once per run of unmarked cells.
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
