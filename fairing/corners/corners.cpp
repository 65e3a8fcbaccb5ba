// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/corners/corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/geometry.h"
#include "batten/fairing/corners/point_noise.h"

namespace batten {

// Likelihood-ratio test: do two polynomial arms that meet at a point fit noisy points significantly
// better than one smooth polynomial?

class CornerLikelihoodTest {
 public:
  /// Gain in χ² of two arms that meet at point `corner` (a row of `points`) over the best smooth
  /// curve.
  ///
  /// χ² is the sum of squared distances across the curve over the noise squared. The smooth curve
  /// is a polynomial in the point index, of up to the third degree against straight arms and up to
  /// the fifth against parabolic ones. The difference in χ² is divided by max(1, χ²/dof) of the
  /// arms. It is multiplied by the turning angle over 50 degrees (0.7 to 2), because noise seldom
  /// makes sharp turns.
  ///
  /// If the arms turn by more than 75 degrees, distances along the curve count too, relative to
  /// those along the arms: a curve that turns so far at one point is slow there, and the points are
  /// not.
  ///
  /// Returns 0 if the arms turn by `least_turn` degrees or less, fit badly themselves, or gain no
  /// more than `least`. Returns -1 if parabolic arms fit so badly that longer ones will too.
  /// `noise` > 0. The matrices of each size are cached: later calls cost O(points).
  double gain(const Points& points, int corner, double noise, double least_turn, double least = 0);

 private:
  struct Shape {
    MatX values, slopes, inverse;  // inverseᵀ points: the least-squares coefficients
  };
  struct Fit {
    double chi = 0;    // squared distances across the curve over the noise squared
    double along = 0;  // squared distances along it, also over the noise squared
    Points coefficients;
  };
  // Least-squares basis of polynomials up to `degree`. With corner ≥ 0: one polynomial on each side
  // of that point.
  const Shape& shape(int count, int corner, int degree);
  static Fit fit(const Shape& shape, const Points& points, double noise);
  // The part of the arms that no polynomial up to 2 degree + 1 can represent, as an orthonormal
  // basis with one column per function.
  const MatX& kinks(int count, int corner, int degree);
  // Upper bound of the decrease of χ² by kinks(), distances along the curve included.
  double max_gain(const Points& points, int corner, int degree, double noise);

  std::map<std::array<int, 3>, Shape> shapes_;
  std::map<std::array<int, 3>, MatX> kinks_;
  std::map<int, MatX> polynomials_;  // orthonormal, up to the fifth degree, by number of points
};

namespace {

constexpr int kFewPoints = 11;            // with at most this many points, noise cannot be
                                          // estimated
constexpr double kMinTurnFewPoints = 20;  // degrees, minimum for lists of few points
constexpr double kMinTurnAtEnd = 60;      // degrees, minimum if one side is a single chord
constexpr double kSharpTurn = 75;         // degrees, always a corner
constexpr double kPolygonTurn = 50;       // degrees; a closed list with this turning angle at every
                                          // point is a polygon
constexpr double kZigzagTurn = 25;        // degrees; a run that turns so much at each point, in
                                          // changing directions, is a zigzag
constexpr double kStarTurn = 20;          // degrees; the same for directions that alternate
constexpr double kUnevenTurn = 40;        // degrees, a corner if the adjacent chords have
constexpr double kUnevenRatio = 2.5;      // at least this length ratio
constexpr double kCertainGain = 24;       // gain that noise does not reach at some hundred
                                          // candidates
constexpr int kMaxArm = 60;               // points per arm
constexpr double kStandardErrors = 5;     // number of standard errors that counts as significant

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

// Points with cyclic indices if the list is closed.
class CyclicSequence {
 public:
  CyclicSequence(const std::vector<Vec3>& points, bool closed)
      : points_(points), closed_(closed), count_(isize(points)) {}
  int count() const { return count_; }
  bool closed() const { return closed_; }
  // True if index i exists.
  bool has(int i) const { return closed_ || (i >= 0 && i < count_); }
  bool inside(int i) const { return has(i - 1) && has(i + 1); }
  int number(int i) const { return ((i % count_) + count_) % count_; }
  const Vec3& at(int i) const { return points_[static_cast<size_t>(number(i))]; }
  double step(int i) const { return (at(i + 1) - at(i)).norm(); }
  double turning_angle(int i) const {
    return degrees_between(at(i) - at(i - 1), at(i + 1) - at(i));
  }
  // Axis of the turn at a point.
  Vec3 turn(int i) const { return (at(i) - at(i - 1)).cross(at(i + 1) - at(i)); }

