// SPDX-License-Identifier: MPL-2.0
// Writes text mesh files back with new coordinates; converts between local and global coordinates.

#include "batten/io/meshes/text_mesh_content.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <ostream>
#include <set>
#include <span>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/meshes/mesh_source_text.h"
#include "batten/mesh/node_rotations.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// The text of one file with new coordinates and directions.
struct Output {
  struct Replacement {
    size_t begin, end;  // in the text of the source
    std::string by;
  };
  const MeshSourceText::Source* source;
  std::vector<Replacement> replacements;
  std::string text;
  std::string changed;  // an entity that changes, for messages; empty: none

  void replace(size_t begin, size_t end, std::string by) {
    replacements.push_back({begin - source->base, end - source->base, std::move(by)});
  }
  void finish() {
    std::stable_sort(replacements.begin(), replacements.end(),
                     [](const auto& a, const auto& b) { return a.begin < b.begin; });
    size_t done = 0;
    for (const Replacement& r : replacements) {
      text.append(source->text, done, r.begin - done);
      text += r.by;
      done = r.end;
    }
    text.append(source->text, done);
  }
};

/// The texts of a mesh file and its included files, with new coordinates.
class Rewriting {
 public:
  Rewriting(const TextMeshContent& mesh, const Points& points, bool large_field_nodes)
      : mesh_(mesh),
        points_(points),
        large_field_nodes_(large_field_nodes),
        size_(mesh.shells.points.size() ? mesh.shells.points.cwiseAbs().maxCoeff() : 0),
        frames_(mesh.systems, mesh.file, [this](int node) { return written_position(node); }) {
    for (const auto& source : mesh.file.sources()) outputs_.push_back({source.get(), {}, {}, {}});
  }

  /// Rewrites the coordinates of a node. Nodes are processed in the order of the text.
  void rewrite(int i) {
    const Node node = choose(i);
    measure(node);
    if (!node.changes()) return;
    check_not_fixed(i);
    Output& output = outputs_[mesh_.file.source_index(node.fields[0].begin)];
    output.changed = "node " + std::to_string(mesh_.node_labels.of(i)) + " moves";
    if (node.wide)
      widen(node, output);
    else
      replace_fields(node, output);
  }

  /// Rewrites the directions of all cards that rotate with the mesh.
  void rewrite_directions();

  std::vector<Output>& finish() {
    for (Output& output : outputs_) output.finish();
    return outputs_;
  }
  const MeshRounding& rounding() const { return rounding_; }

 private:
  /// The new coordinates of a node.
  struct Node {
    int index;
    const std::array<Field, 3>& fields;
    bool wide = false;
    Vec3 local_coordinates = Vec3::Zero();  // as a reader will parse them
    std::array<std::string, 3> text{};
    std::array<bool, 3> changed{};
    bool changes() const { return changed[0] || changed[1] || changed[2]; }
    /// If true, all open fields of the node are written together.
    bool changes_open() const {
      bool any = false;
      for (size_t c = 0; c < 3; ++c) any |= changed[c] && fields[c].open;
      return any;
    }
  };

  Vec3 given_position(int i) const { return points_.row(i).transpose(); }
  Vec3 read_coordinates(int i) const {
    const Points& from =
        mesh_.systems.any() ? mesh_.systems.local_coordinates : mesh_.shells.points;
    return from.row(i).transpose();
  }

  Node choose(int i) {
    Node node{i, mesh_.fields[static_cast<size_t>(i)]};
    const Vec3 old = read_coordinates(i), position = given_position(i);
    const int system = mesh_.systems.of(i);
    node.local_coordinates = old;
    if ((system < 0 ? old : frames_.of(system).position(old)) == position) return node;
    Vec3 desired = position, rounding = Vec3::Constant(noise_of(node.fields[0].kind));
    if (system >= 0) {
      desired = frames_.of(system).local_coordinates(position, old);
      rounding = frames_.of(system).rounding(position, rounding[0]);
    }
    node.wide = large_field_nodes_ && is_small_grid(node);
    for (int c = 0; c < 3; ++c) {
      node.text[c] = trimmed(old_text(node, c));
      if (std::abs(desired[c] - old[c]) <= rounding[c]) continue;
      const FieldKind kind = node.wide ? FieldKind::Nastran16 : node.fields[c].kind;
      double written = 0;
      const std::string text = format_field(desired[c], kind, written);
      if (text.empty() || !std::isfinite(written))
        mesh_.file.fail(node.fields[c].begin, "the coordinate " + format_number(desired[c]) +
                                                  " does not fit into its field");
      // The text already in the file may be as near as the field allows.
      if (std::abs(old[c] - desired[c]) <= std::abs(written - desired[c])) continue;
      node.changed[c] = true;
      node.local_coordinates[c] = written;
      node.text[c] = text;
    }
    return node;
  }

