// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/stress.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "batten/analysis/models/shell_sensitivities.h"
#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/log.h"
#include "batten/core/parallel.h"
#include "batten/io/scene/scene_text.h"
#include "batten/scenes/shapes/stress_analysis.h"
#include "batten/scenes/shapes/stress_results.h"
#include "batten/scenes/shapes/stress_setup.h"
#include "batten/scenes/stress_data.h"

namespace batten {
namespace detail {

// Results at points.

size_t StressData::index(const std::string& load_case) const {
  if (load_case.empty() && !cases.empty()) return governing;
  std::vector<std::string> names;
  for (size_t c = 0; c < cases.size(); ++c) {
    if (cases[c].name == load_case) return c;
    names.push_back(cases[c].name);
  }
  throw InputError("found the load case '" + load_case +
                   "', expected one of the load cases of the analysis" +
                   did_you_mean(load_case, names));
}

StressData::Fields& StressData::fields(size_t load_case) const {
  if (fields_.empty()) fields_.resize(cases.size());
  return fields_.at(load_case);
}

const ShellStresses& StressData::made_stresses(size_t load_case) const {
  Fields& of = fields(load_case);
  if (!assembler_)
    assembler_ = std::make_unique<const ShellAssembler>(
        model->shape.layout->surface(model->shape.dofs), sections);
  if (!of.stresses)
    of.stresses = std::make_unique<const ShellStresses>(*assembler_, displacements[load_case],
                                                        temperatures[load_case]);
  return *of.stresses;
}

const Surface& StressData::made_moved(size_t load_case) const {
  Fields& of = fields(load_case);
  if (!of.moved)
    of.moved =
        std::make_unique<const Surface>(model->shape.layout->surface(displacements[load_case]));
  return *of.moved;
}

std::vector<double> StressData::made_positions(const Surface& surface) const {
  const std::vector<Location>& locations = model->facet_locations();
  std::vector<double> values(3 * locations.size());
  constexpr int chunk = 256;
  parallel_for_each<chunk>(isize(locations), [&](int i) {
    const auto at = static_cast<size_t>(i);
    Eigen::Map<Vec3>(values.data() + 3 * at) = surface.position(locations[at]);
  });
  return values;
}

template <class Value>
std::vector<double> StressData::made_values(size_t load_case, const Value& value) const {
  const ShellStresses& stresses = made_stresses(load_case);
  const std::vector<Location>& locations = model->facet_locations();
  std::vector<double> values(locations.size());
  constexpr int chunk = 256;
  parallel_for_each<chunk>(isize(locations), [&](int i) {
    values[static_cast<size_t>(i)] = value(stresses.at(locations[static_cast<size_t>(i)]));
  });
  return values;
}

const std::vector<double>& StressData::von_mises(size_t load_case) const {
  const std::lock_guard lock(mutex_);
  Fields& of = fields(load_case);
  if (!of.von_mises)
    of.von_mises = std::make_unique<const std::vector<double>>(
        made_values(load_case, [](const ShellStress& at) { return at.largest_von_mises().value; }));
  return *of.von_mises;
}

std::vector<double> StressData::von_mises(size_t load_case, const std::string& side) const {
  const std::vector<std::string> sides = {"bottom", "middle", "top"};
  const auto found = std::find(sides.begin(), sides.end(), side);
  if (found == sides.end())
    throw InputError("side: found '" + side + "', expected top, middle or bottom" +
                     did_you_mean(side, sides));
  const double height = static_cast<double>(found - sides.begin()) - 1;  // from -1 to 1
  const std::lock_guard lock(mutex_);
  return made_values(load_case,
                     [height](const ShellStress& at) { return batten::von_mises(at.at(height)); });
}

std::vector<double> StressData::thickness() const {
  std::vector<double> values;
  for (const Location& where : model->facet_locations())
    values.push_back(
        sections[sections.size() == 1 ? 0 : static_cast<size_t>(where.triangle)].thickness_at(
            where.L));
  return values;
}

const std::vector<double>& StressData::displacement(size_t load_case) const {
  const std::lock_guard lock(mutex_);
  Fields& of = fields(load_case);
  if (!of.displacement)
    of.displacement =
        std::make_unique<const std::vector<double>>(made_positions(made_moved(load_case)));
  return *of.displacement;
}

std::vector<double> StressData::mode(const std::vector<Points>& shapes, int index,
                                     const std::string& key) const {
  if (shapes.empty())
    throw InputError("index: found an analysis without mode shapes, expected one with '" + key +
                     "' above 0" +
                     (key == "buckling" ? " and a load under which the shell buckles" : ""));
  if (index < 0 || index >= isize(shapes))
    throw InputError("index: found " + std::to_string(index) + ", expected 0 to " +
                     std::to_string(shapes.size() - 1));
  const std::lock_guard lock(mutex_);
  std::vector<double> values =
      made_positions(model->shape.layout->surface(shapes[static_cast<size_t>(index)]));
  Eigen::Map<Eigen::Matrix<double, 3, Eigen::Dynamic>> vectors(
      values.data(), 3, static_cast<long>(values.size() / 3));
  vectors /= vectors.colwise().norm().maxCoeff();
  return values;
}

StressPoint StressData::at(const Vec3& p, size_t load_case) const {
  const ModelProjector::Nearest found = model->projector().nearest_inside(p);
  const SkinnedRegion& face = model->shape.regions[static_cast<size_t>(found.at.region)];
  const Location where = model->shape.layout->to_model_location(found.at.region, found.where);
  const SurfaceJet jet = face.surface.jet(found.where);
  const ShellStresses* stresses = nullptr;
  const Surface* moved = nullptr;
  {
    const std::lock_guard lock(mutex_);
    stresses = &made_stresses(load_case);
    moved = &made_moved(load_case);
  }
  const ShellStress stress = stresses->at(where);
  StressPoint point;
  point.position = jet.x;
  point.normal = jet.normal();
  point.face = face.name;
  point.distance = (jet.x - p).norm();
  point.displacement = moved->position(where);
  point.von_mises_top = batten::von_mises(stress.at(1));
  point.von_mises_middle = batten::von_mises(stress.at(0));
  point.von_mises_bottom = batten::von_mises(stress.at(-1));
  point.forces = stress.forces;
  point.moments = stress.moments;
  stress.for_each_ply_face([&](const PlyStress& at) { point.ply_stresses.push_back(at.stress); });
  return point;
}

// [stress] as text.

namespace {

/// Text of [stress], and the setting that each of its lines comes from.
class StressText {
 public:
  StressText(const StressTable& table, const std::string& unit) {
    add("unit = " + SceneText::toml_value(unit), "");
    add("[stress]", "");
    for (const auto& [key, value] : table.values) add(key + " = " + value, key);
    add_list("supports", table.supports);
    add_list("loads", table.loads);
    whole_ += table.settings;
    if (!whole_.ends_with('\n')) whole_ += "\n";
  }

