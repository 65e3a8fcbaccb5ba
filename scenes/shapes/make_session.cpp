// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/shapes/make_session.h"

#include <algorithm>
#include <map>
#include <set>

#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_fit.h"
#include "batten/io/files/input_file.h"
#include "batten/scenes/lines/line_files.h"
#include "batten/skinning/model/model_projector.h"
#include "batten/skinning/model/model_shapes.h"

namespace batten {
namespace {

/// From this number of elements, one facet per element is enough for display.
constexpr int kManyTriangles = 40'000;

/// Points farther from the surface than this, relative to its size, are input errors.
constexpr double kMaxRelativeDistance = 0.5;

/// Resolves the names and positions of a scene on a layout.
class SceneOnLayout {
 public:
  SceneOnLayout(const Scene& scene, const ModelLayout& layout, const BuiltModel& made)
      : scene_(scene), layout_(layout), made_(made) {
    for (const ModelLine& line : layout.lines()) names_.push_back(line.name);
  }

  bool has(const std::string& name) const {
    return std::find(names_.begin(), names_.end(), name) != names_.end();
  }
  /// The line, or the segments into which corners and holes split it.
  std::vector<std::string> segments(const LocatedString& word) const {
    if (has(word.text)) return {word.text};
    std::vector<std::string> parts;
    for (const auto& name : names_)
      if (is_part_of(name, word.text)) parts.push_back(name);
    if (parts.empty())
      throw InputError(scene_.at(word.location) + "found the curve '" + word.text +
                       "', expected one of: " + comma_separated(names_) +
                       did_you_mean(word.text, names_));
    return parts;
  }
  std::string line(const LocatedString& word) const {
    const std::vector<std::string> parts = segments(word);
    if (has(word.text)) return word.text;
    throw InputError(scene_.at(word.location) + "found the curve '" + word.text +
                     "', which is split into segments, expected one of: " + comma_separated(parts));
  }

  Area area(const SceneArea& area) const {
    Area result = area.area;
    if (auto* near = std::get_if<Area::NearLine>(&result.where)) near->line = line(area.line);
    for (const LocatedString& word : area.regions) result.regions.push_back(region(word));
    return result;
  }
  std::string region(const LocatedString& word) const {
    const std::vector<std::string> names = made_.region_names();
    if (std::find(names.begin(), names.end(), word.text) != names.end()) return word.text;
    for (const ModelRegion& other : made_.model.regions)
      if (other.plan.name == word.text)
        throw InputError(scene_.at(word.location) + "found the face '" + word.text +
                         "', which has no surface (" + other.rejection_reason +
                         "), expected one of: " + comma_separated(names));
    throw InputError(scene_.at(word.location) + "found the face '" + word.text + "', expected " +
                     expected_one_of(word.text, names));
  }

  /// A line of the layout, or one from a file.
  HermiteCurve curve(const SceneLoad& load) const {
    if (has(load.curve.text)) return layout_.line(load.curve.text);
    if (line_file_kind(load.file) == LineFileKind::None)
      line(load.curve);  // not a file: reports
                         // an unknown line
    require_input_file(load.file, "a curve file, or one of the curves " + comma_separated(names_),
                       scene_.at(load.location));
    const auto lines = read_source_file(load.file, load.unit, scene_.unit);
    if (lines.size() != 1)
      throw InputError(scene_.at(load.location) + "found " + std::to_string(lines.size()) +
                       " curves in '" + load.file.string() + "', expected one");
    FitOptions options;
    options.corner_angle = scene_.skin.options.corner_angle;
    const auto input = lines.front().as_curve(options.corner_angle);
    Box3 box(input->evaluate(input->start()));
    constexpr int samples = 64;
    for (int i = 1; i <= samples; ++i)
      box.extend(input->evaluate(input->start() + (input->end() - input->start()) * i / samples));
    constexpr double usual = 1e-4;  // relative to its size, as for lines of the surface
    options.tolerance = scene_.skin.options.tolerance > 0 ? scene_.skin.options.tolerance
                                                          : usual * box.diagonal().norm();
    return fit_curve(lines.front().name, input, options);
  }

