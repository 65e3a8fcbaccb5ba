// SPDX-License-Identifier: MPL-2.0
// Reads LS-DYNA keyword decks: nodes, elements and sets. Everything else stays text.

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "batten/core/errors.h"
#include "batten/io/meshes/decks/deck_mesh_builder.h"
#include "batten/io/meshes/mesh_source_text.h"

namespace batten {

// Keywords and cards of LS-DYNA decks, including included files.

/// Field widths, in columns, of integers, coordinates, and the fields of all other cards.
struct DynaWidths {
  int integer = 8, real = 16, card = 10;
  FieldKind kind = FieldKind::Dyna16, free_kind = FieldKind::DynaFree16;
  bool operator==(const DynaWidths&) const = default;
};

struct DynaKeyword {
  std::string name;
  DynaWidths widths;
  std::string_view line;
};

/// The parts "A", "B", … of a keyword "first_A_B"; empty if `name` does not start with `first`.
std::optional<std::set<std::string>> options_after(const std::string& name,
                                                   const std::string& first);

/// Reads keywords and their cards. *INCLUDE is followed; *END in an included file ends that file.
class DynaLines {
 public:
  explicit DynaLines(MeshSourceText& file) : file_(file) {}

  /// The next keyword, skipping cards before it; empty at the end.
  std::optional<DynaKeyword> next_keyword();
  /// Advances line() to the next card of the current keyword; false if there is none.
  bool next_card();
  /// Like next_card(), but skips blank lines.
  bool next_record();
  std::string_view line() const { return line_; }
  /// True if *END was found.
  bool ended() const { return ended_; }
  /// Number of *INCLUDE_… keywords that were not followed.
  long skipped_includes() const { return skipped_includes_; }

 private:
  bool next(std::string_view& line);
  void leave_file();
  DynaKeyword read_keyword();
  void read_format(const DynaKeyword& keyword, std::string_view options);
  bool include(const DynaKeyword& keyword);
  std::vector<std::string_view> rest_of_block();
  std::vector<std::pair<std::string, std::string_view>> names(bool transformed,
                                                              const DynaKeyword& keyword);
  void require_identity(std::span<const std::string_view> cards, const DynaKeyword& keyword) const;