  /// Changes below this bound are rounding noise of an edit; the text of a deck then stays
  /// unchanged.
  double noise_of(FieldKind kind) const {
    constexpr double kNoise = 1e-13;
    return is_deck_field(kind) ? kNoise * size_ : 0;
  }

  Vec3 written_position(int i) {
    const Vec3 local_coordinates = choose(i).local_coordinates;
    const int system = mesh_.systems.of(i);
    return system < 0 ? local_coordinates : frames_.of(system).position(local_coordinates);
  }

  void measure(const Node& node) {
    const int system = mesh_.systems.of(node.index);
    const Vec3 written =
        system < 0 ? node.local_coordinates : frames_.of(system).position(node.local_coordinates);
    const double error = (written - given_position(node.index)).cwiseAbs().maxCoeff();
    if (error <= rounding_.largest) return;
    rounding_.largest = error;
    rounding_.max_error_label = mesh_.node_labels.of(node.index);
  }

  void check_not_fixed(int i) const {
    const auto fixed_nodes = std::lower_bound(mesh_.fixed_nodes.begin(), mesh_.fixed_nodes.end(),
                                              std::pair(i, std::string()));
    if (fixed_nodes != mesh_.fixed_nodes.end() && fixed_nodes->first == i)
      mesh_.file.fail(mesh_.fields[static_cast<size_t>(i)][0].begin,
                      "node " + std::to_string(mesh_.node_labels.of(i)) + " cannot be moved: it " +
                          fixed_nodes->second);
  }

  std::string_view old_text(const Node& node, int c) const {
    return mesh_.file.part(node.fields[c].begin, node.fields[c].length);
  }

  /// Begin and end offset of the line that contains a node's first field.
  std::pair<size_t, size_t> line_of(const Node& node) const {
    const MeshSourceText::Source& source = mesh_.file.source_of(node.fields[0].begin);
    const size_t at = node.fields[0].begin - source.base;
    const size_t before = source.text.rfind('\n', at);
    const size_t begin = before == source.text.npos ? 0 : before + 1;
    return {source.base + begin,
            source.base + std::min(source.text.find('\n', at), source.text.size())};
  }

  /// True if the node is a small-field GRID without tabs.
  bool is_small_grid(const Node& node) const {
    const Field &x = node.fields[0], &z = node.fields[2];
    if (x.kind != FieldKind::Nastran8) return false;
    const auto [begin, end] = line_of(node);
    const std::string_view line = mesh_.file.part(begin, z.begin + z.length - begin);
    return x.begin - begin == 24 && line.find('\t') == line.npos;
  }

  void widen(const Node& node, Output& output) {
    auto [begin, end] = line_of(node);
    const bool carriage = end > begin && mesh_.file.part(end - 1, 1) == "\r";
    end -= carriage;
    output.replace(
        begin, end,
        large_field_grid(mesh_.file.part(begin, end - begin), node.text, carriage ? "\r\n" : "\n"));
  }

  void replace_fields(const Node& node, Output& output) {
    // The y of a node may precede its x in the file.
    std::array<int, 3> order{0, 1, 2};
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return node.fields[a].begin < node.fields[b].begin; });
    for (const int c : order) {
      const Field& field = node.fields[c];
      if (!node.changed[c] && !(node.changes_open() && field.open)) continue;
      std::string by = aligned(node.text[c], field, old_text(node, c));
      if (field.open) by = std::string(field.gap, is_fixed_width(field.kind) ? ' ' : ',') + by;
      output.replace(field.begin, field.begin + field.length, by);
    }
  }

  using Motion = NodeRotations::Motion;
  Vec3 rotated(const RotatingCard& card, const RotatingCard::Numbers& numbers,
               const Motion& motion);
  void rewrite_numbers(const std::string& name, std::span<const Field> fields, const Vec3& old,
                       const Vec3& desired);
  bool on_one_line(const Field& a, const Field& b) const;
  void rewrite_card(const RotatingCard& card, const Motion& motion);
  void rewrite_material_direction(const MaterialDirection& material,
                                  const NodeRotations& rotations);
  void note_moved_axis(const RotatingCard& card, const Motion& motion);
  void note_positions();
  void note_left(const std::string& name, const Motion& motion);
  void note_spread(const std::map<std::string, std::pair<int, double>>& spread);

  const TextMeshContent& mesh_;
  const Points& points_;
  bool large_field_nodes_;
  double size_;                     // largest absolute coordinate
  CoordinateFrameResolver frames_;  // based on the positions as they will be read back
  std::vector<Output> outputs_;
  MeshRounding rounding_;
};

