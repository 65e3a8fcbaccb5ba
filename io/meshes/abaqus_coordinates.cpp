#include "batten/io/meshes/abaqus_coordinates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/core/isize.h"

namespace batten {
namespace {

/// The numbers of a line of data; those that are left out are 0.
std::vector<double> reals(const MeshSourceText& file, std::string_view line) {
  std::vector<double> values;
  for (const std::string_view value : comma_values(line)) values.push_back(file.real(value, true));
  return values;
}

Vec3 three(std::vector<double> values, size_t first) {
  values.resize(std::max(values.size(), first + 3));
  return {values[first], values[first + 1], values[first + 2]};
}

}  // namespace

void AbaqusCoordinates::read_system(const Keyword& keyword, AbaqusLines& lines) {
  frame_ = {};
  local_ = false;
  if (!lines.next_data()) return;
  local_ = true;
  const std::vector<double> first = reals(file_, lines.line());
  frame_.origin = three(first, 0);
  // Without a point on its x axis it is only moved, without one in its plane xy turned about z.
  if (first.size() <= 3) {
    lines.next_data();
    return;
  }
  const Vec3 x = three(first, 3) - frame_.origin;
  const bool plane = lines.next_data();
  const Vec3 in_plane = plane ? Vec3(three(reals(file_, lines.line()), 0) - frame_.origin)
                              : Vec3(Vec3::UnitZ().cross(x));
  const Vec3 z = x.cross(in_plane);
  if (!(z.norm() > 1e-12 * x.norm() * in_plane.norm()))
    file_.fail(keyword.line, "found a *SYSTEM whose points lie on a line");
  frame_.axes.col(0) = x.normalized();
  frame_.axes.col(2) = z.normalized();
  frame_.axes.col(1) = frame_.axes.col(2).cross(frame_.axes.col(0));
  if (plane) lines.next_data();
}

void AbaqusCoordinates::read_instance(AbaqusLines& lines) {
  if (!lines.next_data()) return;
  moves_ = true;
  translation_ = three(reals(file_, lines.line()), 0);
  if (!lines.next_data()) return;
  const std::vector<double> line = reals(file_, lines.line());
  const Vec3 a = three(line, 0), axis = three(line, 3) - a;
  if (line.size() < 7 || !(axis.norm() > 0))
    file_.fail(lines.line(), "found a turn of an instance, expected two points and an angle");
  rotation_ =
      Eigen::AngleAxisd(line[6] * std::numbers::pi / 180, axis.normalized()).toRotationMatrix();
  translation_ = rotation_ * (translation_ - a) + a;
  lines.next_data();
}

int AbaqusCoordinates::system_of(const Keyword& keyword) {
  const std::string name = upper(keyword.value("SYSTEM"));
  CoordinateFrame frame = frame_;
  if (name == "C")
    frame.kind = CoordinateFrame::Kind::Cylindrical;
  else if (name == "S")
    frame.kind = CoordinateFrame::Kind::Latitude;
  else if (!name.empty() && name != "R")
    file_.fail(keyword.line, "found SYSTEM=" + name + ", expected R, C or S");
  if (!local_ && frame.kind == CoordinateFrame::Kind::Rectangular) return -1;
  CoordinateSystemDefinition plan;
  plan.where = file_.offset(keyword.line);
  plan.given = frame;
  plans_.push_back(plan);
  return isize(plans_) - 1;
}

void AbaqusCoordinates::transform_nodes(TextMeshContent& mesh, std::vector<int> systems) const {
  if (!moves_ && std::all_of(systems.begin(), systems.end(), [](int s) { return s < 0; })) return;
  NodeCoordinateSystems all;
  all.plans = plans_;
  if (moves_) {
    all.plans.push_back({});
    all.plans.back().given = CoordinateFrame();
    for (int& system : systems)
      if (system < 0) system = isize(plans_);
    for (CoordinateSystemDefinition& plan : all.plans) {
      plan.given->origin = rotation_ * plan.given->origin + translation_;
      plan.given->axes = rotation_ * plan.given->axes;
    }
  }
  all.of_node = std::move(systems);
  nodes_to_global(mesh, std::move(all));
}

void AbaqusCoordinates::read_parameters(AbaqusLines& lines) {
  while (lines.next_data()) {
    const std::string_view line = lines.line().substr(0, lines.line().find('#'));
    const size_t equals = line.find('=');
    if (equals == line.npos) continue;
    const std::string_view text = trimmed(line.substr(equals + 1));
    const std::string name = upper(trimmed(line.substr(0, equals)));
    double value = 0;
    const auto other = parameters_.find(upper(text));
    if (parse_real(text, value))
      parameters_[name] = value;
    else if (other != parameters_.end())
      parameters_[name] = other->second;
    else
      parameters_.erase(name);  // an expression
  }
}

double AbaqusCoordinates::real(std::string_view value, bool& parameter) const {
  if (!value.starts_with('<')) return file_.real(value, true);
  parameter = true;
  const std::string name = upper(trimmed(value.substr(1, value.find('>') - 1)));
  const auto found = parameters_.find(name);
  if (found == parameters_.end())
    file_.fail(value, "found " + quoted_excerpt(value) +
                          ", expected a number or a parameter before it "
                          "that is given as a number");
  return found->second;
}

}  // namespace batten