  MeshSourceText& file_;
  DynaWidths widths_;
  std::vector<DynaWidths> outer_;  // widths of the including files
  std::vector<std::string> folders_;
  std::string_view line_;
  bool ended_ = false;
  long skipped_includes_ = 0;
};

namespace {

constexpr DynaWidths kStandard;
constexpr DynaWidths kI10{10, 16, 10, FieldKind::Dyna16, FieldKind::DynaFree16};
constexpr DynaWidths kLong{20, 20, 20, FieldKind::Dyna20, FieldKind::DynaFree20};

}  // namespace

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

void DynaLines::leave_file() {
  file_.leave_file();
  widths_ = outer_.back();
  outer_.pop_back();
}

/// Reads the next line that is not a comment; `line` is empty at the end.
bool DynaLines::next(std::string_view& line) {
  for (;;) {
    while (file_.next_in_file(line))
      if (!line.starts_with('$')) return true;
    line = {};
    if (file_.depth() == 0) return false;
    leave_file();
  }
}

bool DynaLines::next_card() {
  // The keyword that ended the cards is kept for next_keyword().
  return !line_.starts_with('*') && next(line_) && !line_.starts_with('*');
}

bool DynaLines::next_record() {
  while (next_card())
    if (!trimmed(line_).empty()) return true;
  return false;
}

std::optional<DynaKeyword> DynaLines::next_keyword() {
  for (;;) {
    while (!line_.starts_with('*'))
      if (!next(line_)) return {};
    const DynaKeyword keyword = read_keyword();
    line_ = {};
    if (keyword.name == "END") {
      if (file_.depth() > 0) {
        leave_file();
        continue;
      }
      ended_ = true;
      return {};
    }
    if (!include(keyword)) return keyword;
  }
}

DynaKeyword DynaLines::read_keyword() {
  std::string_view rest = line_.substr(1);
  DynaKeyword keyword{upper(next_token(rest)), widths_, line_};
  keyword.name = keyword.name.substr(0, keyword.name.find(','));
  char suffix = keyword.name.empty() ? ' ' : keyword.name.back();
  if (suffix == '+' || suffix == '-' || suffix == '%')
    keyword.name.pop_back();
  else
    suffix = trimmed(rest).size() == 1 ? trimmed(rest)[0] : ' ';
  if (suffix == '+') keyword.widths = kLong;
  if (suffix == '-') keyword.widths = kStandard;
  if (suffix == '%') keyword.widths = kI10;
  if (keyword.name == "KEYWORD") read_format(keyword, rest);
  return keyword;
}

void DynaLines::read_format(const DynaKeyword& keyword, std::string_view options) {
  // LONG=S means standard cards.
  std::string text = upper(options);
  std::erase_if(text, is_blank);
  DynaWidths widths = widths_;
  if (text.find("I10=Y") != text.npos) widths = kI10;
  if (text.find("LONG=Y") != text.npos || text.find("LONG=K") != text.npos) widths = kLong;
  // LS-DYNA applies the format of *INCLUDE, other programs that of the included file.
  if (file_.depth() > 0 && widths != widths_)
    file_.fail(keyword.line, "found " + quoted_excerpt(keyword.line) +
                                 " in a file that is included in another format, expected both to "
                                 "be the same (*INCLUDE +, - or %)");
  widths_ = widths;
}

/// The cards of a keyword, up to the next keyword or the end of the current file.
std::vector<std::string_view> DynaLines::rest_of_block() {
  std::vector<std::string_view> cards;
  std::string_view line;
  for (size_t start = file_.position(); file_.next_in_file(line); start = file_.position()) {
    if (line.starts_with('*')) {
      file_.seek(start);
      break;
    }
    if (!line.starts_with('$')) cards.push_back(line);
  }
  return cards;
}

/// File names; a long name continues on the next card after " +".
std::vector<std::pair<std::string, std::string_view>> DynaLines::names(bool transformed,
                                                                       const DynaKeyword& keyword) {
  const std::vector<std::string_view> cards = rest_of_block();
  std::vector<std::pair<std::string, std::string_view>> found;
  bool goes_on = false;
  for (size_t i = 0; i < cards.size(); ++i) {
    std::string_view text = trimmed(cards[i]);
    if (text.empty()) continue;
    if (!goes_on) found.push_back({"", cards[i]});
    goes_on = text.ends_with(" +");
    if (goes_on) text = trimmed(text.substr(0, text.size() - 2));
    found.back().first += text;
    if (goes_on || !transformed) continue;
    require_identity(std::span(cards).subspan(i + 1), keyword);
    break;
  }
  return found;
}

/// Checks that id offsets, unit factors and the transformation change nothing; throws InputError
/// otherwise.
void DynaLines::require_identity(std::span<const std::string_view> cards,
                                 const DynaKeyword& keyword) const {
  constexpr size_t kFactors = 2, kTransformation = 3;
  for (size_t i = 0; i < cards.size() && i <= kTransformation; ++i) {
    const DeckLine line(cards[i]);
    // Fields after the factors control printing; name prefixes and suffixes do not affect nodes.
    const int count = i == 0 ? 7 : i == kFactors ? 4 : 1;
    for (int k = 0; k < count; ++k) {
      const std::string_view value = line.value(k, k * keyword.widths.card, keyword.widths.card);
      double number = 0;
      if (value.empty()) continue;
      const bool same =
          (i == kFactors && value == "0") ||
          (parse_real(value, number) && (number == 0 || (i == kFactors && number == 1)));
      if (!same)
        file_.fail(value, "found " + quoted_excerpt(value) + " of *" + keyword.name +
                              ", expected an untransformed include");
    }
  }
}

bool DynaLines::include(const DynaKeyword& keyword) {
  if (!keyword.name.starts_with("INCLUDE")) return false;
  if (keyword.name == "INCLUDE_PATH" || keyword.name == "INCLUDE_PATH_RELATIVE") {
    for (const auto& [folder, line] : names(false, keyword)) folders_.push_back(folder);
    return true;
  }
  const bool transformed = keyword.name == "INCLUDE_TRANSFORM";
  if (keyword.name != "INCLUDE" && !transformed) {
    ++skipped_includes_;
    return false;
  }
  const auto found = names(transformed, keyword);
  // Included files are stacked, so the last one is pushed first.
  for (auto name = found.rbegin(); name != found.rend(); ++name) {
    file_.include(name->first, name->second, folders_);
    outer_.push_back(widths_);
    widths_ = keyword.widths;
  }
  return true;
}

// Directions of LS-DYNA decks.

/// Reads *DEFINE_COORDINATE_SYSTEM, *DEFINE_COORDINATE_VECTOR, *DEFINE_VECTOR and
/// *DEFINE_SD_ORIENTATION, and notes materials whose axes are global vectors.
class DynaDirections {
 public:
  DynaDirections(MeshSourceText& file, DynaLines& lines, DeckMeshBuilder& deck)
      : file_(file), lines_(lines), deck_(deck) {}
  /// Returns false for any other keyword.
  bool read(const DynaKeyword& keyword);