/// Angles below are not worth a note: a mean rotation serves all elements of a card.
constexpr double kSmallSpread = std::numbers::pi / 180;

/// The basis vectors of a coordinate system at a position, as columns.
Mat3 basis_at(const CoordinateFrame& frame, const Vec3& position) {
  using Kind = CoordinateFrame::Kind;
  if (frame.kind == Kind::Rectangular) return frame.axes;
  const Vec3 p = frame.axes.transpose() * (position - frame.origin);
  const Vec3 radial(p.x(), p.y(), 0);
  if (!(radial.norm() > 1e-12 * p.norm())) return frame.axes;
  const Vec3 around = Vec3::UnitZ().cross(radial).normalized();
  Mat3 local;
  if (frame.kind == Kind::Cylindrical)
    local << radial.normalized(), around, Vec3::UnitZ();
  else if (frame.kind == Kind::Spherical)
    local << p.normalized(), around.cross(p).normalized(), around;
  else
    local << p.normalized(), around, p.cross(around).normalized();
  return frame.axes * local;
}

/// The new value of three numbers of a card.
Vec3 Rewriting::rotated(const RotatingCard& card, const RotatingCard::Numbers& numbers,
                        const Motion& motion) {
  using Kind = RotatingCard::Numbers::Kind;
  const bool local = card.system >= 0;
  if (numbers.kind == Kind::Vector && local) {
    const CoordinateFrame& frame = frames_.of(card.system);
    const int node = card.nodes.front();
    const Vec3 global = basis_at(frame, mesh_.shells.points.row(node).transpose()) * numbers.value;
    return basis_at(frame, given_position(node)).transpose() * (motion.R * global);
  }
  if (numbers.kind == Kind::Vector) return motion.R * numbers.value;
  const Vec3 point = local ? frames_.of(card.system).position(numbers.value) : numbers.value;
  const Vec3 origin = local ? frames_.of(card.system).position(numbers.origin) : numbers.origin;
  const Vec3 moved = numbers.kind == Kind::Point ? Vec3(motion.R * point + motion.translation)
                                                 : Vec3(origin + motion.R * (point - origin));
  return local ? frames_.of(card.system).local_coordinates(moved, numbers.value) : moved;
}

void Rewriting::rewrite_numbers(const std::string& name, std::span<const Field> fields,
                                const Vec3& old, const Vec3& desired) {
  std::array<std::string, 3> text{};
  std::array<bool, 3> changed{};
  const double noise = 1e-13 * std::max(old.norm(), desired.norm());
  for (size_t c = 0; c < fields.size(); ++c) {
    text[c] = trimmed(mesh_.file.part(fields[c].begin, fields[c].length));
    const double value = std::abs(desired[c]) <= noise ? 0 : desired[c];
    if (std::abs(value - old[c]) <= noise) continue;
    double written = 0;
    const std::string by = format_field(value, fields[c].kind, written);
    if (by.empty() || !std::isfinite(written))
      mesh_.file.fail(fields[c].begin, "the number " + format_number(value) + " of " + name +
                                           " does not fit into its field");
    if (std::abs(old[c] - value) <= std::abs(written - value)) continue;
    changed[c] = true;
    text[c] = by;
  }
  bool open = false;
  for (size_t c = 0; c < fields.size(); ++c) open |= changed[c] && fields[c].open;
  for (size_t c = 0; c < fields.size(); ++c) {
    if (!changed[c] && !(open && fields[c].open)) continue;
    const Field& field = fields[c];
    std::string by = aligned(text[c], field, mesh_.file.part(field.begin, field.length));
    if (field.open) by = std::string(field.gap, is_fixed_width(field.kind) ? ' ' : ',') + by;
    Output& output = outputs_[mesh_.file.source_index(field.begin)];
    output.changed = name + " rotates";
    output.replace(field.begin, field.begin + field.length, by);
  }
}