 private:
  const std::vector<Vec3>& points_;
  bool closed_;
  int count_;
};

// Finds the corners of one list of points.
class CornerSearch {
 public:
  CornerSearch(const std::vector<Vec3>& points, bool closed, double angle)
      : points_(points), sequence_(points, closed), angle_(angle) {
    for (int i = 0; i < sequence_.count(); ++i)
      turning_angles_.push_back(sequence_.inside(i) ? sequence_.turning_angle(i) : 0);
    if (sequence_.count() > kFewPoints) noise_ = estimate_noise(points, closed);
  }

  std::vector<int> run() {
    std::vector<int> found;
    if (is_polygon()) {
      for (int i = 0; i < sequence_.count(); ++i)
        if (sequence_.inside(i)) found.push_back(i);
      return found;
    }
    if (sequence_.count() <= kFewPoints) return find_by_turning_angle();
    // Corners must not count as noise: it is estimated again without them.
    constexpr int max_rounds = 4;
    for (int round = 0; round < max_rounds; ++round) {
      if (round > 0) {
        const double before =
            std::exchange(noise_, estimate_noise(points_, sequence_.closed(), found));
        constexpr double same = 0.02;
        if (std::abs(noise_ - before) <= same * before) break;
      }
      const std::vector<int> again =
          is_noisy() ? find_in_noise(find_by_turning_angle()) : find_by_turning_angle();
      if (round > 0 && again == found) break;
      found = again;
    }
    return found;
  }

  // True if the list turns so much at every point that it can only be a polygon (closed lists), or
  // a zigzag.
  bool is_polygon() const {
    double least = 180;
    int changes = 0, inside = 0;
    for (int i = 0; i < sequence_.count(); ++i) {
      if (!sequence_.inside(i)) continue;
      ++inside;
      least = std::min(least, turning_angle_at(i));
      changes += changes_sense(i);
    }
    const bool alternates = changes > 1 && changes == inside - (sequence_.closed() ? 0 : 1);
    return inside > 2 &&
           ((sequence_.closed() && least >= kPolygonTurn && least > angle_) ||
            (changes > 1 && least > std::max(alternates ? kStarTurn : kZigzagTurn, angle_)));
  }

  // True if turns of `angle` between neighbouring chords may be noise.
  bool is_noisy() const {
    std::vector<double> steps;
    for (int i = 0; i + 1 < sequence_.count(); ++i) steps.push_back(sequence_.step(i));
    std::nth_element(steps.begin(), steps.begin() + steps.size() / 2, steps.end());
    return kStandardErrors * error_of_turn(steps[steps.size() / 2]) > angle_;
  }

 private:
  double error_of_turn(double step) const {
    return step > 0 ? degrees(noise_ * std::sqrt(6.0) / step) : 360;
  }

  // Turning angle at the neighbour of a point on one side, and its extrapolation to the point
  // itself. Negative: unknown.
  struct Beside {
    double turning_angle = -1, grown = -1;
  };
  Beside beside(int i, int side) const {
    if (!sequence_.inside(i + side)) return {};
    const double next = turning_angle_at(i + side);
    constexpr double none = 0.5, most_growth = 3;  // degrees; ratio
    if (!sequence_.inside(i + 2 * side) || next <= 2 * none) return {next, next};
    const double behind = std::max(turning_angle_at(i + 2 * side), none);
    return {next, next * std::clamp(next / behind, 1.0, most_growth)};
  }
  double turning_angle_at(int i) const {
    return turning_angles_[static_cast<size_t>(sequence_.number(i))];
  }

  // True if the list turns the other way at the point behind i.
  bool changes_sense(int i) const {
    if (!sequence_.inside(i + 1)) return false;
    const Vec3 here = sequence_.turn(i), next = sequence_.turn(i + 1);
    return here.dot(next) < -0.5 * here.norm() * next.norm();
  }

