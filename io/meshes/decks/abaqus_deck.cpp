// SPDX-License-Identifier: MPL-2.0
// Reads Abaqus and CalculiX input: nodes, elements and connections of one part. Everything else
// stays text.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <string_view>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/meshes/decks/abaqus_connections.h"
#include "batten/io/meshes/decks/abaqus_directions.h"
#include "batten/io/meshes/decks/abaqus_lines.h"
#include "batten/io/meshes/decks/deck_mesh_builder.h"
#include "batten/io/meshes/mesh_file_types.h"

namespace batten {

// Coordinate systems of nodes, and the transformation of the part's instance.

class AbaqusCoordinates {
 public:
  explicit AbaqusCoordinates(MeshSourceText& file) : file_(file) {}

  /// Reads *SYSTEM: its data lines define the system in which subsequent *NODE data is given.
  void read_system(const Keyword& keyword, AbaqusLines& lines);
  /// Reads *INSTANCE of the part: its data lines translate all nodes, then rotate them about an
  /// axis.
  void read_instance(AbaqusLines& lines);
  /// Stands for the system of nodes of the assembly, which the instance does not move.
  static constexpr int kAssembly = -2;
  /// True if the instance is translated or rotated.
  bool is_instance_transformed() const { return moves_; }
  /// Index of the system of the following nodes, given the value of SYSTEM=; -1: global.
  int system_of(const Keyword& node_keyword);
  /// Index of the system of the part, in which its directions are given; -1: global. Call after all
  /// nodes have been read.
  int part_system() const { return moves_ ? isize(plans_) : -1; }
  /// Transforms the nodes of a finished mesh to global coordinates. `systems`: system of each node,
  /// as returned by system_of().
  void transform_nodes(TextMeshContent& mesh, std::vector<int> systems) const;

  /// Reads *PARAMETER: named numbers that "<name>" refers to.
  void read_parameters(AbaqusLines& lines);
  /// Parses a coordinate; sets `parameter` if it is given by a parameter name.
  double real(std::string_view value, bool& parameter) const;

 private:
  MeshSourceText& file_;
  CoordinateFrame frame_;  // of *SYSTEM
  bool local_ = false;
  std::vector<CoordinateSystemDefinition> plans_;
  std::map<std::string, double> parameters_;
  Mat3 rotation_ = Mat3::Identity();
  Vec3 translation_ = Vec3::Zero();
  bool moves_ = false;
};

namespace {

/// The numbers of a data line; omitted ones are 0.
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
  // Without a point on the x axis the system is only translated; without a point in the xy plane it
  // is rotated about z.
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
    file_.fail(lines.line(),
               "found an invalid rotation of an instance, expected two points and an angle");
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
  const std::vector<int> stated = systems;
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
  for (size_t i = 0; i < systems.size(); ++i)
    if (stated[i] == kAssembly) systems[i] = -1;
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
      parameters_.erase(name);  // an expression, which is not evaluated
  }
}

double AbaqusCoordinates::real(std::string_view value, bool& parameter) const {
  if (!value.starts_with('<')) return file_.real(value, true);
  parameter = true;
  const std::string name = upper(trimmed(value.substr(1, value.find('>') - 1)));
  const auto found = parameters_.find(name);
  if (found == parameters_.end())
    file_.fail(value, "found " + quoted_excerpt(value) +
                          ", expected a number or a preceding parameter "
                          "with a numeric value");
  return found->second;
}

// Element types of Abaqus and CalculiX.

/// Properties of an element type: corner and mid-side nodes of a face, or the node count of another
/// element. `count` is 0 for unknown types.
struct AbaqusElement {
  bool face = false;
  int corners = 0, middle = 0;
  NonShellElement::Kind kind = NonShellElement::Kind::Other;
  int count = 0;
  bool direction = false;  ///< a further node may define the orientation of a beam
  bool centre = false;     ///< the last node of a face is its centre
};
AbaqusElement abaqus_element(const std::string& type);

