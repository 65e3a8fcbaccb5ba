// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/smoothing_spline_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/corners/point_noise.h"
#include "batten/fairing/corners/point_sequence.h"

namespace batten {

SmoothingSplineSolver::SmoothingSplineSolver(const std::string& name,
                                             const std::vector<Vec3>& given,
                                             const PointSequence& row, const FairOptions& options)
    : name_(name), given_(given), sequence_(row), options_(options), count_(row.count()) {
  // Uneven spacing of exact points is no noise. The factor keeps the second estimate, whose weights
  // are noisy, from reducing the first one by chance.
  constexpr double by_chance = 2;
  noise_ = std::min(
      estimate_noise(row.points, row.closed, row.corners),
      by_chance * estimate_noise(row.points, row.closed, row.corners, row.averaged_chord()));
  begin();
}

// Initial parameters from chord lengths.
void SmoothingSplineSolver::begin() {
  u_ = sequence_.averaged_chord();
  length_ = u_.back();
  u_.resize(count_);
  wavelength_factor_ = {};
  at_.clear();
  max_knots_ = std::min(kMinKnots, count_);
  if (const CurveCondition* plane = symmetry()) centre(*plane);
}

// Adjusts the parameters so that the curve crosses the symmetry plane at half of its length; a
// closed curve also starts at the plane.
void SmoothingSplineSolver::centre(const CurveCondition& plane) {
  std::vector<double> crossings;
  for (int i = 0; i < (sequence_.closed ? count_ : count_ - 1); ++i) {
    const double a = signed_distance(plane, sequence_.points[i]),
                 b = signed_distance(plane, sequence_.points[(i + 1) % count_]);
    if ((a < 0) != (b < 0))
      crossings.push_back(sequence_.chord[i] +
                          (sequence_.chord[i + 1] - sequence_.chord[i]) * a / (a - b));
  }
  if (sequence_.closed && crossings.size() < 2)
    throw InputError("curve '" + name_ + "', condition '" + plane.name +
                     "': the closed curve does not intersect the plane of symmetry");
  const double first = sequence_.closed ? crossings.front() : 0;
  double middle = 0.5 * length_, distance = std::numeric_limits<double>::infinity();
  for (const double c : crossings) {
    const double u = c - first;
    if (u > 0 && std::abs(u - 0.5 * length_) < distance) {
      middle = u;
      distance = std::abs(u - 0.5 * length_);
    }
  }
  for (double& u : u_) {
    u -= first;
    if (u < 0) u += length_;
    u = u < middle ? u * 0.5 * length_ / middle
                   : length_ - (length_ - u) * 0.5 * length_ / (length_ - middle);
  }
}

// Parameters at which nodes are required.
std::vector<double> SmoothingSplineSolver::required_knots() {
  std::vector<double> forced = {0};
  for (const int c : sequence_.corners) forced.push_back(u_[c]);
  const bool searched = !at_.empty();  // project_points() has moved them since
  at_.resize(options_.conditions.size(), 0);
  for (size_t k = 0; k < options_.conditions.size(); ++k) {
    const CurveCondition& c = options_.conditions[k];
    if (c.type != Type::Point && c.type != Type::Tangent) continue;
    if (!searched) {
      double nearest = std::numeric_limits<double>::infinity();
      for (int i = 0; i < (sequence_.closed ? count_ : count_ - 1); ++i) {
        const int j = (i + 1) % count_;
        const Vec3 chord = sequence_.points[j] - sequence_.points[i];
        const double s =
            std::clamp((c.at - sequence_.points[i]).dot(chord) / chord.squaredNorm(), 0.0, 1.0);
        const double d = (sequence_.points[i] + s * chord - c.at).norm();
        if (d < nearest) {
          nearest = d;
          double gap = u_[j] - u_[i];
          if (sequence_.closed && gap < 0) gap += length_;
          at_[k] = u_[i] + s * gap;
          if (at_[k] > length_) at_[k] -= length_;
        }
      }
    }
    forced.push_back(at_[k]);
  }
  return forced;
}

// Points whose foot point is an end of the curve, without being the end point themselves, get no
// spring. Such a point would pull the end towards itself in every round, and it does not determine
// where the curve ends. The same holds at corners.
std::vector<Spring> SmoothingSplineSolver::springs() const {
  std::vector<Spring> springs;
  for (int i = 0; i < count_; ++i) {
    const bool own = (!sequence_.closed && (i == 0 || i + 1 == count_)) ||
                     std::binary_search(sequence_.corners.begin(), sequence_.corners.end(), i);
    if (!own && at_end_or_corner(u_[i])) continue;
    springs.push_back({mesh_.locate(u_[i]), sequence_.points[i]});
  }
  return springs;
}

// True if the parameter is that of an end or of a corner.
bool SmoothingSplineSolver::at_end_or_corner(double u) const {
  const double same = 1e-9 * length_;
  if (!sequence_.closed && (u < same || u > length_ - same)) return true;
  return std::any_of(mesh_.corners().begin(), mesh_.corners().end(), [&](int node) {
    const double off = u - mesh_.parameters()[node];
    return std::abs(sequence_.closed ? std::remainder(off, length_) : off) < same;
  });
}

std::vector<std::pair<int, Vec3>> SmoothingSplineSolver::fixed_dofs() const {
  if (!options_.fix_ends || sequence_.closed) return {};
  return {{mesh_.position_dof(0), sequence_.points.front()},
          {mesh_.position_dof(mesh_.node_count() - 1), sequence_.points.back()}};
}

// True if the rounds are over. Stores the best round, in case the last one is not.
bool SmoothingSplineSolver::is_finished(FairCurve& result, double wavelength, double change) {
  const auto keep = [&](double score) {
    best_ = {curve_, foot_parameters_, constrained_at_, length_, wavelength, result.effective_dofs,
             score};
  };
  // Converged: parameters move by little compared with what is smoothed anyway.
  result.converged =
      result.rounds > 1 && change * length_ < std::max(1e-4 * length_, 0.01 * wavelength);
  if (options_.smoothing == FairOptions::Smoothing::Deviation) {
    const double worst = deviation_of(curve_, sequence_, foot_parameters_).max;
    // Spikes grow from round to round until nothing of the curve is left.
    if (has_spikes() && !best_.foot_parameters.empty()) return true;
    if (worst <= std::max(best_.score, options_.deviation)) keep(worst);
    if (worst > options_.deviation) {
      tolerance_factor_ *= 0.999 * options_.deviation / worst;
      result.converged = false;
      constexpr int more_rounds = 20;
      return result.rounds >= options_.max_rounds + more_rounds;
    }
  } else if (result.rounds >= kWavelengthSearches) {
    // Foot points that move farther and farther indicate divergence.
    constexpr double farther = 3;
    if (change > farther * best_.score) return true;
    if (change <= best_.score) keep(change);
  }
  return result.converged || result.rounds >= options_.max_rounds;
}

FairCurve SmoothingSplineSolver::run() {
  FairCurve result = iterate();
  while (repeats_with_less_movement(result)) {
    best_ = {};
    begin();
    result = iterate();
  }
  return result;
}

// True if points moved by more than their noise, because the curve still changed after the last
// search of the wavelength. The next search then permits less.
bool SmoothingSplineSolver::repeats_with_less_movement(const FairCurve& result) {
  if (options_.smoothing != FairOptions::Smoothing::CrossValidation || min_wavelength_ > 0)
    return false;
  const double over = result.deviation.rms / max_rms_move();
  constexpr double least = 0.3, margin = 0.95;
  if (over <= 1 || move_factor_ < least) return false;
  move_factor_ *= margin / over;
  return true;
}

FairCurve SmoothingSplineSolver::iterate() {
  FairCurve result;
  double wavelength = 0;
  const double alpha = options_.alpha / (sequence_.size * sequence_.size);
  while (true) {
    KnotPlacement nodes =
        place_knots(sequence_, u_, length_, required_knots(), symmetry() != nullptr, max_knots_);
    mesh_ = std::move(nodes.mesh);
    corner_node_ = std::move(nodes.corner_node);
    const std::vector<Spring> springs = this->springs();
    const FairingEnergy energy(mesh_, wavelength_factor_.of(mesh_), alpha);
    PenalisedLeastSquares smoothing(mesh_, springs, energy, fixed_dofs());
    reduce_conditions();
    if (result.rounds < kWavelengthSearches ||
        options_.smoothing == FairOptions::Smoothing::Deviation)
      wavelength = choose_wavelength(smoothing, wavelength);
    solve_at_wavelength(smoothing, wavelength);
    result.effective_dofs = smoothing.effective_dofs();
    if (estimates_noise() && min_wavelength_ < 0.5 * sequence_.length() && has_spikes()) {
      // Between points that zigzag, the curve would oscillate.
      min_wavelength_ = std::max(2 * min_wavelength_, 4 * sequence_.length() / count_);
      wavelength = 0;
      result.rounds = 0;
      begin();
      continue;
    }
    // Uses more nodes than the smoothing can make use of, but not so many that long waves lose
    // their digits. If all points are interpolated, two nodes per point reproduce their curvature.
    const bool through =
        estimates_noise() && is_unconstrained() && result.effective_dofs > 0.5 * count_;
    const int enough = through ? count_ + 1 : count_;
    if (result.effective_dofs > 0.25 * mesh_.node_count() && max_knots_ < enough) {
      max_knots_ = std::min(2 * max_knots_, enough);
      continue;
    }
    if (result.effective_dofs < mesh_.node_count() / 16.0 && max_knots_ > kMinKnots)
      max_knots_ /= 2;
    if (estimates_noise() && result.rounds < kWavelengthSearches)
      wavelength_factor_ = CurvatureAdaptiveWavelength(curve_, wavelength, wavelength_factor_);
    constrained_at_ = at_;
    const double change = project_points(result.rounds == 0);
    ++result.rounds;
    if (is_finished(result, wavelength, change)) break;
  }
  if (!best_.foot_parameters.empty()) {
    result.effective_dofs = best_.effective_dofs;
    wavelength = best_.wavelength;
    length_ = best_.length;
    curve_ = best_.curve;
    foot_parameters_ = best_.foot_parameters;
    constrained_at_ = best_.constrained_at;
  }
  remove_curvature_jumps();
  result.max_residual = max_residual(options_.conditions, constrained_at_, curve_, sequence_.size);
  reparametrize_by_arc_length();
  result.curve = curve_;
  result.wavelength = wavelength;
  result.noise = noise_;
  result.deviation = deviation_of(curve_, sequence_, foot_parameters_);
  for (size_t i = 0; i < sequence_.index.size(); ++i) {
    const int at = sequence_.index[i];
    if (at < 0) result.outliers.push_back(static_cast<int>(i));
    result.parameters.push_back(at < 0 ? curve_.closest_point(given_[i]).u : foot_parameters_[at]);
  }
  return result;
}

// Largest distance of a point from the curve at its parameter, perpendicular to the tangent (at
// corners: the full distance).
double SmoothingSplineSolver::max_normal_distance(const Points& q) const {
  const HermiteCurve curve(mesh_, q);
  double worst = 0;
  for (int i = 0; i < count_; ++i) {
    Vec3 d = curve.evaluate(u_[i]) - sequence_.points[i];
    const Vec3 t = curve.evaluate(u_[i], 1).normalized();
    if (!std::binary_search(sequence_.corners.begin(), sequence_.corners.end(), i))
      d -= t.dot(d) * t;
    worst = std::max(worst, d.norm());
  }
  return worst;
}

// RMS by which noise may have moved the points; larger moves are not noise.
double SmoothingSplineSolver::max_rms_move() const {
  constexpr double any = 0.025;  // fraction of the size
  constexpr int fewest = 11;     // number of points below which estimate_noise() returns 0
  if (count_ < fewest) return any * sequence_.size;
  return std::min(any * sequence_.size, largest_movement(noise_, sequence_.size));
}

bool SmoothingSplineSolver::exceeds_noise(const FairCurve& result) const {
  return result.deviation.rms > largest_movement(noise_, sequence_.size);
}

// The longest wavelength for which `fits` holds, by bisection: short waves are assumed to fit, long
// ones not.
double SmoothingSplineSolver::longest_wavelength(const std::function<bool(double)>& fits) const {
  const auto can = [&](double wavelength) {
    try {
      return fits(wavelength);
    } catch (const NoSolutionError&) {
      return false;  // the wave is so long that nothing of the springs remains
    }
  };
  const double coarsest = 2 * length_;
  if (can(coarsest)) return coarsest;
  const bool is_close = options_.smoothing == FairOptions::Smoothing::Deviation;
  double low = std::log(is_close ? negligible_wavelength() : shortest_wavelength()),
         high = std::log(coarsest);
  constexpr int halvings = 24;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (can(std::exp(middle)) ? low : high) = middle;
  }
  return std::exp(low);
}

