// LS-DYNA keyword decks: nodes and shells; everything else stays text.
#include <algorithm>
#include <optional>
#include <set>

#include "batten/core/errors.h"
#include "batten/io/meshes/deck_mesh.h"

namespace batten {
namespace {

/// Columns of numbers, coordinates, and the fields of all other cards.
struct Widths {
  int integer = 8, real = 16, card = 10;
  FieldKind kind = FieldKind::Dyna16, free_kind = FieldKind::DynaFree16;
};
constexpr Widths kStandard;
constexpr Widths kI10{10, 16, 10, FieldKind::Dyna16, FieldKind::DynaFree16};
constexpr Widths kLong{20, 20, 20, FieldKind::Dyna20, FieldKind::DynaFree20};

struct Keyword {
  std::string name;
  Widths widths;
  std::string_view line;
};

/// Parts of "A_B_C" after `first`; nothing when the name does not start with it.
std::optional<std::set<std::string>> options_after(const std::string& name,
                                                   const std::string& first) {
  if (!name.starts_with(first)) return {};
  std::set<std::string> options;
  std::string_view rest = std::string_view(name).substr(first.size());
  if (!rest.empty() && rest[0] != '_') return {};
  while (!rest.empty()) {
    rest.remove_prefix(1);
    options.emplace(rest.substr(0, rest.find('_')));
    rest.remove_prefix(std::min(rest.find('_'), rest.size()));
  }
  return options;
}

class DynaReader {
 public:
  explicit DynaReader(TextMesh& mesh) : mesh_(mesh), file_(mesh.file), deck_(mesh) {}

  void read() {
    bool more = next(line_);
    while (more && !line_.starts_with('*')) more = next(line_);
    bool ended = false;
    while (line_.starts_with('*')) {
      const Keyword keyword = read_keyword();
      if (ended = keyword.name == "END"; ended) break;
      handle(keyword);
      while (next_card()) {
      }
    }
    finish();
    if (!ended) mesh_.warnings.push_back("the deck has no *END: it may be cut short");
  }

 private:
  struct DynaSet {
    bool of_nodes;
    std::string name, title;
    std::vector<LabelRange> ranges;
  };

  /// The next line that is not a comment; empty at the end.
  bool next(std::string_view& line) {
    while (file_.next(line))
      if (!line.starts_with('$')) return true;
    line = {};
    return false;
  }
  /// The next card; line_ is the keyword that ends them, and stays it.
  bool next_card() {
    if (line_.starts_with('*') && in_block_) return false;
    in_block_ = next(line_);
    return in_block_ && !line_.starts_with('*');
  }
  /// The same, passing over blank lines.
  bool next_record() {
    while (next_card())
      if (!trimmed(line_).empty()) return true;
    return false;
  }

  Keyword read_keyword() {
    std::string_view rest = line_.substr(1);
    Keyword keyword{upper(next_word(rest)), widths_, line_};
    keyword.name = keyword.name.substr(0, keyword.name.find(','));
    char suffix = keyword.name.empty() ? ' ' : keyword.name.back();
    if (suffix == '+' || suffix == '-' || suffix == '%')
      keyword.name.pop_back();
    else
      suffix = trimmed(rest).size() == 1 ? trimmed(rest)[0] : ' ';
    if (suffix == '+') keyword.widths = kLong;
    if (suffix == '-') keyword.widths = kStandard;
    if (suffix == '%') keyword.widths = kI10;
    if (keyword.name == "KEYWORD") {
      // LONG=S reads standard cards.
      std::string text = upper(rest);
      std::erase_if(text, blank);
      if (text.find("I10=Y") != text.npos) widths_ = kI10;
      if (text.find("LONG=Y") != text.npos || text.find("LONG=K") != text.npos) widths_ = kLong;
    }
    in_block_ = false;
    return keyword;
  }

