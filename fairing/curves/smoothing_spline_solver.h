// The rounds of fair_points(): nodes, springs, wavelength, curve, feet, until parameters stand still.
// Internal.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/fairing/curves/fairing_energy.h"
#include "batten/fairing/curves/curve_options.h"
#include "batten/fairing/curves/penalised_least_squares.h"
#include "batten/fairing/corners/point_sequence.h"
#include "batten/constraints/constraint_set.h"

namespace batten {

/// One fairing of one line. Keeps references. Its parts: rounds, nodes and springs in
/// fair_rounds.cpp; the wavelength in fair_search.cpp; one curve, and where its points are nearest,
/// in fair_solve.cpp.
class SmoothingSplineSolver {
 public:
  SmoothingSplineSolver(const std::string& name, const std::vector<Vec3>& given,
                        const PointSequence& row, const FairOptions& options);

  FairCurve run();

 private:
  using Type = CurveCondition::Type;
  double spacing() const { return length_ / std::min(count_, max_knots_); }  // of nodes
  // So short that nothing is smoothed, and the system still positive definite in floating point.
  double negligible_wavelength() const { return 0.1 * spacing(); }
  // Shorter waves than noisy points can show would be spikes between them.
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
  // Whether the balance is between noise and shape, rather than a length that must be kept.
  bool estimates_noise() const {
    return options_.smoothing == FairOptions::Smoothing::CrossValidation ||
           options_.smoothing == FairOptions::Smoothing::Noise;
  }
  static constexpr int kWavelengthSearches =
      4;  // rounds in which the balance is sought; it then stays
  void begin();
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
  void reparametrize_by_arc_length();
  void iterate_tangent_conditions(PenalisedLeastSquares& smoothing, double wavelength);

  const std::string& name_;
  const std::vector<Vec3>& given_;
  const PointSequence& sequence_;
  const FairOptions& options_;
  const int count_;
  double length_ = 0;
  double noise_ = 0;                    // standard deviation across the line
  std::vector<double> u_;               // of the points, in [0, length_]
  std::vector<double> at_;              // where the conditions act, or unused
  std::vector<double> constrained_at_;  // those of the last solve
  static constexpr int kMinKnots = 64;
  int max_knots_ = kMinKnots;
  double tolerance_factor_ =
      1;  // of the stated deviation, so that it holds after the last projection
  CurveMesh mesh_;
  std::vector<int> corner_node_;         // of each corner of the row
  HermiteCurve curve_;                   // of the last round
  std::vector<double> foot_parameters_;  // of each point, on it
  double min_wavelength_ = 0;            // that leaves no spikes
  struct Iterate {
    HermiteCurve curve;
    std::vector<double> foot_parameters, constrained_at;
    double length = 0, wavelength = 0, effective_dofs = 0;
    double score = std::numeric_limits<double>::infinity();
  };
  // Under a stated deviation: the last round that keeps it, or the one that comes nearest, by its
  // deviation. Else the one in which parameters moved least, by how far.
  Iterate best_;
  CurvatureAdaptiveWavelength
      wavelength_factor_;  // of the last round; even where the balance is stated
  // Of the conditions, for one mesh.
  std::optional<AffineReduction> reduction_;
  VecX positions_;  // 1 at position dofs
};


// Inside of fair_points: what has to hold while a curve is faired.

/// Throws InputError, which names the line, for options out of their range and for conditions that
/// have no meaning or do not fit a closed line.
void check(const std::string& name, const FairOptions& options, bool closed);

/// Signed distance of p from the plane of a condition.
double signed_distance(const CurveCondition& plane, const Vec3& p);

/// Adds the rows of all conditions; at[k]: parameter of condition k, where it has one.
void add_rows(const std::vector<CurveCondition>& conditions, const std::vector<double>& at,
              const CurveMesh& mesh, ConstraintSet& set);

/// Largest violation of a condition, measured on the finished curve: distance over the size, angles
/// in radians. constrained_at[k]: parameter at which condition k was held.
double max_residual(const std::vector<CurveCondition>& conditions,
                    const std::vector<double>& constrained_at, const HermiteCurve& curve,
                    double size);

}  // namespace batten