double SmoothingSplineSolver::choose_wavelength(PenalisedLeastSquares& smoothing, double before) {
  const double finest = shortest_wavelength(), coarsest = 2 * length_;
  switch (options_.smoothing) {
    case FairOptions::Smoothing::Wavelength:
      // Beyond twice the length of an open curve, everything but a parabola is smoothed away.
      return sequence_.closed ? options_.wavelength : std::min(options_.wavelength, coarsest);
    case FairOptions::Smoothing::CrossValidation: {
      constexpr int fewest = 6;  // with fewer points, nothing can be learned about noise
      if (count_ < fewest || is_few(count_, options_)) return min_wavelength_;
      // If points are spaced unevenly, even the shortest wave may move points that have no noise.
      const double most = move_factor_ * max_rms_move();
      if (smoothing.rms_residual(smoothing.solve(finest)) > most) return min_wavelength_;
      const double low = before > 0 ? std::max(finest, before / 3) : finest,
                   high = before > 0 ? std::min(coarsest, before * 3) : coarsest;
      return std::exp(
          golden_section_minimum([&](double x) { return smoothing.gcv_score(std::exp(x), most); },
                                 std::log(low), std::log(high), before > 0 ? 6 : 16));
    }
    case FairOptions::Smoothing::Noise:
      return longest_wavelength([&](double wavelength) {
        const Points q = solve(smoothing, wavelength);
        if (!is_unconstrained()) smoothing.solve(wavelength);
        const double left = 1 - smoothing.effective_dofs() / count_;
        return left > 0 && smoothing.rms_residual(q) <= options_.noise * std::sqrt(left);
      });
    case FairOptions::Smoothing::Deviation:
      return longest_wavelength([&](double wavelength) {
        return max_normal_distance(solve(smoothing, wavelength)) <=
               tolerance_factor_ * options_.deviation;
      });
  }
  return 0;
}

