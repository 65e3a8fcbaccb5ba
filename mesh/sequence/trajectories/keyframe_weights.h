// Interpolation of keyframes in time, especially of rotations, and C1 piecewise cubic curves.
//
// Rotations are interpolated by their logarithms (core/geometry.h), so the result is linear in the
// logarithms of the keyframes:
//
//     log R(t_k) = Σ_m w_km log R_m
//
// There are at most four weights per frame. They depend on times only, so all vertices share them.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Interval of influence of an edit: the edit is zero up to frame `from` and from frame `to` on
/// (0-based). Empty: the edit of the nearest keyframe extends to that end of the sequence.
struct InfluenceInterval {
  std::optional<int> from, to;
};

/// Extrapolation of an edit beyond its first and last keyframe.
enum class KeyframeExtrapolation {
  None,   ///< constant, with zero slope at the first and last keyframe
  Linear  ///< linear, with the slope between the two nearest keyframes
};

/// Weights of cubic Hermite interpolation of keyframe values, for a list of times.
///
/// The slope at an inner keyframe is that of the parabola through it and its two neighbours
/// (non-uniform Catmull-Rom), so a keyframe affects two intervals on each side. An end of the
/// influence interval acts as a keyframe with value 0 and slope 0. Sources: [Xu2007], section 5;
/// [BarryGoldman1988] (slopes).
class KeyframeWeights {
 public:
  /// Weights of one time: the interpolated value is Σ_j weights[j] value[first + j], j < count.
  struct Row {
    int first = 0, count = 0;
    std::array<double, 4> weights{};
  };

  /// Computes the weights for all `times`. `from`, `to`: ends of the influence interval. Throws
  /// InputError: no keyframes, times that do not ascend, an end of the influence interval that is
  /// not outside the keyframes. O(times).
  KeyframeWeights(std::span<const double> times, std::span<const double> keyframe_times,
                  KeyframeExtrapolation ends = KeyframeExtrapolation::None,
                  std::optional<double> from = {}, std::optional<double> to = {});
  /// The same with keyframes and influence interval given as 0-based frames, ascending. Also throws
  /// InputError for frames out of range.
  static KeyframeWeights of_frames(std::span<const double> times, std::span<const int> keyframes,
                                   KeyframeExtrapolation ends = KeyframeExtrapolation::None,
                                   const InfluenceInterval& influence = {});

  int frame_count() const { return isize(rows_); }
  int keyframe_count() const { return keyframes_; }
  /// Weights of a frame. At a keyframe it is a single weight of 1.
  const Row& row(int frame) const { return rows_[frame]; }

 private:
  std::vector<Row> rows_;
  int keyframes_ = 0;
};

/// The times 0, 1, …, frames - 1.
std::vector<double> frame_numbers(int frames);

/// Logarithm (rotation vector) of a rotation that is nearest to `previous`. All logarithms are
/// (φ + 2 π k) n with the axis n, the shortest angle φ and an integer k; ties go to the smaller k. A rotation by
/// less than 1e-12 has no axis of its own and takes that of `previous`.
Vec3 nearest_log(const Mat3& rotation, const Vec3& previous);

/// Continuous logarithms of a sequence of rotations, F×3. The first one is nearest to 0, each
/// further one nearest to its predecessor. Consecutive rotations must differ by less than half a
/// turn.
Points unwrapped_logs(std::span<const Mat3> rotations);

/// Rotation vectors of the rotations of n vertices at K keyframes, as K matrices n×3. Full turns are
/// chosen for each vertex so that its vectors are continuous from keyframe to keyframe. Throws InputError if the numbers of vertices differ. O(n K).
std::vector<Points> unwrapped_logs(const std::vector<std::vector<Mat3>>& rotations_at_keyframes);

/// The same for meshes with large relative rotations (more than half a turn between distant
/// vertices, as in a twisted bar). In each manifold patch the vertex with the smallest rotation at
/// the first keyframe is followed through the keyframes. The others are followed from neighbour to
/// neighbour in breadth-first order. A whole patch may be off by full turns, which rotations alone
/// cannot determine. Vertices without triangles are followed independently. Also throws InputError
/// if the number of rotations is not the number of vertices. O(n K).
std::vector<Points> unwrapped_logs(const std::vector<std::vector<Mat3>>& rotations_at_keyframes,
                                   const MeshTopology& topology);

/// Logarithms at one frame: result = Σ w_m logs_m, n×3. `result` is not reallocated if it has n
/// rows. O(n).
void interpolate_logs(const KeyframeWeights::Row& row, const std::vector<Points>& logs,
                      Points& result);

/// Interpolates rotations to all frames. Rotations at keyframes are reproduced to the last bit.
/// Throws InputError if the numbers of rotations and keyframes differ. O(frames + keyframes).
std::vector<Mat3> interpolated_rotations(const KeyframeWeights& weights,
                                         std::span<const Mat3> rotations);

// Piecewise cubic curves.

/// A C1 piecewise cubic curve, given by values and slopes at ascending knots. It is extended
/// linearly beyond its ends.
class PiecewiseCubic {
 public:
  PiecewiseCubic() = default;
  PiecewiseCubic(std::vector<double> knots, Points values, Points slopes)
      : knots_(std::move(knots)), values_(std::move(values)), slopes_(std::move(slopes)) {}

  /// End condition of an interpolating curve.
  enum class Ends {
    Natural,  ///< zero curvature
    Flat      ///< zero slope
  };
  /// The C2 curve of least ∫ |x''|² du through one value per knot (cubic spline). O(knots).
  static PiecewiseCubic through(std::vector<double> knots, const Points& values, Ends ends);
  /// Least-squares fit by uniform cubic B-splines: the C2 curve with `spans` uniform spans over
  /// [u_first, u_last] nearest to the values at u. `u` must ascend, with at least one entry per
  /// span, at least spans + 3 entries, and first < last. O(values + spans).
  static PiecewiseCubic fitted(const std::vector<double>& u, const Points& values, int spans);

  const std::vector<double>& knots() const { return knots_; }
  /// Value at u.
  Vec3 at(double u) const;
  /// Derivative at u.
  Vec3 slope(double u) const;

 private:
  int piece(double u) const;
  std::vector<double> knots_;
  Points values_, slopes_;
};

}  // namespace batten
