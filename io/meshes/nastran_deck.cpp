// Nastran bulk data: GRIDs and shells; everything else stays text.
#include <optional>
#include <set>

#include "batten/core/errors.h"
#include "batten/io/meshes/deck_mesh.h"

namespace batten {
namespace {

/// Names of other elements, which are counted for the warnings.
const std::set<std::string, std::less<>> kOtherElements{
    "CBAR",   "CBARAO", "CBEAM",   "CBEAM3", "CBEND",  "CBUSH",  "CBUSH1D", "CBUSH2D", "CCONEAX",
    "CDAMP1", "CDAMP2", "CDAMP3",  "CDAMP4", "CDAMP5", "CELAS1", "CELAS2",  "CELAS3",  "CELAS4",
    "CFAST",  "CGAP",   "CHBDYG",  "CHBDYP", "CHEXA",  "CMASS1", "CMASS2",  "CMASS3",  "CMASS4",
    "CONM1",  "CONM2",  "CONROD",  "CPENTA", "CPYRAM", "CQUAD",  "CQUADX",  "CQUADX4", "CQUADX8",
    "CROD",   "CSEAM",  "CSHEAR",  "CTETRA", "CTRAX3", "CTRAX6", "CTRIAX",  "CTRIAX6", "CTUBE",
    "CVISC",  "CWELD",  "PLOTEL",  "RBAR",   "RBAR1",  "RBE1",   "RBE2",    "RBE2GS",  "RBE3",
    "RJOINT", "RROD",   "RSPLINE", "RSSCON", "RTRPLT", "RTRPLT1"};

/// One line of a card: its name, whether its fields are large, the values 1 to 8 (large: 1 to 4).
struct CardLine {
  explicit CardLine(std::string_view line) : data(line.substr(0, line.find('$'))), cells(data) {
    std::string_view first = cells.value(0, 0, 8);
    // A name may run on past its columns: INCLUDE 'file', BEGIN BULK.
    large = first.ends_with('*') || first.starts_with('*');
    if (first.ends_with('*') && first.size() > 1) first.remove_suffix(1);
    name = first;
  }
  bool continues() const { return name.empty() || name[0] == '+' || name[0] == '*'; }
  int count() const { return large ? 4 : 8; }
  int column(int field) const { return large ? 16 * field - 8 : 8 * field; }
  std::string_view value(int field) const {
    return cells.value(field, column(field), large ? 16 : 8);
  }
  void fields(const MeshText& file, int first, std::span<Field> result) const {
    cells.fields(file, first, column(first), large ? FieldKind::Nastran16 : FieldKind::Nastran8,
                 FieldKind::NastranFree, result);
  }

  std::string_view data;
  DeckLine cells;
  std::string_view name;
  bool large = false;
};

class NastranReader {
 public:
  explicit NastranReader(TextMesh& mesh) : mesh_(mesh), file_(mesh.file), deck_(mesh) {}

  void read() {
    go_to_bulk();
    std::string_view line;
    bool ended = false;
    while (file_.next(line)) {
      if (line.empty() || line[0] == '$') continue;
      const CardLine card(line);
      if (card.continues()) continue;
      const std::string name = upper(card.name);
      if (ended = name == "ENDDATA"; ended) break;
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
        sets_.push_back(values_of(card));
      } else if (name == "GRDSET") {
        if (!card.value(2).empty()) default_system_ = file_.integer(card.value(2), "a system");
      } else {
        other(name, line);
      }
    }
    finish();
    if (!ended) mesh_.warnings.push_back("the deck has no ENDDATA: it may be cut short");
  }

 private:
  /// Executive and case control end with BEGIN BULK, if they are there at all.
  void go_to_bulk() {
    const size_t start = file_.position();
    std::string_view line;
    while (file_.next(line)) {
      std::string_view rest = line;
      const std::string first = upper(next_word(rest)), second = upper(next_word(rest));
      if (first == "INCLUDE") refuse_include(line);
      if (first == "BEGIN" && second.starts_with("BULK")) return;
    }
    file_.go_to(start);
  }

  void other(const std::string& name, std::string_view line) {
    if (name.starts_with("INCLUDE")) refuse_include(line);
    if (name.starts_with("BEGIN"))
      file_.fail(line, "found a second " + in_quotes(line) + ", expected one model");
    if (name.starts_with("="))
      file_.fail(line, "found a repeated card " + in_quotes(line) + ", expected it written out");
    if (kOtherElements.contains(name)) deck_.add_other(name);
  }

  [[noreturn]] void refuse_include(std::string_view line) const {
    file_.fail(line, "found " + in_quotes(line) + ", expected everything in one file");
  }