void SmoothingSplineSolver::reduce_conditions() {
  reduction_.reset();
  if (is_unconstrained()) return;
  ConstraintSet set(mesh_.dof_count());
  for (const auto& [dof, value] : fixed_dofs()) set.fix("ends", dof, value);
  add_rows(options_.conditions, at_, mesh_, set);
  // Relative to a point of the curve, to keep digits far from the origin.
  positions_ = VecX::Zero(mesh_.dof_count());
  for (int n = 0; n < mesh_.node_count(); ++n) positions_[mesh_.position_dof(n)] = 1;
  reduction_.emplace(set.translated(positions_, sequence_.points.front()));
}

Points SmoothingSplineSolver::solve(PenalisedLeastSquares& smoothing, double wavelength) const {
  if (!reduction_) return smoothing.solve(wavelength);
  const Vec3 origin = sequence_.points.front();
  const SparseMatrix K = smoothing.matrix(wavelength);
  const SparseMatrix A = reduction_->reduce(K);
  SparseCholesky cholesky;
  cholesky.analyze(A);
  if (!cholesky.factorize(A)) throw NoSolutionError(cholesky.message());
  const auto answer = [&](const SparseMatrix& matrix, const Points& load) {
    return reduction_->expand(cholesky.solve(reduction_->reduce_load(matrix, load)));
  };
  Points q = answer(K, smoothing.load(origin)) + positions_ * origin.transpose();
  // Iterative refinement, because the positions of conditions depend on the last digits of the
  // curve.
  const SparseMatrix none(K.rows(), K.cols());
  const Points fixed =
      reduction_->expand(MatX::Zero(reduction_->free_count(), reduction_->coupled() ? 1 : 3));
  constexpr int refinements = 2;
  for (int i = 0; i < refinements; ++i)
    q += answer(none, smoothing.residual(wavelength, q)) - fixed;
  return q;
}

