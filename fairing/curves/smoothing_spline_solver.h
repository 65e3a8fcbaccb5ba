// SPDX-License-Identifier: MPL-2.0
// Iterative solver of fair_points(): placement of nodes, springs, choice of wavelength, solve and
// foot points, repeated until the parameters no longer move.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/constraints/constraint_set.h"
#include "batten/fairing/corners/point_sequence.h"
#include "batten/fairing/curves/curve_options.h"
#include "batten/fairing/curves/fairing_energy.h"
#include "batten/fairing/curves/penalised_least_squares.h"

namespace batten {

/// Fairs one curve, see FairOptions. Keeps references to its arguments.
class SmoothingSplineSolver {
 public:
  SmoothingSplineSolver(const std::string& name, const std::vector<Vec3>& given,
                        const PointSequence& row, const FairOptions& options);

  FairCurve run();
  /// True if the curve moves the points by more than largest_movement(), because it would have
  /// spikes between them otherwise.
  bool exceeds_noise(const FairCurve& result) const;

 private:
  using Type = CurveCondition::Type;
  double spacing() const { return length_ / std::min(count_, max_knots_); }  // spacing of the nodes
  // So short that nothing is smoothed, while the system stays positive definite in floating point.
  double negligible_wavelength() const { return 0.1 * spacing(); }
  // Waves shorter than noisy points can resolve would be spikes between them.
  double shortest_wavelength() const {
    const double gap = length_ / count_;
    constexpr double noisy = 0.05;
    return std::max(min_wavelength_, noise_ > noisy * gap ? 2 * gap : 0.5 * spacing());
  }
  const CurveCondition* symmetry() const {
    for (const auto& c : options_.conditions)
      if (c.type == Type::Symmetry) return &c;
    return nullptr;
  }
  // True if the wavelength is chosen by noise, rather than stated or bound by a deviation.
  bool estimates_noise() const {
    return options_.smoothing == FairOptions::Smoothing::CrossValidation ||
           options_.smoothing == FairOptions::Smoothing::Noise;
  }
  static constexpr int kWavelengthSearches =
      4;  // the wavelength is searched in this many rounds and then kept
  void begin();
  FairCurve iterate();
  bool repeats_with_less_movement(const FairCurve& result);
  bool is_finished(FairCurve& result, double wavelength, double change);
  bool has_spikes() const {
    constexpr double longer = 1.5;
    return HermiteArcLength(curve_).total() > longer * sequence_.length();
  }
  bool is_unconstrained() const { return options_.conditions.empty(); }

  void centre(const CurveCondition& plane);
  std::vector<double> required_knots();
  bool at_end_or_corner(double u) const;
  std::vector<Spring> springs() const;
  std::vector<std::pair<int, Vec3>> fixed_dofs() const;
  double max_rms_move() const;
  double longest_wavelength(const std::function<bool(double)>& fits) const;
  double choose_wavelength(PenalisedLeastSquares& smoothing, double before);
  void solve_at_wavelength(PenalisedLeastSquares& smoothing, double& wavelength);
  void reduce_conditions();
  Points solve(PenalisedLeastSquares& smoothing, double wavelength) const;
  double max_normal_distance(const Points& q) const;
  double project_points(bool first);
  void remove_curvature_jumps();
  void reparametrize_by_arc_length();
  void iterate_tangent_conditions(PenalisedLeastSquares& smoothing, double wavelength);

  const std::string& name_;
  const std::vector<Vec3>& given_;
  const PointSequence& sequence_;
  const FairOptions& options_;
  const int count_;
  double length_ = 0;
  double noise_ = 0;                    // standard deviation across the curve
  std::vector<double> u_;               // parameters of the points, in [0, length_]
  std::vector<double> at_;              // parameters of the conditions; unused entries are
                                        // arbitrary
  std::vector<double> constrained_at_;  // at_ of the last solve
  static constexpr int kMinKnots = 64;
  int max_knots_ = kMinKnots;
  double tolerance_factor_ =
      1;  // factor of the stated deviation, so that it holds after the last projection
  CurveMesh mesh_;
  std::vector<int> corner_node_;         // node of each corner of the sequence
  HermiteCurve curve_;                   // faired curve of the last round
  std::vector<double> foot_parameters_;  // foot point of each point on curve_
  double move_factor_ = 1;               // factor of max_rms_move() in the search, so that it
                                         // holds after the last projection
  double min_wavelength_ = 0;            // shortest wavelength that leaves no spikes
  struct Iterate {
    HermiteCurve curve;
    std::vector<double> foot_parameters, constrained_at;
    double length = 0, wavelength = 0, effective_dofs = 0;
    double score = std::numeric_limits<double>::infinity();
  };
  // If a deviation is stated: the last round that satisfies it, or the one that comes closest;
  // score: its deviation. Otherwise the round in which the parameters moved least; score: by how
  // far.
  Iterate best_;
  CurvatureAdaptiveWavelength
      wavelength_factor_;  // local wavelength factor of the last round; 1 everywhere if a
                           // wavelength or deviation is stated
  // Reduction of the conditions to free unknowns, on the current mesh.
  std::optional<AffineReduction> reduction_;
  VecX positions_;  // per dof: 1 for positions, 0 for slopes
};

// Interpolation of few points, whose noise cannot be distinguished from their shape.

/// True if fair_points() does not smooth so few points, unless that is requested.
bool is_few(int points, const FairOptions& options);

/// Parameters of points for interpolation by a cubic spline: chord lengths, longer beside turns.
///
/// A chord d between chords d₋ and d₊, with the turning angles θ and θ₊ at its ends, counts
///
///     d (1 + 3/2 θ̂ d₋/(d₋ + d) + 3/2 θ̂₊ d₊/(d + d₊)),    θ̂ = 2/π min(θ, π/2)²
///
/// as proposed in [FoleyNielson1989], but with the squares of the angles, which hardly matter
/// between dense points. Ends and corners count as θ = 0. Splines over chord lengths overshoot
/// between points that zigzag: through 300 random and zigzag lists of 5 to 14 points, their median
/// distance from the polyline is 0.18 of the longest chord, and 1.7 at most. Over these parameters,
/// it is 0.11 and 0.29.
/// One value per point, starting at 0; closed: one more, the total.
std::vector<double> interpolating_parameters(const PointSequence& sequence);

/// The cubic spline through the points of a sequence, with continuous second derivative between
/// corners, and at ends and corners with the second derivatives that make its third derivative
/// least. `u`: parameters of the points, as interpolating_parameters() returns them.
HermiteCurve spline_through(const PointSequence& sequence, const std::vector<double>& u);

// Conditions of fairing as linear constraints.

/// Throws InputError, naming the curve, for options out of range and for conditions that are
/// invalid or do not fit a closed curve.
void check(const std::string& name, const FairOptions& options, bool closed);

/// Signed distance of p from the plane of a condition.
double signed_distance(const CurveCondition& plane, const Vec3& p);

/// Adds the constraint equations of all conditions to a set. at[k]: curve parameter of condition k,
/// if it has one.
void add_rows(const std::vector<CurveCondition>& conditions, const std::vector<double>& at,
              const CurveMesh& mesh, ConstraintSet& set);

/// Largest violation of a condition, measured on the finished curve: distance relative to the size,
/// angles in radians. constrained_at[k]: parameter at which condition k was imposed.
double max_residual(const std::vector<CurveCondition>& conditions,
                    const std::vector<double>& constrained_at, const HermiteCurve& curve,
                    double size);

}  // namespace batten