bool Rewriting::on_one_line(const Field& a, const Field& b) const {
  const auto [low, high] = std::minmax(a.begin, b.begin);
  if (mesh_.file.source_index(low) != mesh_.file.source_index(high)) return false;
  return mesh_.file.part(low, high - low).find('\n') == std::string_view::npos;
}

void Rewriting::rewrite_card(const RotatingCard& card, const Motion& motion) {
  using Kind = RotatingCard::Numbers::Kind;
  for (const RotatingCard::Numbers& numbers : card.numbers) {
    if (!motion.is_rotated && numbers.kind != Kind::Point && card.system < 0) continue;
    const Vec3 desired = rotated(card, numbers, motion);
    // Fields of two lines are written line by line.
    size_t first = 0;
    for (size_t c = 1; c <= 3; ++c) {
      if (c < 3 && on_one_line(numbers.fields[first], numbers.fields[c])) continue;
      Vec3 from = Vec3::Zero(), to = Vec3::Zero();
      for (size_t k = first; k < c; ++k) {
        from[static_cast<int>(k - first)] = numbers.value[static_cast<int>(k)];
        to[static_cast<int>(k - first)] = desired[static_cast<int>(k)];
      }
      rewrite_numbers(card.name, std::span(numbers.fields).subspan(first, c - first), from, to);
      first = c;
    }
  }
}

/// Writes the angle from the first edge of a shell to its material direction.
void Rewriting::rewrite_material_direction(const MaterialDirection& material,
                                           const NodeRotations& rotations) {
  const auto corners = mesh_.shells.corners(material.face);
  const Motion motion = rotations.of(corners);
  if (!motion.is_rotated) return;
  const auto point = [&](const Points& at, size_t k) { return at.row(corners[k]).transpose(); };
  const auto angle_in = [&](const Points& at, const Vec3& direction) {
    const Vec3 edge = point(at, 1) - point(at, 0);
    const Vec3 normal =
        corners.size() == 3
            ? Vec3(edge.cross(Vec3(point(at, 2) - point(at, 0))))
            : Vec3(Vec3(point(at, 2) - point(at, 0)).cross(Vec3(point(at, 3) - point(at, 1))));
    const Vec3 n = normal.normalized(), flat = direction - direction.dot(n) * n;
    return std::atan2(edge.cross(flat).dot(n), edge.dot(flat)) * 180 / std::numbers::pi;
  };
  double angle = angle_in(points_, motion.R * material.direction);
  if (std::abs(angle) < 1e-9) angle = 0;  // a rounding error
  // The field contains the number of a system, not an angle.
  const double none = std::numeric_limits<double>::quiet_NaN();
  if (!std::isfinite(angle)) return;
  rewrite_numbers(material.name, {&material.field, 1}, Vec3(none, 0, 0), Vec3(angle, 0, 0));
}

void Rewriting::note_spread(const std::map<std::string, std::pair<int, double>>& spread) {
  for (const auto& [name, found] : spread)
    rounding_.notes.push_back(
        name + " rotates by the mean of its " + format_count(found.first, "node") +
        ", which differ from it by up to " + format_number(found.second * 180 / std::numbers::pi) +
        " degrees; use one card per part that rotates alike where this matters");
}

/// An axis given by points moves with the mean of its nodes, which may deform.
void Rewriting::note_moved_axis(const RotatingCard& card, const Motion& motion) {
  using Kind = RotatingCard::Numbers::Kind;
  if (card.numbers.empty() || card.numbers[0].kind != Kind::Point) return;
  double deviation = 0;
  Box3 box;
  for (const int v : card.nodes) {
    const Vec3 p = mesh_.shells.points.row(v).transpose();
    box.extend(p);
    deviation = std::max(deviation, (motion.R * p + motion.translation - given_position(v)).norm());
  }
  constexpr double kSmallDeviation = 1e-3;  // relative to the size of the part
  if (deviation > kSmallDeviation * box.diagonal().norm())
    rounding_.notes.push_back(card.name + ": its axis moves with the mean of its " +
                              format_count(isize(card.nodes), "node") +
                              ", which differ from that motion by up to " +
                              format_number(deviation) + "; check it in the written deck");
}