// Solves again until every tangent condition acts at the point of the final curve that is closest
// to its `at`, instead of that of the previous curve.
void SmoothingSplineSolver::iterate_tangent_conditions(PenalisedLeastSquares& smoothing,
                                                       double wavelength) {
  const auto move = [&] {
    double most = 0;
    for (size_t k = 0; k < at_.size(); ++k) {
      if (options_.conditions[k].type != Type::Tangent) continue;
      const double u = curve_.closest_point(options_.conditions[k].at).u;
      most = std::max(most, std::abs(u - at_[k]));
      at_[k] = u;
    }
    return most;
  };
  // In the end rounding moves the parameters back and forth: the best ones are kept.
  constexpr int most_moves = 40;
  constexpr double still = 1e-14;
  double least = std::numeric_limits<double>::infinity();
  HermiteCurve best;
  std::vector<double> best_at;
  for (int k = 0; k < most_moves; ++k) {
    const std::vector<double> held = at_;
    const double moved = move();
    if (moved < least) {
      least = moved;
      best = curve_;
      best_at = held;
    }
    if (moved <= still * length_) break;
    reduce_conditions();
    curve_ = HermiteCurve(mesh_, solve(smoothing, wavelength));
  }
  curve_ = best;
  at_ = best_at;
}

// Moves the parameter of every point to its foot point and to arc length. Returns the largest
// change relative to the length.
double SmoothingSplineSolver::project_points(bool first) {
  const HermiteArcLength arc(curve_);
  foot_parameters_.resize(count_);
  double change = 0;
  for (int i = 0; i < count_; ++i) {
    const Vec3& p = sequence_.points[i];
    double u = u_[i];
    const bool end = !sequence_.closed && (i == 0 || i == count_ - 1);
    const auto corner = std::lower_bound(sequence_.corners.begin(), sequence_.corners.end(), i);
    if (corner != sequence_.corners.end() && *corner == i) {
      u = mesh_.parameters()[corner_node_[corner - sequence_.corners.begin()]];
    } else if (!end) {
      const double reach = std::max(3 * spacing(), 2 * (curve_.evaluate(u) - p).norm());
      std::vector<double> around;
      for (int k = -4; k <= 4; ++k) {
        const double x = u + reach * k / 4;
        around.push_back(sequence_.closed ? x : std::clamp(x, 0.0, length_));
      }
      around.erase(std::unique(around.begin(), around.end()), around.end());
      u = mesh_.wrapped(
          closest_on_curve([&](double x, int order) { return curve_.evaluate(x, order); }, around,
                           p)
              .u);
    }
    foot_parameters_[i] = u;
    const double s = arc(u) / arc.total();
    double moved = std::abs(s - u_[i] / length_);
    if (sequence_.closed) moved = std::min(moved, 1 - moved);
    change = std::max(change, moved);
    u_[i] = s;
  }
  if (!(arc.total() > 1e-6 * sequence_.size))
    throw NoSolutionError("curve '" + name_ +
                          "' shrinks to a point when it is faired; smooth it less");
  // If the smoothing is stated, a closed curve that shrinks would shrink faster and faster if the
  // parameter shrank with it. The parameter range therefore stays the length of the points or, if
  // that is mostly noise, of the first curve.
  if (options_.smoothing == FairOptions::Smoothing::CrossValidation ||
      (first && is_zigzag(sequence_.points)))
    length_ = arc.total();
  for (double& u : u_) u *= length_;
  for (size_t k = 0; k < at_.size(); ++k) {
    const CurveCondition& c = options_.conditions[k];
    if (c.type != Type::Point && c.type != Type::Tangent) continue;
    const double s = arc(curve_.closest_point(c.at).u) / arc.total() * length_;
    at_[k] = s;
  }
  return change;
}

