#include "batten/io/meshes/nastran_elements.h"

#include <map>
#include <set>

#include "batten/core/errors.h"

namespace batten {
namespace {

using Kind = NonShellElement::Kind;

/// Where the nodes of a card stand among its values, which count from its number: 0. `nodes` are in
/// the order in which an element has them; at `direction` there may be a node, or the first of three
/// components of a vector.
struct CardLayout {
  Kind kind = Kind::Other;
  std::vector<int> nodes;
  int direction = -1;
};

std::vector<int> numbered_fields(int first, int count) {
  std::vector<int> places;
  for (int i = 0; i < count; ++i) places.push_back(first + i);
  return places;
}

const std::map<std::string, CardLayout>& card_layouts() {
  static const std::map<std::string, CardLayout> all{
      {"CHEXA", {Kind::Solid, numbered_fields(2, 20)}},
      {"CPENTA", {Kind::Solid, numbered_fields(2, 15)}},
      {"CTETRA", {Kind::Solid, numbered_fields(2, 10)}},
      {"CPYRAM", {Kind::Solid, numbered_fields(2, 13)}},
      {"CPYRA", {Kind::Solid, numbered_fields(2, 13)}},
      {"CBAR", {Kind::Beam, {2, 3}, 4}},
      {"CBEAM", {Kind::Beam, {2, 3}, 4}},
      {"CBEND", {Kind::Beam, {2, 3}, 4}},
      {"CBEAM3", {Kind::Beam, {2, 3, 4}, 5}},
      {"CROD", {Kind::Beam, {2, 3}}},
      {"CTUBE", {Kind::Beam, {2, 3}}},
      {"CONROD", {Kind::Beam, {1, 2}}},
      {"CVISC", {Kind::Bush, {2, 3}}},
      {"CBUSH", {Kind::Bush, {2, 3}, 4}},
      {"CBUSH1D", {Kind::Bush, {2, 3}}},
      {"CBUSH2D", {Kind::Bush, {2, 3}}},
      {"CGAP", {Kind::Bush, {2, 3}, 4}},
      {"CELAS1", {Kind::Bush, {2, 4}}},
      {"CELAS2", {Kind::Bush, {2, 4}}},
      {"CDAMP1", {Kind::Bush, {2, 4}}},
      {"CDAMP2", {Kind::Bush, {2, 4}}},
      {"CDAMP5", {Kind::Bush, {2, 3}}},
      {"CFAST", {Kind::Bush, {6, 7, 5}}},
      {"CWELD", {Kind::Bush, {4, 5, 2}}},
      {"CMASS1", {Kind::Mass, {2, 4}}},
      {"CMASS2", {Kind::Mass, {2, 4}}},
      {"CONM1", {Kind::Mass, {1}}},
      {"CONM2", {Kind::Mass, {1}}},
      {"CSHEAR", {Kind::Other, numbered_fields(2, 4)}},
      {"PLOTEL", {Kind::Other, {1, 2}}},
      {"RBAR1", {Kind::Rigid, {1, 2}}},
      {"RJOINT", {Kind::Rigid, {1, 2}}},
      {"RTRPLT", {Kind::Rigid, {1, 2, 3}}},
      {"RTRPLT1", {Kind::Rigid, {1, 2, 3}}}};
  return all;
}

/// Elements whose nodes are not read: scalar points, boundaries, planes, couplings by elements.
bool counted_only(const std::string& name) {
  static const std::set<std::string, std::less<>> names{
      "CCONEAX", "CDAMP3", "CDAMP4", "CELAS3",  "CELAS4",  "CHBDYG",  "CHBDYP",
      "CMASS3",  "CMASS4", "CQUAD",  "CQUADX",  "CQUADX4", "CQUADX8", "CSEAM",
      "CTRAX3",  "CTRAX6", "CTRIAX", "CTRIAX6", "CBARAO",  "RBE2GS",  "RSSCON"};
  return names.contains(name);
}

/// The values of one card.
class Card {
 public:
  Card(const std::string& name, std::span<const std::string_view> values,
       const MeshSourceText& file)
      : values_(values), file_(file) {
    element_.name = name;
    element_.where = values.front();
    parse_integer(values.front(), element_.label);
  }