  const std::string& whole() const { return whole_; }
  /// The table with its header.
  std::string table() const { return whole_.substr(whole_.find('\n') + 1); }

  /// A message in which the setting replaces the location "stress():LINE:COLUMN: ".
  std::string with_setting(const std::string& message) const {
    const std::string file = std::string(kStressFile) + ":";
    const size_t line_from = file.size(), line_to = message.find(':', line_from);
    const size_t column_to = message.find(": ", line_from);
    if (!message.starts_with(file) || column_to == std::string::npos || column_to <= line_to)
      return message;
    const int line = std::atoi(message.c_str() + line_from);
    if (line < 1) return message;
    std::string setting;
    if (line > isize(settings_))
      setting = "settings:" + std::to_string(line - isize(settings_)) +
                message.substr(line_to, column_to - line_to);
    else
      setting = settings_[static_cast<size_t>(line - 1)];
    return file + " " + (setting.empty() ? "" : setting + ": ") + message.substr(column_to + 2);
  }

 private:
  void add(const std::string& line, const std::string& setting) {
    whole_ += line + "\n";
    settings_.push_back(setting);
  }
  void add_list(const std::string& key, const std::vector<std::string>& tables) {
    if (tables.empty()) return;
    add(key + " = [", key);
    for (size_t i = 0; i < tables.size(); ++i)
      add("  " + tables[i] + ",", key + "[" + std::to_string(i) + "]");
    add("]", key);
  }

  std::string whole_;
  std::vector<std::string> settings_;  // of each line before the further settings
};

/// Reads [stress] as in a scene.
SceneStress parsed_stress(const StressText& text) {
  const Scene scene = parse_scene(text.whole(), kStressFile, false);
  const SceneText whole(text.whole(), kStressFile);
  for (const SceneTable& table : whole.tables())
    if (table.kind != "stress" && table.kind != "field")  // from the further settings
      throw InputError(std::string(kStressFile) + ": settings: found the table '" + table.kind +
                       "', expected keys of [stress], or [[field]]");
  return *scene.stress;
}

/// Keeps the displacements and mode shapes of an analysis.
class StressCollector : public StressVisitor {
 public:
  explicit StressCollector(StressData& data) : data_(data) {}
  void visit_shell(const ShellModel& shell) override {
    data_.sections = triangle_sections(shell.layout(), shell.definition());
  }
  void visit_case(const StressReport::Case&, const ShellCaseResult& result,
                  const ShellStresses&) override {
    data_.displacements.push_back(result.displacement);
    data_.temperatures.push_back(result.temperature);
    data_.buckling_shapes.emplace_back();
  }
  void visit_buckling(const StressReport::Case&, const std::vector<Points>& shapes) override {
    data_.buckling_shapes.back() = shapes;
  }
  void visit_modes(const std::vector<double>&, const std::vector<Points>& shapes) override {
    data_.mode_shapes = shapes;
  }