// Removes the small jumps that the penalty leaves, unless the curve would move noticeably: at very
// short wavelengths, the penalty hardly acts.
void SmoothingSplineSolver::remove_curvature_jumps() {
  if (!is_unconstrained()) return;
  HermiteCurve smooth = with_continuous_second_derivative(curve_);
  double moved = 0;
  const CurveMesh& mesh = curve_.mesh();
  for (int s = 0; s < mesh.segment_count(); ++s) {
    constexpr double largest = 4.0 / 27;  // of the shape function of a slope, over the length
    const auto dof = mesh.segment_dofs(s);
    for (const int slope : {dof[1], dof[3]})
      moved = std::max(moved, 2 * largest * mesh.length(s) *
                                  (smooth.dofs().row(slope) - curve_.dofs().row(slope)).norm());
  }
  constexpr double little = 0.01, none = 1e-6;  // fractions of the RMS deviation and of the size
  const Deviation before = deviation_of(curve_, sequence_, foot_parameters_);
  if (moved > std::max(little * before.rms, none * sequence_.size)) return;
  if (options_.smoothing == FairOptions::Smoothing::Deviation &&
      deviation_of(smooth, sequence_, foot_parameters_).max >
          std::max(options_.deviation, before.max))
    return;
  curve_ = std::move(smooth);
}

