// Lines of an embedding as curves.

#include "batten/core/words.h"
#include "batten/skinning/domains/domain_task.h"

namespace batten {
namespace {

// Of lines in an embedding: fit and gap share the tolerance.
constexpr double kFitShare = 0.25;

FitOptions fit_options(const DomainTask& task, bool closed) {
  FitOptions fit;
  fit.tolerance = kFitShare * task.tolerance;
  fit.corner_angle = 180;
  fit.closed = closed;
  fit.even = true;
  return fit;
}

HermiteCurve fitted_open(const Stretch& s, const Joint& start, const Joint& end,
                         const DomainTask& task) {
  if (s.given) return s.given->curve;
  if (const auto exact = kept_as_given(s, 0, start.position, end.position)) return *exact;
  FitOptions fit = fit_options(task, false);
  fit.start = {start.position, start.outgoing};
  fit.end = {end.position, end.incoming};
  return fit_curve(s.name, s.curve, fit);
}

HermiteCurve fitted_closed(const Stretch& s, const DomainTask& task) {
  if (s.given && s.given->curve.segment_count() > 1) return closed_curve(s.given->curve);
  const FitOptions fit = fit_options(task, true);
  if (const auto exact = exact_curve(*s.curve, fit.corner_angle); exact && exact->closed())
    return *exact;
  return fit_curve(s.name, s.curve, fit);
}

bool closes(const Stretch& s, double join) {
  const InputCurve& c = *s.curve;
  return (c.evaluate(c.start()) - c.evaluate(c.end())).norm() <= join;
}

bool smooth_at_seam(const Stretch& s, double corner_angle) {
  const InputCurve& c = *s.curve;
  return degrees_between(c.evaluate(c.end(), 1), c.evaluate(c.start(), 1)) <= corner_angle;
}

}  // namespace

std::vector<EmbeddedLine> embedded_loop(const Outline& loop, const DomainTask& task) {
  std::vector<EmbeddedLine> lines;
  const size_t n = loop.pieces.size();
  for (size_t p = 0; p < n; ++p) {
    const auto& piece = loop.pieces[p];
    EmbeddedLine line;
    line.line = piece.stretch.line(false);
    line.fitted = n == 1 && loop.corners.empty() ? fitted_closed(piece.stretch, task)
                                                 : fitted_open(piece.stretch, joint_at(loop, p),
                                                               joint_at(loop, (p + 1) % n), task);
    if (piece.stretch.given && piece.flipped) line.fitted = line.fitted.backwards();
    lines.push_back(std::move(line));
  }
  return lines;
}

EmbeddedLine embedded_inner(const Stretch& s, const DomainTask& task) {
  const InputCurve& c = *s.curve;
  EmbeddedLine line;
  line.line = s.line(false);
  if (closes(s, task.join) && smooth_at_seam(s, task.options.corner_angle)) {
    line.fitted = fitted_closed(s, task);
    return line;
  }
  Vec3 start = c.evaluate(c.start()), end = c.evaluate(c.end());
  if (closes(s, task.join)) start = end = 0.5 * (start + end);
  const Vec3 t0 = c.evaluate(c.start(), 1).normalized(), t1 = c.evaluate(c.end(), 1).normalized();
  line.fitted = fitted_open(s, {start, t0, t0}, {end, t1, t1}, task);
  return line;
}

}  // namespace batten