 private:
  StressData& data_;
};

StressCase stress_case(const StressReport::Case& c) {
  StressCase result;
  result.name = c.name;
  result.combination = c.combination;
  result.force = c.force;
  result.max_displacement = c.displacement;
  result.max_displacement_error = c.displacement_error;
  result.displacement = c.displacement_vector;
  result.displacement_at = c.max_displacement_at;
  result.displacement_face = c.max_displacement_region;
  result.max_von_mises = c.stress;
  result.stress_at = c.max_stress_at;
  result.stress_face = c.max_stress_region;
  result.stress_side = c.side;
  result.stress_spread = c.spread;
  result.near_singularity = c.near_singularity;
  for (const auto& place : c.singular_places)
    result.singular_places.push_back({place.at, place.radius});
  result.stress_ply = c.ply;
  for (const auto& r : c.reserves) result.reserve_factors[r.criterion] = r.factor;
  result.safety_factor = c.safety;
  result.strain_energy = c.energy;
  result.error_estimate = c.error;
  result.equilibrium_residual = c.equilibrium_residual;
  result.buckling_factors = c.buckling;
  for (const StressReport::Reaction& r : c.reactions)
    result.reactions.push_back({r.support, r.force, r.moment});
  return result;
}

/// Analyses the shape of a model. `scene`: its scene with the [stress] to use; `file`: that of the
/// model, to which the locations of all other tables belong.
void analyse_into(StressData& data, Scene scene, const std::filesystem::path& file,
                  const StressAccuracy& accuracy, const Progress& progress) {
  RunReport notes;
  const RefinedShape refined = refine_adaptively(scene, data.model->shape, accuracy, {}, progress);
  if (refined.meshes.size() > 1)
    data.model = std::make_shared<const ModelData>(data.model->text, data.model->scene, *data.model,
                                                   refined.shape, std::nullopt);
  const ModelData& model = *data.model;
  StressCollector collector(data);
  data.report = compute_stresses(scene, refined, accuracy, {}, notes, collector, progress);
  if (scene.stress->sensitivities) {
    scene.file = file;
    data.report.sensitivities =
        compute_sensitivities(data.report, scene, *model.made, model.shape, progress);
  }
  for (const FailedCheck& one : non_finite_numbers(data.report)) notes.failed_checks.push_back(one);
  data.failed_checks = sentences(notes.failed_checks);
  data.warnings = notes.warnings;
  for (const std::string& warning : notes.warnings) log(LogLevel::Warning, [&] { return warning; });
  for (const StressReport::Case& c : data.report.cases) {
    data.cases.push_back(stress_case(c));
    if (c.stress > data.cases[data.governing].max_von_mises) data.governing = data.cases.size() - 1;
  }
  scene.file = file;
  data.scene = std::move(scene);
}

}  // namespace

bool StressTable::empty() const {
  return values.empty() && supports.empty() && loads.empty() &&
         settings.find_first_not_of(" \t\r\n") == std::string::npos;
}

SceneStress parsed_table(const StressTable& table, const std::string& unit) {
  return parsed_stress(StressText(table, unit));
}

std::string with_settings(const StressTable& table, const std::string& unit,
                          const std::string& message) {
  return StressText(table, unit).with_setting(message);
}

Stress stress_of_table(const Model& model, const StressTable& table, const Progress& progress) {
  const ProgressScope scope(progress);
  model.data().require_surface();
  auto data = std::make_shared<StressData>(model.shared_data());
  Scene scene = model.data().scene;
  const std::filesystem::path file = scene.file;
  if (table.empty()) {
    if (!scene.stress)
      throw InputError(scene.name +
                       ": found no [stress], expected one, or settings with material, thickness, "
                       "supports and loads");
    analyse_into(*data, std::move(scene), file, stress_accuracy(table.accuracy), progress);
    return Stress(std::move(data));
  }
  const std::string unit = scene.unit;
  try {
    scene.stress = parsed_table(table, unit);
    scene.file = kStressFile;
    data->table = StressText(table, unit).table();
    analyse_into(*data, std::move(scene), file, stress_accuracy(table.accuracy), progress);
  } catch (const InputError& e) {
    const std::string message = with_settings(table, unit, e.what());
    if (message == e.what()) throw;
    throw InputError(message);
  }
  return Stress(std::move(data));
}

}  // namespace detail

// Settings as text.

namespace {

/// Writes the members of a support or a load that are set as an inline table.
class StressEntry {
 public:
  /// `label`: name of the entry in messages, such as "supports[0]".
  explicit StressEntry(std::string label) : label_(std::move(label)) {}