// Scales u, and the foot points, to the arc length.
void SmoothingSplineSolver::reparametrize_by_arc_length() {
  const double scale = HermiteArcLength(curve_).total() / length_;
  for (double& x : foot_parameters_) x *= scale;
  curve_ = curve_.with_scaled_parameter(scale);
}

// Computes the curve of one round. If the precision does not suffice for the wavelength, the
// wavelength is reduced until it does.
void SmoothingSplineSolver::solve_at_wavelength(PenalisedLeastSquares& smoothing,
                                                double& wavelength) {
  constexpr double shorter = 0.8;
  const bool as_stated =
      sequence_.closed && options_.smoothing == FairOptions::Smoothing::Wavelength;
  for (;; wavelength *= shorter) {
    const double smoothed = std::max(wavelength, negligible_wavelength());
    try {
      curve_ = HermiteCurve(mesh_, solve(smoothing, smoothed));
      iterate_tangent_conditions(smoothing, smoothed);
      if (!is_unconstrained()) smoothing.solve(smoothed);
      return;
    } catch (const NoSolutionError&) {
      if (as_stated || shorter * wavelength < negligible_wavelength()) throw;
    }
  }
}

bool is_few(int points, const FairOptions& options) {
  constexpr int enough = 15;
  return options.smoothing == FairOptions::Smoothing::CrossValidation && points < enough &&
         !options.drawn_by_hand;
}

std::vector<double> interpolating_parameters(const PointSequence& sequence) {
  const int n = sequence.count(), chords = sequence.closed ? n : n - 1;
  const auto chord = [&](int i) -> Vec3 {
    return sequence.points[(i + 1) % n] - sequence.points[i % n];
  };
  const auto turn = [&](int i) {  // θ̂
    const bool end = !sequence.closed && (i == 0 || i == n - 1);
    if (end || std::binary_search(sequence.corners.begin(), sequence.corners.end(), i)) return 0.0;
    constexpr double quarter = 0.5 * std::numbers::pi;
    const double angle =
        std::min(degrees_between(chord(i + n - 1), chord(i)) * std::numbers::pi / 180, quarter);
    return angle * angle / quarter;
  };
  std::vector<double> u = {0};
  for (int i = 0; i < chords; ++i) {
    const double d = chord(i).norm();
    const auto share = [&](double beside) { return 1.5 * beside / (beside + d); };
    double factor = 1;
    if (const double angle = turn(i); angle > 0) factor += angle * share(chord(i + n - 1).norm());
    if (const double angle = turn((i + 1) % n); angle > 0)
      factor += angle * share(chord(i + 1).norm());
    u.push_back(u.back() + d * factor);
  }
  return u;
}

HermiteCurve spline_through(const PointSequence& sequence, const std::vector<double>& u) {
  const CurveMesh mesh(u, sequence.closed, sequence.corners);
  std::vector<Spring> springs;
  std::vector<std::pair<int, Vec3>> fixed_dofs;
  for (int i = 0; i < sequence.count(); ++i) {
    springs.push_back({mesh.locate(u[i]), sequence.points[i]});
    fixed_dofs.emplace_back(mesh.position_dof(i), sequence.points[i]);
  }
  constexpr double mu = 1e8;  // makes second derivatives continuous to some digits
  const FairingEnergy energy(mesh, {}, 0, mu);
  return with_continuous_second_derivative(
      {mesh, PenalisedLeastSquares(mesh, springs, energy, fixed_dofs).solve(1e-6 * u.back())});
}

using Type = CurveCondition::Type;

double signed_distance(const CurveCondition& plane, const Vec3& p) {
  return plane.direction.normalized().dot(p - plane.at);
}