 private:
  using Kind = RotatingCard::Numbers::Kind;
  RotatingCard::Numbers three(int first, const DynaKeyword& keyword, Kind kind) const;
  bool material(const DynaKeyword& keyword);
  MeshSourceText& file_;
  DynaLines& lines_;
  DeckMeshBuilder& deck_;
};

/// Three numbers of a card; omitted ones are 0.
RotatingCard::Numbers three_of(const MeshSourceText& file, std::string_view card, int first,
                               int width, RotatingCard::Numbers::Kind kind) {
  const DeckLine line(card);
  RotatingCard::Numbers numbers;
  for (int c = 0; c < 3; ++c)
    numbers.value[c] = file.real(line.value(first + c, (first + c) * width, width), true);
  const FieldKind fixed = width == 10   ? FieldKind::Dyna10
                          : width == 16 ? FieldKind::Dyna16
                                        : FieldKind::Dyna20;
  const FieldKind free = width == 10   ? FieldKind::DynaFree10
                         : width == 16 ? FieldKind::DynaFree16
                                       : FieldKind::DynaFree20;
  line.fields(file, first, first * width, fixed, free, numbers.fields);
  numbers.kind = kind;
  return numbers;
}

RotatingCard::Numbers DynaDirections::three(int first, const DynaKeyword& keyword,
                                            Kind kind) const {
  return three_of(file_, lines_.line(), first, keyword.widths.card, kind);
}

bool DynaDirections::read(const DynaKeyword& keyword) {
  std::string name = keyword.name;
  const bool titled = name.ends_with("_TITLE");
  if (titled) name.resize(name.size() - 6);
  const bool system = name == "DEFINE_COORDINATE_SYSTEM";
  const bool axes = name == "DEFINE_COORDINATE_VECTOR", vector = name == "DEFINE_VECTOR",
             spring = name == "DEFINE_SD_ORIENTATION";
  if (!system && !axes && !vector && !spring) return material(keyword);
  while (lines_.next_record()) {
    if (titled && !lines_.next_record()) break;
    RotatingCard card;
    const DeckLine line(lines_.line());
    const int w = keyword.widths.card;
    card.name = "*" + name + " " + std::string(line.value(0, 0, w));
    if (spring) {
      const std::string_view by = line.value(1, w, w);
      if (by.empty() || by == "0" || by == "1") card.numbers = {three(2, keyword, Kind::Vector)};
    } else {
      card.numbers = {three(1, keyword, axes ? Kind::Vector : Kind::Arm),
                      three(4, keyword, axes ? Kind::Vector : Kind::Arm)};
      if (system) {
        if (!lines_.next_card()) break;
        card.numbers.push_back(three(0, keyword, Kind::Arm));
      }
      // The first point of a system or vector is the centre of its rotation.
      if (!axes)
        for (auto& numbers : card.numbers) numbers.origin = card.numbers[0].value;
    }
    if (!card.numbers.empty()) deck_.add_rotating(std::move(card));
  }
  return true;
}

/// Position of AOPT in materials with axes: card and field. With AOPT 2 and 3, the axes are global
/// vectors.
bool DynaDirections::material(const DynaKeyword& keyword) {
  static const std::map<std::string, std::array<int, 2>> places{
      {"MAT_ORTHOTROPIC_ELASTIC", {2, 3}},
      {"MAT_002", {2, 3}},
      {"MAT_COMPOSITE_DAMAGE", {1, 4}},
      {"MAT_022", {1, 4}},
      {"MAT_ENHANCED_COMPOSITE_DAMAGE", {1, 4}},
      {"MAT_054", {1, 4}},
      {"MAT_055", {1, 4}},
      {"MAT_3-PARAMETER_BARLAT", {2, 0}},
      {"MAT_036", {2, 0}},
      {"MAT_LAMINATED_COMPOSITE_FABRIC", {2, 0}},
      {"MAT_058", {2, 0}}};
  std::string name = keyword.name;
  const bool titled = name.ends_with("_TITLE");
  if (titled) name.resize(name.size() - 6);
  const auto place = places.find(name);
  if (place == places.end()) return false;
  if (titled && !lines_.next_record()) return true;
  std::string number;
  for (int card = 0; card <= place->second[0]; ++card) {
    if (!lines_.next_card()) return true;
    if (card == 0) number = DeckLine(lines_.line()).value(0, 0, keyword.widths.card);
  }
  const int w = keyword.widths.card, field = place->second[1];
  double option = 0;
  if (parse_real(DeckLine(lines_.line()).value(field, field * w, w), option) &&
      (option == 2 || option == 3))
    deck_.add_global_directions("*" + name + " " + number + " with AOPT " +
                                std::to_string(static_cast<int>(option)));
  return true;
}

// Non-shell elements and connections of LS-DYNA decks.

/// Reads *ELEMENT_SOLID, _BEAM, _DISCRETE, _SEATBELT, _MASS, _INERTIA, _PLOTEL,
/// *CONSTRAINED_NODAL_RIGID_BODY, _SPOTWELD, _RIVET, _INTERPOLATION. Other elements, and elements
/// with unknown options, are only counted, by block.
class DynaElements {
 public:
  DynaElements(MeshSourceText& file, DynaLines& lines, DeckMeshBuilder& deck)
      : file_(file), lines_(lines), deck_(deck) {}

