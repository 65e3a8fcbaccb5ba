#include "batten/fairing/spring_balance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/elements/quadrature.h"

namespace batten {

NodeArc::NodeArc(const HermiteCurve& curve) : curve_(curve), at_node_{0} {
  for (int s = 0; s < curve.segment_count(); ++s)
    at_node_.push_back(at_node_.back() + inside({s, 1}));
}

double NodeArc::operator()(double u) const {
  const auto at = curve_.mesh().where(u);
  return at_node_[at.segment] + inside(at);
}

double NodeArc::inside(CurveMesh::Where at) const {
  static const SegmentRule rule = gauss_legendre(5);
  double sum = 0;
  for (long p = 0; p < rule.s.size(); ++p)
    sum += rule.weights[p] * curve_.evaluate({at.segment, at.s * rule.s[p]}, 1).norm();
  return sum * at.s * curve_.mesh().length(at.segment);
}

Points SpringBalance::solve(double lambda) {
  band_.reset(A_);
  right_.setZero(mesh_.dof_count(), 3);
  for (int s = 0; s < mesh_.segment_count(); ++s) {
    const HermiteSegment segment(mesh_.length(s));
    const HermiteSegment::Linear ease = ease_.empty() ? 1 : ease_[static_cast<size_t>(s)];
    HermiteSegment::Matrix K = segment.bending({lambda * ease.start, lambda * ease.end});
    if (alpha_ > 0) K += segment.stretching(lambda * alpha_);
    band_.add(A_, s, K);
  }
  for (int n = 0; n < mesh_.node_count(); ++n) {
    const int i = band_.place(mesh_.position_dof(n));
    A_.add(i, i, springs_.weight[n]);
    right_.row(i) += springs_.weight[n] * springs_.goal[n].transpose();
  }
  for (const auto& [dof, value] : held_) A_.fix(band_.place(dof), value, right_);
  if (!A_.factorize())
    throw NoSolutionError("a curve cannot be faired: its system is not positive definite");
  A_.solve(right_);
  Points q(mesh_.dof_count(), 3);
  for (int d = 0; d < mesh_.dof_count(); ++d) q.row(d) = right_.row(band_.place(d));
  return q;
}

double SpringBalance::freedom() const {
  const VecX inverse = A_.inverse_diagonal();
  double trace = 0;
  for (int n = 0; n < mesh_.node_count(); ++n) {
    const int dof = mesh_.position_dof(n);
    const bool is_held =
        std::any_of(held_.begin(), held_.end(), [&](const auto& h) { return h.first == dof; });
    trace += is_held ? 1 : springs_.weight[n] * inverse[band_.place(dof)];
  }
  return trace;
}

double SpringBalance::rest_of(const Points& q) const {
  double rest = springs_.scatter;
  for (int n = 0; n < mesh_.node_count(); ++n)
    rest += springs_.weight[n] *
            (q.row(mesh_.position_dof(n)).transpose() - springs_.goal[n]).squaredNorm();
  return rest;
}

double SpringBalance::moved(double lambda) { return std::sqrt(rest_of(solve(lambda)) / points_); }

double SpringBalance::score(double lambda, double most) {
  const double dearer = 1 + 0.4 * std::clamp((points_ - 6) / 14.0, 0.0, 1.0);
  const double rest = rest_of(solve(lambda));
  const double left = points_ - dearer * freedom();
  return left > 0 && rest <= points_ * most * most ? rest / (left * left)
                                                   : std::numeric_limits<double>::infinity();
}

double minimum_of(const std::function<double(double)>& f, double low, double high, int samples) {
  double best = low, best_value = std::numeric_limits<double>::infinity();
  // From the fairest on, so that of equal ones the fairest wins.
  for (int i = samples; i >= 0; --i) {
    const double x = low + (high - low) * i / samples, value = f(x);
    if (value < best_value) {
      best = x;
      best_value = value;
    }
  }
  double a = std::max(low, best - (high - low) / samples),
         b = std::min(high, best + (high - low) / samples);
  const double golden = 1 / std::numbers::phi;
  double x = b - golden * (b - a), y = a + golden * (b - a), fx = f(x), fy = f(y);
  for (int i = 0; i < 8; ++i) {
    if (fx < fy) {
      b = y;
      y = x;
      fy = fx;
      fx = f(x = b - golden * (b - a));
    } else {
      a = x;
      x = y;
      fx = fy;
      fy = f(y = a + golden * (b - a));
    }
  }
  return fx < best_value || fy < best_value ? (fx < fy ? x : y) : best;
}

}  // namespace batten
