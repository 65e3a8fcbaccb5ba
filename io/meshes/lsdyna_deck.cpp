// LS-DYNA keyword decks: nodes, elements and sets; everything else stays text.
#include <algorithm>
#include <optional>
#include <set>

#include "batten/core/errors.h"
#include "batten/io/meshes/deck_mesh_builder.h"
#include "batten/io/meshes/lsdyna_elements.h"
#include "batten/io/meshes/lsdyna_lines.h"

namespace batten {
namespace {

class DynaReader {
 public:
  explicit DynaReader(TextMeshContent& mesh)
      : mesh_(mesh),
        file_(mesh.file),
        lines_(mesh.file),
        deck_(mesh),
        elements_(mesh.file, lines_, deck_) {}

  void read() {
    while (const auto keyword = lines_.next_keyword()) {
      handle(*keyword);
      while (lines_.next_card()) {
      }
    }
    finish();
    if (!lines_.ended()) mesh_.warnings.push_back("the deck has no *END: it may be cut short");
  }

 private:
  struct DynaSet {
    bool of_nodes;
    std::string name, title;
    std::vector<LabelRange> ranges;
  };

  void handle(const DynaKeyword& keyword) {
    const std::string& name = keyword.name;
    if (name == "NODE") return nodes(keyword.widths);
    if (const auto options = options_after(name, "ELEMENT_SHELL")) return shells(keyword, *options);
    if (name == "PART" || name.starts_with("PART_")) return parts(keyword);
    if (const auto options = options_after(name, "SET_NODE")) return set(keyword, *options, true);
    if (const auto options = options_after(name, "SET_SHELL")) return set(keyword, *options, false);
    if (name.starts_with("NODE_TRANSFORM"))
      mesh_.warnings.push_back("*NODE_TRANSFORM is not applied");
    elements_.read(keyword);
  }

  void nodes(const DynaWidths& w) {
    while (lines_.next_record()) {
      const DeckLine line(lines_.line());
      const std::string_view label = line.value(0, 0, w.integer);
      const long number = file_.integer(label, "a node number");
      std::array<double, 3> xyz;
      for (int c = 0; c < 3; ++c)
        xyz[c] = file_.real(line.value(c + 1, w.integer + c * w.real, w.real), true);
      std::array<Field, 3> fields;
      line.fields(file_, 1, w.integer, w.kind, w.free_kind, fields);
      deck_.add_node(number, label, xyz, fields);
    }
  }

  void shells(const DynaKeyword& keyword, const std::set<std::string>& options) {
    static const std::set<std::string> known{"THICKNESS", "BETA", "MCID", "OFFSET",
                                             "DOF",       "SHL4", "TO",   "SHL8"};
    if (options.contains("COMPOSITE"))
      file_.fail(keyword.line, "found " + quoted_excerpt(keyword.line) +
                                   ", expected shells without COMPOSITE, whose cards have no end");
    if (!std::includes(known.begin(), known.end(), options.begin(), options.end()))
      return deck_.count_other_element("*" + keyword.name, 0);
    const bool thickness =
        options.contains("THICKNESS") || options.contains("BETA") || options.contains("MCID");
    const int w = keyword.widths.integer;
    while (lines_.next_record()) {
      const DeckLine line(lines_.line());
      const std::string_view label = line.value(0, 0, w), property = line.value(1, w, w);
      std::array<long, 8> n{};
      for (int i = 0; i < 8; ++i) {
        const std::string_view value = line.value(i + 2, (i + 2) * w, w);
        if (!value.empty()) n[i] = file_.integer(value, "a node number");
      }
      const bool middle = n[4] != 0 || n[5] != 0 || n[6] != 0 || n[7] != 0;
      add(file_.integer(label, "an element number"), label, std::string(property), n, middle);
      int cards = options.contains("OFFSET") + options.contains("DOF");
      if (thickness) cards += 1 + middle;
      for (; cards > 0; --cards)
        if (!lines_.next_card())
          file_.fail(label, "found element " + std::string(label) + " without its " +
                                format_count(cards, "more card") + " of *" + keyword.name);
    }
  }