  /// Returns false for any other keyword.
  bool read(const DynaKeyword& keyword);
  /// Node numbers of the beams, springs and solids of each part.
  const std::map<std::string, std::vector<long>>& parts() const { return parts_; }
  /// Adds bodies defined by node sets to a finished mesh. `set` returns the nodes of a set.
  void finish(TextMeshContent& mesh,
              const std::function<std::optional<std::vector<int>>(long set)>& set) const;

 private:
  struct Body {
    std::string name;
    long label, set, node;
  };
  bool plain(const DynaKeyword& keyword, const std::string& name, NonShellElement::Kind kind,
             int nodes, const std::set<std::string>& one_more_card);
  bool solids(const DynaKeyword& keyword);
  void read_axes(const DeckElement& element);
  bool bodies(const DynaKeyword& keyword);
  bool pairs(const DynaKeyword& keyword, const std::string& name);
  bool interpolation(const DynaKeyword& keyword);
  void skip(int cards);

  MeshSourceText& file_;
  DynaLines& lines_;
  DeckMeshBuilder& deck_;
  void add_to_part(std::string_view part, const std::vector<long>& nodes, size_t count);
  std::vector<Body> bodies_;
  std::map<std::string, std::vector<long>> parts_;
};

namespace {

using Kind = NonShellElement::Kind;

/// The fields of one card of uniform width.
struct Card {
  Card(std::string_view line, int width) : line(line), width(width) {}
  std::string_view at(int i) const { return line.value(i, i * width, width); }
  long number(const MeshSourceText& file, int i, const char* expected = "a node number") const {
    return at(i).empty() ? 0 : file.integer(at(i), expected);
  }
  DeckLine line;
  int width;
};

/// Skips repeated nodes: solids with fewer than 8 corners repeat some.
void add_once(std::vector<long>& nodes, long node) {
  if (node != 0 && std::find(nodes.begin(), nodes.end(), node) == nodes.end())
    nodes.push_back(node);
}

bool only(const std::set<std::string>& options, const std::set<std::string>& known) {
  return std::includes(known.begin(), known.end(), options.begin(), options.end());
}

}  // namespace

bool DynaElements::read(const DynaKeyword& keyword) {
  const std::set<std::string> beam_cards{"ELBOW", "OFFSET",  "ORIENTATION", "PID",    "SCALAR",
                                         "SCALR", "SECTION", "THICKNESS",   "WARPAGE"};
  if (plain(keyword, "ELEMENT_BEAM", Kind::Beam, 3, beam_cards) ||
      plain(keyword, "ELEMENT_DISCRETE", Kind::Bush, 2, {"LCO"}) ||
      plain(keyword, "ELEMENT_SEATBELT", Kind::Beam, 2, {}) || solids(keyword) || bodies(keyword) ||
      pairs(keyword, "ELEMENT_PLOTEL") || pairs(keyword, "ELEMENT_MASS") ||
      pairs(keyword, "ELEMENT_INERTIA") || pairs(keyword, "CONSTRAINED_SPOTWELD") ||
      pairs(keyword, "CONSTRAINED_RIVET") || interpolation(keyword))
    return true;
  if (!keyword.name.starts_with("ELEMENT_") &&
      !keyword.name.starts_with("CONSTRAINED_NODAL_RIGID_BODY"))
    return false;
  deck_.count_other_element("*" + keyword.name, 0);
  return true;
}

void DynaElements::add_to_part(std::string_view part, const std::vector<long>& nodes,
                               size_t count) {
  auto& all = parts_[std::string(part)];
  for (size_t i = 0; i < std::min(count, nodes.size()); ++i)
    if (nodes[i] > 0) all.push_back(nodes[i]);
}

void DynaElements::skip(int cards) {
  while (cards-- > 0 && lines_.next_card()) {
  }
}

/// Elements whose card holds number, part and nodes; each option adds one card.
bool DynaElements::plain(const DynaKeyword& keyword, const std::string& name, Kind kind, int nodes,
                         const std::set<std::string>& one_more_card) {
  const auto options = options_after(keyword.name, name);
  if (!options || !only(*options, one_more_card)) return false;
  while (lines_.next_record()) {
    const Card card(lines_.line(), keyword.widths.integer);
    DeckElement element{kind, "*" + name, 0, card.at(0), {}, {}};
    element.label = file_.integer(card.at(0), "an element number");
    for (int i = 0; i < nodes; ++i) element.nodes.push_back(card.number(file_, 2 + i));
    add_to_part(card.at(1), element.nodes, 2);  // without the orientation node
    if (options->contains("ORIENTATION"))
      deck_.add_global_directions("*" + name + "_ORIENTATION", element.nodes);
    deck_.add_element(std::move(element));
    skip(static_cast<int>(options->size()));
  }
  return true;
}

/// Solids: the nodes follow the part on the same card, or are on separate cards.
bool DynaElements::solids(const DynaKeyword& keyword) {
  const auto options = options_after(keyword.name, "ELEMENT_SOLID");
  if (!options || !only(*options, {"H20", "ORTHO"})) return false;
  const bool second_order = options->contains("H20");
  while (lines_.next_record()) {
    const Card card(lines_.line(), keyword.widths.integer);
    DeckElement element{Kind::Solid, "*ELEMENT_SOLID", 0, card.at(0), {}, {}};
    element.label = file_.integer(card.at(0), "an element number");
    if (!card.at(2).empty()) {
      for (int i = 2; i < 10; ++i) add_once(element.nodes, card.number(file_, i));
    } else {
      for (int more = second_order ? 2 : 1; more > 0; --more) {
        if (!lines_.next_card()) file_.fail(element.where, "found a solid without its nodes");
        const Card nodes(lines_.line(), keyword.widths.integer);
        for (int i = 0; i < 10; ++i) add_once(element.nodes, nodes.number(file_, i));
      }
    }
    add_to_part(card.at(1), element.nodes, element.nodes.size());
    if (options->contains("ORTHO")) read_axes(element);
    deck_.add_element(std::move(element));
  }
  return true;
}

/// The material axes of a solid: the vectors a and d on two cards.
void DynaElements::read_axes(const DeckElement& element) {
  constexpr int kAxisWidth = 16;
  RotatingCard card{"*ELEMENT_SOLID_ORTHO " + std::to_string(element.label), {}, {}};
  for (int k = 0; k < 2 && lines_.next_card(); ++k)
    card.numbers.push_back(
        three_of(file_, lines_.line(), 0, kAxisWidth, RotatingCard::Numbers::Kind::Vector));
  // A single number is an angle.
  if (!card.numbers.empty() && card.numbers[0].value.tail<2>().isZero(0) &&
      std::abs(card.numbers[0].value[0]) > 1)
    return;
  deck_.add_rotating(std::move(card), element.nodes);
}

bool DynaElements::bodies(const DynaKeyword& keyword) {
  const auto options = options_after(keyword.name, "CONSTRAINED_NODAL_RIGID_BODY");
  if (!options || !only(*options, {"INERTIA", "OVERRIDE", "SPC", "TITLE"})) return false;
  const bool titled = options->contains("TITLE");
  while (lines_.next_record()) {
    if (titled && !lines_.next_record()) break;
    const Card card(lines_.line(), keyword.widths.card);
    Body body{"*CONSTRAINED_NODAL_RIGID_BODY", card.number(file_, 0, "a part number"),
              card.number(file_, 2, "the number of a set"), card.number(file_, 3)};
    if (body.set == 0) body.set = body.label;
    deck_.count_other_element(body.name);
    bodies_.push_back(body);
    // Options add further cards.
    if (options->size() > (titled ? 1u : 0u)) break;
  }
  return true;
}

/// Elements with a special card layout, and connections of two nodes.
bool DynaElements::pairs(const DynaKeyword& keyword, const std::string& name) {
  auto options = options_after(keyword.name, name);
  const bool joint = name.starts_with("CONSTRAINED_");
  if (!options || !only(*options, joint ? std::set<std::string>{"FILTERED", "FORCE", "ID"}
                                  : name == "ELEMENT_INERTIA" ? std::set<std::string>{"OFFSET"}
                                                              : std::set<std::string>{}))
    return false;
  while (lines_.next_record()) {
    DeckElement element{Kind::Rigid, "*" + name, 0, {}, {}, {}};
    if (joint && options->contains("ID")) {
      element.label = Card(lines_.line(), keyword.widths.card).number(file_, 0, "a number");
      if (!lines_.next_record()) break;
    }
    const Card card(lines_.line(), joint ? keyword.widths.card : keyword.widths.integer);
    element.where = card.at(0);
    if (joint) {
      element.nodes = {card.number(file_, 0), card.number(file_, 1)};
    } else {
      element.kind = name == "ELEMENT_PLOTEL" ? Kind::Other : Kind::Mass;
      element.label = file_.integer(card.at(0), "an element number");
      element.nodes = {card.number(file_, 1)};
      if (name == "ELEMENT_PLOTEL") element.nodes.push_back(card.number(file_, 2));
    }
    deck_.add_element(std::move(element));
    if (name == "ELEMENT_INERTIA") skip(1 + static_cast<int>(options->size()));
    if (joint && options->contains("FILTERED")) skip(1);
  }
  return true;
}

bool DynaElements::interpolation(const DynaKeyword& keyword) {
  if (keyword.name != "CONSTRAINED_INTERPOLATION") return false;
  if (!lines_.next_record()) return true;
  const Card first(lines_.line(), keyword.widths.card);
  if (first.number(file_, 4, "0 or 1") != 0) {  // nodes given by sets
    deck_.count_other_element("*" + keyword.name);
    return true;
  }
  DeckElement element{Kind::Interpolation, "*" + keyword.name, 0, first.at(0), {}, {}};
  element.label = first.number(file_, 0, "a number");
  element.nodes.push_back(first.number(file_, 1));
  while (lines_.next_record()) {
    const Card card(lines_.line(), keyword.widths.card);
    const double weight = file_.real(card.at(2), true);
    element.nodes.push_back(card.number(file_, 0));
    element.weights.push_back(weight == 0 ? 1 : weight);
  }
  deck_.add_element(std::move(element));
  return true;
}

void DynaElements::finish(
    TextMeshContent& mesh,
    const std::function<std::optional<std::vector<int>>(long set)>& set) const {
  for (const Body& body : bodies_) {
    NonShellElement element{Kind::Rigid, body.name, body.label, {}, {}};
    const auto first = mesh.node_labels.find(body.node);
    if (first) element.nodes.push_back(*first);
    if (const auto nodes = set(body.set))
      for (const int node : *nodes)
        if (!first || node != *first) element.nodes.push_back(node);
    if (!element.nodes.empty()) mesh.other_elements.push_back(std::move(element));
  }
}

// Ties, spot welds and joints of LS-DYNA decks.

/// Reads *CONTACT_…TIED…, *CONTACT_…TIEBREAK…, *CONTACT_SPOTWELD…, *CONSTRAINED_EXTRA_NODES_…,
/// *CONSTRAINED_JOINT_…, *CONSTRAINED_GENERALIZED_WELD_…, *CONSTRAINED_TIED_NODES_FAILURE, *SET_PART,
/// *SET_SEGMENT, and counts rigid walls.
class DynaTies {
 public:
  DynaTies(MeshSourceText& file, DynaLines& lines, DeckMeshBuilder& deck)
      : file_(file), lines_(lines), deck_(deck) {}