namespace {

using Kind = NonShellElement::Kind;

struct Start {
  std::string_view name;
  Kind kind;
  int count;
  bool direction = false;
};

/// Element types by prefix; the remaining letters state the integration. Of two types with a common
/// prefix, the longer one comes first.
constexpr std::array kStarts{
    Start{"C3D10", Kind::Solid, 10},      Start{"C3D15", Kind::Solid, 15},
    Start{"C3D20", Kind::Solid, 20},      Start{"C3D27", Kind::Solid, 20},
    Start{"C3D4", Kind::Solid, 4},        Start{"C3D5", Kind::Solid, 5},
    Start{"C3D6", Kind::Solid, 6},        Start{"C3D8", Kind::Solid, 8},
    Start{"SC6", Kind::Solid, 6},         Start{"SC8", Kind::Solid, 8},
    Start{"CSS8", Kind::Solid, 8},        Start{"COH3D6", Kind::Solid, 6},
    Start{"COH3D8", Kind::Solid, 8},      Start{"B21", Kind::Beam, 2, true},
    Start{"B22", Kind::Beam, 3, true},    Start{"B23", Kind::Beam, 2, true},
    Start{"B31", Kind::Beam, 2, true},    Start{"B32", Kind::Beam, 3, true},
    Start{"B33", Kind::Beam, 2, true},    Start{"PIPE31", Kind::Beam, 2, true},
    Start{"PIPE32", Kind::Beam, 3, true}, Start{"FRAME3D", Kind::Beam, 2, true},
    Start{"RB3D2", Kind::Beam, 2},        Start{"T2D2", Kind::Beam, 2},
    Start{"T3D2", Kind::Beam, 2},         Start{"T3D3", Kind::Beam, 3},
    Start{"CONN3D2", Kind::Bush, 2},      Start{"CONN2D2", Kind::Bush, 2},
    Start{"SPRING1", Kind::Bush, 1},      Start{"SPRING", Kind::Bush, 2},
    Start{"DASHPOT1", Kind::Bush, 1},     Start{"DASHPOT", Kind::Bush, 2},
    Start{"GAP", Kind::Bush, 2},          Start{"JOINTC", Kind::Bush, 2},
    Start{"MASS", Kind::Mass, 1},         Start{"ROTARYI", Kind::Mass, 1},
    Start{"DCOUP3D", Kind::Other, 1},     Start{"R3D3", Kind::Other, 3},
    Start{"R3D4", Kind::Other, 4}};

const std::map<std::string, std::array<int, 2>> kFaces{
    {"S3", {3, 0}},     {"S3R", {3, 0}},   {"S3RS", {3, 0}},  {"STRI3", {3, 0}}, {"S4", {4, 0}},
    {"S4R", {4, 0}},    {"S4RS", {4, 0}},  {"S4RSW", {4, 0}}, {"S4R5", {4, 0}},  {"S6", {3, 3}},
    {"STRI65", {3, 3}}, {"S8", {4, 4}},    {"S8R", {4, 4}},   {"S8R5", {4, 4}},  {"M3D3", {3, 0}},
    {"M3D4", {4, 0}},   {"M3D4R", {4, 0}}, {"M3D6", {3, 3}},  {"M3D8", {4, 4}},  {"M3D8R", {4, 4}},
    {"CPS3", {3, 0}},   {"CPS4", {4, 0}},  {"CPS4R", {4, 0}}, {"CPS4I", {4, 0}}, {"CPS6", {3, 3}},
    {"CPS6M", {3, 3}},  {"CPS8", {4, 4}},  {"CPS8R", {4, 4}}};

/// Plane, axisymmetric, thermal and shell elements by prefix. The number of nodes follows, and
/// letters for the integration.
constexpr std::array<std::string_view, 15> kFacePrefixes{"CGAX",  "CPEG",  "CPE",  "CPS",  "CAX",
                                                         "DCAX",  "DC2D",  "ACAX", "AC2D", "CINPE",
                                                         "CINPS", "CINAX", "DS",   "M3D",  "S"};

/// Corners and mid-side nodes of a face element; empty for other types.
std::optional<std::array<int, 2>> face_of_type(const std::string& type) {
  if (const auto face = kFaces.find(type); face != kFaces.end()) return face->second;
  for (const std::string_view prefix : kFacePrefixes) {
    if (!type.starts_with(prefix) || type.size() == prefix.size()) continue;
    const std::string_view rest = std::string_view(type).substr(prefix.size());
    const bool one_digit = rest.size() == 1 || !std::isdigit(static_cast<unsigned char>(rest[1]));
    const std::string_view counts = "34689";
    if (!one_digit || counts.find(rest[0]) == counts.npos) continue;
    const int count = rest[0] - '0', corners = count == 3 || count == 6 ? 3 : 4;
    return std::array<int, 2>{corners, count == 9 ? 4 : count - corners};
  }
  return {};
}

/// Number of nodes of a thermal, fluid or other solid, which follows "3D" in its type; 0: no solid.
int nodes_of_solid(const std::string& type) {
  const size_t at = type.find("3D");
  if (at == type.npos || at == 0) return 0;
  const std::string_view rest = std::string_view(type).substr(at + 2);
  static const std::set<std::string_view> counts{"4", "5", "6", "8", "10", "15", "20"};
  for (const size_t digits : {size_t{2}, size_t{1}}) {
    const auto found = counts.find(rest.substr(0, digits));
    if (found != counts.end()) return std::stoi(std::string(*found));
  }
  return 0;
}

}  // namespace