  DeckElement read() {
    const std::string& name = element_.name;
    if (const auto layout = card_layouts().find(name); layout != card_layouts().end()) {
      read(layout->second);
    } else if (name == "RBAR" || name == "RROD") {
      rigid_bar(name == "RROD");
    } else if (name == "RBE1") {
      rigid_body();
    } else if (name == "RBE2") {
      spider();
    } else if (name == "RBE3") {
      average();
    } else if (name == "RSPLINE") {
      for (int i = 2; i < count(); i += i == 2 ? 1 : 2) add(i);
    } else if (name == "MPC") {
      equation();
    }
    return std::move(element_);
  }

 private:
  int count() const { return static_cast<int>(values_.size()); }
  std::string_view at(int i) const { return i < count() ? values_[i] : std::string_view(); }
  bool is_integer(int i) const {
    long value = 0;
    return parse_integer(at(i), value);
  }
  static bool is_real(std::string_view text) {
    double value = 0;
    return text.find_first_of(".eEdD") != text.npos && parse_real(text, value);
  }
  void add(int i) {
    if (!at(i).empty()) element_.nodes.push_back(file_.integer(at(i), "a node number"));
  }

  void read(const CardLayout& layout) {
    element_.kind = layout.kind;
    for (const int i : layout.nodes) add(i);
    const int d = layout.direction;
    if (d > 0 && at(d + 1).empty() && at(d + 2).empty() && is_integer(d)) add(d);
  }

  /// RBAR says what is independent at A and B, RROD what is dependent.
  void rigid_bar(bool rod) {
    element_.kind = Kind::Rigid;
    const bool b_first = rod ? !at(3).empty() : at(3).empty() && !at(4).empty();
    add(b_first ? 2 : 1);
    add(b_first ? 1 : 2);
  }

  /// Pairs of a node and its components; those behind UM are dependent.
  void rigid_body() {
    element_.kind = Kind::Rigid;
    bool node = true;
    for (int i = 1; i < count(); ++i) {
      if (at(i).empty() || upper(at(i)) == "UM") continue;
      if (is_real(at(i))) break;  // thermal expansion
      if (node) add(i);
      node = !node;
    }
  }

  /// At THRU, adds the nodes between the one before it and the one behind it.
  bool thru(int i) {
    if (upper(at(i)) != "THRU" || element_.nodes.empty()) return false;
    const long last = file_.integer(at(i + 1), "a node number");
    constexpr long kMost = 10'000'000;
    if (last - element_.nodes.back() > kMost)
      file_.fail(at(i + 1), "found more nodes than an element has");
    for (long n = element_.nodes.back() + 1; n < last; ++n) element_.nodes.push_back(n);
    return true;
  }

  void spider() {
    element_.kind = Kind::Rigid;
    add(1);
    // A real number is the thermal expansion.
    for (int i = 3; i < count() && !is_real(at(i)); ++i)
      if (!thru(i)) add(i);
  }

  /// A weight with its components begins a group of nodes. Weights of turns alone hold nothing in
  /// its place.
  void average() {
    element_.kind = Kind::Interpolation;
    if (at(2).empty()) file_.fail(at(0), "found an RBE3 without its reference node, expected one");
    add(2);
    double weight = 0;
    bool moves = false;
    for (int i = 4; i < count(); ++i) {
      const std::string word = upper(at(i));
      if (word == "UM" || word == "ALPHA") break;
      if (is_real(word)) {
        weight = file_.real(at(i));
        moves = at(++i).find_first_of("123") != std::string_view::npos;
      } else if (moves && !thru(i)) {
        add(i);
      }
      element_.weights.resize(element_.nodes.size() - 1, weight);
    }
  }

  /// Two terms a line: node, component, factor.
  void equation() {
    for (int i = 0; i < count(); i += 8) {
      add(i + 1);
      add(i + 4);
    }
  }

  std::span<const std::string_view> values_;
  const MeshSourceText& file_;
  DeckElement element_;
};

}  // namespace

bool is_non_shell_element(const std::string& name) {
  return card_layouts().contains(name) || counted_only(name) || name == "RBAR" || name == "RROD" ||
         name == "RBE1" || name == "RBE2" || name == "RBE3" || name == "RSPLINE" || name == "MPC";
}

void add_non_shell_element(const std::string& name, std::span<const std::string_view> values,
                           const MeshSourceText& file, DeckMeshBuilder& deck) {
  if (counted_only(name)) return deck.count_other_element(name);
  deck.add_element(Card(name, values, file).read());
}

}  // namespace batten