  // Adds the points of zigzags: runs of three points or more that turn by more than kZigzagTurn
  // each, and more than noise explains, with two changes of direction or more.
  void add_zigzags(std::vector<int>& found) const {
    const int n = sequence_.count();
    const auto turns = [&](int i) {
      if (!sequence_.inside(i)) return false;
      const double error = error_of_turn(std::min(sequence_.step(i - 1), sequence_.step(i)));
      return turning_angle_at(i) >
             std::max({kZigzagTurn, angle_, kStandardErrors * error});
    };
    // A run may cross the seam of a closed list: start behind a point that belongs to none.
    int start = 0;
    while (start < n && turns(start)) ++start;
    for (int i = start; i < start + n;) {
      int end = i, changes = 0;
      for (; end < start + n && turns(end); ++end)
        changes += turns(end + 1) && changes_sense(end);
      if (end - i > 2 && changes > 1)
        for (int k = i; k < end; ++k) found.push_back(sequence_.number(k));
      i = end + 1;
    }
    found = sorted_unique(std::move(found));
  }

  bool is_corner(int i) const {
    const double before = sequence_.step(i - 1), after = sequence_.step(i);
    const double error = error_of_turn(std::min(before, after));
    const bool is_short = sequence_.count() <= kFewPoints;
    const double turning_angle = turning_angle_at(i);
    if (turning_angle <=
        std::max(is_short ? std::max(angle_, kMinTurnFewPoints) : angle_, kStandardErrors * error))
      return false;
    const Beside left = beside(i, -1), right = beside(i, 1);
    const double next = std::max(left.turning_angle, right.turning_angle),
                 grown = std::max(left.grown, right.grown);
    // Towards the nose of an airfoil the turning angles grow from both sides.
    const bool nose =
        std::min(left.grown, right.grown) > 0.8 * turning_angle && next < 0.5 * turning_angle;
    if (turning_angle > kSharpTurn) return !nose;
    if (ends_in_nose(i)) return false;
    const auto [less, more] = std::minmax(before, after);
    if (turning_angle - kStandardErrors * error > kUnevenTurn && more > kUnevenRatio * less)
      return true;
    if (next < 0) return false;
    if (is_short && std::min(left.turning_angle, right.turning_angle) < 0 &&
        turning_angle < kMinTurnAtEnd)
      return false;
    return turning_angle > std::max((is_short ? 3 : 2.2) * next, 1.2 * grown) &&
           turning_angle - grown > kStandardErrors * error;
  }

  // True if i is next to an end and the turning angles grow steadily towards it: half of an airfoil
  // section, which ends at its nose.
  bool ends_in_nose(int i) const {
    const int side = !sequence_.inside(i - 1) ? 1 : -1;
    if (sequence_.inside(i - side)) return false;
    constexpr int places = 4;
    constexpr double growth = 1.2, none = 0.5;  // degrees
    for (int k = 0; k + 1 < places; ++k) {
      if (!sequence_.inside(i + side * (k + 1))) return false;
      const double here = turning_angle_at(i + side * k),
                   behind = turning_angle_at(i + side * (k + 1));
      if (behind < none || here < growth * behind) return false;
    }
    return true;
  }

  std::vector<int> find_by_turning_angle() const {
    std::vector<int> found;
    for (int i = 0; i < sequence_.count(); ++i)
      if (sequence_.inside(i) && is_corner(i)) found.push_back(i);
    add_zigzags(found);
    return found;
  }

  // Adds corners found by the likelihood test, the most significant first. Arms end at corners
  // found so far.
  std::vector<int> find_in_noise(std::vector<int> found) {
    struct ArmGain {
      int before, behind;
      double gain;
    };
    std::map<int, ArmGain> gains;
    if (likely_.empty()) find_likely();
    for (;;) {
      int best = -1;
      double most = kCertainGain;
      for (int i = 0; i < sequence_.count(); ++i) {
        const int before = reach(i, -1, found), behind = reach(i, 1, found);
        constexpr int fewest = 2;
        if (before < fewest || behind < fewest) continue;
        ArmGain& t = gains.try_emplace(i, ArmGain{-1, -1, 0}).first->second;
        if (t.before != before || t.behind != behind)
          t = {before, behind, gain_at(i, before, behind, false)};
        if (t.gain > most) {
          most = t.gain;
          best = i;
        }
      }
      if (best < 0) return found;
      best = refined(best, found);
      found.insert(std::upper_bound(found.begin(), found.end(), best), best);
    }
  }