AbaqusElement abaqus_element(const std::string& type) {
  AbaqusElement element;
  if (type == "D") {  // of a network of pipes, with 0 for no node
    element.count = 3;
    return element;
  }
  for (const Start& start : kStarts)
    if (type.starts_with(start.name)) {
      element.kind = start.kind;
      element.count = start.count;
      element.direction = start.direction;
      return element;
    }
  if (const auto face = face_of_type(type)) {
    element.face = true;
    element.corners = (*face)[0];
    element.middle = (*face)[1];
    element.centre = type.find('9') != type.npos;
    element.count = element.corners + element.middle + (element.centre ? 1 : 0);
  } else if (const int nodes = nodes_of_solid(type)) {
    element.kind = NonShellElement::Kind::Solid;
    element.count = nodes;
  }
  return element;
}

namespace {

/// A set as written in the deck: numbers, and names of previously defined sets.
struct RawSet {
  std::string_view name;
  bool of_nodes;
  std::vector<LabelRange> ranges;
  std::vector<std::pair<std::string, std::string_view>> names;
};

/// Stands for the system of the part, which is known only after its instance.
constexpr int kPartSystem = -3;

class AbaqusReader {
 public:
  explicit AbaqusReader(TextMeshContent& mesh)
      : mesh_(mesh),
        file_(mesh.file),
        lines_(mesh.file),
        deck_(mesh),
        coordinate_systems_(mesh.file),
        connections_(mesh.file, deck_),
        directions_(mesh.file) {}

  void read() {
    while (const auto keyword = lines_.next_keyword()) {
      handle(*keyword);
      while (lines_.next_data()) {
      }
    }
    finish();
  }