  Load load(const SceneLoad& load) const {
    using Type = SceneLoad::Type;
    switch (load.type) {
      case Type::Pressure:
        return {load.name, Load::Pressure{area(load.area)}};
      case Type::Uniform:
        return {load.name, Load::Uniform{load.direction, area(load.area)}};
      case Type::Gravity:
        return {load.name, Load::Gravity{load.direction}};
      case Type::Point:
        return {load.name, Load::Point{load.at, load.direction}};
      case Type::Line:
        return {load.name, Load::Line{line(load.line), load.direction}};
      case Type::PointCloudSprings:
        return {load.name, Load::PointCloudSprings{scan_points(scene_, load)}};
      case Type::AttractorSprings:
        break;
    }
    Load::AttractorSprings pulls = load.pulls;
    if (!load.curve.text.empty()) pulls.target = Load::AttractorSprings::Curve{curve(load)};
    return {load.name, std::move(pulls)};
  }

  StiffnessField weight(const SceneStiffnessField& weight) const {
    StiffnessField field{weight.name, weight.kind, area(weight.area), {}};
    if (!weight.along) return field;
    if (const auto* word = std::get_if<LocatedString>(&*weight.along))
      field.along = line(*word);
    else
      field.along = std::get<Vec2>(*weight.along);
    return field;
  }

 private:
  const Scene& scene_;
  const ModelLayout& layout_;
  const BuiltModel& made_;
  std::vector<std::string> names_;
};

/// The parameters of the scene without rules, which are added once all parameters exist.
std::map<std::string, ScalarParameter> values_of(const Scene& scene) {
  std::map<std::string, ScalarParameter> values;
  for (ScalarParameter p : scene.named_values()) {
    p.rule_terms.clear();
    p.offset = 0;
    values.emplace(p.name, std::move(p));
  }
  return values;
}

bool driven(const Scene& scene, const std::string& name) {
  for (const SceneRule& rule : scene.rules)
    if (rule.driven == name) return true;
  return false;
}

class SessionBuilder {
 public:
  SessionBuilder(const ModelLayout& layout, const Scene& scene, const BuiltModel& made,
                 FactorReuse factor_reuse, const Progress& progress, RestShapeFunction rest)
      : scene_(scene),
        on_layout_(scene, layout, made),
        values_(values_of(scene)),
        session_(layout,
                 options(scene, layout.mesh()->triangle_count(), factor_reuse, std::move(rest)),
                 progress),
        unloaded_(session_.dofs()),
        unloaded_projector_(layout, unloaded_) {}

  SculptingSession made() {
    using Type = SceneConstraint::Type;
    // Constraints that preserve the current state come first.
    for (const auto& c : scene_.constraints)
      if (c.type == Type::LineNormal && c.keep_tangent_planes)
        add(c.location, Constraint{c.name, Constraint::LineNormal{on_layout_.line(c.line), {}}});
    for (const bool keyframes : {false, true})
      for (const SceneLineOffset& move : scene_.moves)
        if (!move.keyframes.empty() == keyframes) add_move(move);
    for (const auto& c : scene_.constraints)
      if (c.type == Type::Point) add_point(c);
    for (const auto& c : scene_.constraints) {
      if (c.type == Type::Normal)
        add(c.location, Constraint{c.name, Constraint::Normal{now(c), c.goal}});
      else if (c.type == Type::Tangent)
        add(c.location, Constraint{c.name, Constraint::Tangent{now(c), c.along, c.goal}});
      else if (c.type == Type::LineNormal && !c.keep_tangent_planes)
        add(c.location,
            Constraint{c.name, Constraint::LineNormal{on_layout_.line(c.line), c.goal}});
    }
    // Loads act at the nearest points of the surface under the constraints alone; they take effect
    // with the next solution.
    if (!goals_.empty()) {
      for (const auto& [name, value] : goals_) session_.set(name, value);
      session_.solve_to_equilibrium();
    }
    constrained_ = session_.dofs();
    for (const SceneLoad& load : scene_.loads)
      add(load.name_location, on_layout_.load(load), {values_.at(load.name)});
    for (const SceneStiffnessField& weight : scene_.weights)
      add(weight.name_location, on_layout_.weight(weight), {values_.at(weight.name)});
    for (const ScalarParameter& slider : scene_.sliders)
      session_.add_parameter(values_.at(slider.name));
    for (const auto& [name, value] : moves_) session_.set(name, value);
    for (const ScalarParameter& p : scene_.named_values())
      if (!p.rule_terms.empty()) session_.set_rule(p.name, p.rule_terms, p.offset);
    session_.clear_history();
    return std::move(session_);
  }
  SessionReference start() && { return {std::move(unloaded_), std::move(constrained_)}; }

