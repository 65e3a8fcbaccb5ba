// SPDX-License-Identifier: MPL-2.0
#include "batten/io/meshes/decks/deck_mesh_builder.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {

void DeckMeshBuilder::add_node(long label, std::string_view where, const std::array<double, 3>& xyz,
                               const std::array<Field, 3>& fields) {
  if (label <= 0)
    mesh_.file.fail(where, "found node number " + quoted_excerpt(where) + ", expected 1 or more");
  if (node_labels_.size() == std::numeric_limits<int>::max())
    mesh_.file.fail(where, "found more nodes than can be numbered");
  node_labels_.push_back(label);
  node_where_.push_back(mesh_.file.offset(where));
  coordinates_.insert(coordinates_.end(), xyz.begin(), xyz.end());
  mesh_.fields.push_back(fields);
}

void DeckMeshBuilder::add_shell(long label, std::string_view where, const std::string& property,
                                std::span<const long> corners, std::span<const long> middle) {
  if (label <= 0)
    mesh_.file.fail(where,
                    "found element number " + quoted_excerpt(where) + ", expected 1 or more");
  const auto known = property_index_.find(property);
  const size_t index = known != property_index_.end() ? known->second : properties_.size();
  if (known == property_index_.end()) {
    property_index_[property] = index;
    properties_.push_back(property);
  }
  shell_labels_.push_back(label);
  shells_.push_back({mesh_.file.offset(where), index, nodes_.size(),
                     static_cast<std::uint8_t>(corners.size()),
                     static_cast<std::uint8_t>(middle.size())});
  nodes_.insert(nodes_.end(), corners.begin(), corners.end());
  nodes_.insert(nodes_.end(), middle.begin(), middle.end());
}

void DeckMeshBuilder::finish(const std::string& missing_hint) {
  const MeshSourceText& file = mesh_.file;
  const auto once = [&](const Labels& labels, const char* what, const auto& where) {
    const auto duplicate = labels.duplicate();
    if (!duplicate) return;
    file.fail(where(duplicate->second),
              "found " + std::string(what) + " " + std::to_string(labels.of(duplicate->second)) +
                  " a second time, the first is in " +
                  file.line_name(where(duplicate->first), where(duplicate->second)));
  };
  mesh_.node_labels = Labels(std::move(node_labels_));
  mesh_.face_labels = Labels(std::move(shell_labels_));
  once(mesh_.node_labels, "node", [&](int i) { return node_where_[i]; });
  once(mesh_.face_labels, "element", [&](int i) { return shells_[i].where; });
  mesh_.shells.points = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
      coordinates_.data(), mesh_.node_labels.count(), 3);

  std::vector<MeshSet> properties(properties_.size());
  for (size_t p = 0; p < properties.size(); ++p) properties[p].name = properties_[p];
  for (size_t s = 0; s < shells_.size(); ++s) {
    join_shell(shells_[s], mesh_.face_labels.of(static_cast<int>(s)), missing_hint);
    properties[shells_[s].property].faces.push_back(static_cast<int>(s));
  }
  for (MeshSet& property : properties)
    if (!property.name.empty()) mesh_.properties.push_back(std::move(property));
  for (DeckElement& element : elements_) join_element(element, missing_hint);
  elements_.clear();
  join_directions();
}

/// The nodes with these numbers that exist; all nodes if there are no numbers.
std::vector<int> DeckMeshBuilder::known_nodes(const std::vector<long>& labels) const {
  std::vector<int> nodes;
  if (labels.empty()) {
    nodes.resize(static_cast<size_t>(mesh_.node_labels.count()));
    std::iota(nodes.begin(), nodes.end(), 0);
  }
  for (const long label : labels)
    if (const auto node = mesh_.node_labels.find(label)) nodes.push_back(*node);
  return sorted_unique(std::move(nodes));
}

void DeckMeshBuilder::join_directions() {
  for (auto& [card, labels] : rotating_) {
    card.nodes = known_nodes(labels);
    if (labels.empty()) card.use = RotatingCard::Use::Unknown;
    mesh_.rotating_cards.push_back(std::move(card));
  }
  for (const auto& [name, labels] : global_directions_)
    mesh_.global_directions.push_back({name, known_nodes(labels)});
}

void DeckMeshBuilder::add_element(DeckElement element) {
  count_other_element(element.name);
  count_members(element.nodes.size());
  elements_.push_back(std::move(element));
}

void DeckMeshBuilder::add_tie(const std::string& name, std::vector<int> nodes,
                              std::vector<int> faces, double reach) {
  nodes = sorted_unique(std::move(nodes));
  const std::vector<int> own = nodes_of_faces(faces);
  std::erase_if(nodes, [&](int v) { return std::binary_search(own.begin(), own.end(), v); });
  if (!nodes.empty())
    mesh_.ties.push_back(
        {SurfaceTie::Kind::Tie, name, std::move(nodes), {std::move(faces)}, reach});
}