 private:
  void handle(const Keyword& keyword) {
    const std::string& name = keyword.name;
    static const std::set<std::string> generators{"NGEN", "NFILL", "NCOPY",
                                                  "NMAP", "ELGEN", "ELCOPY"};
    if (generators.contains(name))
      file_.fail(keyword.line, "found *" + name + ", expected nodes and elements written out");
    // Inside an assembly, nodes and sets belong to the assembly, or name their instance.
    const bool here = !in_assembly_ || parts_ == 0;
    // Nodes and elements of the assembly are numbered after those of the part.
    shift_ = here || keyword.has("INSTANCE") ? 0 : assembly_shift();
    connections_.set_shift(shift_);
    directions_.note_users(keyword);
    if (name == "PART") {
      in_part_ = true;
      if (++parts_ > 1) file_.fail(keyword.line, "found a second *PART, expected one flat part");
    } else if (name == "END PART") {
      in_part_ = false;
    } else if (name == "INSTANCE") {
      if (++instances_ > 1) file_.fail(keyword.line, "found a second *INSTANCE, expected one");
      coordinate_systems_.read_instance(lines_);
    } else if (name == "ASSEMBLY" || name == "END ASSEMBLY") {
      in_assembly_ = name == "ASSEMBLY";
    } else if (name == "NODE") {
      nodes(keyword);
    } else if (name == "ELEMENT") {
      elements(keyword);
    } else if (name == "SYSTEM" && here) {
      coordinate_systems_.read_system(keyword, lines_);
    } else if (name == "PARAMETER") {
      coordinate_systems_.read_parameters(lines_);
    } else if (name == "NSET" || name == "ELSET") {
      set(keyword, name == "NSET");
    } else if (name == "SHELL SECTION" || name == "SHELL GENERAL SECTION" ||
               name == "MEMBRANE SECTION" || name == "SOLID SECTION") {
      sections_.push_back(keyword.value("ELSET"));
      if (keyword.has("COMPOSITE") && !keyword.has("ORIENTATION"))
        composites_.push_back(keyword.value("ELSET"));
    } else if (directions_.read(keyword, lines_, in_part_ ? kPartSystem : -1)) {
    } else {
      connections_.read(keyword, lines_);
    }
  }

  void nodes(const Keyword& keyword) {
    lines_.follow_input(keyword);
    const int system =
        shift_ > 0 ? AbaqusCoordinates::kAssembly : coordinate_systems_.system_of(keyword);
    RawSet* const set = new_set(keyword.value("NSET"), true);
    while (lines_.next_data()) {
      const std::string_view data = lines_.line();
      std::array<Field, 3> fields;
      const DeckLine line(data);
      const std::string_view label = line.free() ? line.value(0, 0, 0) : trimmed(data);
      const long number = file_.integer(label, "a node number") + shift_;
      largest_label_ = std::max(largest_label_, number);
      line.fields(file_, 1, 0, FieldKind::Abaqus, FieldKind::Abaqus, fields);
      if (!line.free())  // only the node number
        for (int c = 0; c < 3; ++c)
          fields[c] = {file_.offset(data) + data.size(), 0, FieldKind::Abaqus, true, 1};
      std::array<double, 3> xyz{};
      for (int c = 0; c < 3 && line.free(); ++c) {
        bool parameter = false;
        xyz[c] = coordinate_systems_.real(line.value(c + 1, 0, 0), parameter);
        if (parameter)
          mesh_.fixed_nodes.push_back({isize(systems_), "has a coordinate that is the parameter " +
                                                            std::string(line.value(c + 1, 0, 0))});
      }
      if (line.count() > 4) directions_.read_normal(data, isize(systems_), number);
      deck_.add_node(number, label, xyz, fields);
      systems_.push_back(system);
      if (set) set->ranges.push_back({number, number});
    }
  }

  void elements(const Keyword& keyword) {
    lines_.follow_input(keyword);
    const std::string type = upper(keyword.value("TYPE"));
    if (type.empty()) file_.fail(keyword.line, "found *ELEMENT without TYPE=, expected one");
    RawSet* const set = new_set(keyword.value("ELSET"), false);
    const AbaqusElement element = abaqus_element(type);
    while (lines_.next_data()) {
      if (element.face) {
        const std::vector<std::string_view> values = record(type, element.count);
        face(element, values);
        if (set) set->ranges.push_back({face_label_, face_label_});
      } else if (element.count > 0) {
        other(element, type, record(type, element.count), keyword.value("ELSET"), set);
      } else {
        deck_.count_other_element(type);
        while (trimmed(lines_.line()).ends_with(',') && lines_.next_data()) {
        }
      }
    }
  }

