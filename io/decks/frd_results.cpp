// SPDX-License-Identifier: MPL-2.0
#include "batten/io/decks/frd_results.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

// A data line consists of " -1", a number of ten columns (of five in the short format), and values of
// twelve columns each.
constexpr size_t kKeyWidth = 3, kLongNumber = 10, kShortNumber = 5, kValueWidth = 12;
// Column of the value in a step header, "  100CL"; width of the type in an element header.
constexpr size_t kStepValue = 12, kTypeWidth = 5;

// Parses a number, ignoring surrounding blanks, independent of the locale.
template <class Value>
Value parsed(std::string_view text, const std::string& at) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\r')) text.remove_suffix(1);
  Value value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw InputError(at + "found " + quoted_excerpt(text) + ", expected a number");
  return value;
}

/// Parses a .frd file. Derived classes implement the callbacks.
class FrdParser {
 public:
  explicit FrdParser(const std::filesystem::path& path) : path_(path) {}
  virtual ~FrdParser() = default;

  void run() {
    require_input_file(path_, "results of CalculiX (.frd)");
    std::ifstream in(path_);
    bool any = false;
    row_ = 0;
    for (std::string line; std::getline(in, line);) {
      ++row_;
      const std::string key = line.substr(0, std::min<size_t>(line.size(), 6));
      if (key.starts_with(" -1") || key.starts_with(" -2")) {
        data_line(line);
      } else if (key.starts_with(" -3")) {
        end_block();
      } else if (key == "    2C" || key == "    3C") {
        read_format(line);
        block_ = key == "    2C" ? Block::Nodes : Block::Elements;
      } else if (key == "  100C") {
        read_format(line);
        value_ = parsed<double>(part(line, kStepValue, kValueWidth), at());
      } else if (key.starts_with(" -4")) {
        const std::string name = line.substr(std::min<size_t>(line.size(), 5), 8);
        block_ = name.starts_with("DISP")     ? Block::Displacement
                 : name.starts_with("STRESS") ? Block::Stress
                                              : Block::None;
        any = any || block_ == Block::Displacement;
      }
    }
    if (block_ != Block::None)
      throw InputError(at() + "found the end of the file, expected the end of a block (-3)");
    if (!any)
      throw InputError(path_.string() +
                       ": found no displacements, expected the displacements of a step");
  }

 protected:
  virtual void node(int label, const Vec3& x) = 0;
  virtual void element(int, int) {}
  virtual void element_node(int) {}
  virtual void displacement(int label, const Vec3& u) = 0;
  virtual void stress(int, const double*) {}
  virtual void nodes_end() {}
  virtual void elements_end() {}
  virtual void step_end(double) {}
  /// The current position in the file, as a prefix of messages.
  std::string at() const { return format_location(path_.string(), {row_, 1}); }

 private:
  enum class Block { None, Nodes, Elements, Displacement, Stress };

  static std::string_view part(const std::string& line, size_t begin, size_t length) {
    return std::string_view(line).substr(std::min(begin, line.size()), length);
  }

  /// The last number of a block header is the format: 0 is short text, 1 long text.
  void read_format(const std::string& line) {
    const size_t last = line.find_last_not_of(" \r");
    const char format = last != line.npos && last >= 72 ? line[last] : '1';
    if (format == '2' || format == '3')
      throw InputError(at() + "found a binary block, expected text");
    number_width_ = format == '0' ? kShortNumber : kLongNumber;
  }

  void data_line(const std::string& line) {
    if (block_ == Block::None) return;
    if (block_ == Block::Elements) {
      const bool head = line[2] == '1';
      if (head) {
        element(parsed<int>(part(line, kKeyWidth, number_width_), at()),
                parsed<int>(part(line, kKeyWidth + number_width_, kTypeWidth), at()));
        return;
      }
      const size_t end = line.find_last_not_of(" \r");
      for (size_t from = kKeyWidth; from <= end && end != line.npos; from += number_width_)
        element_node(parsed<int>(part(line, from, number_width_), at()));
      return;
    }
    if (line[2] != '1') return;
    const size_t count = block_ == Block::Stress ? 6 : 3;
    if (line.size() < kKeyWidth + number_width_ + count * kValueWidth)
      throw InputError(at() + "found a short line, expected a node and " + std::to_string(count) +
                       " numbers");
    const int label = parsed<int>(part(line, kKeyWidth, number_width_), at());
    double v[6] = {};
    for (size_t k = 0; k < count; ++k)
      v[k] = parsed<double>(part(line, kKeyWidth + number_width_ + k * kValueWidth, kValueWidth),
                            at());
    if (block_ == Block::Nodes) node(label, {v[0], v[1], v[2]});
    if (block_ == Block::Displacement) displacement(label, {v[0], v[1], v[2]});
    if (block_ == Block::Stress) stress(label, v);
  }