void Rewriting::note_positions() {
  const double moved = (points_ - mesh_.shells.points).rowwise().norm().maxCoeff();
  if (!(moved > noise_of(FieldKind::Dyna20))) return;
  for (const auto& [name, count] : mesh_.global_positions)
    rounding_.notes.push_back(std::to_string(count) + " " + name +
                              (count == 1 ? " stays" : " stay") +
                              " in place, while the mesh moves by up to " + format_number(moved) +
                              "; move it in the written deck if it belongs to the moved part");
}

void Rewriting::rewrite_directions() {
  if (!mesh_.global_positions.empty() && points_.rows() > 0) note_positions();
  if (mesh_.rotating_cards.empty() && mesh_.material_directions.empty() &&
      mesh_.global_directions.empty())
    return;
  const NodeRotations rotations(mesh_.shells, mesh_.other_elements, mesh_.shells.points, points_);
  std::map<std::string, std::pair<int, double>> spread;
  for (const RotatingCard& card : mesh_.rotating_cards) {
    const Motion motion = rotations.of(card.nodes);
    if (motion.is_identity) continue;
    if (card.use == RotatingCard::Use::Unknown && motion.spread > kSmallSpread) {
      note_left(card.name, motion);
      continue;
    }
    rewrite_card(card, motion);
    if (card.use == RotatingCard::Use::Shared && motion.spread > kSmallSpread)
      spread[card.name] = {isize(card.nodes), motion.spread};
    else if (card.use == RotatingCard::Use::Shared)
      note_moved_axis(card, motion);
  }
  note_spread(spread);
  for (const MaterialDirection& material : mesh_.material_directions)
    rewrite_material_direction(material, rotations);
  for (const GlobalDirections& card : mesh_.global_directions) {
    note_left(card.name, rotations.of(card.nodes));
  }
}

void Rewriting::note_left(const std::string& name, const Motion& motion) {
  const double angle = Eigen::AngleAxisd(motion.R).angle() + motion.spread;
  if (angle > kSmallSpread)
    rounding_.notes.push_back(name +
                              ": its directions stay as they are, but the mesh there rotates "
                              "by up to " +
                              format_number(angle * 180 / std::numbers::pi) +
                              " degrees; check them in the written deck");
}

/// The path to which each file is written: the main file to `path`, included files beside it. A
/// file included twice is written once, and an unchanged one that is already there is not written.
/// Throws InputError if a changed file cannot be written.
std::map<fs::path, const Output*> targets_of(const fs::path& path,
                                             const fs::path& destination_folder,
                                             const std::vector<Output>& outputs) {
  const fs::path folder = destination_folder.empty() ? path.parent_path() : destination_folder;
  std::set<fs::path> inputs;
  for (const Output& output : outputs) inputs.insert(output.source->canonical);
  std::map<fs::path, const Output*> targets;
  for (const Output& output : outputs) {
    const bool main = &output == &outputs.front();
    if (output.source->beside.empty()) {
      if (!output.changed.empty())
        throw InputError(
            output.source->path.string() + ": " + output.changed +
            ", but its file is included by an absolute path, expected a relative path");
      continue;
    }
    const fs::path target =
        main ? path : (path.parent_path() / output.source->beside).lexically_normal();
    std::error_code error;
    const fs::path last =
        fs::weakly_canonical(folder / target.lexically_relative(path.parent_path()), error);
    if (outputs.size() > 1 && inputs.contains(last)) {
      if (!main && output.changed.empty() && last == output.source->canonical) continue;
      throw InputError(last.string() +
                       ": found a file of the deck that was read, expected another folder");
    }
    const auto there = targets.find(target);
    if (there != targets.end() && there->second->source->path != output.source->path)
      throw InputError(target.string() +
                       ": found the name of an included file, expected another name");
    if (there == targets.end() || !output.changed.empty()) targets[target] = &output;
  }
  return targets;
}

void write_files(const std::map<fs::path, const Output*>& targets, const fs::path& main) {
  std::vector<std::unique_ptr<AtomicFile>> files;
  for (const auto& [target, output] : targets) {
    if (targets.size() > 1 && target.has_parent_path()) make_output_folder(target.parent_path());
    files.push_back(std::make_unique<AtomicFile>(target));
    std::string text = output->text;
    if (output->source->ends_with_carriage_returns)
      std::replace(text.begin(), text.end(), '\n', '\r');
    files.back()->write([&](std::ostream& stream) { stream << text; });
  }
  // The main file is moved last.
  std::vector<const AtomicFile*> all;
  for (const auto& file : files)
    all.insert(file->path() == main ? all.end() : all.begin(), file.get());
  commit_together(all);
}

}  // namespace

