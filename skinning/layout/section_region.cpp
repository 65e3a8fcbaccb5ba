#include "batten/skinning/layout/section_region.h"

#include <algorithm>
#include <utility>

#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/fairing/not_a_knot_spline.h"

namespace batten {
namespace {

struct Ends {
  Vec3 start, end;
};

Ends ends_of(const CharacterLine& line) {
  return {line.curve->evaluate(line.curve->start()), line.curve->evaluate(line.curve->end())};
}

bool is_closed(const CharacterLine& line) {
  const auto [start, end] = ends_of(line);
  const double middle = 0.5 * (line.curve->start() + line.curve->end());
  constexpr double same = 1e-9;
  return (start - end).norm() <= same * (line.curve->evaluate(middle) - start).norm();
}

CharacterLine rail(const std::string& name, const std::vector<Vec3>& points) {
  std::vector<double> u{0};
  Points x(static_cast<long>(points.size()), 3);
  for (size_t i = 0; i < points.size(); ++i) {
    x.row(static_cast<long>(i)) = points[i];
    if (i > 0) u.push_back(u.back() + (points[i] - points[i - 1]).norm());
  }
  CharacterLine line;
  line.name = name;
  line.curve = curve_from_hermite(HermiteCurve(u, x, not_a_knot_slopes(u, x)));
  return line;
}

}  // namespace

std::vector<CharacterLine> section_lines(std::vector<CharacterLine> sections) {
  if (sections.size() < 2)
    throw InputError("found " + std::to_string(sections.size()) +
                     " section, expected two or more, or rails beside it");
  const bool closed = is_closed(sections.front());
  std::vector<Vec3> starts, ends;
  for (CharacterLine& section : sections) {
    const bool outer = &section == &sections.front() || &section == &sections.back();
    section.role = outer ? CharacterLine::Role::Outline : CharacterLine::Role::Inner;
    if (is_closed(section) != closed)
      throw InputError("the section '" + section.name + "' is " + (closed ? "open" : "closed") +
                       ", '" + sections.front().name + "' is " + (closed ? "closed" : "open") +
                       ": expected all alike");
    auto [start, end] = ends_of(section);
    if (!starts.empty() && (start - starts.back()).norm() + (end - ends.back()).norm() >
                               (end - starts.back()).norm() + (start - ends.back()).norm())
      std::swap(start, end);
    if (!closed && !starts.empty() && (start == starts.back() || end == ends.back()))
      throw InputError("the section '" + section.name + "' ends where the one before it does, " +
                       "expected a place of its own: no rail can run there");
    starts.push_back(start);
    ends.push_back(end);
  }
  if (closed) return sections;
  sections.push_back(rail("rail 1", starts));
  sections.push_back(rail("rail 2", ends));
  return sections;
}

bool have_corner_at_seam(const std::vector<CharacterLine>& sections, double corner_angle) {
  return !sections.empty() &&
         std::all_of(sections.begin(), sections.end(), [&](const CharacterLine& line) {
           const InputCurve& curve = *line.curve;
           return is_closed(line) && degrees_between(curve.evaluate(curve.start(), 1),
                                                     curve.evaluate(curve.end(), 1)) > corner_angle;
         });
}

std::vector<CharacterLine> corner_rails(const std::vector<CharacterLine>& sections) {
  if (sections.size() < 2)
    throw InputError("found " + std::to_string(sections.size()) + " section, expected two or more");
  std::vector<Vec3> corners, noses;
  for (const CharacterLine& line : sections) {
    const InputCurve& curve = *line.curve;
    corners.push_back(curve.evaluate(curve.start()));
    constexpr int samples = 400;
    double most = 0;
    noses.push_back(corners.back());
    for (int k = 1; k < samples; ++k) {
      const Vec3 p = curve.evaluate(curve.start() + (curve.end() - curve.start()) * k / samples);
      if (const double d = (p - corners.back()).norm(); d > most) most = d, noses.back() = p;
    }
  }
  return {rail("rail 1", corners), rail("rail 2", noses)};
}

RegionLayout section_region(const std::string& name, std::vector<CharacterLine> sections,
                            SkinOptions options, const Progress& progress) {
  const std::vector<CharacterLine> lines = section_lines(std::move(sections));
  options.sections = true;
  if (!is_closed(lines.back())) {
    options.corner_angle = std::min(options.corner_angle, 2.0);
    if (options.domain == SkinOptions::Domain::Auto) options.domain = SkinOptions::Domain::Polygon;
  }
  if (options.edge_length == 0) {
    Vec3 low = lines[0].curve->evaluate(lines[0].curve->start()), high = low;
    constexpr int samples = 64;
    for (const CharacterLine& line : lines)
      for (int i = 0; i <= samples; ++i) {
        const double f = static_cast<double>(i) / samples;
        const Vec3 p = line.curve->evaluate((1 - f) * line.curve->start() + f * line.curve->end());
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    options.edge_length = (high - low).norm() / 33;
  }
  return RegionLayout(name, lines, options, progress);
}

}  // namespace batten