  void handle(const Keyword& keyword) {
    const std::string& name = keyword.name;
    if (name == "NODE") return nodes(keyword.widths);
    if (const auto options = options_after(name, "ELEMENT_SHELL")) return shells(keyword, *options);
    if (name == "PART" || name.starts_with("PART_")) return parts(keyword);
    if (const auto options = options_after(name, "SET_NODE")) return set(keyword, *options, true);
    if (const auto options = options_after(name, "SET_SHELL")) return set(keyword, *options, false);
    if (name.starts_with("INCLUDE") && name != "INCLUDE_PATH") ++includes_;
    if (name.starts_with("ELEMENT_") || name.starts_with("CONSTRAINED_NODAL_RIGID_BODY"))
      deck_.add_other("*" + name, 0);
    if (name.starts_with("NODE_TRANSFORM"))
      mesh_.warnings.push_back("*NODE_TRANSFORM is not applied");
  }

  void nodes(const Widths& w) {
    while (next_record()) {
      const DeckLine line(line_);
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

  void shells(const Keyword& keyword, const std::set<std::string>& options) {
    static const std::set<std::string> known{"THICKNESS", "BETA", "MCID", "OFFSET",
                                             "DOF",       "SHL4", "TO",   "SHL8"};
    if (options.contains("COMPOSITE"))
      file_.fail(keyword.line, "found " + in_quotes(keyword.line) +
                                   ", expected shells without COMPOSITE, whose cards have no end");
    if (!std::includes(known.begin(), known.end(), options.begin(), options.end()))
      return deck_.add_other("*" + keyword.name, 0);
    const bool thickness =
        options.contains("THICKNESS") || options.contains("BETA") || options.contains("MCID");
    const int w = keyword.widths.integer;
    while (next_record()) {
      const DeckLine line(line_);
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
        if (!next_card())
          file_.fail(label, "found element " + std::string(label) + " without its " +
                                counted(cards, "more card") + " of *" + keyword.name);
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

  void parts(const Keyword& keyword) {
    const int w = keyword.widths.card;
    while (next_card()) {
      const std::string title(trimmed(line_));
      if (!next_card()) return;
      const std::string_view number = DeckLine(line_).value(0, 0, w);
      titles_[std::string(number)] = title;
      // Options have cards of their own.
      if (keyword.name != "PART") return;
    }
  }

  void set(const Keyword& keyword, std::set<std::string> options, bool of_nodes) {
    const bool titled = options.erase("TITLE") > 0;
    options.erase("LIST");
    options.erase("COLLECT");
    const bool generate = options.erase("GENERATE") > 0;
    if (!options.empty()) {
      mesh_.warnings.push_back("*" + keyword.name + " is not read");
      return;
    }
    DynaSet set{of_nodes, "", "", {}};
    if (titled && next_card()) set.title = trimmed(line_);
    if (!next_record()) return;
    const int w = keyword.widths.card;
    set.name = DeckLine(line_).value(0, 0, w);
    std::vector<long> numbers;
    while (next_record()) {
      const DeckLine line(line_);
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
    deck_.finish(includes_ > 0 ? " (included files are not followed)" : "");
    for (MeshSet& property : mesh_.properties)
      if (const auto title = titles_.find(property.name); title != titles_.end())
        property.title = title->second;
    for (const DynaSet& set : sets_) {
      MeshSet found{set.name, set.title, {}, {}};
      (set.of_nodes ? found.nodes : found.faces) =
          set.of_nodes ? deck_.nodes_of(set.ranges) : deck_.faces_of(set.ranges);
      if (!found.nodes.empty() || !found.faces.empty()) mesh_.sets.push_back(std::move(found));
    }
    if (includes_ > 0)
      mesh_.warnings.push_back(counted(includes_, "*INCLUDE") + " is not followed");
    deck_.warn_of_others();
  }

  TextMesh& mesh_;
  MeshText& file_;
  DeckMesh deck_;
  Widths widths_;
  std::string_view line_;
  bool in_block_ = false;
  std::map<std::string, std::string> titles_;
  std::vector<DynaSet> sets_;
  long includes_ = 0;
};

}  // namespace

std::unique_ptr<MeshContent> read_lsdyna_deck(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMesh>(MeshText(path));
  mesh->format = "LS-DYNA keyword";
  mesh->extensions = {".k", ".key", ".dyn"};
  DynaReader(*mesh).read();
  return mesh;
}

}  // namespace batten