MeshRounding TextMeshContent::write(const fs::path& path, const Points& points,
                                    const MeshWriteOptions& options) const {
  Rewriting rewriting(*this, points, options.large_field_nodes);
  for (int i = 0; i < isize(fields); ++i) rewriting.rewrite(i);
  rewriting.rewrite_directions();
  write_files(targets_of(path, options.destination_folder, rewriting.finish()), path);
  return rewriting.rounding();
}

std::vector<fs::path> TextMeshContent::included_files() const {
  std::vector<fs::path> names;
  for (const auto& source : file.sources())
    if (source->included_at != std::string::npos && !source->beside.empty() &&
        std::find(names.begin(), names.end(), source->beside) == names.end())
      names.push_back(source->beside);
  return names;
}

fs::path TextMeshContent::folder_in_tree() const {
  long above = 0;
  for (const fs::path& name : included_files())
    above = std::max<long>(above, std::count(name.begin(), name.end(), ".."));
  fs::path rest = file.sources().front()->canonical.parent_path(), folder;
  for (; above > 0; --above) {
    folder = folder.empty() ? rest.filename() : rest.filename() / folder;
    rest = rest.parent_path();
  }
  return folder;
}

void TextMeshContent::warn_about_unwritten_includes() {
  std::vector<fs::path> said;
  for (const auto& source : file.sources()) {
    if (!source->beside.empty() || std::find(said.begin(), said.end(), source->path) != said.end())
      continue;
    said.push_back(source->path);
    warnings.push_back(
        source->path.string() +
        " is included by an absolute path: it is not written, and the written deck refers to it by "
        "the same name");
  }
}

void nodes_to_global(TextMeshContent& mesh, NodeCoordinateSystems systems) {
  Points& points = mesh.shells.points;
  systems.local_coordinates = points;
  mesh.systems = std::move(systems);
  const NodeCoordinateSystems& all = mesh.systems;
  std::function<Vec3(int)> position;
  CoordinateFrameResolver frames(all, mesh.file, [&](int node) { return position(node); });
  position = [&](int node) -> Vec3 {
    const Vec3 local_coordinates = all.local_coordinates.row(node).transpose();
    return all.of(node) < 0 ? local_coordinates
                            : frames.of(all.of(node)).position(local_coordinates);
  };
  for (int i = 0; i < mesh.shells.node_count(); ++i) {
    if (all.of(i) >= 0) points.row(i) = position(i).transpose();
    if (!points.row(i).allFinite())
      mesh.file.fail(mesh.fields[static_cast<size_t>(i)][0].begin,
                     "found a node whose position is not finite");
  }
}

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr int kDeepestSystem = 200;

/// Cosine and sine of an angle in degrees, exact at multiples of 90.
std::array<double, 2> direction(double degrees) {
  int quarter = 0;
  const double rest = std::remquo(degrees, 90, &quarter) * kDegree;
  const double c = std::cos(rest), s = std::sin(rest);
  switch (quarter & 3) {
    case 0:
      return {c, s};
    case 1:
      return {-s, c};
    case 2:
      return {-c, -s};
    default:
      return {s, -c};
  }
}

double degrees_of(double y, double x, double near) {
  if (x == 0 && y == 0) return near;
  const double angle = std::atan2(y, x) / kDegree;
  return angle + 360 * std::round((near - angle) / 360);
}

/// Spherical coordinates (r, polar, around) of a local position; `polar` is measured from z.
Vec3 sphere(const Vec3& p, const Vec3& near) {
  const double flat = std::hypot(p.x(), p.y());
  const Vec3 direct(p.norm(), degrees_of(flat, p.z(), near[1]), degrees_of(p.y(), p.x(), near[2])),
      turned(p.norm(), degrees_of(-flat, p.z(), near[1]), degrees_of(-p.y(), -p.x(), near[2]));
  const auto away = [&](const Vec3& a) {
    return std::abs(a[1] - near[1]) + std::abs(a[2] - near[2]);
  };
  return away(turned) < away(direct) ? turned : direct;
}

}  // namespace

