// Coordinates put back into the text that they were read from.
#include "batten/io/meshes/text_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <ostream>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/io/files/whole_file.h"
#include "batten/io/meshes/field_text.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// The text of one file with other coordinates.
struct Output {
  const MeshText::Source* source;
  std::string text;
  size_t done = 0;  // end of what was taken over, in the source's text
  int node = -1;    // one that changes

  void replace(size_t begin, size_t end, const std::string& by) {
    begin -= source->base;
    text.append(source->text, done, begin - done);
    text += by;
    done = end - source->base;
  }
};

/// The texts of a mesh file, and of the files that it includes, with other coordinates.
class Rewriting {
 public:
  Rewriting(const TextMesh& mesh, const Points& points, bool wide_nodes)
      : mesh_(mesh),
        points_(points),
        wide_nodes_(wide_nodes),
        size_(mesh.shells.points.size() ? mesh.shells.points.cwiseAbs().maxCoeff() : 0),
        frames_(mesh.systems, mesh.file, [this](int node) { return written_place(node); }) {
    for (const auto& source : mesh.file.sources()) outputs_.push_back({source.get(), "", 0, -1});
  }

  /// The coordinates of a node, by their order in the text.
  void rewrite(int i) {
    const Node node = choose(i);
    measure(node);
    if (!node.changes()) return;
    refuse_held(i);
    Output& output = outputs_[mesh_.file.source_index(node.fields[0].begin)];
    output.node = i;
    if (node.wide)
      widen(node, output);
    else
      replace_fields(node, output);
  }

  std::vector<Output>& finish() {
    for (Output& output : outputs_) output.text.append(output.source->text, output.done);
    return outputs_;
  }
  const MeshRounding& rounding() const { return rounding_; }

 private:
  /// What is to be written of a node.
  struct Node {
    int index;
    const std::array<Field, 3>& fields;
    bool wide = false;
    Vec3 numbers = Vec3::Zero();  // as a reader will have them
    std::array<std::string, 3> text{};
    std::array<bool, 3> changed{};
    bool changes() const { return changed[0] || changed[1] || changed[2]; }
    /// Then all its open fields are written, together.
    bool changes_open() const {
      bool any = false;
      for (size_t c = 0; c < 3; ++c) any |= changed[c] && fields[c].open;
      return any;
    }
  };

  Vec3 place_given(int i) const { return points_.row(i).transpose(); }
  Vec3 numbers_read(int i) const {
    const Points& from = mesh_.systems.any() ? mesh_.systems.numbers : mesh_.shells.points;
    return from.row(i).transpose();
  }

  Node choose(int i) {
    Node node{i, mesh_.fields[static_cast<size_t>(i)]};
    const Vec3 old = numbers_read(i), place = place_given(i);
    const int system = mesh_.systems.of(i);
    node.numbers = old;
    if ((system < 0 ? old : frames_.of(system).place(old)) == place) return node;
    Vec3 wanted = place, rounding = Vec3::Constant(noise_of(node.fields[0].kind));
    if (system >= 0) {
      wanted = frames_.of(system).numbers(place, old);
      rounding = frames_.of(system).rounding(place, rounding[0]);
    }
    node.wide = wide_nodes_ && is_small_grid(node);
    for (int c = 0; c < 3; ++c) {
      node.text[c] = trimmed(old_text(node, c));
      if (std::abs(wanted[c] - old[c]) <= rounding[c]) continue;
      const FieldKind kind = node.wide ? FieldKind::Nastran16 : node.fields[c].kind;
      double written = 0;
      const std::string text = text_of(wanted[c], kind, written);
      if (text.empty() || !std::isfinite(written))
        mesh_.file.fail(node.fields[c].begin,
                        "the coordinate " + number(wanted[c]) + " does not fit into its field");
      // What is there may be as near as the field allows.
      if (std::abs(old[c] - wanted[c]) <= std::abs(written - wanted[c])) continue;
      node.changed[c] = true;
      node.numbers[c] = written;
      node.text[c] = text;
    }
    return node;
  }

  /// A deck keeps its text where an edit leaves nothing but the rounding of its sums behind.
  double noise_of(FieldKind kind) const {
    constexpr double kNoise = 1e-13;
    return of_deck(kind) ? kNoise * size_ : 0;
  }

  Vec3 written_place(int i) {
    const Vec3 numbers = choose(i).numbers;
    const int system = mesh_.systems.of(i);
    return system < 0 ? numbers : frames_.of(system).place(numbers);
  }

  void measure(const Node& node) {
    const int system = mesh_.systems.of(node.index);
    const Vec3 written = system < 0 ? node.numbers : frames_.of(system).place(node.numbers);
    const double error = (written - place_given(node.index)).cwiseAbs().maxCoeff();
    if (error > rounding_.largest) rounding_ = {error, mesh_.node_labels.of(node.index)};
  }

  void refuse_held(int i) const {
    const auto held =
        std::lower_bound(mesh_.held.begin(), mesh_.held.end(), std::pair(i, std::string()));
    if (held != mesh_.held.end() && held->first == i)
      mesh_.file.fail(mesh_.fields[static_cast<size_t>(i)][0].begin,
                      "node " + std::to_string(mesh_.node_labels.of(i)) + " cannot be moved: it " +
                          held->second);
  }

  std::string_view old_text(const Node& node, int c) const {
    return mesh_.file.part(node.fields[c].begin, node.fields[c].length);
  }

