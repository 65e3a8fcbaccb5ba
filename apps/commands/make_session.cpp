#include "batten/apps/commands/make_session.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "batten/apps/commands/line_files.h"
#include "batten/core/words.h"
#include "batten/fairing/curve_fit.h"

namespace batten {
namespace {

/// What the scene's words mean on one layout.
class SceneOnLayout {
 public:
  SceneOnLayout(const Scene& scene, const RegionLayout& layout)
      : scene_(scene), runs_(layout.runs()), embedded_(layout.embedded()) {
    for (const LineRun& run : runs_) names_.push_back(run.line.name);
    for (const EmbeddedLine& line : embedded_) names_.push_back(line.line.name);
  }

  bool has(const std::string& name) const {
    return std::find(names_.begin(), names_.end(), name) != names_.end();
  }
  std::string line(const PlacedWord& word) const {
    if (has(word.text)) return word.text;
    std::vector<std::string> parts;
    for (const auto& name : names_)
      if (is_part_of(name, word.text)) parts.push_back(name);
    throw InputError(scene_.at(word.place) + "found the line '" + word.text + "'" +
                     (parts.empty() ? "" : ", which was cut at its corners") +
                     ", expected one of: " + listed(parts.empty() ? names_ : parts) +
                     (parts.empty() ? did_you_mean(word.text, names_) : ""));
  }

  Area area(const SceneArea& area) const {
    Area result = area.area;
    if (auto* near = std::get_if<Area::NearLine>(&result.where)) near->line = line(area.line);
    return result;
  }