  void end_block() {
    if (block_ == Block::Nodes) nodes_end();
    if (block_ == Block::Elements) elements_end();
    if (block_ == Block::Displacement) step_end(value_);
    block_ = Block::None;
  }

  std::filesystem::path path_;
  Block block_ = Block::None;
  double value_ = 0;
  size_t number_width_ = kLongNumber;
  int row_ = 0;
};

class FrdResultsParser : public FrdParser {
 public:
  using FrdParser::FrdParser;
  std::map<int, FrdResults::Node> nodes;

 private:
  void node(int label, const Vec3& x) override { nodes[label].x = x; }
  void displacement(int label, const Vec3& u) override { nodes[label].displacement = u; }
  void stress(int label, const double* s) override {
    nodes[label].stress << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
  }
};

using FrdStep = std::function<void(const FrdMesh&, double, const Points&)>;

class FrdStepsParser : public FrdParser {
 public:
  FrdStepsParser(const std::filesystem::path& path, const FrdStep& step)
      : FrdParser(path), step_(step) {}
  FrdMesh mesh;

 private:
  void node(int label, const Vec3& x) override { places_[label] = x; }
  void nodes_end() override {
    mesh.labels.clear();
    mesh.points.resize(isize(places_), 3);
    for (const auto& [label, x] : places_) {
      mesh.points.row(isize(mesh.labels)) = x.transpose();
      mesh.labels.push_back(label);
    }
    displacements_ = Points::Zero(mesh.points.rows(), 3);
  }
  void element(int label, int type) override { mesh.elements.push_back({label, type, {}}); }
  void element_node(int label) override {
    if (mesh.elements.empty()) throw InputError(at() + "found element nodes before their element");
    mesh.elements.back().nodes.push_back(index_of(label));
  }
  void displacement(int label, const Vec3& u) override {
    displacements_.row(index_of(label)) = u.transpose();
  }
  void step_end(double value) override {
    step_(mesh, value, displacements_);
    displacements_.setZero();
  }
  int index_of(int label) const {
    const auto found = std::lower_bound(mesh.labels.begin(), mesh.labels.end(), label);
    if (found == mesh.labels.end() || *found != label)
      throw InputError(at() + "found node " + std::to_string(label) +
                       ", expected one of the nodes of the file");
    return static_cast<int>(found - mesh.labels.begin());
  }

  const FrdStep& step_;
  std::map<int, Vec3> places_;
  Points displacements_;
};

/// The faces of an element type, as local nodes: corners, then mid-side nodes, counter-clockwise as
/// seen from outside. `nodes`: number of nodes of the element.
struct ElementFaces {
  size_t nodes;
  bool second_order, solid;
  std::vector<std::vector<int>> faces;
};

