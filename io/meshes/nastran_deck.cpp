// Nastran bulk data: GRIDs, elements and the systems of coordinates; everything else stays text.
#include "batten/core/errors.h"
#include "batten/io/meshes/deck_mesh_builder.h"
#include "batten/io/meshes/nastran_cards.h"
#include "batten/io/meshes/nastran_elements.h"
#include "batten/io/meshes/nastran_systems.h"

namespace batten {
namespace {

class NastranReader {
 public:
  explicit NastranReader(TextMeshContent& mesh)
      : mesh_(mesh), file_(mesh.file), cards_(mesh.file), deck_(mesh), coordinates_(mesh.file) {}

  void read() {
    go_to_bulk();
    std::string_view line;
    bool ended = false;
    while (!ended && cards_.next(line)) {
      if (line.empty() || line[0] == '$') continue;
      const CardLine card(line);
      if (card.continues()) continue;
      const std::string name = upper(card.name);
      ended = name == "ENDDATA";
      read(card, name, line);
    }
    if (!ended && begun_)
      file_.fail_at_end(
          "found the end of a deck with BEGIN BULK, expected ENDDATA: it may be cut "
          "short");
    finish();
    if (!ended) mesh_.warnings.push_back("the deck has no ENDDATA: it may be cut short");
    mesh_.warn_about_unwritten_includes();
  }

 private:
  /// Executive and case control end with BEGIN BULK, if they are there at all.
  void go_to_bulk() {
    const auto begins = [](std::string_view line) {
      const std::string first = upper(next_word(line)), second = upper(next_word(line));
      return first == "BEGIN" && second.starts_with("BULK");
    };
    const size_t start = file_.position();
    std::string_view line;
    while (!begun_ && file_.next_in_file(line)) begun_ = begins(line);
    file_.seek(start);
    if (begun_)
      while (cards_.next(line) && !begins(line)) {
      }
  }

  void read(const CardLine& card, const std::string& name, std::string_view line) {
    if (name == "GRID") {
      grid(card);
    } else if (name == "CTRIA3" || name == "CTRIAR") {
      shell(card, 3, 0);
    } else if (name == "CQUAD4" || name == "CQUADR") {
      shell(card, 4, 0);
    } else if (name == "CTRIA6") {
      shell(card, 3, 3);
    } else if (name == "CQUAD8") {
      shell(card, 4, 4);
    } else if (name == "SET1") {
      sets_.push_back(cards_.values_of(card));
    } else if (name == "GRDSET") {
      if (!card.value(2).empty()) default_system_ = file_.integer(card.value(2), "a system");
    } else if (name.starts_with("CORD")) {
      coordinates_.read(name, cards_.values_of(card));
    } else if (name == "SPOINT" || name == "EPOINT") {
      std::vector<LabelRange> points;
      read_ranges(cards_.values_of(card), points);
      for (const LabelRange& range : points) deck_.add_scalar_points(range);
    } else if (is_non_shell_element(name)) {
      add_non_shell_element(name, cards_.values_of(card), file_, deck_);
    } else {
      other(name, line);
    }
  }

  void other(const std::string& name, std::string_view line) {
    if (name.starts_with("BEGIN") && upper(line).find("SUPER") != std::string::npos)
      file_.fail(line,
                 "found " + quoted_excerpt(line) + ", expected one model without superelements");
    if (name.starts_with("BEGIN") && begun_)
      file_.fail(line, "found a second " + quoted_excerpt(line) + ", expected one model");
    // That of an included file, in a deck that is nothing but included files.
    if (name.starts_with("BEGIN")) begun_ = true;
    if (name.starts_with("="))
      file_.fail(line,
                 "found a repeated card " + quoted_excerpt(line) + ", expected it written out");
  }

  void grid(const CardLine& card) {
    std::array<Field, 3> fields;
    std::array<std::string_view, 3> values{card.value(3), card.value(4)};
    if (card.large) {
      std::optional<CardLine> second;
      if (!cards_.next_line(second))
        file_.fail(card.name, "found a GRID* without its second line, expected one");
      card.fields(file_, 3, {fields.data(), 2});
      second->fields(file_, 1, {fields.data() + 2, 1});
      values[2] = second->value(1);
    } else {
      card.fields(file_, 3, fields);
      values[2] = card.value(5);
    }
    std::array<double, 3> xyz;
    for (int c = 0; c < 3; ++c) xyz[c] = file_.real(values[c], true);
    const std::string_view label = card.value(1), system = card.value(2);
    deck_.add_node(file_.integer(label, "a node number"), label, xyz, fields);
    systems_.push_back(system.empty() ? kDefault : file_.integer(system, "a coordinate system"));
  }

  void shell(const CardLine& card, size_t corners, size_t middle) {
    std::array<std::string_view, 10> values{};
    size_t count = 0;
    const size_t needed = 2 + corners + middle;
    std::optional<CardLine> line(card);
    do {
      for (int i = 1; i <= line->count() && count < needed; ++i) values[count++] = line->value(i);
    } while (count < needed && cards_.next_line(line));
    const long label = file_.integer(values[0], "an element number");
    std::array<long, 8> nodes{};
    for (size_t i = 0; i < corners + middle; ++i) {
      const std::string_view value = values[2 + i];
      if (i < corners && value.empty())
        file_.fail(card.name, "found " + format_count(static_cast<long>(i), "corner") +
                                  " of element " + std::to_string(label) + ", expected " +
                                  std::to_string(corners));
      if (!value.empty()) nodes[i] = file_.integer(value, "a node number");
    }
    // A property that is not given has the element's number.
    deck_.add_shell(label, values[0], std::string(values[1].empty() ? values[0] : values[1]),
                    {nodes.data(), corners}, {nodes.data() + corners, middle});
  }

  void finish() {
    deck_.finish();
    for (long& system : systems_)
      if (system == kDefault) system = default_system_;
    coordinates_.transform_nodes(mesh_, deck_, systems_);
    for (const auto& values : sets_) set(values);
    deck_.warn_about_other_elements();
  }

  void set(const std::vector<std::string_view>& values) {
    std::vector<LabelRange> ranges;
    const std::string_view bad = read_ranges(std::span(values).subspan(1), ranges);
    if (!bad.empty()) {
      mesh_.warnings.push_back("SET1 " + std::string(values[0]) + " is not read: it has " +
                               quoted_excerpt(bad));
      return;
    }
    MeshSet set{std::string(values[0]), {}, deck_.nodes_of(ranges), {}};
    if (!set.nodes.empty()) mesh_.sets.push_back(std::move(set));
  }

  static constexpr long kDefault = -1;  // the system that GRDSET says
  TextMeshContent& mesh_;
  MeshSourceText& file_;
  NastranCards cards_;
  DeckMeshBuilder deck_;
  NastranSystems coordinates_;
  std::vector<long> systems_;  // of each node
  std::vector<std::vector<std::string_view>> sets_;
  long default_system_ = 0;
  bool begun_ = false;  // BEGIN BULK was found
};

}  // namespace

std::unique_ptr<MeshContent> read_nastran_deck(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMeshContent>(MeshSourceText(path));
  mesh->format = "Nastran bulk data";
  mesh->extensions = {".bdf", ".nas", ".dat"};
  NastranReader(*mesh).read();
  return mesh;
}

}  // namespace batten
