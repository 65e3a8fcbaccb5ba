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
#include "batten/fairing/fair_curve.h"
#include "batten/fairing/point_row.h"
#include "batten/fairing/spring_balance.h"
#include "batten/fairing/wave_ease.h"

namespace batten {

/// One fairing of one line. Keeps references. Its parts: rounds, nodes and springs in
/// fair_rounds.cpp; the wavelength in fair_search.cpp; one curve, and where its points are nearest,
/// in fair_solve.cpp.
class FairRounds {
 public:
  FairRounds(const std::string& name, const std::vector<Vec3>& given, const PointRow& row,
             const FairOptions& options);

  FairCurve run();

 private:
  using Type = CurveCondition::Type;
  double spacing() const { return length_ / std::min(count_, most_nodes_); }  // of nodes
  // So short that nothing is smoothed, and the system still positive definite in floating point.
  double no_wave() const { return 0.1 * spacing(); }
  // Shorter waves than noisy points can show would be spikes between them.
  double finest_wave() const {
    const double gap = length_ / count_;
    constexpr double noisy = 0.05;
    return std::max(least_wave_, noise_ > noisy * gap ? 2 * gap : 0.5 * spacing());
  }
  const CurveCondition* symmetry() const {
    for (const auto& c : options_.conditions)
      if (c.type == Type::Symmetry) return &c;
    return nullptr;
  }
  // Whether the balance is between noise and shape, rather than a length that must be kept.
  bool tells_noise() const {
    return options_.balance == FairOptions::Balance::CrossValidation ||
           options_.balance == FairOptions::Balance::Noise;
  }
  static constexpr int searches = 4;  // rounds in which the balance is sought; it then stays
  void begin();
  bool over(FairCurve& result, double wave, double change);
  bool spiky() const {
    constexpr double longer = 1.5;
    return NodeArc(curve_).total() > longer * row_.length();
  }
  bool free_of_rows() const { return options_.conditions.empty(); }

  void centre(const CurveCondition& plane);
  std::vector<double> forced_nodes();
  bool at_stop(double u) const;
  std::vector<Spring> springs() const;
  std::vector<std::pair<int, Vec3>> held() const;
  double most_move() const;
  double longest_wave(const std::function<bool(double)>& fits) const;
  double find_wave(SpringBalance& balance, double before);
  void solve_round(SpringBalance& balance, double& wave);
  void reduce_conditions();
  Points solve(SpringBalance& balance, double wave) const;
  double off_axis(const Points& q) const;
  double project(bool first);
  void run_by_arc_length();
  void settle_tangents(SpringBalance& balance, double wave);

  const std::string& name_;
  const std::vector<Vec3>& given_;
  const PointRow& row_;
  const FairOptions& options_;
  const int count_;
  double length_ = 0;
  double noise_ = 0;             // standard deviation across the line
  std::vector<double> u_;        // of the points, in [0, length_]
  std::vector<double> at_;       // where the conditions act, or unused
  std::vector<double> held_at_;  // those of the last solve
  static constexpr int fewest_nodes = 64;
  int most_nodes_ = fewest_nodes;
  double tightened_ = 1;  // of the stated deviation, so that it holds after the last projection
  CurveMesh mesh_;
  std::vector<int> corner_node_;  // of each corner of the row
  HermiteCurve curve_;            // of the last round
  std::vector<double> foot_;      // of each point, on it
  double least_wave_ = 0;         // that leaves no spikes
  struct Round {
    HermiteCurve curve;
    std::vector<double> foot, held_at;
    double length = 0, wave = 0, freedom = 0;
    double score = std::numeric_limits<double>::infinity();
  };
  // Under a stated deviation: the last round that keeps it, or the one that comes nearest, by its
  // deviation. Else the one in which parameters moved least, by how far.
  Round kept_;
  WaveEase ease_;  // of the last round; even where the balance is stated
  // Of the conditions, for one mesh.
  std::optional<AffineReduction> reduction_;
  VecX positions_;  // 1 at position dofs
};

}  // namespace batten
