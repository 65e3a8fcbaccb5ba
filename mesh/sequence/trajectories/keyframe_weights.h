// Rotations of all frames from those of keyframes.
//
// A rotation is interpolated by its logarithm (core/rotations.h), so that what a frame gets is
// linear in the keyframes' logarithms:
//
//     log R(t_k) = Σ_m w_km log R_m
//
// with at most four weights that depend on times only: the same ones serve every vertex of a mesh.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/containers.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Frames at which an edit has died away: before and at `from`, at and after `to`. None: it goes on
/// to that end of the sequence as it is at the nearest keyframe.
struct InfluenceInterval {
  std::optional<int> from, to;
};

/// How an edit goes on outside of its keyframes.
enum class KeyframeExtrapolation {
  None,   ///< constant; the slope at the first and the last keyframe is zero
  Linear  ///< straight on, with the slope between the two nearest keyframes
};

/// Weights of cubic Hermite splines through values at keyframes, for each of some times.
///
/// The slope at an inner keyframe is that of the parabola through it and its two neighbours
/// (Catmull-Rom for uneven times), so that an edit reaches two keyframes far. An end of the
/// influence is one more keyframe with the value 0 and the slope 0. Source: Xu et al. 2007, section
/// 5; Barry, Goldman 1988 (the slopes).
class KeyframeWeights {
 public:
  /// Σ_j weights[j] value[first + j], j < count.
  struct Row {
    int first = 0, count = 0;
    std::array<double, 4> weights{};
  };

  /// Throws InputError that names what is wrong: no keyframes, times that do not ascend, an end of
  /// the influence that is not outside of the keyframes. O(times).
  KeyframeWeights(std::span<const double> times, std::span<const double> keyframe_times,
                  KeyframeExtrapolation ends = KeyframeExtrapolation::None,
                  std::optional<double> from = {}, std::optional<double> to = {});
  /// The same with keyframes and influence as numbers of frames, ascending. Also throws InputError
  /// on a keyframe or end that is no frame.
  static KeyframeWeights of_frames(std::span<const double> times, std::span<const int> keyframes,
                                   KeyframeExtrapolation ends = KeyframeExtrapolation::None,
                                   const InfluenceInterval& influence = {});

  int frame_count() const { return isize(rows_); }
  int keyframe_count() const { return keyframes_; }
  /// At a keyframe itself: one weight, 1.
  const Row& row(int frame) const { return rows_[frame]; }

 private:
  std::vector<Row> rows_;
  int keyframes_ = 0;
};

/// 0, 1, … as times.
std::vector<double> frame_numbers(int frames);

/// Of all logarithms h n + k π n of a rotation (k whole: the signs of its quaternion, and full
/// turns) the one nearest to `previous`; of two, the one with the smaller k. A rotation by less
/// than 1e-12 has no axis of its own and takes that of `previous`.
Vec3 nearest_log(const Mat3& rotation, const Vec3& previous);

/// Logarithms of rotations in their order, each the nearest to the one before; the first to 0. F×3.
/// Two in a row must be less than half a turn apart to be followed.
Points unwrapped_logs(std::span<const Mat3> rotations);

/// Rotations of n vertices at K keyframes → K matrices n×3 of their logarithms, each vertex
/// followed through the keyframes. Throws InputError on different numbers of vertices. O(n K).
std::vector<Points> unwrapped_logs(const std::vector<std::vector<Mat3>>& rotations_at_keyframes);

/// The same where vertices far from each other turn by more than half a turn against each other, as
/// in a twisted bar: in each sheet of the mesh the vertex that turns least at the first keyframe is
/// followed through the keyframes, the others from neighbour to neighbour, breadth first. A whole
/// sheet may be off by full turns: rotations do not tell. Vertices without triangles are followed
/// by themselves. Also throws InputError on another number of rotations than vertices. O(n K).
std::vector<Points> unwrapped_logs(const std::vector<std::vector<Mat3>>& rotations_at_keyframes,
                                   const MeshTopology& topology);

/// result = Σ w_m logs_m: the logarithms at one frame, n×3. `result` keeps its memory when it has n
/// rows. O(n).
void interpolate_logs(const KeyframeWeights::Row& row, const std::vector<Points>& logs,
                      Points& result);

/// Rotations at all frames from those at keyframes, which come back to the last bit. Throws
/// InputError on another number of rotations than keyframes. O(frames + keyframes).
std::vector<Mat3> interpolated_rotations(const KeyframeWeights& weights,
                                         std::span<const Mat3> rotations);


// Curves of cubic pieces over increasing knots. Internal.

/// A C1 curve by its values and slopes at knots; beyond its ends it goes straight on.
class PiecewiseCubic {
 public:
  PiecewiseCubic() = default;
  PiecewiseCubic(std::vector<double> knots, Points values, Points slopes)
      : knots_(std::move(knots)), values_(std::move(values)), slopes_(std::move(slopes)) {}

  /// How an interpolating curve ends.
  enum class Ends {
    Natural,  ///< without curvature
    Flat      ///< with slope zero
  };
  /// The curve through one value a knot of least ∫ |x''|² du, which is C2. O(knots).
  static PiecewiseCubic through(std::vector<double> knots, const Points& values, Ends ends);
  /// The C2 curve of `spans` even pieces over [u_first, u_last] that comes nearest to values at u
  /// in the least-squares sense: uniform cubic B-splines. `u` ascends, at least once in every piece
  /// and spans + 3 times in all, first < last. O(values + spans).
  static PiecewiseCubic fitted(const std::vector<double>& u, const Points& values, int spans);

  const std::vector<double>& knots() const { return knots_; }
  Vec3 at(double u) const;
  Vec3 slope(double u) const;

 private:
  int piece(double u) const;
  std::vector<double> knots_;
  Points values_, slopes_;
};

}  // namespace batten
