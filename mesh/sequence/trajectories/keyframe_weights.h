// SPDX-License-Identifier: MPL-2.0
// Interpolation of keyframes in time, especially of rotations.
//
// Rotations are interpolated by their logarithms (core/geometry.h), so the result is linear in the
// logarithms of the keyframes:
//
//     log R(t_k) = Σ_m w_km log R_m
//
// R_m are the rotations at the keyframes m. A frame k has at most four nonzero weights w_km. They
// depend only on the times of frames and keyframes, so all vertices have the same weights.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Interval of frames (0-based) that an edit influences. The edit changes only frames strictly
/// between `from` and `to`; these two frames and all frames outside the interval are unchanged.
/// Without `from`, the edit also changes the frames before the first keyframe (see
/// KeyframeExtrapolation); without `to`, those after the last keyframe.
struct InfluenceInterval {
  std::optional<int> from, to;
};

/// Extrapolation of an edit before its first keyframe and after its last one.
enum class KeyframeExtrapolation {
  None,   ///< the edit is constant, with zero slope at the first and last keyframe
  Linear  ///< the edit continues linearly, with the slope between the two nearest keyframes
};

/// Weights of cubic Hermite interpolation of keyframe values, for a list of times.
///
/// The slope at an inner keyframe is that of the parabola through it and its two neighbours
/// (non-uniform Catmull-Rom), so a keyframe affects two intervals on each side. Each end of the
/// influence interval (see InfluenceInterval) acts as a keyframe with value 0 and slope 0.
/// References: [Xu2007], section 5; [BarryGoldman1988] (slopes).
class KeyframeWeights {
 public:
  /// Weights of one frame. The interpolated value is Σ_j weights[j] · value[first + j] with 0 ≤ j <
  /// count, where value[m] is the value at keyframe m.
  struct Row {
    int first = 0, count = 0;
    std::array<double, 4> weights{};
  };

  /// Computes the weights for all `times` of frames. `from`, `to`: times of the ends of the
  /// influence interval, at which the edit is zero. Throws InputError if there are no keyframes,
  /// times do not ascend, or `from` is not before the first keyframe or `to` not after the last
  /// one. O(times).
  KeyframeWeights(std::span<const double> times, std::span<const double> keyframe_times,
                  KeyframeExtrapolation ends = KeyframeExtrapolation::None,
                  std::optional<double> from = {}, std::optional<double> to = {});
  /// Computes the weights for keyframes and an influence interval that are given as 0-based frames.
  /// `keyframes`: ascending. Throws the exceptions of the constructor, and InputError if a frame is
  /// out of range.
  static KeyframeWeights of_frames(std::span<const double> times, std::span<const int> keyframes,
                                   KeyframeExtrapolation ends = KeyframeExtrapolation::None,
                                   const InfluenceInterval& influence = {});

  int frame_count() const { return isize(rows_); }
  int keyframe_count() const { return keyframes_; }
  /// Interpolation weights of a frame. At a keyframe there is a single weight of 1.
  const Row& row(int frame) const { return rows_[frame]; }

 private:
  std::vector<Row> rows_;
  int keyframes_ = 0;
};

/// Frame numbers as times: 0, 1, …, frames - 1.
std::vector<double> frame_numbers(int frames);

/// The logarithm (rotation vector) of a rotation that is nearest to the rotation vector `previous`.
/// The logarithms of a rotation are (φ + 2πk) n with the axis n, the smallest angle φ and any
/// integer k (ties: smallest k). For rotations by less than 1e-12 rad, n is the direction of
/// `previous`.
Vec3 nearest_log(const Mat3& rotation, const Vec3& previous);

/// Continuous logarithms (rotation vectors) of a sequence of F rotations, F×3. The first one is
/// nearest to 0, each further one is nearest to the previous one; see nearest_log(). Consecutive
/// rotations must differ by less than half a turn.
Points unwrapped_logs(std::span<const Mat3> rotations);

/// Continuous rotation vectors of n vertices at K keyframes, as K matrices n×3. The rotation
/// vectors of each vertex are chosen by nearest_log() from keyframe to keyframe. Throws InputError
/// if the keyframes have different numbers of vertices. O(n K).
std::vector<Points> unwrapped_logs(const std::vector<std::vector<Mat3>>& rotations_at_keyframes);

/// Continuous rotation vectors of the n vertices of a mesh at K keyframes, as K matrices n×3.
/// Distant vertices may differ in their rotations by more than half a turn, as in a twisted bar. In
/// each manifold patch, the function starts from the vertex with the smallest rotation at the first
/// keyframe, whose rotation vectors are continuous from keyframe to keyframe. At each keyframe, the
/// rotation vectors of the other vertices are continuous from neighbour to neighbour, in
/// breadth-first order. All rotation vectors of a patch may be wrong by the same number of full
/// turns, which cannot be determined from rotations. Rotation vectors of vertices without triangles
/// are continuous from keyframe to keyframe. Throws InputError if the number of rotations at a
/// keyframe is not the number of vertices. O(n K).
std::vector<Points> unwrapped_logs(const std::vector<std::vector<Mat3>>& rotations_at_keyframes,
                                   const MeshTopology& topology);

/// Interpolates the rotation vectors of n vertices at one frame: `result` (n×3) is the sum of the
/// `logs` at the keyframes, with the weights of `row`. `result` is not reallocated if it has n
/// rows. O(n).
void interpolate_logs(const KeyframeWeights::Row& row, const std::vector<Points>& logs,
                      Points& result);

/// Interpolates the rotations at keyframes to all frames. `rotations`: one per keyframe; they are
/// reproduced bit-identically at the keyframes. Throws InputError if the numbers of rotations and
/// keyframes differ. O(frames + keyframes).
std::vector<Mat3> interpolated_rotations(const KeyframeWeights& weights,
                                         std::span<const Mat3> rotations);

}  // namespace batten