  /// Reads the number of an element and at least `count` nodes, which may be spread over several
  /// lines.
  std::vector<std::string_view> record(const std::string& type, int count) {
    const std::string_view start = lines_.line();
    std::vector<std::string_view> values;
    for (;;) {
      for (const std::string_view value : comma_values(lines_.line())) values.push_back(value);
      if (values.back().empty()) values.pop_back();  // the comma at the end of a line
      if (isize(values) > count) return values;
      if (!lines_.next_data())
        file_.fail(start, "found " + format_count(isize(values) - 1, "node") +
                              " of an element of type " + type + ", expected " +
                              std::to_string(count));
    }
  }

  /// A node number; "instance.5" is node 5 of the part.
  long node_number(std::string_view value) const {
    const size_t dot = value.rfind('.');
    if (dot != value.npos) return file_.integer(value.substr(dot + 1), "a node number");
    const long number = file_.integer(value, "a node number");
    return number == 0 ? 0 : number + shift_;  // 0: no node
  }

  /// A power of ten above all numbers of the part.
  long assembly_shift() {
    if (assembly_shift_ > 0) return assembly_shift_;
    for (assembly_shift_ = 10; assembly_shift_ <= largest_label_;) assembly_shift_ *= 10;
    return assembly_shift_;
  }

  void face(const AbaqusElement& element, const std::vector<std::string_view>& values) {
    face_label_ = file_.integer(values[0], "an element number") + shift_;
    largest_label_ = std::max(largest_label_, face_label_);
    std::array<long, 9> nodes{};
    for (int i = 0; i < element.count; ++i) nodes[i] = node_number(values[i + 1]);
    const auto corners = static_cast<size_t>(element.corners);
    deck_.add_shell(face_label_, values[0], "", {nodes.data(), corners},
                    {nodes.data() + corners, static_cast<size_t>(element.middle)});
    if (!element.centre) return;
    // The centre moves like the nodes around it.
    DeckElement centre{Kind::Interpolation, "centre of nine-node shells", face_label_, values[0],
                       {nodes[8]},          std::vector<double>(8, 1)};
    centre.nodes.insert(centre.nodes.end(), nodes.begin(), nodes.begin() + 8);
    deck_.add_element(std::move(centre));
  }

  void other(const AbaqusElement& element, const std::string& type,
             const std::vector<std::string_view>& values, std::string_view elset, RawSet* set) {
    DeckElement read{element.kind, type, file_.integer(values[0], "an element number") + shift_,
                     values[0],    {},   {}};
    largest_label_ = std::max(largest_label_, read.label);
    const int count = element.count + (element.direction ? 1 : 0);
    for (int i = 1; i <= count && i < isize(values); ++i)
      if (!values[i].empty()) read.nodes.push_back(node_number(values[i]));
    if (type == "DCOUP3D" && !read.nodes.empty())
      connections_.add_coupling_node(elset, read.nodes[0]);
    if (set) set->ranges.push_back({read.label, read.label});
    deck_.add_element(std::move(read));
  }

  RawSet* new_set(std::string_view name, bool of_nodes) {
    if (name.empty()) return nullptr;
    raw_sets_.push_back(std::make_unique<RawSet>(RawSet{name, of_nodes, {}, {}}));
    return raw_sets_.back().get();
  }

  /// The same numbers in ascending order.
  static LabelRange ascending(const LabelRange& range) {
    if (range.step > 0) return range;
    const long steps = (range.first - range.last) / -range.step;
    return {range.first + steps * range.step, range.first, -range.step};
  }

  void set(const Keyword& keyword, bool of_nodes) {
    const std::string_view name = keyword.value(of_nodes ? "NSET" : "ELSET");
    if (name.empty()) file_.fail(keyword.line, "found a set without a name, expected one");
    RawSet& set = *new_set(name, of_nodes);
    if (of_nodes && keyword.has("ELSET")) {
      // The nodes of an element set.
      set.names.push_back({"E" + upper(keyword.value("ELSET")), keyword.line});
    }
    while (lines_.next_data()) {
      std::vector<std::string_view> values = comma_values(lines_.line());
      std::erase_if(values, [](std::string_view value) { return value.empty(); });
      if (values.empty()) continue;
      if (keyword.has("GENERATE")) {
        LabelRange range{file_.integer(values[0], "a number"), 0};
        range.last = values.size() > 1 ? file_.integer(values[1], "a number") : range.first;
        if (values.size() > 2) range.step = file_.integer(values[2], "a step");
        if (range.step == 0) file_.fail(values.back(), "found a step of 0, expected another one");
        range.first += shift_;
        range.last += shift_;
        set.ranges.push_back(ascending(range));
        continue;
      }
      for (std::string_view value : values) {
        long label = 0;
        if (parse_integer(value, label))
          set.ranges.push_back({label + shift_, label + shift_});
        else
          set.names.push_back({(of_nodes ? "N" : "E") + upper(value), value});
      }
    }
  }

