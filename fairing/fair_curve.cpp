#include "batten/fairing/fair_curve.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/errors.h"
#include "batten/fairing/fair_conditions.h"
#include "batten/fairing/fair_nodes.h"
#include "batten/fairing/noise.h"
#include "batten/fairing/point_row.h"
#include "batten/fairing/spring_balance.h"
#include "batten/fairing/wave_ease.h"

namespace batten {
namespace {

class Fairing {
 public:
  Fairing(const std::string& name, const std::vector<Vec3>& given, const PointRow& row,
          const FairOptions& options)
      : name_(name), given_(given), row_(row), options_(options), count_(row.count()) {
    noise_ = noise_across(row.points, row.closed, row.corners);
    begin();
  }

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
  void begin();
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
  // Whether the way from point to point is much longer than that from every fourth to the next.
  bool zigzags() const {
    double shorter = 0;
    for (int i = 4; i < count_; i += 4) shorter += (row_.points[i] - row_.points[i - 4]).norm();
    return count_ >= 16 && shorter < 0.7 * row_.length();
  }
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
  WaveEase ease_;                 // of the last round; even where the balance is stated
  // Of the conditions, for one mesh.
  std::optional<AffineReduction> reduction_;
  VecX positions_;  // 1 at position dofs
};

// Parameters from chords.
void Fairing::begin() {
  u_ = row_.denoised_chord();
  length_ = u_.back();
  u_.resize(count_);
  ease_ = {};
  at_.clear();
  most_nodes_ = fewest_nodes;
  if (const CurveCondition* plane = symmetry()) centre(*plane);
}

// Moves the parameters so that the curve crosses the plane half way; a closed one starts there too.
void Fairing::centre(const CurveCondition& plane) {
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
std::vector<double> Fairing::forced_nodes() {
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
std::vector<Spring> Fairing::springs() const {
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
bool Fairing::at_stop(double u) const {
  const double same = 1e-9 * length_;
  if (!row_.closed && (u < same || u > length_ - same)) return true;
  return std::any_of(mesh_.corners().begin(), mesh_.corners().end(), [&](int node) {
    const double off = u - mesh_.parameters()[node];
    return std::abs(row_.closed ? std::remainder(off, length_) : off) < same;
  });
}

std::vector<std::pair<int, Vec3>> Fairing::held() const {
  if (!options_.hold_ends || row_.closed) return {};
  return {{mesh_.position_dof(0), row_.points.front()},
          {mesh_.position_dof(mesh_.node_count() - 1), row_.points.back()}};
}

// Largest distance of a point from the curve at its parameter, across the tangent.
double Fairing::off_axis(const Points& q) const {
  const HermiteCurve curve(mesh_, q);
  double worst = 0;
  for (int i = 0; i < count_; ++i) {
    Vec3 d = curve.evaluate(u_[i]) - row_.points[i];
    const Vec3 t = curve.evaluate(u_[i], 1).normalized();
    if (!std::binary_search(row_.corners.begin(), row_.corners.end(), i)) d -= t.dot(d) * t;
    worst = std::max(worst, d.norm());
  }
  return worst;
}

// Root mean square by which noise may have moved the points: what moves them farther was none.
double Fairing::most_move() const {
  constexpr double any = 0.025, none = 1e-6;  // of the size
  constexpr int fewest = 11;                  // points of which noise_across() knows something
  if (count_ < fewest) return any * row_.size;
  return std::min(any * row_.size, 2 * noise_ + none * row_.size);
}

// The longest wavelength that fits, of those that are long, fit not, or are short and fit.
double Fairing::longest_wave(const std::function<bool(double)>& fits) const {
  const auto can = [&](double wave) {
    try {
      return fits(wave);
    } catch (const NoSolutionError&) {
      return false;  // so long a wave leaves nothing of the springs
    }
  };
  const double coarsest = 2 * length_;
  if (can(coarsest)) return coarsest;
  const bool is_close = options_.balance == FairOptions::Balance::Deviation;
  double low = std::log(is_close ? no_wave() : finest_wave()), high = std::log(coarsest);
  constexpr int halvings = 24;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (can(std::exp(middle)) ? low : high) = middle;
  }
  return std::exp(low);
}

double Fairing::find_wave(SpringBalance& balance, double before) {
  const double finest = finest_wave(), coarsest = 2 * length_;
  switch (options_.balance) {
    case FairOptions::Balance::Wavelength:
      // Beyond twice an open line's length all of it is smoothed but a parabola.
      return row_.closed ? options_.wavelength : std::min(options_.wavelength, coarsest);
    case FairOptions::Balance::CrossValidation: {
      constexpr int fewest = 6;  // points from which something can be learned about noise
      if (count_ < fewest) return 0;
      // Where points lie unevenly the finest wave already moves what has no noise.
      if (balance.moved(balance.solve(finest)) > most_move()) return 0;
      const double low = before > 0 ? std::max(finest, before / 3) : finest,
                   high = before > 0 ? std::min(coarsest, before * 3) : coarsest;
      return std::exp(minimum_of([&](double x) { return balance.score(std::exp(x), most_move()); },
                                 std::log(low), std::log(high), before > 0 ? 6 : 16));
    }
    case FairOptions::Balance::Noise:
      return longest_wave([&](double wave) {
        const Points q = solve(balance, wave);
        if (!free_of_rows()) balance.solve(wave);
        const double left = 1 - balance.freedom() / count_;
        return left > 0 && balance.moved(q) <= options_.noise * std::sqrt(left);
      });
    case FairOptions::Balance::Deviation:
      return longest_wave([&](double wave) {
        return off_axis(solve(balance, wave)) <= tightened_ * options_.deviation;
      });
  }
  return 0;
}

void Fairing::reduce_conditions() {
  reduction_.reset();
  if (free_of_rows()) return;
  ConstraintSet set(mesh_.dof_count());
  for (const auto& [dof, value] : held()) set.fix("ends", dof, value);
  add_rows(options_.conditions, at_, mesh_, set);
  // About a point of the curve, so that far from the origin no digits are lost.
  positions_ = VecX::Zero(mesh_.dof_count());
  for (int n = 0; n < mesh_.node_count(); ++n) positions_[mesh_.position_dof(n)] = 1;
  reduction_.emplace(set.moved(positions_, row_.points.front()));
}

Points Fairing::solve(SpringBalance& balance, double wave) const {
  if (!reduction_) return balance.solve(wave);
  const Vec3 origin = row_.points.front();
  const SparseMatrix K = balance.matrix(wave);
  const SparseMatrix A = reduction_->reduce(K);
  SparseCholesky cholesky;
  cholesky.analyze(A);
  if (!cholesky.factorize(A)) throw NoSolutionError(cholesky.message());
  const auto answer = [&](const SparseMatrix& matrix, const Points& load) {
    return reduction_->expand(cholesky.solve(reduction_->reduce_load(matrix, load)));
  };
  Points q = answer(K, balance.load(origin)) + positions_ * origin.transpose();
  // Where conditions act depends on the last digits of the curve.
  const SparseMatrix none(K.rows(), K.cols());
  const Points fixed =
      reduction_->expand(MatX::Zero(reduction_->free_count(), reduction_->coupled() ? 1 : 3));
  constexpr int refinements = 2;
  for (int i = 0; i < refinements; ++i) q += answer(none, balance.imbalance(wave, q)) - fixed;
  return q;
}

// Solves again with every direction held where the curve is nearest to its place in the end, not
// where it was before.
void Fairing::settle_tangents(SpringBalance& balance, double wave) {
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
  // In the end rounding moves them to and fro: the best stays.
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
    curve_ = HermiteCurve(mesh_, solve(balance, wave));
  }
  curve_ = best;
  at_ = best_at;
}

// Moves every point's parameter to the nearest point of the curve and to arc length; returns the
// largest change over the length.
double Fairing::project(bool first) {
  const NodeArc arc(curve_);
  foot_.resize(count_);
  double change = 0;
  for (int i = 0; i < count_; ++i) {
    const Vec3& p = row_.points[i];
    double u = u_[i];
    const bool end = !row_.closed && (i == 0 || i == count_ - 1);
    const auto corner = std::lower_bound(row_.corners.begin(), row_.corners.end(), i);
    if (corner != row_.corners.end() && *corner == i) {
      u = mesh_.parameters()[corner_node_[corner - row_.corners.begin()]];
    } else if (!end) {
      const double reach = std::max(3 * spacing(), 2 * (curve_.evaluate(u) - p).norm());
      std::vector<double> around;
      for (int k = -4; k <= 4; ++k) {
        const double x = u + reach * k / 4;
        around.push_back(row_.closed ? x : std::clamp(x, 0.0, length_));
      }
      around.erase(std::unique(around.begin(), around.end()), around.end());
      u = mesh_.wrapped(
          closest_on_curve([&](double x, int order) { return curve_.evaluate(x, order); }, around,
                           p)
              .u);
    }
    foot_[i] = u;
    const double s = arc(u) / arc.total();
    double moved = std::abs(s - u_[i] / length_);
    if (row_.closed) moved = std::min(moved, 1 - moved);
    change = std::max(change, moved);
    u_[i] = s;
  }
  if (!(arc.total() > 1e-6 * row_.size))
    throw NoSolutionError("line '" + name_ + "' shrinks to a point when faired");
  // Under a stated balance a closed curve that shrinks would shrink faster and faster if the
  // parameter shrank with it: it keeps the length of the points, or, where that is mostly noise, of
  // the first curve.
  if (options_.balance == FairOptions::Balance::CrossValidation || (first && zigzags()))
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

// The same curve and feet, u scaled to the length.
void Fairing::run_by_arc_length() {
  const double scale = NodeArc(curve_).total() / length_;
  for (double& x : foot_) x *= scale;
  curve_ = curve_.with_parameter_times(scale);
}

// The curve of one round. Where digits are too few for so long a wave, of one that they suffice for.
void Fairing::solve_round(SpringBalance& balance, double& wave) {
  constexpr double shorter = 0.8;
  const bool as_stated = row_.closed && options_.balance == FairOptions::Balance::Wavelength;
  for (;; wave *= shorter) {
    const double smoothed = std::max(wave, no_wave());
    try {
      curve_ = HermiteCurve(mesh_, solve(balance, smoothed));
      settle_tangents(balance, smoothed);
      if (!free_of_rows()) balance.solve(smoothed);
      return;
    } catch (const NoSolutionError&) {
      if (as_stated || shorter * wave < no_wave()) throw;
    }
  }
}

FairCurve Fairing::run() {
  FairCurve result;
  double wave = 0;
  const double alpha = options_.alpha / (row_.size * row_.size);
  constexpr int searches = 4;  // rounds in which the balance is sought; it then stays
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
    if (spiky() && options_.balance != FairOptions::Balance::Wavelength &&
        least_wave_ < 0.5 * row_.length()) {
      // Through points that go to and fro the curve would run off between them.
      least_wave_ = std::max(2 * least_wave_, 4 * row_.length() / count_);
      wave = 0;
      result.rounds = 0;
      begin();
      continue;
    }
    // More nodes than the balance makes use of, but not so many that long waves lose their digits.
    if (result.freedom > 0.25 * mesh_.node_count() && most_nodes_ < count_) {
      most_nodes_ *= 2;
      continue;
    }
    if (result.freedom < mesh_.node_count() / 16.0 && most_nodes_ > fewest_nodes) most_nodes_ /= 2;
    if (result.rounds < searches && (options_.balance == FairOptions::Balance::CrossValidation ||
                                     options_.balance == FairOptions::Balance::Noise))
      ease_ = WaveEase(curve_, wave, ease_);
    held_at_ = at_;
    const double change = project(result.rounds == 0);
    ++result.rounds;
    // Parameters stand still when they move by little of what is smoothed anyway.
    result.settled = result.rounds > 1 && change * length_ < std::max(1e-4 * length_, 0.01 * wave);
    int more_rounds = 0;
    if (options_.balance == FairOptions::Balance::Deviation) {
      const double worst = deviation_of(curve_, row_, foot_).max;
      if (worst > options_.deviation) {
        tightened_ *= 0.999 * options_.deviation / worst;
        result.settled = false;
        more_rounds = 20;
      }
    }
    if (result.settled || result.rounds >= options_.most_rounds + more_rounds) break;
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

}  // namespace

FairCurve fair_points(const std::string& name, const std::vector<Vec3>& points,
                      const FairOptions& options) {
  const PointRow row(name, points, options.corner_angle, options.corners, options.closed,
                     options.drop_outliers ? PointRow::Outliers::Drop : PointRow::Outliers::Keep);
  check(name, options, row.closed);
  return Fairing(name, points, row, options).run();
}

HermiteCurve curve_as_given(const std::string& name, const std::vector<Vec3>& points,
                            const FairOptions& options) {
  const PointRow row(name, points, options.corner_angle, options.corners, options.closed);
  const CurveMesh mesh(row.chord, row.closed, row.corners);
  std::vector<Spring> springs;
  std::vector<std::pair<int, Vec3>> held;
  for (int i = 0; i < row.count(); ++i) {
    springs.push_back({mesh.where(row.chord[i]), row.points[i]});
    held.emplace_back(mesh.position_dof(i), row.points[i]);
  }
  const FairEnergy energy(mesh, {}, 0);
  return {mesh, SpringBalance(mesh, springs, energy, held).solve(1e-6 * row.length())};
}

}  // namespace batten
