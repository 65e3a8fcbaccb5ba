#include "batten/fairing/smoothing_spline_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/fairing/fair_conditions.h"
#include "batten/fairing/knot_placement.h"
#include "batten/fairing/noise_estimate.h"

namespace batten {

SmoothingSplineSolver::SmoothingSplineSolver(const std::string& name,
                                             const std::vector<Vec3>& given,
                                             const PointSequence& row, const FairOptions& options)
    : name_(name), given_(given), sequence_(row), options_(options), count_(row.count()) {
  noise_ = estimate_noise(row.points, row.closed, row.corners);
  begin();
}

// Parameters from chords.
void SmoothingSplineSolver::begin() {
  u_ = sequence_.averaged_chord();
  length_ = u_.back();
  u_.resize(count_);
  wavelength_factor_ = {};
  at_.clear();
  max_knots_ = std::min(kMinKnots, count_);
  if (const CurveCondition* plane = symmetry()) centre(*plane);
}

// Moves the parameters so that the curve crosses the plane half way; a closed one starts there too.
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
    throw InputError("line '" + name_ + "', condition '" + plane.name +
                     "': the closed line does not cross the plane of symmetry");
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

// Parameters at which there has to be a node.
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

// A point whose foot is the end of the line, though it is not the end itself, has no spring: it
// would draw the end towards itself in every round, and what lies beside an end says nothing about
// where that ends. So it is at corners.
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

// Whether a parameter is that of an end or of a corner.
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

// Whether the rounds are over. Keeps the round that is the answer, if the last one is not.
bool SmoothingSplineSolver::is_finished(FairCurve& result, double wavelength, double change) {
  const auto keep = [&](double score) {
    best_ = {curve_, foot_parameters_, constrained_at_, length_, wavelength, result.effective_dofs,
             score};
  };
  // Parameters stand still when they move by little of what is smoothed anyway.
  result.converged =
      result.rounds > 1 && change * length_ < std::max(1e-4 * length_, 0.01 * wavelength);
  if (options_.smoothing == FairOptions::Smoothing::Deviation) {
    const double worst = deviation_of(curve_, sequence_, foot_parameters_).max;
    // Spikes grow from round to round, until nothing of the line is left.
    if (has_spikes() && !best_.foot_parameters.empty()) return true;
    if (worst <= std::max(best_.score, options_.deviation)) keep(worst);
    if (worst > options_.deviation) {
      tolerance_factor_ *= 0.999 * options_.deviation / worst;
      result.converged = false;
      constexpr int more_rounds = 20;
      return result.rounds >= options_.max_rounds + more_rounds;
    }
  } else if (result.rounds >= kWavelengthSearches) {
    // Feet that move farther and farther run off with the curve.
    constexpr double farther = 3;
    if (change > farther * best_.score) return true;
    if (change <= best_.score) keep(change);
  }
  return result.converged || result.rounds >= options_.max_rounds;
}

FairCurve SmoothingSplineSolver::run() {
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
      // Through points that go to and fro the curve would run off between them.
      min_wavelength_ = std::max(2 * min_wavelength_, 4 * sequence_.length() / count_);
      wavelength = 0;
      result.rounds = 0;
      begin();
      continue;
    }
    // More nodes than the balance makes use of, but not so many that long waves lose their digits.
    // Where all points are passed through, two a point bring the curvature that they tell.
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

}  // namespace batten