  /// The line of a node's first field, from its first to behind its last byte.
  std::pair<size_t, size_t> line_of(const Node& node) const {
    const MeshText::Source& source = mesh_.file.source_of(node.fields[0].begin);
    const size_t at = node.fields[0].begin - source.base;
    const size_t before = source.text.rfind('\n', at);
    const size_t begin = before == source.text.npos ? 0 : before + 1;
    return {source.base + begin,
            source.base + std::min(source.text.find('\n', at), source.text.size())};
  }

  /// Whether the node is a GRID in small fields without tabs.
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
        wide_grid(mesh_.file.part(begin, end - begin), node.text, carriage ? "\r\n" : "\n"));
  }

  void replace_fields(const Node& node, Output& output) {
    // A file may have its y before its x.
    std::array<int, 3> order{0, 1, 2};
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return node.fields[a].begin < node.fields[b].begin; });
    for (const int c : order) {
      const Field& field = node.fields[c];
      if (!node.changed[c] && !(node.changes_open() && field.open)) continue;
      std::string by = placed(node.text[c], field, old_text(node, c));
      if (field.open) by = std::string(field.gap, fixed_columns(field.kind) ? ' ' : ',') + by;
      output.replace(field.begin, field.begin + field.length, by);
    }
  }

  const TextMesh& mesh_;
  const Points& points_;
  bool wide_nodes_;
  double size_;        // largest coordinate
  NodeFrames frames_;  // as they will be read
  std::vector<Output> outputs_;
  MeshRounding rounding_;
};

/// Where each file is written: the first one to `path`, the others beside it; a file that was read
/// twice once. Throws InputError for one that changes where it cannot be written.
std::map<fs::path, const Output*> targets_of(const TextMesh& mesh, const fs::path& path,
                                             const fs::path& appears_in,
                                             const std::vector<Output>& outputs) {
  std::map<fs::path, const Output*> targets;
  for (const Output& output : outputs) {
    const bool main = &output == &outputs.front();
    if (output.source->beside.empty()) {
      if (output.node >= 0)
        throw InputError(output.source->path.string() + ": node " +
                         std::to_string(mesh.node_labels.of(output.node)) +
                         " moves, but the file lies outside of the deck's folder or is included by "
                         "a whole path: expected it in the folder, included by a relative name");
      continue;
    }
    const fs::path target = main ? path : path.parent_path() / output.source->beside;
    const auto there = targets.find(target);
    if (there != targets.end() && there->second->source->path != output.source->path)
      throw InputError(target.string() + ": found the name of an included file, expected another");
    if (there == targets.end() || output.node >= 0) targets[target] = &output;
  }
  if (outputs.size() == 1) return targets;
  std::set<fs::path> inputs;
  std::error_code error;
  for (const Output& output : outputs)
    inputs.insert(fs::weakly_canonical(output.source->path, error));
  const fs::path folder = appears_in.empty() ? path.parent_path() : appears_in;
  for (const auto& [target, output] : targets) {
    const fs::path last = folder / target.lexically_relative(path.parent_path());
    if (inputs.contains(fs::weakly_canonical(last, error)))
      throw InputError(last.string() +
                       ": found a file of the deck that was read, expected another folder");
  }
  return targets;
}

void write_files(const std::map<fs::path, const Output*>& targets) {
  std::vector<std::unique_ptr<WholeFile>> files;
  for (const auto& [target, output] : targets) {
    if (targets.size() > 1 && target.has_parent_path()) make_output_folder(target.parent_path());
    files.push_back(std::make_unique<WholeFile>(target));
    write_whole_file(files.back()->temporary(), [&](std::ostream& stream) {
      stream.write(output->text.data(), static_cast<std::streamsize>(output->text.size()));
    });
  }
  for (const auto& file : files) file->commit();
}

}  // namespace

MeshRounding TextMesh::write(const fs::path& path, const Points& points,
                             const MeshWriteOptions& options) const {
  Rewriting rewriting(*this, points, options.wide_nodes);
  for (int i = 0; i < count_of(fields); ++i) rewriting.rewrite(i);
  write_files(targets_of(*this, path, options.appears_in, rewriting.finish()));
  return rewriting.rounding();
}

std::vector<fs::path> TextMesh::files_beside() const {
  std::vector<fs::path> names;
  for (const auto& source : file.sources())
    if (source->included_at != std::string::npos && !source->beside.empty() &&
        std::find(names.begin(), names.end(), source->beside) == names.end())
      names.push_back(source->beside);
  return names;
}

void TextMesh::warn_of_files_elsewhere() {
  std::vector<fs::path> said;
  for (const auto& source : file.sources()) {
    if (!source->beside.empty() || std::find(said.begin(), said.end(), source->path) != said.end())
      continue;
    said.push_back(source->path);
    warnings.push_back(source->path.string() +
                       " lies outside of the deck's folder or is included by a whole path: it is "
                       "not written, and a deck that is written looks for it under the same name");
  }
}

void place_nodes(TextMesh& mesh, NodeSystems systems) {
  Points& points = mesh.shells.points;
  systems.numbers = points;
  mesh.systems = std::move(systems);
  const NodeSystems& all = mesh.systems;
  std::function<Vec3(int)> place;
  NodeFrames frames(all, mesh.file, [&](int node) { return place(node); });
  place = [&](int node) -> Vec3 {
    const Vec3 numbers = all.numbers.row(node).transpose();
    return all.of(node) < 0 ? numbers : frames.of(all.of(node)).place(numbers);
  };
  for (int i = 0; i < mesh.shells.node_count(); ++i) {
    if (all.of(i) >= 0) points.row(i) = place(i).transpose();
    if (!points.row(i).allFinite())
      mesh.file.fail(mesh.fields[static_cast<size_t>(i)][0].begin,
                     "found a node whose place is not finite");
  }
}

}  // namespace batten