  /// A line of the layout, or one from a file.
  HermiteCurve curve(const SceneLoad& load) const {
    for (const LineRun& run : runs_)
      if (run.line.name == load.curve.text) return run.fitted;
    for (const EmbeddedLine& e : embedded_)
      if (e.line.name == load.curve.text) return e.fitted;
    if (line_file_kind(load.file) == LineFileKind::None) line(load.curve);  // no file: a wrong name
    if (!std::filesystem::is_regular_file(load.file))
      throw InputError(scene_.at(load.place) + "found '" + load.file.string() +
                       "', expected a file of a line, or one of: " + listed(names_));
    const auto lines = read_source_file(load.file, load.unit, scene_.unit);
    if (lines.size() != 1)
      throw InputError(scene_.at(load.place) + "found " + std::to_string(lines.size()) +
                       " lines in '" + load.file.string() + "', expected one");
    FitOptions options;
    options.corner_angle = scene_.skin.options.corner_angle;
    const auto input = lines.front().as_curve(options.corner_angle);
    Vec3 low = input->evaluate(input->start()), high = low;
    constexpr int samples = 64;
    for (int i = 1; i <= samples; ++i) {
      const Vec3 p =
          input->evaluate(input->start() + (input->end() - input->start()) * i / samples);
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    constexpr double usual = 1e-4;  // of its size, as lines of the surface
    options.tolerance = scene_.skin.options.tolerance > 0 ? scene_.skin.options.tolerance
                                                          : usual * (high - low).norm();
    return fit_curve(lines.front().name, input, options);
  }

  LiveLoad load(const SceneLoad& load) const {
    using Type = SceneLoad::Type;
    switch (load.type) {
      case Type::Pressure:
        return {load.name, LiveLoad::Pressure{area(load.area)}};
      case Type::Uniform:
        return {load.name, LiveLoad::Uniform{load.direction, area(load.area)}};
      case Type::Gravity:
        return {load.name, LiveLoad::Gravity{load.direction}};
      case Type::Point:
        return {load.name, LiveLoad::Point{load.at, load.direction}};
      case Type::Line:
        return {load.name, LiveLoad::Line{line(load.line), load.direction}};
      case Type::Springs:
        return {load.name, LiveLoad::Measured{spring_points(scene_, load)}};
      case Type::Pulls:
        break;
    }
    LiveLoad::Springs springs = load.pulls;
    if (!load.curve.text.empty()) springs.target = LiveLoad::Springs::Curve{curve(load)};
    return {load.name, std::move(springs)};
  }

  WeightField weight(const SceneWeight& weight) const {
    WeightField field{weight.name, weight.kind, area(weight.area), {}};
    if (!weight.along) return field;
    if (const auto* word = std::get_if<PlacedWord>(&*weight.along))
      field.along = line(*word);
    else
      field.along = std::get<Vec2>(*weight.along);
    return field;
  }

 private:
  const Scene& scene_;
  // The layout goes to the session.
  const std::vector<LineRun> runs_;
  const std::vector<EmbeddedLine> embedded_;
  std::vector<std::string> names_;
};

/// The scene's parameters, without rules: these come when all parameters are there.
std::map<std::string, NamedValue> values_of(const Scene& scene) {
  std::map<std::string, NamedValue> values;
  for (NamedValue p : scene.named_values()) {
    p.follows.clear();
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

class Maker {
 public:
  Maker(RegionLayout layout, const Scene& scene, const Progress& progress)
      : scene_(scene),
        on_layout_(scene, layout),
        values_(values_of(scene)),
        session_(std::move(layout), options(scene), progress),
        unloaded_(session_.region().surface) {}

  SculptingSession made() {
    using Type = SceneConstraint::Type;
    // What refers to the surface as it is comes first.
    for (const auto& c : scene_.constraints)
      if (c.type == Type::LineNormal && c.as_it_is)
        session_.add(
            LiveConstraint{c.name, LiveConstraint::LineNormal{on_layout_.line(c.line), {}}});
    for (const bool over_time : {false, true})
      for (const SceneMove& move : scene_.moves)
        if (!move.over_time.empty() == over_time) add(move);
    for (const auto& c : scene_.constraints)
      if (c.type == Type::Point) add_point(c);
    for (const auto& c : scene_.constraints) {
      if (c.type == Type::Normal)
        session_.add(LiveConstraint{c.name, LiveConstraint::Normal{now(c.at), c.goal}});
      else if (c.type == Type::Tangent)
        session_.add(LiveConstraint{c.name, LiveConstraint::Tangent{now(c.at), c.along, c.goal}});
      else if (c.type == Type::LineNormal && !c.as_it_is)
        session_.add(
            LiveConstraint{c.name, LiveConstraint::LineNormal{on_layout_.line(c.line), c.goal}});
    }
    // Loads act where the surface under the constraints alone is nearest, as in sculpt(); they take
    // effect with the next answer only.
    if (!goals_.empty()) {
      for (const auto& [name, value] : goals_) session_.set(name, value);
      session_.settle();
    }
    for (const SceneLoad& load : scene_.loads)
      session_.add(on_layout_.load(load), {values_.at(load.name)});
    for (const SceneWeight& weight : scene_.weights)
      session_.add(on_layout_.weight(weight), {values_.at(weight.name)});
    for (const NamedValue& slider : scene_.sliders) session_.add_parameter(values_.at(slider.name));
    for (const auto& [name, value] : moves_) session_.set(name, value);
    for (const NamedValue& p : scene_.named_values())
      if (!p.follows.empty()) session_.drive(p.name, p.follows, p.offset);
    return std::move(session_);
  }
  const Surface& unloaded() const { return unloaded_; }

 private:
  static SessionOptions options(const Scene& scene) {
    SessionOptions options;
    options.material = scene.skin.material;
    options.isotropic_alpha = scene.skin.isotropic_alpha;
    options.isotropic_beta = scene.skin.isotropic_beta;
    options.units = scene.skin.units;
    options.hold_corners = scene.skin.hold == SceneSkin::Hold::Corners;
    return options;
  }

  /// Where the place nearest on the unloaded surface is by now: constraints that were added have
  /// moved it.
  Vec3 now(const Vec3& at) const {
    return session_.region().surface.position(unloaded_.closest_point(at).where);
  }

  /// Added where it does not move anything yet.
  void add(const SceneMove& move) {
    NamedValue p = values_.at(move.name);
    if (p.over_time.empty()) {
      if (!driven(scene_, move.name)) moves_.emplace_back(move.name, p.value);
      p.value = std::clamp(0.0, p.min, p.max);
    }
    session_.add(LineMove{move.name, on_layout_.line(move.line), move.direction, move.fade}, {p});
  }

  void add_point(const SceneConstraint& c) {
    Vec3 goal = now(c.at);
    std::vector<NamedValue> parameters;
    for (int i = 0; i < 3; ++i) {
      NamedValue p = values_.at(c.name + "." + "xyz"[i]);
      if (!driven(scene_, p.name)) goals_.emplace_back(p.name, p.value);
      p.value = goal[i] = std::clamp(goal[i], p.min, p.max);
      parameters.push_back(p);
    }
    session_.add(LiveConstraint{c.name, LiveConstraint::Point{now(c.at), goal}}, parameters);
  }

  const Scene& scene_;
  SceneOnLayout on_layout_;
  std::map<std::string, NamedValue> values_;
  SculptingSession session_;
  Surface unloaded_;
  // Set when nothing that is to be added refers to the surface without them.
  std::vector<std::pair<std::string, double>> goals_, moves_;
};

/// Degrees between the surface's normal at a place and a direction, either sign.
double turned(const Surface& surface, const Location& where, const Vec3& direction) {
  const Vec3 n = surface.jet(where).normal();
  return std::min(degrees_between(n, direction), degrees_between(n, -direction));
}

}  // namespace

SculptingSession make_session(RegionLayout layout, const Scene& scene, const Progress& progress,
                              std::optional<Surface>* unloaded) {
  const std::string where = scene.at({});
  try {
    Maker maker(std::move(layout), scene, progress);
    if (unloaded) unloaded->emplace(maker.unloaded());
    return maker.made();
  } catch (const InputError& e) {
    const std::string message = e.what();
    const std::string file = scene.file.string();
    throw InputError(!file.empty() && message.starts_with(file) ? message : where + message);
  }
}

void refine_for_lines(RegionLayout& layout, const Scene& scene, const Progress& progress) {
  if (scene.skin.hold != SceneSkin::Hold::Lines || layout.embedded().empty()) return;
  constexpr int most_rounds = 8;
  for (int round = 0; round < most_rounds; ++round) {
    SculptingSession session = make_session(layout, scene, progress);
    try {
      session.settle();
    } catch (const NoSolutionError&) {
      return;
    }
    const SkinnedRegion region = session.region();
    double gap = 0;
    for (const EmbeddedLine& line : region.embedded)
      gap = std::max(gap, line_gap(region.surface, line));
    if (gap <= kMostGap * layout.tolerance()) return;
    if (!halve_at_gaps(layout, region, 0.5 * layout.tolerance())) return;
  }
}

bool is_live(const Scene& scene, const std::string& parameter) {
  bool live = true;
  for_each_fair_parameter(scene.fairing,
                          [&](const std::string& name, double) { live &= name != parameter; });
  for (const auto& c : scene.constraints)
    for (int i = 0; i < 3 && c.type != SceneConstraint::Type::Point; ++i)
      live &= parameter != c.name + "." + "xyz"[i];
  return live;
}

MadeShape shape_of(const SculptingSession& session, const Scene& scene, const Surface& unloaded,
                   const Answer& answer) {
  MadeShape made{session.region(), unloaded, {}};
  made.sculpt.dofs = session.dofs();
  made.sculpt.energy = session.energy();
  made.sculpt.iterations = answer.iterations;
  made.sculpt.last_change = answer.change;
  made.sculpt.max_constraint_residual = session.residual();
  made.sculpt.reactions = session.reactions();
  for (const auto& c : scene.constraints)
    if (c.type == SceneConstraint::Type::Normal) {
      // The mesh may be finer by now.
      const Location was = unloaded.closest_point(c.at).where;
      const Vec2 uv = unloaded.mesh().shape(was.triangle).point(was.L);
      const Surface& surface = made.region.surface;
      const double degrees = turned(surface, surface.locate(uv), c.goal);
      if (!(degrees <= made.max_normal_constraint_deg)) made.max_normal_constraint_deg = degrees;
    }
  return made;
}

}  // namespace batten