 private:
  static SessionOptions options(const Scene& scene, int triangles, FactorReuse factor_reuse,
                                RestShapeFunction rest) {
    SessionOptions options;
    options.rest = std::move(rest);
    options.factor_reuse = factor_reuse;
    options.material = scene.skin.material;
    options.isotropic_alpha = scene.skin.isotropic_alpha;
    options.isotropic_beta = scene.skin.isotropic_beta;
    options.units = scene.skin.units;
    options.fix_corners_only = scene.skin.boundary == SceneSkin::FixedBoundary::Corners;
    options.facets_per_edge = triangles > kManyTriangles ? 1 : 2;
    return options;
  }

  /// Current position of the point that is nearest on the unloaded surface. Constraints added
  /// before have moved it.
  Vec3 now(const SceneConstraint& c) const {
    const auto was = unloaded_projector_.nearest_inside(c.at);
    const double size = session_.layout().size();
    if (!(was.distance <= kMaxRelativeDistance * size))
      throw InputError(scene_.at(c.location) + "found the constraint '" + c.name +
                       "' at a distance of " + format_number(was.distance) +
                       " from the surface, expected a point on it (its size is " +
                       format_number(size) + ")");
    return session_.layout()
        .surface(session_.dofs())
        .position(session_.layout().to_model_location(was.at.region, was.where));
  }

  /// Adds the location in the scene to exceptions of the session.
  template <class Thing>
  void add(const SourceLocation& location, const Thing& thing,
           const std::vector<ScalarParameter>& parameters = {}) {
    try {
      session_.add(thing, parameters);
    } catch (const InputError& e) {
      throw InputError(scene_.at(location) + e.what());
    }
  }

  /// Fraction of a segment over which its offset fades: as given, or else chosen so that the
  /// segment stays attached to lines that do not move.
  double blend_length(const SceneLineOffset& move, const std::string& segment) const {
    if (move.fade) return *move.fade;
    const ModelLayout& layout = session_.layout();
    const HermiteCurve& curve = layout.line(segment);
    std::set<std::string> moved;
    for (const SceneLineOffset& other : scene_.moves)
      for (std::string& name : on_layout_.segments(other.line)) moved.insert(std::move(name));
    const auto stays = [&](const Vec3& end) {
      return std::any_of(layout.lines().begin(), layout.lines().end(), [&](const ModelLine& line) {
        return !moved.count(line.name) &&
               layout.line(line.name).closest_point(end).distance <= layout.tolerance();
      });
    };
    constexpr double usual = 0.25;
    return !curve.closed() &&
                   (stays(curve.evaluate(curve.start())) || stays(curve.evaluate(curve.end())))
               ? usual
               : 0;
  }