  void add(long label, std::string_view where, const std::string& property,
           const std::array<long, 8>& n, bool middle) {
    if (n[0] == 0 || n[1] == 0 || n[2] == 0)
      file_.fail(where, "found element " + std::string(where) + " of fewer than 3 nodes");
    const bool triangle = n[3] == 0 || n[3] == n[2];
    if (!middle) {
      deck_.add_shell(label, where, property, {n.data(), triangle ? 3u : 4u});
    } else if (triangle) {
      // The fourth side has no length; its middle node, if there is one, is the third corner.
      const bool short_side = n[7] != 0 && (n[6] == n[2] || n[6] == 0);
      const std::array<long, 3> sides{n[4], n[5], short_side ? n[7] : n[6]};
      deck_.add_shell(label, where, property, {n.data(), 3}, sides);
    } else if (n[6] == 0 && n[7] == 0) {
      deck_.add_shell(label, where, property, {n.data(), 3}, {n.data() + 3, 3});
    } else {
      deck_.add_shell(label, where, property, {n.data(), 4}, {n.data() + 4, 4});
    }
  }

  void parts(const DynaKeyword& keyword) {
    const int w = keyword.widths.card;
    while (lines_.next_card()) {
      const std::string title(trimmed(lines_.line()));
      if (!lines_.next_card()) return;
      const std::string_view number = DeckLine(lines_.line()).value(0, 0, w);
      titles_[std::string(number)] = title;
      // Options have cards of their own.
      if (keyword.name != "PART") return;
    }
  }

  void set(const DynaKeyword& keyword, std::set<std::string> options, bool of_nodes) {
    const bool titled = options.erase("TITLE") > 0;
    options.erase("LIST");
    options.erase("COLLECT");
    const bool generate = options.erase("GENERATE") > 0;
    if (!options.empty()) {
      mesh_.warnings.push_back("*" + keyword.name + " is not read");
      return;
    }
    DynaSet set{of_nodes, "", "", {}};
    if (titled && lines_.next_card()) set.title = trimmed(lines_.line());
    if (!lines_.next_record()) return;
    const int w = keyword.widths.card;
    set.name = DeckLine(lines_.line()).value(0, 0, w);
    std::vector<long> numbers;
    while (lines_.next_record()) {
      const DeckLine line(lines_.line());
      for (int i = 0; i < 8; ++i) {
        const std::string_view value = line.value(i, i * w, w);
        const long number = value.empty() ? 0 : file_.integer(value, "a number");
        if (generate || number != 0) numbers.push_back(number);
      }
    }
    for (size_t i = 0; i + generate < numbers.size(); i += 1 + generate)
      set.ranges.push_back({numbers[i], numbers[i + generate]});
    sets_.push_back(std::move(set));
  }

  void finish() {
    deck_.finish(lines_.skipped_includes() > 0 ? " (some included files are not followed)" : "");
    for (MeshSet& property : mesh_.properties)
      if (const auto title = titles_.find(property.name); title != titles_.end())
        property.title = title->second;
    elements_.finish(mesh_, [&](long number) -> std::optional<std::vector<int>> {
      for (const DynaSet& set : sets_)
        if (set.of_nodes && set.name == std::to_string(number)) return deck_.nodes_of(set.ranges);
      return {};
    });
    for (const DynaSet& set : sets_) {
      MeshSet found{set.name, set.title, {}, {}};
      (set.of_nodes ? found.nodes : found.faces) =
          set.of_nodes ? deck_.nodes_of(set.ranges) : deck_.faces_of(set.ranges);
      if (!found.nodes.empty() || !found.faces.empty()) mesh_.sets.push_back(std::move(found));
    }
    if (lines_.skipped_includes() > 0)
      mesh_.warnings.push_back(format_count(lines_.skipped_includes(), "*INCLUDE_…") +
                               " is not followed");
    deck_.warn_about_other_elements();
    mesh_.warn_about_unwritten_includes();
  }

  TextMeshContent& mesh_;
  MeshSourceText& file_;
  DynaLines lines_;
  DeckMeshBuilder deck_;
  DynaElements elements_;
  std::map<std::string, std::string> titles_;
  std::vector<DynaSet> sets_;
};

}  // namespace

std::unique_ptr<MeshContent> read_lsdyna_deck(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMeshContent>(MeshSourceText(path));
  mesh->format = "LS-DYNA keyword";
  mesh->extensions = {".k", ".key", ".dyn"};
  DynaReader(*mesh).read();
  return mesh;
}

}  // namespace batten