  // The best corner near one that long arms have found.
  int refined(int i, const std::vector<int>& found) {
    int best = i;
    double most = 0;
    for (int k = i - stride(kMaxArm); k <= i + stride(kMaxArm); ++k) {
      if (!sequence_.inside(k)) continue;
      const int before = reach(sequence_.number(k), -1, found),
                behind = reach(sequence_.number(k), 1, found);
      const double gain = gain_at(sequence_.number(k), before, behind, true);
      if (gain > most) {
        most = gain;
        best = sequence_.number(k);
      }
    }
    return best;
  }

  // Number of points from i to the next corner or end, at most kMaxArm.
  int reach(int i, int side, const std::vector<int>& found) const {
    int k = 0;
    while (
        k < kMaxArm && k < sequence_.count() / 2 && sequence_.has(i + side * (k + 1)) &&
        (k == 0 || !std::binary_search(found.begin(), found.end(), sequence_.number(i + side * k))))
      ++k;
    return std::binary_search(found.begin(), found.end(), i) ? 0 : k;
  }

  // Next arm length to be tried.
  static int longer(int m) { return m + std::max(1, m / 4); }
  // Spacing of the candidates for arms of m points; long arms detect a corner even from a distance.
  static int stride(int m) { return std::max(1, m / 6); }

  // Marks, for each arm length, the points that may be corners: the least-squares lines through
  // both arms turn by at least half of the angle, and by nearly as much as anywhere nearby.
  void find_likely() {
    likely_.clear();
    const int n = sequence_.count(), margin = sequence_.closed() ? kMaxArm : 0;
    std::vector<Vec3> sum(1, Vec3::Zero()), moment = sum;  // prefix sums of the points and of index
                                                           // times point
    for (int k = -margin; k < n + margin; ++k) {
      sum.push_back(sum.back() + sequence_.at(k) - sequence_.at(0));
      moment.push_back(moment.back() + k * (sequence_.at(k) - sequence_.at(0)));
    }
    const auto direction = [&](int from, int to) -> Vec3 {
      const int first = from + margin, last = to + margin + 1;
      const auto a = static_cast<size_t>(first), b = static_cast<size_t>(last);
      return moment[b] - moment[a] - 0.5 * (from + to) * (sum[b] - sum[a]);
    };
    for (int m = 2; m <= std::min(kMaxArm, n / 2); m = longer(m)) {
      std::vector<double> turning_angle(static_cast<size_t>(n));
      for (int i = 0; i < n; ++i) {
        const int first = sequence_.closed() ? m : std::min(m, i),
                  last = sequence_.closed() ? m : std::min(m, n - 1 - i);
        if (first > 0 && last > 0)
          turning_angle[static_cast<size_t>(i)] =
              degrees_between(direction(i - first, i), direction(i, i + last));
      }
      std::vector<char>& likely = likely_.emplace_back(turning_angle.size());
      constexpr double nearly = 0.8;
      for (int i = 0; i < n; ++i) {
        const double here = turning_angle[static_cast<size_t>(i)];
        bool most = here >= 0.5 * angle_;
        for (int k = -m / 2; k <= m / 2 && most; ++k)
          if (sequence_.has(i + k))
            most = here >= nearly * turning_angle[static_cast<size_t>(sequence_.number(i + k))];
        likely[static_cast<size_t>(i)] = most;
      }
    }
  }

  double gain_at(int i, int before, int behind, bool every_place) {
    double best = 0;
    size_t size = 0;
    for (int m = 2; m <= std::max(before, behind); m = longer(m)) {
      if (!likely_.at(size++)[static_cast<size_t>(i)]) continue;
      if (!every_place && i % stride(m) != 0) continue;
      const int first = std::min(m, before), last = std::min(m, behind);
      Points near(first + last + 1, 3);
      for (int k = -first; k <= last; ++k) near.row(k + first) = sequence_.at(i + k);
      const double gain = arms_.gain(near, first, noise_, angle_, std::max(best, kCertainGain));
      if (gain < 0) break;
      best = std::max(best, gain);
    }
    return best;
  }