/// Face tables by element type. In .frd, the mid-side nodes of the vertical edges come before those
/// of the top face.
const ElementFaces* faces_of(int type) {
  static const std::map<int, ElementFaces> all{
      {1,
       {8,
        false,
        true,
        {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}}},
      {2, {6, false, true, {{0, 2, 1}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}}},
      {3, {4, false, true, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}}},
      {4,
       {20,
        true,
        true,
        {{0, 3, 2, 1, 11, 10, 9, 8},
         {4, 5, 6, 7, 16, 17, 18, 19},
         {0, 1, 5, 4, 8, 13, 16, 12},
         {1, 2, 6, 5, 9, 14, 17, 13},
         {2, 3, 7, 6, 10, 15, 18, 14},
         {3, 0, 4, 7, 11, 12, 19, 15}}}},
      {5,
       {15,
        true,
        true,
        {{0, 2, 1, 8, 7, 6},
         {3, 4, 5, 12, 13, 14},
         {0, 1, 4, 3, 6, 10, 12, 9},
         {1, 2, 5, 4, 7, 11, 13, 10},
         {2, 0, 3, 5, 8, 9, 14, 11}}}},
      {6,
       {10,
        true,
        true,
        {{0, 2, 1, 6, 5, 4}, {0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {2, 0, 3, 6, 7, 9}}}},
      {7, {3, false, false, {{0, 1, 2}}}},
      {8, {6, true, false, {{0, 1, 2, 3, 4, 5}}}},
      {9, {4, false, false, {{0, 1, 2, 3}}}},
      {10, {8, true, false, {{0, 1, 2, 3, 4, 5, 6, 7}}}}};
  const auto found = all.find(type);
  return found == all.end() ? nullptr : &found->second;
}

}  // namespace

FrdResults read_frd(const std::filesystem::path& path) {
  FrdResultsParser walk(path);
  walk.run();
  FrdResults results;
  for (const auto& [number, node] : walk.nodes) results.nodes.push_back(node);
  return results;
}

FrdMesh read_frd_steps(const std::filesystem::path& path, const FrdStep& step) {
  FrdStepsParser walk(path, step);
  walk.run();
  return std::move(walk.mesh);
}

std::vector<FrdFace> outer_faces(const FrdMesh& mesh) {
  std::vector<FrdFace> faces;
  // Number of solids that have the face with these sorted corners.
  std::map<std::vector<int>, int> times;
  const auto corners_of = [](const FrdFace& face) {
    const auto count = static_cast<long>(face.nodes.size()) / (face.second_order ? 2 : 1);
    std::vector<int> corners(face.nodes.begin(), face.nodes.begin() + count);
    std::sort(corners.begin(), corners.end());
    return corners;
  };
  for (int e = 0; e < isize(mesh.elements); ++e) {
    const FrdMesh::Element& element = mesh.elements[e];
    const ElementFaces* const type = faces_of(element.type);
    if (!type) continue;
    if (element.nodes.size() != type->nodes)
      throw InputError("element " + std::to_string(element.label) + " has " +
                       std::to_string(element.nodes.size()) + " nodes, expected " +
                       std::to_string(type->nodes));
    for (const std::vector<int>& local : type->faces) {
      FrdFace face{e, {}, type->second_order};
      for (const int node : local) face.nodes.push_back(element.nodes[node]);
      if (type->solid) ++times[corners_of(face)];
      faces.push_back(std::move(face));
    }
  }
  std::erase_if(faces, [&](const FrdFace& face) {
    const auto found = times.find(corners_of(face));
    return found != times.end() && found->second > 1 &&
           faces_of(mesh.elements[face.element].type)->solid;
  });
  return faces;
}

namespace {

// The numbers in one column of the rows "1  a  b …" after a heading, until another heading.
std::vector<double> column_after(const std::filesystem::path& path, const std::string& heading,
                                 size_t column) {
  std::ifstream in(path);
  if (!in) throw InputError(path.string() + ": cannot be read");
  std::vector<double> numbers;
  std::string line;
  bool inside = false;
  while (std::getline(in, line)) {
    if (line.find(heading) != std::string::npos) {
      inside = true;
      continue;
    }
    if (!inside) continue;
    std::istringstream words(line);
    size_t number = 0;
    if (!(words >> number) || number != numbers.size() + 1) {
      if (!numbers.empty()) break;
      continue;
    }
    double value = 0;
    for (size_t k = 1; k <= column; ++k) words >> value;
    if (words) numbers.push_back(value);
  }
  return numbers;
}

}  // namespace

std::vector<double> read_ccx_frequencies(const std::filesystem::path& path) {
  return column_after(path, "E I G E N V A L U E   O U T P U T", 3);
}

std::vector<double> read_ccx_buckling_factors(const std::filesystem::path& path) {
  return column_after(path, "B U C K L I N G   F A C T O R   O U T P U T", 1);
}

}  // namespace batten