  /// Returns false for any other keyword.
  bool read(const DynaKeyword& keyword, TextMeshContent& mesh);
  /// Finds the nodes of a node set, or the faces of a shell set.
  using Sets = std::function<std::optional<std::vector<int>>(long set, bool nodes)>;
  /// Adds the ties to a finished mesh. `parts`: node numbers of the beams and solids of each part.
  void finish(TextMeshContent& mesh, const Sets& sets,
              const std::map<std::string, std::vector<long>>& parts) const;

 private:
  /// A set or part of a contact, by its type.
  struct Side {
    long id = 0, type = 0;
  };
  struct Contact {
    std::string name;
    Side slave, master;
  };
  struct Found {
    std::vector<int> nodes, faces;
  };
  struct Finder;
  bool contact(const DynaKeyword& keyword);
  bool extra_nodes(const DynaKeyword& keyword);
  bool joint(const DynaKeyword& keyword);
  bool bound_nodes(const DynaKeyword& keyword);
  bool list(const DynaKeyword& keyword);

  MeshSourceText& file_;
  DynaLines& lines_;
  DeckMeshBuilder& deck_;
  std::vector<Contact> contacts_;
  struct Extra {
    std::string name;
    long part, node, set;
  };
  std::vector<Extra> extras_;
  std::vector<std::pair<std::string, long>> bound_;         // rigid bodies: name and node set
  std::map<long, std::vector<long>> part_sets_, segments_;  // parts; nodes
};

bool DynaTies::read(const DynaKeyword& keyword, TextMeshContent& mesh) {
  if (keyword.name.starts_with("RIGIDWALL_")) {
    ++mesh.global_positions["*" + keyword.name];
    return true;
  }
  return contact(keyword) || extra_nodes(keyword) || joint(keyword) || bound_nodes(keyword) ||
         list(keyword);
}

bool DynaTies::contact(const DynaKeyword& keyword) {
  const std::string& name = keyword.name;
  const auto has = [&](const char* word) { return name.find(word) != name.npos; };
  if (!name.starts_with("CONTACT_") || !(has("TIED") || has("TIEBREAK") || has("SPOTWELD")))
    return false;
  const int w = keyword.widths.card;
  Contact contact{"*" + name, {}, {}};
  if (name.ends_with("_ID") || name.ends_with("_TITLE")) {
    if (!lines_.next_card()) return true;
    contact.name += " " + std::string(Card(lines_.line(), w).at(0));
  }
  if (!lines_.next_card()) return true;
  if (has("_MPP")) {
    if (!lines_.next_card()) return true;
    if (trimmed(lines_.line()).starts_with('&') && !lines_.next_card()) return true;
  }
  const Card card(lines_.line(), w);
  contact.slave = {card.number(file_, 0, "a set"), card.number(file_, 2, "a type")};
  contact.master = {card.number(file_, 1, "a set"), card.number(file_, 3, "a type")};
  contacts_.push_back(contact);
  return true;
}

bool DynaTies::extra_nodes(const DynaKeyword& keyword) {
  const std::string& name = keyword.name;
  if (!name.starts_with("CONSTRAINED_EXTRA_NODES_")) return false;
  const bool set = name.ends_with("_SET");
  while (lines_.next_record()) {
    const Card card(lines_.line(), keyword.widths.card);
    const long part = card.number(file_, 0, "a part"), node = card.number(file_, 1);
    extras_.push_back(
        {"*" + name + " of part " + std::to_string(part), part, set ? 0 : node, set ? node : 0});
  }
  return true;
}

/// The nodes of a joint come in pairs at the same place.
bool DynaTies::joint(const DynaKeyword& keyword) {
  const std::string& name = keyword.name;
  if (!name.starts_with("CONSTRAINED_JOINT_") || name.starts_with("CONSTRAINED_JOINT_STIFFNESS"))
    return false;
  const bool named = name.find("_ID") != name.npos;
  const bool more = name.find("_FAILURE") != name.npos || name.find("_LOCAL") != name.npos;
  while (lines_.next_record()) {
    DeckElement element{NonShellElement::Kind::Bush, "*" + name, 0, lines_.line(), {}, {}};
    if (named) {
      element.label = Card(lines_.line(), keyword.widths.card).number(file_, 0, "a number");
      if (!lines_.next_record()) break;
    }
    const Card card(lines_.line(), keyword.widths.card);
    for (int i = 0; i < 6; ++i)
      if (const long node = card.number(file_, i); node > 0) element.nodes.push_back(node);
    deck_.add_element(std::move(element));
    if (more) break;
  }
  return true;
}

bool DynaTies::bound_nodes(const DynaKeyword& keyword) {
  const std::string& name = keyword.name;
  const bool weld = name.starts_with("CONSTRAINED_GENERALIZED_WELD_");
  if (!weld && name != "CONSTRAINED_TIED_NODES_FAILURE") return false;
  if (!lines_.next_record()) return true;
  if (weld && name.ends_with("_ID") && !lines_.next_record()) return true;
  bound_.push_back(
      {"*" + name, Card(lines_.line(), keyword.widths.card).number(file_, 0, "a set")});
  deck_.count_other_element("*" + name);
  return true;
}

bool DynaTies::list(const DynaKeyword& keyword) {
  const bool segments = keyword.name.starts_with("SET_SEGMENT");
  if (!segments && !keyword.name.starts_with("SET_PART")) return false;
  if (keyword.name.ends_with("GENERAL")) return false;
  if (keyword.name.ends_with("_TITLE") && !lines_.next_card()) return true;
  if (!lines_.next_record()) return true;
  const int w = keyword.widths.card;
  auto& members = (segments ? segments_ : part_sets_)[Card(lines_.line(), w).number(file_, 0)];
  const bool ranges = keyword.name.find("GENERATE") != std::string::npos;
  while (lines_.next_record()) {
    const Card card(lines_.line(), w);
    for (int i = 0; i < (segments ? 4 : 8); ++i) {
      long value = card.number(file_, i, "a number");
      if (value <= 0) continue;
      if (ranges && i % 2 == 1)
        for (long k = members.back() + 1; k < value && k < members.back() + 100000;)
          members.push_back(k++);
      members.push_back(value);
    }
  }
  return true;
}

/// Resolves the sides of contacts to nodes and faces.
struct DynaTies::Finder {
  const DynaTies& ties;
  const TextMeshContent& mesh;
  const Sets& sets;
  const std::map<std::string, std::vector<long>>& parts;

