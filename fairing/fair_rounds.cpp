#include "batten/fairing/fair_rounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/fairing/fair_conditions.h"
#include "batten/fairing/fair_nodes.h"
#include "batten/fairing/noise.h"

namespace batten {

FairRounds::FairRounds(const std::string& name, const std::vector<Vec3>& given, const PointRow& row,
                       const FairOptions& options)
    : name_(name), given_(given), row_(row), options_(options), count_(row.count()) {
  noise_ = noise_across(row.points, row.closed, row.corners);
  begin();
}

// Parameters from chords.
void FairRounds::begin() {
  u_ = row_.denoised_chord();
  length_ = u_.back();
  u_.resize(count_);
  ease_ = {};
  at_.clear();
  most_nodes_ = std::min(fewest_nodes, count_);
  if (const CurveCondition* plane = symmetry()) centre(*plane);
}

// Moves the parameters so that the curve crosses the plane half way; a closed one starts there too.
void FairRounds::centre(const CurveCondition& plane) {
  std::vector<double> crossings;
  for (int i = 0; i < (row_.closed ? count_ : count_ - 1); ++i) {
    const double a = height_above(plane, row_.points[i]),
                 b = height_above(plane, row_.points[(i + 1) % count_]);
    if ((a < 0) != (b < 0))
      crossings.push_back(row_.chord[i] + (row_.chord[i + 1] - row_.chord[i]) * a / (a - b));
  }
  if (row_.closed && crossings.size() < 2)
    throw InputError("line '" + name_ + "', condition '" + plane.name +
                     "': the closed line does not cross the plane of symmetry");
  const double first = row_.closed ? crossings.front() : 0;
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
std::vector<double> FairRounds::forced_nodes() {
  std::vector<double> forced = {0};
  for (const int c : row_.corners) forced.push_back(u_[c]);
  const bool searched = !at_.empty();  // project() has moved them since
  at_.resize(options_.conditions.size(), 0);
  for (size_t k = 0; k < options_.conditions.size(); ++k) {
    const CurveCondition& c = options_.conditions[k];
    if (c.type != Type::Point && c.type != Type::Tangent) continue;
    if (!searched) {
      double nearest = std::numeric_limits<double>::infinity();
      for (int i = 0; i < (row_.closed ? count_ : count_ - 1); ++i) {
        const int j = (i + 1) % count_;
        const Vec3 chord = row_.points[j] - row_.points[i];
        const double s =
            std::clamp((c.at - row_.points[i]).dot(chord) / chord.squaredNorm(), 0.0, 1.0);
        const double d = (row_.points[i] + s * chord - c.at).norm();
        if (d < nearest) {
          nearest = d;
          double gap = u_[j] - u_[i];
          if (row_.closed && gap < 0) gap += length_;
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
std::vector<Spring> FairRounds::springs() const {
  std::vector<Spring> springs;
  for (int i = 0; i < count_; ++i) {
    const bool own = (!row_.closed && (i == 0 || i + 1 == count_)) ||
                     std::binary_search(row_.corners.begin(), row_.corners.end(), i);
    if (!own && at_stop(u_[i])) continue;
    springs.push_back({mesh_.where(u_[i]), row_.points[i]});
  }
  return springs;
}

// Whether a parameter is that of an end or of a corner.
bool FairRounds::at_stop(double u) const {
  const double same = 1e-9 * length_;
  if (!row_.closed && (u < same || u > length_ - same)) return true;
  return std::any_of(mesh_.corners().begin(), mesh_.corners().end(), [&](int node) {
    const double off = u - mesh_.parameters()[node];
    return std::abs(row_.closed ? std::remainder(off, length_) : off) < same;
  });
}

std::vector<std::pair<int, Vec3>> FairRounds::held() const {
  if (!options_.hold_ends || row_.closed) return {};
  return {{mesh_.position_dof(0), row_.points.front()},
          {mesh_.position_dof(mesh_.node_count() - 1), row_.points.back()}};
}

// Whether the rounds are over. Keeps the round that is the answer, if the last one is not.
bool FairRounds::over(FairCurve& result, double wave, double change) {
  const auto keep = [&](double score) {
    kept_ = {curve_, foot_, held_at_, length_, wave, result.freedom, score};
  };
  // Parameters stand still when they move by little of what is smoothed anyway.
  result.settled = result.rounds > 1 && change * length_ < std::max(1e-4 * length_, 0.01 * wave);
  if (options_.balance == FairOptions::Balance::Deviation) {
    const double worst = deviation_of(curve_, row_, foot_).max;
    // Spikes grow from round to round, until nothing of the line is left.
    if (spiky() && !kept_.foot.empty()) return true;
    if (worst <= std::max(kept_.score, options_.deviation)) keep(worst);
    if (worst > options_.deviation) {
      tightened_ *= 0.999 * options_.deviation / worst;
      result.settled = false;
      constexpr int more_rounds = 20;
      return result.rounds >= options_.most_rounds + more_rounds;
    }
  } else if (result.rounds >= searches) {
    // Feet that move farther and farther run off with the curve.
    constexpr double farther = 3;
    if (change > farther * kept_.score) return true;
    if (change <= kept_.score) keep(change);
  }
  return result.settled || result.rounds >= options_.most_rounds;
}

FairCurve FairRounds::run() {
  FairCurve result;
  double wave = 0;
  const double alpha = options_.alpha / (row_.size * row_.size);
  while (true) {
    FairNodes nodes =
        choose_nodes(row_, u_, length_, forced_nodes(), symmetry() != nullptr, most_nodes_);
    mesh_ = std::move(nodes.mesh);
    corner_node_ = std::move(nodes.corner_node);
    const std::vector<Spring> springs = this->springs();
    const FairEnergy energy(mesh_, ease_.of(mesh_), alpha);
    SpringBalance balance(mesh_, springs, energy, held());
    reduce_conditions();
    if (result.rounds < searches || options_.balance == FairOptions::Balance::Deviation)
      wave = find_wave(balance, wave);
    solve_round(balance, wave);
    result.freedom = balance.freedom();
    if (tells_noise() && least_wave_ < 0.5 * row_.length() && spiky()) {
      // Through points that go to and fro the curve would run off between them.
      least_wave_ = std::max(2 * least_wave_, 4 * row_.length() / count_);
      wave = 0;
      result.rounds = 0;
      begin();
      continue;
    }
    // More nodes than the balance makes use of, but not so many that long waves lose their digits.
    // Where all points are passed through, two a point bring the curvature that they tell.
    const bool through = tells_noise() && free_of_rows() && result.freedom > 0.5 * count_;
    const int enough = through ? count_ + 1 : count_;
    if (result.freedom > 0.25 * mesh_.node_count() && most_nodes_ < enough) {
      most_nodes_ = std::min(2 * most_nodes_, enough);
      continue;
    }
    if (result.freedom < mesh_.node_count() / 16.0 && most_nodes_ > fewest_nodes) most_nodes_ /= 2;
    if (tells_noise() && result.rounds < searches) ease_ = WaveEase(curve_, wave, ease_);
    held_at_ = at_;
    const double change = project(result.rounds == 0);
    ++result.rounds;
    if (over(result, wave, change)) break;
  }
  if (!kept_.foot.empty()) {
    result.freedom = kept_.freedom;
    wave = kept_.wave;
    length_ = kept_.length;
    curve_ = kept_.curve;
    foot_ = kept_.foot;
    held_at_ = kept_.held_at;
  }
  result.max_residual = max_residual(options_.conditions, held_at_, curve_, row_.size);
  run_by_arc_length();
  result.curve = curve_;
  result.wavelength = wave;
  result.noise = noise_;
  result.deviation = deviation_of(curve_, row_, foot_);
  for (size_t i = 0; i < row_.index.size(); ++i) {
    const int at = row_.index[i];
    if (at < 0) result.outliers.push_back(static_cast<int>(i));
    result.parameters.push_back(at < 0 ? curve_.closest_point(given_[i]).u : foot_[at]);
  }
  return result;
}

}  // namespace batten