Vec3 CoordinateFrame::position(const Vec3& n) const {
  Vec3 local = n;
  if (kind == Kind::Cylindrical) {
    const auto [c, s] = direction(n[1]);
    local = {n[0] * c, n[0] * s, n[2]};
  } else if (kind != Kind::Rectangular) {
    const bool polar = kind == Kind::Spherical;
    const auto [c, s] = direction(polar ? n[2] : n[1]);
    const auto [up, flat] = direction(polar ? n[1] : 90 - n[2]);
    local = {n[0] * flat * c, n[0] * flat * s, n[0] * up};
  }
  return origin + axes * local;
}

Vec3 CoordinateFrame::local_coordinates(const Vec3& position, const Vec3& near) const {
  const Vec3 p = axes.transpose() * (position - origin);
  switch (kind) {
    case Kind::Rectangular:
      return p;
    case Kind::Cylindrical: {
      // A negative radius is read as a position on the opposite side.
      const double sign = near[0] < 0 ? -1 : 1;
      return {sign * std::hypot(p.x(), p.y()), degrees_of(sign * p.y(), sign * p.x(), near[1]),
              p.z()};
    }
    case Kind::Spherical:
      return near[0] < 0 ? Vec3(sphere(-p, near).cwiseProduct(Vec3(-1, 1, 1))) : sphere(p, near);
    default: {
      const Vec3 polar(near[0], 90 - near[2], near[1]);
      const Vec3 a =
          near[0] < 0 ? Vec3(sphere(-p, polar).cwiseProduct(Vec3(-1, 1, 1))) : sphere(p, polar);
      return {a[0], a[2], 90 - a[1]};
    }
  }
}

Vec3 CoordinateFrame::rounding(const Vec3& position, double length) const {
  const Vec3 p = axes.transpose() * (position - origin);
  length += 16 * kEps * (position.cwiseAbs().maxCoeff() + origin.cwiseAbs().maxCoeff() + p.norm());
  const auto angle = [&](double arm) {
    return std::min(360., length / (kDegree * std::max(arm, 1e-300)) + 360 * kEps);
  };
  const double around = angle(std::hypot(p.x(), p.y())), polar = angle(p.norm());
  switch (kind) {
    case Kind::Rectangular:
      return Vec3::Constant(length);
    case Kind::Cylindrical:
      return {length, around, length};
    case Kind::Spherical:
      return {length, polar, around};
    default:
      return {length, around, polar};
  }
}

const CoordinateFrame& CoordinateFrameResolver::of(int system) {
  const CoordinateSystemDefinition& plan = systems_.plans[system];
  if (state_[system] == 2) return frames_[system];
  const std::string name = "coordinate system " + std::to_string(plan.label);
  if (!plan.unsupported_name.empty())
    file_.fail(plan.where, "found nodes in " + name + ", a " + plan.unsupported_name +
                               ", expected rectangular, cylindrical or spherical systems");
  if (state_[system] == 1) file_.fail(plan.where, "found " + name + ", which is defined by itself");
  if (depth_ > kDeepestSystem)
    file_.fail(plan.where, "found more than " + std::to_string(kDeepestSystem) +
                               " coordinate systems that are defined by one another");
  state_[system] = 1;
  ++depth_;
  frames_[system] = make(plan);
  --depth_;
  state_[system] = 2;
  return frames_[system];
}

CoordinateFrame CoordinateFrameResolver::make(const CoordinateSystemDefinition& plan) {
  if (plan.given) return *plan.given;
  std::array<Vec3, 3> points = plan.points;
  for (int k = 0; k < 3; ++k) {
    if (plan.nodes[k] >= 0)
      points[k] = position_(plan.nodes[k]);
    else if (plan.in >= 0)
      points[k] = of(plan.in).position(plan.points[k]);
  }
  CoordinateFrame frame{plan.kind, points[0], {}};
  const Vec3 z = points[1] - points[0], y = z.cross(points[2] - points[0]);
  const double length = z.norm(), area = y.norm();
  if (!(area > 1e-12 * length * (points[2] - points[0]).norm()))
    file_.fail(plan.where, "found coordinate system " + std::to_string(plan.label) +
                               " whose three points lie on a line");
  frame.axes.col(2) = z / length;
  frame.axes.col(1) = y / area;
  frame.axes.col(0) = frame.axes.col(1).cross(frame.axes.col(2));
  return frame;
}

}  // namespace batten