  void add_part(long part, Found& found) const {
    const std::string name = std::to_string(part);
    const std::vector<int> faces = ties.deck_.faces_of_property(name);
    found.faces.insert(found.faces.end(), faces.begin(), faces.end());
    if (const auto others = parts.find(name); others != parts.end())
      for (const long label : others->second)
        if (const auto node = mesh.node_labels.find(label)) found.nodes.push_back(*node);
  }

  Found find(const Side& side) const {
    Found found;
    if (side.type == 0) {
      if (const auto set = ties.segments_.find(side.id); set != ties.segments_.end())
        for (const long label : set->second)
          if (const auto node = mesh.node_labels.find(label)) found.nodes.push_back(*node);
      if (!found.nodes.empty()) found.faces = ties.deck_.faces_among(found.nodes);
    } else if (side.type == 1) {
      found.faces = sets(side.id, false).value_or(std::vector<int>());
    } else if (side.type == 2) {
      if (const auto set = ties.part_sets_.find(side.id); set != ties.part_sets_.end())
        for (const long part : set->second) add_part(part, found);
    } else if (side.type == 3) {
      add_part(side.id, found);
    } else if (side.type == 4) {
      found.nodes = sets(side.id, true).value_or(std::vector<int>());
    }
    const std::vector<int> more = ties.deck_.nodes_of_faces(found.faces);
    found.nodes.insert(found.nodes.end(), more.begin(), more.end());
    return found;
  }
};

void DynaTies::finish(TextMeshContent& mesh, const Sets& sets,
                      const std::map<std::string, std::vector<long>>& parts) const {
  const Finder finder{*this, mesh, sets, parts};
  for (const Contact& contact : contacts_) {
    Found slave = finder.find(contact.slave), master = finder.find(contact.master);
    if (slave.nodes.empty())
      mesh.warnings.push_back(contact.name +
                              " is not followed: the nodes of its first side are "
                              "not known");
    else if (master.faces.empty() && !slave.faces.empty() && !master.nodes.empty())
      deck_.add_tie(contact.name, std::move(master.nodes), std::move(slave.faces));
    else
      deck_.add_tie(contact.name, std::move(slave.nodes), std::move(master.faces));
  }
  for (const Extra& extra : extras_) {
    Found part;
    finder.add_part(extra.part, part);
    std::vector<int> nodes;
    if (extra.set > 0) nodes = sets(extra.set, true).value_or(std::vector<int>());
    if (const auto node = mesh.node_labels.find(extra.node)) nodes.push_back(*node);
    const double anywhere = std::numeric_limits<double>::max();
    if (!part.faces.empty()) deck_.add_tie(extra.name, std::move(nodes), part.faces, anywhere);
  }
  for (const auto& [name, set] : bound_)
    if (auto nodes = sets(set, true); nodes && nodes->size() > 1)
      mesh.other_elements.push_back({Kind::Rigid, name, set, std::move(*nodes), {}});
}

namespace {

class DynaReader {
 public:
  explicit DynaReader(TextMeshContent& mesh)
      : mesh_(mesh),
        file_(mesh.file),
        lines_(mesh.file),
        deck_(mesh),
        directions_(mesh.file, lines_, deck_),
        elements_(mesh.file, lines_, deck_),
        ties_(mesh.file, lines_, deck_) {}

  void read() {
    while (const auto keyword = lines_.next_keyword()) {
      handle(*keyword);
      while (lines_.next_card()) {
      }
    }
    finish();
    if (!lines_.ended())
      mesh_.warnings.push_back("the deck has no *END: the file may be truncated");
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
    if (!directions_.read(keyword) && !ties_.read(keyword, mesh_)) elements_.read(keyword);
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
      // The fourth side is degenerate; its mid-side node, if any, coincides with the third corner.
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
      // Options add further cards.
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
    ties_.finish(
        mesh_,
        [&](long number, bool of_nodes) -> std::optional<std::vector<int>> {
          for (const DynaSet& set : sets_)
            if (set.of_nodes == of_nodes && set.name == std::to_string(number))
              return of_nodes ? deck_.nodes_of(set.ranges) : deck_.faces_of(set.ranges);
          return {};
        },
        elements_.parts());
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
  DynaDirections directions_;
  DynaElements elements_;
  DynaTies ties_;
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