  StressEntry& add(const std::string& key, const std::string& text) {
    return text.empty() ? *this : add_value(key, SceneText::toml_value(text));
  }
  StressEntry& add(const std::string& key, const std::optional<double>& value) {
    return value ? add_value(key, number(key, *value)) : *this;
  }
  StressEntry& add(const std::string& key, const std::optional<bool>& value) {
    return value ? add_value(key, *value ? "true" : "false") : *this;
  }
  StressEntry& add(const std::string& key, const std::optional<Vec3>& value) {
    return value ? add_value(key, vector(key, *value)) : *this;
  }
  StressEntry& add(const std::string& key, const std::optional<Box3>& box) {
    return box ? add(key, std::vector<Vec3>{box->min(), box->max()}) : *this;
  }
  StressEntry& add(const std::string& key, const std::vector<Vec3>& rows) {
    std::vector<std::string> texts;
    for (const Vec3& row : rows) texts.push_back(vector(key, row));
    return rows.empty() ? *this : add_value(key, SceneText::list(texts));
  }
  std::string text() const { return SceneText::inline_table(values_); }

 private:
  StressEntry& add_value(const std::string& key, const std::string& value) {
    values_.emplace_back(key, value);
    return *this;
  }
  std::string number(const std::string& key, double value) const {
    if (std::isfinite(value)) return SceneText::toml_value(value);
    throw InputError("stress(): " + label_ + "." + key + ": found " + format_number(value) +
                     ", expected a finite number");
  }
  std::string vector(const std::string& key, const Vec3& v) const {
    return SceneText::list({number(key, v[0]), number(key, v[1]), number(key, v[2])});
  }