  /// The line that continues a card, if there is one; comments may stand between.
  bool next_line(std::optional<CardLine>& card) {
    const size_t start = file_.position();
    std::string_view line;
    while (file_.next(line)) {
      if (line.empty() || line[0] == '$' || trimmed(line).empty()) continue;
      card.emplace(line);
      if (card->continues()) return true;
      break;
    }
    file_.go_to(start);
    return false;
  }

  std::vector<std::string_view> values_of(const CardLine& card) {
    std::vector<std::string_view> values;
    std::optional<CardLine> line(card);
    do {
      for (int i = 1; i <= line->count(); ++i) values.push_back(line->value(i));
    } while (next_line(line));
    return values;
  }

  void grid(const CardLine& card) {
    std::array<Field, 3> fields;
    std::array<std::string_view, 3> values{card.value(3), card.value(4)};
    if (card.large) {
      std::optional<CardLine> second;
      if (!next_line(second))
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
    systems_.push_back(system.empty()                                      ? System::Default
                       : file_.integer(system, "a coordinate system") == 0 ? System::Basic
                                                                           : System::Local);
  }

  void shell(const CardLine& card, size_t corners, size_t middle) {
    std::array<std::string_view, 10> values{};
    size_t count = 0;
    const size_t needed = 2 + corners + middle;
    std::optional<CardLine> line(card);
    do {
      for (int i = 1; i <= line->count() && count < needed; ++i) values[count++] = line->value(i);
    } while (count < needed && next_line(line));
    const long label = file_.integer(values[0], "an element number");
    std::array<long, 8> nodes{};
    for (size_t i = 0; i < corners + middle; ++i) {
      const std::string_view value = values[2 + i];
      if (i < corners && value.empty())
        file_.fail(card.name, "found " + counted(static_cast<long>(i), "corner") + " of element " +
                                  std::to_string(label) + ", expected " + std::to_string(corners));
      if (!value.empty()) nodes[i] = file_.integer(value, "a node number");
    }
    // A property that is not given has the element's number.
    deck_.add_shell(label, values[0], std::string(values[1].empty() ? values[0] : values[1]),
                    {nodes.data(), corners}, {nodes.data() + corners, middle});
  }

  void finish() {
    deck_.finish();
    local_systems();
    for (const auto& values : sets_) set(values);
    deck_.warn_of_others("elements");
  }

  void local_systems() {
    std::vector<char> used(systems_.size());
    for (int f = 0; f < mesh_.shells.face_count(); ++f)
      for (const int node : mesh_.shells.face(f)) used[node] = 1;
    long local = 0;
    for (size_t i = 0; i < systems_.size(); ++i) {
      if (systems_[i] == System::Basic) continue;
      if (systems_[i] == System::Default && default_system_ == 0) continue;
      ++local;
      const int node = static_cast<int>(i);
      if (used[i])
        file_.fail(deck_.node_position(node),
                   "found node " + std::to_string(mesh_.node_labels.of(node)) +
                       " in a local coordinate system, expected the basic system (CP 0 or blank)");
    }
    if (local > 0)
      mesh_.warnings.push_back("in local coordinate systems, used by no shell: " +
                               counted(local, "node"));
  }

  void set(const std::vector<std::string_view>& values) {
    std::vector<LabelRange> ranges;
    bool thru = false;
    for (size_t i = 1; i < values.size(); ++i) {
      long label = 0;
      if (values[i].empty()) continue;
      if (upper(values[i]) == "THRU" && !ranges.empty()) {
        thru = true;
      } else if (!parse_integer(values[i], label)) {
        mesh_.warnings.push_back("SET1 " + std::string(values[0]) + " is not read: it has " +
                                 in_quotes(values[i]));
        return;
      } else if (thru) {
        ranges.back().last = label;
        thru = false;
      } else {
        ranges.push_back({label, label});
      }
    }
    MeshSet set{std::string(values[0]), {}, deck_.nodes_of(ranges), {}};
    if (!set.nodes.empty()) mesh_.sets.push_back(std::move(set));
  }

  enum class System : char { Basic, Default, Local };
  TextMesh& mesh_;
  MeshText& file_;
  DeckMesh deck_;
  std::vector<System> systems_;
  std::vector<std::vector<std::string_view>> sets_;
  long default_system_ = 0;
};

}  // namespace

std::unique_ptr<MeshContent> read_nastran_deck(const std::filesystem::path& path) {
  auto mesh = std::make_unique<TextMesh>(MeshText(path));
  mesh->format = "Nastran bulk data";
  mesh->extensions = {".bdf", ".nas", ".dat"};
  NastranReader(*mesh).read();
  return mesh;
}

}  // namespace batten