void check(const std::string& name, const FairOptions& options, bool closed) {
  const std::string line = "curve '" + name + "': ";
  const auto positive = [&](double value, const char* what) {
    if (!(value > 0) || !std::isfinite(value))
      throw InputError(line + "found the " + what + " " + format_number(value) +
                       ", expected a length above 0");
  };
  if (options.smoothing == FairOptions::Smoothing::Deviation)
    positive(options.deviation, "deviation");
  if (options.smoothing == FairOptions::Smoothing::Noise) positive(options.noise, "noise");
  if (options.smoothing == FairOptions::Smoothing::Wavelength)
    positive(options.wavelength, "wavelength");
  if (!(options.alpha >= 0) || !std::isfinite(options.alpha))
    throw InputError(line + "found alpha = " + format_number(options.alpha) +
                     ", expected 0 or more");
  if (options.max_rounds < 1)
    throw InputError(line + "found " + std::to_string(options.max_rounds) +
                     " iterations, expected one or more");
  for (const auto& c : options.conditions) {
    if (!c.at.allFinite() || !c.direction.allFinite() ||
        (c.type != Type::Point && !(c.direction.norm() > 0)))
      throw InputError(line + "condition '" + c.name +
                       "': a value is not finite, or the direction has length 0");
    if (closed && c.type == Type::ZeroEndCurvature)
      throw InputError(line + "condition '" + c.name + "' needs an open curve, found a closed one");
  }
}

void add_rows(const std::vector<CurveCondition>& conditions, const std::vector<double>& at,
              const CurveMesh& mesh, ConstraintSet& set) {
  CurveConstraints rows(mesh, set);
  for (size_t k = 0; k < conditions.size(); ++k) {
    const CurveCondition& c = conditions[k];
    switch (c.type) {
      case Type::Point:
        rows.point(c.name, at[k], c.at);
        break;
      case Type::Tangent:
        rows.direction(c.name, at[k], c.direction);
        break;
      case Type::ZeroEndCurvature:
        rows.zero_curvature(c.name, mesh.start());
        rows.zero_curvature(c.name, mesh.end());
        break;
      case Type::Plane:
        rows.in_plane(c.name, c.at, c.direction);
        break;
      case Type::Symmetry:
        rows.symmetric(c.name, c.at, c.direction);
        break;
    }
  }
}

double max_residual(const std::vector<CurveCondition>& conditions,
                    const std::vector<double>& constrained_at, const HermiteCurve& curve,
                    double size) {
  double worst = 0;
  constexpr int samples = 200;
  for (size_t k = 0; k < conditions.size(); ++k) {
    const CurveCondition& c = conditions[k];
    const auto along = [&](int i) {
      return curve.start() + (curve.end() - curve.start()) * i / samples;
    };
    switch (c.type) {
      case Type::Point:
        worst = std::max(worst, curve.closest_point(c.at).distance / size);
        break;
      case Type::Tangent: {
        // Direction where it was imposed, and its distance from the closest point.
        const Vec3 tangent = curve.evaluate(constrained_at[k], 1).normalized();
        const Vec3 nearest = curve.evaluate(curve.closest_point(c.at).u);
        worst = std::max({worst, tangent.cross(c.direction.normalized()).norm(),
                          (curve.evaluate(constrained_at[k]) - nearest).norm() / size});
        break;
      }
      case Type::ZeroEndCurvature:
        for (const double s : {0.0, 1.0}) {
          // Curvature times length², the amount by which it bends the last segment.
          const int segment = s > 0 ? curve.segment_count() - 1 : 0;
          const double h = curve.mesh().length(segment);
          worst = std::max(worst, h * h * curve.evaluate({segment, s}, 2).norm() / size);
        }
        break;
      case Type::Plane:
        for (int i = 0; i <= samples; ++i)
          worst = std::max(worst, std::abs(signed_distance(c, curve.evaluate(along(i)))) / size);
        break;
      case Type::Symmetry:
        for (int i = 0; i <= samples; ++i) {
          const Vec3 p = curve.evaluate(along(i));
          const Vec3 image = p - 2 * signed_distance(c, p) * c.direction.normalized();
          worst = std::max(worst, (image - curve.evaluate(along(samples - i))).norm() / size);
        }
        break;
    }
  }
  return worst;
}

}  // namespace batten