  const std::vector<Vec3>& points_;
  CyclicSequence sequence_;
  double angle_, noise_ = 0;
  std::vector<double> turning_angles_;
  std::vector<std::vector<char>> likely_;  // indexed by arm length and point
  CornerLikelihoodTest arms_;
};

// Skips points that nearly coincide with the previous one: their chords have no reliable direction.
std::vector<int> distinct(const std::vector<Vec3>& points) {
  std::vector<int> kept;
  const int n = isize(points);
  constexpr double a_part = 0.05;
  std::vector<double> steps;
  for (int i = 0; i + 1 < n; ++i) steps.push_back((points[i + 1] - points[i]).norm());
  for (int i = 0; i < n; ++i) {
    if (i > 0 && n > 3) {
      const double around =
          std::min(i > 1 ? steps[i - 2] : steps[i], i + 1 < n ? steps[i] : steps[i - 2]);
      if (steps[i - 1] < a_part * around) continue;
    }
    kept.push_back(i);
  }
  return kept;
}

}  // namespace

std::vector<int> find_corners(const std::vector<Vec3>& points, bool closed, double angle,
                              int block_size) {
  if (points.size() < 3 || angle >= 180) return {};
  const std::vector<int> kept = distinct(points);
  std::vector<Vec3> row;
  for (const int i : kept) row.push_back(points[i]);
  std::vector<int> corners;
  constexpr int most = 300;
  CornerSearch search(row, closed, angle);
  int each = block_size;
  if (search.is_noisy()) each = std::max(each, static_cast<int>((row.size() + most - 1) / most));
  std::vector<int> found;
  if (each > 1) {
    const std::vector<Vec3> some = block_means(row, each);
    for (const int c : CornerSearch(some, closed, angle).run())
      found.push_back(static_cast<int>((c + 0.5) * isize(row) / isize(some)));
  } else {
    found = search.run();
  }
  for (const int c : found) corners.push_back(kept[c]);
  return corners;
}

namespace {

// Orthogonalises a column against orthonormal ones and normalises it.
void orthonormalize(const Eigen::Ref<const MatX>& Q, Eigen::Ref<VecX> column) {
  for (long k = 0; k < Q.cols(); ++k) column -= Q.col(k).dot(column) * Q.col(k);
  const double size = column.norm();
  if (size > 0) column /= size;
}

}  // namespace

const CornerLikelihoodTest::Shape& CornerLikelihoodTest::shape(int count, int corner, int degree) {
  const auto [found, added] = shapes_.try_emplace({count, corner, degree});
  Shape& s = found->second;
  if (!added) return s;
  const bool arms = corner >= 0;
  const int columns = arms ? 1 + 2 * degree : 1 + degree;
  s.values = MatX::Zero(count, columns);
  s.slopes = MatX::Zero(count, columns);
  for (int i = 0; i < count; ++i) {
    const double x = (arms ? i - corner : i - 0.5 * (count - 1)) / (0.5 * count);
    s.values(i, 0) = 1;
    double power = 1;
    for (int d = 1; d <= degree; ++d) {
      const int column = arms && i > corner ? degree + d : d;
      s.slopes(i, column) = d * power;
      power *= x;
      s.values(i, column) = power;
    }
  }
  // At most six columns over [-1, 1]: the normal equations keep enough digits.
  s.inverse =
      solve_symmetric(s.values.transpose().lazyProduct(s.values), s.values.transpose()).transpose();
  return s;
}

CornerLikelihoodTest::Fit CornerLikelihoodTest::fit(const Shape& shape, const Points& points,
                                                    double noise) {
  Fit fit;
  fit.coefficients.resize(shape.values.cols(), 3);
  Points off = points, velocity = Points::Zero(points.rows(), 3);
  // By columns: the overhead of Eigen's kernels for large products would exceed these products.
  for (long c = 0; c < shape.values.cols(); ++c)
    for (int k = 0; k < 3; ++k) {
      const double x = shape.inverse.col(c).dot(points.col(k));
      fit.coefficients(c, k) = x;
      off.col(k) -= x * shape.values.col(c);
      velocity.col(k) += x * shape.slopes.col(c);
    }
  for (long i = 0; i < points.rows(); ++i) {
    const double along = velocity.row(i).squaredNorm();
    const double part = along > 0 ? std::pow(off.row(i).dot(velocity.row(i)), 2) / along : 0;
    fit.chi += (off.row(i).squaredNorm() - part) / (noise * noise);
    fit.along += part / (noise * noise);
  }
  return fit;
}

const MatX& CornerLikelihoodTest::kinks(int count, int corner, int degree) {
  const auto [found, added] = kinks_.try_emplace({count, corner, degree});
  MatX& H = found->second;
  if (!added) return H;
  const int highest = std::min(2 * degree + 1, count - 2);
  const auto [known, is_new] = polynomials_.try_emplace(count);
  MatX& Q = known->second;
  if (is_new) {
    Q.resize(count, std::min(6, count - 1));
    for (int i = 0; i < count; ++i) {
      double power = 1;
      for (long d = 0; d < Q.cols(); ++d) {
        Q(i, d) = power;
        power *= (i - 0.5 * (count - 1)) / (0.5 * count);
      }
    }
    for (long d = 0; d < Q.cols(); ++d) orthonormalize(Q.leftCols(d), Q.col(d));
  }
  H.resize(count, degree);
  for (int i = 0; i < count; ++i) {
    const double x = (i - corner) / (0.5 * count);
    H(i, 0) = std::abs(x);
    if (degree == 2) H(i, 1) = x * std::abs(x);
  }
  for (int d = 0; d < degree; ++d) {
    orthonormalize(Q.leftCols(highest + 1), H.col(d));
    orthonormalize(H.leftCols(d), H.col(d));
  }
  return H;
}

double CornerLikelihoodTest::max_gain(const Points& points, int corner, int degree, double noise) {
  const MatX& H = kinks(static_cast<int>(points.rows()), corner, degree);
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    for (int d = 0; d < degree; ++d) sum += std::pow(H.col(d).dot(points.col(k)), 2);
  return sum / (noise * noise);
}

double CornerLikelihoodTest::gain(const Points& points, int corner, double noise, double least_turn,
                                  double least) {
  const auto count = static_cast<int>(points.rows());
  double best = least;
  constexpr double sharpest = 2, slack = 1.15, few = 1;
  for (const int degree : {1, 2}) {
    const int dof = count - 1 - 2 * degree;
    if (dof < 2) continue;
    // Distances across the curve alone may gain a little more than the bound.
    if (sharpest * (slack * max_gain(points, corner, degree, noise) + few) <= best) continue;
    const Fit arms = fit(shape(count, corner, degree), points, noise);
    const double good = 1.3 * dof + 3 * std::sqrt(2.0 * dof);
    if (degree == 2 && arms.chi > 2 * good) return -1;
    if (arms.chi > good) continue;
    const Vec3 before = arms.coefficients.row(1), behind = arms.coefficients.row(degree + 1);
    const double turning_angle = degrees_between(before, behind);
    if (!(turning_angle > least_turn)) continue;
    const double sharpness = std::clamp(turning_angle / 50, 0.7, sharpest);
    constexpr double sharp = 75;
    const double of_along = turning_angle > sharp ? 1 / std::max(1.0, arms.along / dof) : 0;
    const auto misfit = [&](const Fit& fit) { return fit.chi + of_along * fit.along; };
    double gain = std::numeric_limits<double>::infinity();
    // Higher degrees can only reduce the gain.
    for (int d = degree + 1; d <= 2 * degree + 1 && d < count - 1 && gain > best; ++d)
      gain = std::min(gain, sharpness *
                                (misfit(fit(shape(count, -1, d), points, noise)) - misfit(arms)) /
                                std::max(1.0, arms.chi / dof));
    if (std::isfinite(gain)) best = std::max(best, gain);
  }
  return best > least ? best : 0;
}

}  // namespace batten