  /// Adds a move with value 0, or the nearest value of its range, so that nothing moves yet.
  void add_move(const SceneLineOffset& move) {
    ScalarParameter p = values_.at(move.name);
    if (p.keyframes.empty()) {
      if (!driven(scene_, move.name)) moves_.emplace_back(move.name, p.value);
      p.value = std::clamp(0.0, p.min, p.max);
    }
    // The segments of a split line move together: all follow the first one.
    std::string name = move.name;
    int number = 1;
    for (const std::string& segment : on_layout_.segments(move.line)) {
      add(move.name_location,
          LineOffset{name, segment, move.direction, blend_length(move, segment)}, {p});
      name = move.name + "." + std::to_string(++number);
      p.name = name;
      p.keyframes.clear();
      p.rule_terms = {{move.name}};
    }
  }

  void add_point(const SceneConstraint& c) {
    Vec3 goal = now(c);
    std::vector<ScalarParameter> parameters;
    for (int i = 0; i < 3; ++i) {
      ScalarParameter p = values_.at(c.name + "." + "xyz"[i]);
      if (!driven(scene_, p.name)) goals_.emplace_back(p.name, p.value);
      p.value = goal[i] = std::clamp(goal[i], p.min, p.max);
      parameters.push_back(p);
    }
    add(c.location, Constraint{c.name, Constraint::Point{now(c), goal}}, parameters);
  }

  const Scene& scene_;
  SceneOnLayout on_layout_;
  std::map<std::string, ScalarParameter> values_;
  SculptingSession session_;
  Points unloaded_, constrained_;
  ModelProjector unloaded_projector_;
  // Set last, because the objects added before refer to the surface without them.
  std::vector<std::pair<std::string, double>> goals_, moves_;
};

}  // namespace

SculptingSession make_session(const ModelLayout& layout, const Scene& scene, const BuiltModel& made,
                              FactorReuse factor_reuse, const Progress& progress,
                              SessionReference* start, RestShapeFunction rest) {
  const std::string where = scene.at({});
  if (!rest && scene.skin.has_rest() && scene.skin.boundary == SceneSkin::FixedBoundary::Lines)
    rest = [](const RestShapeInput& task) { return rest_dofs(task.layout); };
  try {
    SessionBuilder builder(layout, scene, made, factor_reuse, progress, std::move(rest));
    SculptingSession session = builder.made();
    if (start) *start = std::move(builder).start();
    return session;
  } catch (const InputError& e) {
    const std::string message = e.what();
    const std::string file = scene.file.string();
    throw InputError(!file.empty() && message.starts_with(file) ? message : where + message);
  }
}

void add_load(SculptingSession& session, const Scene& scene, const BuiltModel& made,
              const SceneLoad& load, const Points& constrained) {
  const ModelLayout& layout = session.layout();
  const ModelProjector places(layout, constrained);
  const Surface present = layout.surface(session.dofs());
  const auto now = [&](const Vec3& at) {
    const ModelProjector::Nearest was = places.nearest_inside(at);
    if (!(was.distance <= kMaxRelativeDistance * layout.size()))
      return at;  // rejected by the session
    return present.position(layout.to_model_location(was.at.region, was.where));
  };
  Load added = SceneOnLayout(scene, layout, made).load(load);
  if (auto* point = std::get_if<Load::Point>(&added.kind)) point->at = now(point->at);
  if (auto* pulls = std::get_if<Load::AttractorSprings>(&added.kind))
    for (Vec3& at : pulls->at) at = now(at);
  try {
    session.add(added, {values_of(scene).at(load.name)});
  } catch (const InputError& e) {
    throw InputError(scene.at(load.name_location) + e.what());
  }
}

bool is_session_parameter(const Scene& scene, const std::string& parameter) {
  bool live = true;
  for_each_fair_parameter(scene.fairing,
                          [&](const std::string& name, double) { live &= name != parameter; });
  for (const auto& c : scene.constraints)
    for (int i = 0; i < 3 && c.type != SceneConstraint::Type::Point; ++i)
      live &= parameter != c.name + "." + "xyz"[i];
  return live;
}

}  // namespace batten