  std::string label_;
  std::vector<SceneText::Value> values_;
};

std::string support_text(const ShellSupport& support, const std::string& label) {
  StressEntry entry(label);
  entry.add("curve", support.curve)
      .add("point", support.point)
      .add("face", support.face)
      .add("box", support.box)
      .add("type", support.type)
      .add("directions", support.directions)
      .add("normal", support.normal)
      .add("rotation", support.rotation)
      .add("displacement", support.displacement)
      .add("spring", support.spring);
  if (support.foundation != 0) entry.add("foundation", std::optional(support.foundation));
  return entry.text();
}

std::string load_text(const ShellLoad& load, const std::string& label) {
  return StressEntry(label)
      .add("case", load.load_case)
      .add("pressure", load.pressure)
      .add("traction", load.traction)
      .add("gravity", load.gravity)
      .add("hydrostatic", load.hydrostatic)
      .add("force", load.force)
      .add("moment", load.moment)
      .add("edge_force", load.edge_force)
      .add("total_force", load.total_force)
      .add("total_moment", load.total_moment)
      .add("angular_velocity", load.angular_velocity)
      .add("temperature", load.temperature)
      .add("temperature_difference", load.temperature_difference)
      .add("axis", load.axis)
      .add("origin", load.origin)
      .add("level", load.level)
      .add("point", load.point)
      .add("curve", load.curve)
      .add("face", load.face)
      .add("box", load.box)
      .text();
}

}  // namespace

detail::StressTable detail::stress_table(const StressSettings& settings) {
  StressTable table;
  const auto add = [&](const std::string& key, double value, double usual) {
    if (value == usual) return;
    if (!std::isfinite(value))
      throw InputError("stress(): " + key + ": found " + format_number(value) +
                       ", expected a finite number");
    table.values.emplace_back(key, SceneText::toml_value(value));
  };
  const auto add_count = [&](const std::string& key, int count) {
    if (count != 0) table.values.emplace_back(key, std::to_string(count));
  };
  if (!settings.material.empty())
    table.values.emplace_back("material", SceneText::toml_value(settings.material));
  add("young", settings.young, 0);
  add("poisson", settings.poisson, StressSettings{}.poisson);
  add("density", settings.density, 0);
  add("thickness", settings.thickness, 0);
  add("yield", settings.yield_stress, 0);
  add_count("modes", settings.modes);
  add_count("buckling", settings.buckling);
  for (size_t i = 0; i < settings.supports.size(); ++i)
    table.supports.push_back(
        support_text(settings.supports[i], "supports[" + std::to_string(i) + "]"));
  for (size_t i = 0; i < settings.loads.size(); ++i)
    table.loads.push_back(load_text(settings.loads[i], "loads[" + std::to_string(i) + "]"));
  table.settings = settings.settings;
  table.accuracy = settings.accuracy;
  return table;
}

Stress stress(const Model& model, const StressSettings& settings, const Progress& progress) {
  return detail::stress_of_table(model, detail::stress_table(settings), progress);
}

// Stress.

double Stress::max_von_mises() const {
  return data_->cases.empty() ? 0 : data_->cases[data_->governing].max_von_mises;
}

double Stress::max_displacement() const {
  double most = 0;
  for (const StressCase& c : data_->cases) most = std::max(most, c.max_displacement);
  return most;
}

const std::vector<StressCase>& Stress::cases() const { return data_->cases; }

const StressCase& Stress::load_case(const std::string& name) const {
  return data_->cases[data_->index(name)];
}

const std::vector<double>& Stress::frequencies() const { return data_->report.frequencies; }

StressPoint Stress::at(const Vec3& p, const std::string& load_case) const {
  if (!p.allFinite()) throw InputError("point: found a number that is not finite");
  return data_->at(p, data_->index(load_case));
}

const std::vector<double>& Stress::von_mises(const std::string& load_case) const {
  return data_->von_mises(data_->index(load_case));
}

std::vector<double> Stress::von_mises(const std::string& load_case, const std::string& side) const {
  return data_->von_mises(data_->index(load_case), side);
}

std::vector<double> Stress::thickness() const { return data_->thickness(); }

const std::vector<double>& Stress::displacement(const std::string& load_case) const {
  return data_->displacement(data_->index(load_case));
}

std::vector<double> Stress::mode_shape(int index) const {
  return data_->mode(data_->mode_shapes, index, "modes");
}

std::vector<double> Stress::buckling_shape(int index, const std::string& load_case) const {
  return data_->mode(data_->buckling_shapes[data_->index(load_case)], index, "buckling");
}

StressGradients Stress::gradients(double norm_exponent, const std::string& load_case,
                                  const Progress& progress) const {
  const ProgressScope scope(progress);
  const detail::ModelData& model = *data_->model;
  const StressCase& of = this->load_case(load_case);
  Scene own = data_->scene;
  if (!data_->table.empty()) own.file = detail::kStressFile;
  require_differentiable(own);
  const bool moves = of.max_displacement > 0;
  const Vec3 direction = moves ? of.displacement : Vec3(Vec3::UnitZ());
  const ShellSensitivities sensitivities(*model.shape.layout, model.shape.dofs,
                                         shell_problem(data_->scene),
                                         {{of.name, of.displacement_at, direction}}, norm_exponent);
  const ShellSensitivities::Quantities values = sensitivities.values().front();
  StressGradients gradients;
  gradients.max_displacement.value = of.max_displacement;
  gradients.compliance.value = values.compliance;
  gradients.von_mises_norm.value = values.von_mises_norm;
  gradients.mass.value = values.mass;
  for (const ShapeDerivative& change : model.shape_derivatives(progress)) {
    const std::string& name = change.parameter;
    const ShellSensitivities::Quantities along = sensitivities.along(change.rate).front();
    gradients.max_displacement.gradient[name] = moves ? along.displacement : 0;
    gradients.compliance.gradient[name] = along.compliance;
    gradients.von_mises_norm.gradient[name] = along.von_mises_norm;
    gradients.mass.gradient[name] = along.mass;
  }
  return gradients;
}

const std::vector<std::string>& Stress::warnings() const { return data_->warnings; }
const std::vector<std::string>& Stress::failed_checks() const { return data_->failed_checks; }
std::string Stress::report() const { return to_json(data_->report); }
Model Stress::model() const { return Model(data_->model); }

std::string Stress::scene() const {
  const std::string scene = model().scene();
  if (data_->table.empty()) return scene;
  SceneText text(scene, data_->model->scene.file);
  const std::vector<SceneText::Value> values = text.values({});
  const auto is_stress = [](const SceneText::Value& value) { return value.first == "stress"; };
  if (std::any_of(values.begin(), values.end(), is_stress))
    text.erase({}, "stress");
  else if (text.has({"stress", ""}))
    text.remove({"stress", ""});
  return text.text() + (text.text().ends_with('\n') ? "\n" : "\n\n") + data_->table;
}

}  // namespace batten