std::vector<int> DeckMeshBuilder::faces_of_property(const std::string& name) const {
  for (const MeshSet& property : mesh_.properties)
    if (property.name == name) return property.faces;
  return {};
}

std::vector<int> DeckMeshBuilder::faces_among(const std::vector<int>& nodes) const {
  const std::vector<int> all = sorted_unique(nodes);
  std::vector<int> faces;
  for (int f = 0; f < mesh_.shells.face_count(); ++f) {
    const auto corners = mesh_.shells.corners(f);
    if (std::all_of(corners.begin(), corners.end(),
                    [&](int v) { return std::binary_search(all.begin(), all.end(), v); }))
      faces.push_back(f);
  }
  return faces;
}

std::vector<int> DeckMeshBuilder::nodes_of_faces(const std::vector<int>& faces) const {
  std::vector<int> nodes;
  for (const int f : faces)
    nodes.insert(nodes.end(), mesh_.shells.face(f).begin(), mesh_.shells.face(f).end());
  return sorted_unique(std::move(nodes));
}

bool DeckMeshBuilder::scalar_point(long label) const {
  return std::any_of(scalar_points_.begin(), scalar_points_.end(), [&](const LabelRange& range) {
    return label >= range.first && label <= range.last;
  });
}

void DeckMeshBuilder::join_element(DeckElement& element, const std::string& missing_hint) {
  NonShellElement joined{element.kind, std::move(element.name), element.label, {}, {}};
  for (size_t i = 0; i < element.nodes.size(); ++i) {
    const long node = element.nodes[i];
    if (node == 0) continue;
    const auto found = mesh_.node_labels.find(node);
    if (!found && scalar_point(node)) continue;
    if (!found)
      mesh_.file.fail(element.where,
                      "found node " + std::to_string(node) + " in " + joined.name +
                          (joined.label ? " " + std::to_string(joined.label) : std::string()) +
                          ", expected the number of a node" + missing_hint);
    joined.nodes.push_back(*found);
    if (i > 0 && i <= element.weights.size()) joined.weights.push_back(element.weights[i - 1]);
  }
  if (!joined.nodes.empty()) mesh_.other_elements.push_back(std::move(joined));
}

void DeckMeshBuilder::join_shell(const Shell& shell, long label, const std::string& missing_hint) {
  const auto index = [&](long node) {
    const auto found = mesh_.node_labels.find(node);
    if (!found)
      mesh_.file.fail(shell.where, "found node " + std::to_string(node) + " in element " +
                                       std::to_string(label) + ", expected the number of a node" +
                                       missing_hint);
    return *found;
  };
  const long* const nodes = nodes_.data() + shell.first;
  const long* const middle = nodes + shell.corners;
  const auto there = std::count_if(middle, middle + shell.middle, [](long n) { return n != 0; });
  std::array<int, 8> face{};
  size_t count = 0;
  if (there == shell.corners) {
    for (int i = 0; i < shell.corners + shell.middle; ++i) face[count++] = index(nodes[i]);
  } else {
    // Only some edges have mid-side nodes: a polygon, so that these nodes move with their face.
    for (int i = 0; i < shell.corners; ++i) {
      face[count++] = index(nodes[i]);
      if (i < shell.middle && middle[i] != 0) face[count++] = index(middle[i]);
    }
  }
  mesh_.shells.add_face({face.data(), count}, there == shell.corners);
}

namespace {

/// Number of steps between the ends of a range that is not empty.
unsigned long steps_of(const LabelRange& range) {
  const unsigned long length =
      static_cast<unsigned long>(range.last) - static_cast<unsigned long>(range.first);
  return length / static_cast<unsigned long>(range.step);
}

}  // namespace

