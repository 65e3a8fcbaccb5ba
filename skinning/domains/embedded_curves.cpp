// Lines of an embedding as curves.

#include "batten/core/format.h"
#include "batten/skinning/domains/domain_input.h"

namespace batten {
namespace {

// Of lines in an embedding: fit and gap share the tolerance.
constexpr double kFitToleranceFraction = 0.25;

FitOptions fit_options(const DomainInput& task, bool closed) {
  FitOptions fit;
  fit.tolerance = kFitToleranceFraction * task.tolerance;
  fit.corner_angle = 180;
  fit.closed = closed;
  fit.fixed_parameters = true;
  return fit;
}

HermiteCurve fitted_open(const SmoothSegment& s, const LoopVertex& start, const LoopVertex& end,
                         const DomainInput& task) {
  if (s.prescribed) return s.prescribed->curve;
  if (const auto exact = reuse_cubic_input(s, 0, start.position, end.position)) return *exact;
  FitOptions fit = fit_options(task, false);
  fit.start = {start.position, start.outgoing};
  fit.end = {end.position, end.incoming};
  return fit_curve(s.name, s.curve, fit);
}

HermiteCurve fitted_closed(const SmoothSegment& s, const DomainInput& task) {
  if (s.prescribed && s.prescribed->curve.segment_count() > 1)
    return as_closed_curve(s.prescribed->curve);
  const FitOptions fit = fit_options(task, true);
  if (const auto exact = exact_curve(*s.curve, fit.corner_angle); exact && exact->closed())
    return *exact;
  return fit_curve(s.name, s.curve, fit);
}

bool closes(const SmoothSegment& s, double gap_tolerance) {
  const InputCurve& c = *s.curve;
  return (c.evaluate(c.start()) - c.evaluate(c.end())).norm() <= gap_tolerance;
}

bool smooth_at_seam(const SmoothSegment& s, double corner_angle) {
  const InputCurve& c = *s.curve;
  return degrees_between(c.evaluate(c.end(), 1), c.evaluate(c.start(), 1)) <= corner_angle;
}

}  // namespace

std::vector<EmbeddedLine> fit_loop_lines(const Outline& loop, const DomainInput& task) {
  std::vector<EmbeddedLine> lines;
  const size_t n = loop.segments.size();
  for (size_t p = 0; p < n; ++p) {
    const auto& piece = loop.segments[p];
    EmbeddedLine line;
    line.line = piece.segment.line(false);
    line.fitted = n == 1 && loop.corners.empty()
                      ? fitted_closed(piece.segment, task)
                      : fitted_open(piece.segment, loop_vertex_at(loop, p),
                                    loop_vertex_at(loop, (p + 1) % n), task);
    if (piece.segment.prescribed && piece.flipped) line.fitted = line.fitted.backwards();
    lines.push_back(std::move(line));
  }
  return lines;
}

EmbeddedLine fit_inner_line(const SmoothSegment& s, const DomainInput& task) {
  const InputCurve& c = *s.curve;
  EmbeddedLine line;
  line.line = s.line(false);
  if (closes(s, task.gap_tolerance) && smooth_at_seam(s, task.options.corner_angle)) {
    line.fitted = fitted_closed(s, task);
    return line;
  }
  Vec3 start = c.evaluate(c.start()), end = c.evaluate(c.end());
  if (closes(s, task.gap_tolerance)) start = end = 0.5 * (start + end);
  const Vec3 t0 = c.evaluate(c.start(), 1).normalized(), t1 = c.evaluate(c.end(), 1).normalized();
  line.fitted = fitted_open(s, {start, t0, t0}, {end, t1, t1}, task);
  return line;
}

}  // namespace batten