  void finish() {
    deck_.finish();
    coordinate_systems_.transform_nodes(mesh_, systems_);
    std::map<std::string, std::vector<int>> known;
    std::map<std::string, size_t> position;
    std::vector<MeshSet> sets;
    for (const auto& raw : raw_sets_) {
      std::vector<int> members =
          raw->of_nodes ? deck_.nodes_of(raw->ranges) : deck_.faces_of(raw->ranges);
      for (const auto& [name, where] : raw->names) {
        auto found = known.end();
        long label = 0;
        for (const std::string_view local : local_names(std::string_view(name).substr(1))) {
          if (found == known.end()) found = known.find(name[0] + std::string(local));
          if (!parse_integer(local, label)) label = 0;
        }
        if (found == known.end() && label > 0) {
          const std::vector<LabelRange> one{{label, label}};
          const std::vector<int> member = raw->of_nodes ? deck_.nodes_of(one) : deck_.faces_of(one);
          members.insert(members.end(), member.begin(), member.end());
          continue;
        }
        if (found == known.end())
          file_.fail(where, "found " + quoted_excerpt(name.substr(1)) +
                                ", expected a number or the name of a set before it");
        if (raw->of_nodes && name[0] == 'E') {
          for (const int f : found->second)
            members.insert(members.end(), mesh_.shells.face(f).begin(), mesh_.shells.face(f).end());
        } else {
          members.insert(members.end(), found->second.begin(), found->second.end());
        }
      }
      // Several blocks may contribute to one set.
      const std::string key = (raw->of_nodes ? "N" : "E") + upper(raw->name);
      std::vector<int>& all = known[key];
      all.insert(all.end(), members.begin(), members.end());
      std::sort(all.begin(), all.end());
      all.erase(std::unique(all.begin(), all.end()), all.end());
      if (position.try_emplace(key, sets.size()).second)
        sets.push_back({std::string(raw->name), {}, {}, {}});
    }
    for (const auto& [key, index] : position)
      (key[0] == 'N' ? sets[index].nodes : sets[index].faces) = known[key];
    for (MeshSet& set : sets)
      if (!set.nodes.empty() || !set.faces.empty()) mesh_.sets.push_back(std::move(set));
    properties(known);
    finish_directions(known);
    connections_.finish(
        mesh_,
        [&](const std::string& name, bool faces) -> std::optional<std::vector<int>> {
          const auto found = known.find((faces ? "E" : "N") + name);
          return found == known.end() ? std::nullopt : std::optional(found->second);
        },
        [&](const std::string& name) { return others_of(name); }, parts_ == 0);
    warn();
  }

  /// Calls visit(raw set) for an element set and all sets that it contains.
  template <class Visit>
  bool visit_elements(const std::string& set, const Visit& visit,
                      std::set<std::string> open = {}) const {
    bool known = false;
    if (!open.insert(set).second) return false;
    for (const auto& raw : raw_sets_) {
      if (raw->of_nodes || upper(raw->name) != set) continue;
      known = true;
      visit(*raw);
      for (const auto& [name, where] : raw->names) visit_elements(name.substr(1), visit, open);
    }
    return known;
  }