std::vector<int> indices_of(const Labels& labels, const std::vector<LabelRange>& ranges) {
  std::vector<int> result;
  for (const LabelRange& range : ranges) {
    if (range.last < range.first || range.step <= 0) continue;
    const unsigned long length =
        static_cast<unsigned long>(range.last) - static_cast<unsigned long>(range.first);
    if (steps_of(range) <= 2 * static_cast<unsigned long>(labels.count())) {
      for (unsigned long i = 0; i <= length; i += static_cast<unsigned long>(range.step))
        if (const auto found = labels.find(range.first + static_cast<long>(i)))
          result.push_back(*found);
    } else {
      for (int i = 0; i < labels.count(); ++i) {
        const long label = labels.of(i);
        if (label >= range.first && label <= range.last && (label - range.first) % range.step == 0)
          result.push_back(i);
      }
    }
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

size_t DeckMeshBuilder::text_size() const {
  const MeshSourceText::Source& last = *mesh_.file.sources().back();
  return last.base + last.text.size();
}

void DeckMeshBuilder::count_members(size_t count) {
  constexpr size_t most_per_byte = 16, always = 1000000;
  members_ += count;
  if (const size_t most = always + most_per_byte * text_size(); members_ > most)
    throw InputError(mesh_.file.path().string() + ": found more than " + std::to_string(most) +
                     " nodes and faces in the sets and connections together, expected fewer for a "
                     "deck of " +
                     std::to_string(text_size()) + " bytes");
}

void DeckMeshBuilder::count_members(const std::vector<LabelRange>& ranges, const Labels& labels) {
  for (const LabelRange& range : ranges)
    if (range.last >= range.first && range.step > 0)
      count_members(std::min(steps_of(range) + 1, static_cast<unsigned long>(labels.count())));
}

std::vector<int> DeckMeshBuilder::nodes_of(const std::vector<LabelRange>& ranges) {
  count_members(ranges, mesh_.node_labels);
  return indices_of(mesh_.node_labels, ranges);
}

std::vector<int> DeckMeshBuilder::faces_of(const std::vector<LabelRange>& ranges) {
  count_members(ranges, mesh_.face_labels);
  return indices_of(mesh_.face_labels, ranges);
}

void DeckMeshBuilder::warn_about_other_elements() {
  const int unused = unused_nodes(mesh_.shells);
  std::string text;
  for (const auto& [name, count] : other_counts_)
    text += (text.empty() ? "" : ", ") + (count > 0 ? std::to_string(count) + " " : "") + name;
  if (unused > 0)
    text += (text.empty() ? "" : "; ") + format_count(unused, "node") + " not used by a shell";
  if (!text.empty()) mesh_.warnings.push_back(text);
  mesh_.element_counts = text;
}

DeckLine::DeckLine(std::string_view data)
    : data_(data), free_(data.find(',') != data.npos), tabs_(data.find('\t') != data.npos) {
  if (!free_) {
    columns_ = isize(data_);
    if (tabs_) columns_ = 0;
    for (size_t i = 0; tabs_ && i < data_.size(); ++i)
      columns_ = data_[i] == '\t' ? (columns_ / 8 + 1) * 8 : columns_ + 1;
    return;
  }
  for (size_t begin = 0;;) {
    const size_t end = std::min(data_.find(',', begin), data_.size());
    const std::string_view value = data_.substr(begin, end - begin);
    if (count_ < isize(values_))
      values_[count_] = value;
    else
      more_.push_back(value);
    ++count_;
    if (end == data_.size()) break;
    begin = end + 1;
  }
}

size_t DeckLine::byte_of(int column) const {
  if (!tabs_) return std::min(static_cast<size_t>(column), data_.size());
  size_t byte = 0;
  for (int at = 0; byte < data_.size() && at < column; ++byte)
    at = data_[byte] == '\t' ? (at / 8 + 1) * 8 : at + 1;
  return byte;
}

std::string_view DeckLine::value(int index, int column, int width) const {
  if (free_) return index < count_ ? trimmed(at(index)) : data_.substr(data_.size());
  const size_t begin = byte_of(column);
  return trimmed(data_.substr(begin, byte_of(column + width) - begin));
}

void DeckLine::fields(const MeshSourceText& file, int index, int column, FieldKind fixed_kind,
                      FieldKind free_kind, std::span<Field> result) const {
  const size_t line = file.offset(data_);
  const int width = width_of(fixed_kind);
  for (int i = 0; i < isize(result); ++i) {
    Field& field = result[i];
    field = {line + data_.size(), 0, free_ ? free_kind : fixed_kind, false, 0};
    if (free_) {
      if (index + i < count_) {
        std::string_view value = at(index + i);
        if (!trimmed(value).empty()) value = trimmed(value);
        field.begin = file.offset(value);
        field.length = static_cast<std::uint32_t>(value.size());
      } else {
        field.open = true;
        field.gap = static_cast<std::uint16_t>(i == 0 ? index - count_ + 1 : 1);
      }
      continue;
    }
    const int begin = column + i * width;
    if (begin < columns_) {
      const size_t byte = byte_of(begin);
      field.begin = line + byte;
      field.length = static_cast<std::uint32_t>(byte_of(begin + width) - byte);
    } else {
      field.open = true;
      if (i == 0) field.gap = static_cast<std::uint16_t>(begin - columns_);
      // The previous field ends with the line: pad it, so that this one starts in its column.
      if (i > 0 && begin - width < columns_ && begin > columns_) result[i - 1].open = true;
    }
  }
}

}  // namespace batten