  /// The elements that are not shells of an element set, or with an element number.
  std::vector<int> others_of(const std::string& set) const {
    std::vector<int> others;
    const auto add = [&](const std::vector<LabelRange>& ranges) {
      for (int i = 0; i < isize(mesh_.other_elements); ++i) {
        const long label = mesh_.other_elements[i].label;
        if (label > 0 && std::any_of(ranges.begin(), ranges.end(), [&](const LabelRange& range) {
              return label >= range.first && label <= range.last &&
                     (label - range.first) % range.step == 0;
            }))
          others.push_back(i);
      }
    };
    if (long label = 0; parse_integer(set, label))
      add({{label, label}});
    else
      visit_elements(set, [&](const RawSet& raw) { add(raw.ranges); });
    return others;
  }

  /// The nodes of all elements of an element set; empty for an unknown set.
  std::optional<std::vector<int>> nodes_of_elements(const std::string& set) const {
    std::vector<int> nodes;
    const auto add = [&](const auto& members) {
      nodes.insert(nodes.end(), members.begin(), members.end());
    };
    const bool known = visit_elements(set, [&](const RawSet& raw) {
      for (const int f : indices_of(mesh_.face_labels, raw.ranges)) add(mesh_.shells.face(f));
    });
    if (!known) return {};
    for (const int e : others_of(set)) add(mesh_.other_elements[e].nodes);
    return sorted_unique(std::move(nodes));
  }

  void finish_directions(const std::map<std::string, std::vector<int>>& known) {
    const auto nodes_of = [&](std::string_view name,
                              bool elements) -> std::optional<std::vector<int>> {
      for (const std::string_view local : local_names(name)) {
        long label = 0;
        if (elements) {
          if (auto nodes = nodes_of_elements(upper(local))) return nodes;
        } else if (parse_integer(local, label)) {
          if (const auto node = mesh_.node_labels.find(label)) return std::vector<int>{*node};
        } else if (const auto set = known.find("N" + upper(local)); set != known.end()) {
          return set->second;
        }
      }
      return {};
    };
    directions_.finish(mesh_, nodes_of);
    for (RotatingCard& card : mesh_.rotating_cards)
      if (card.system == kPartSystem) card.system = coordinate_systems_.part_system();
    for (const std::string_view set : composites_)
      if (const auto nodes = nodes_of_elements(upper(set)))
        mesh_.global_directions.push_back(
            {"*SHELL SECTION, COMPOSITE of " + std::string(set) + " without ORIENTATION", *nodes});
  }

  void properties(const std::map<std::string, std::vector<int>>& known) {
    std::set<std::string> taken;
    for (const std::string_view name : sections_) {
      const auto found = known.find("E" + upper(name));
      if (found == known.end() || found->second.empty() || !taken.insert(found->first).second)
        continue;
      mesh_.properties.push_back({std::string(name), {}, {}, found->second});
    }
  }

  void warn() {
    deck_.warn_about_other_elements();
    mesh_.warn_about_unwritten_includes();
    if (file_.ends_in_mid_line())
      mesh_.warnings.push_back("the last line has no line end: the file may be truncated");
    if (assembly_shift_ > 0 && largest_label_ > assembly_shift_)
      mesh_.warnings.push_back("the numbers of nodes and elements of the assembly are shown plus " +
                               std::to_string(assembly_shift_));
  }

  TextMeshContent& mesh_;
  MeshSourceText& file_;
  AbaqusLines lines_;
  DeckMeshBuilder deck_;
  AbaqusCoordinates coordinate_systems_;
  AbaqusConnections connections_;
  AbaqusDirections directions_;
  std::vector<int> systems_;  // of each node
  std::vector<std::unique_ptr<RawSet>> raw_sets_;
  std::vector<std::string_view> sections_, composites_;
  long face_label_ = 0;
  int parts_ = 0, instances_ = 0;
  long shift_ = 0, assembly_shift_ = 0, largest_label_ = 0;
  bool in_assembly_ = false, in_part_ = false;
};

}  // namespace

std::unique_ptr<MeshContent> read_abaqus_deck(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMeshContent>(MeshSourceText(path));
  mesh->format = "Abaqus input";
  mesh->extensions = {".inp"};
  AbaqusReader(*mesh).read();
  return mesh;
}

}  // namespace batten
