#include "batten/io/decks/calculix.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <ostream>
#include <set>

#include "batten/core/errors.h"
#include "batten/io/decks/calculix_elements.h"
#include "batten/io/decks/ccx_deck.h"
#include "batten/io/files/atomic_file.h"
#include "batten/skinning/facets/model_elements.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

using Regions = std::vector<const SkinnedRegion*>;

/// Names of sets, unlike each other and unlike NALL and ALL.
class SetNames {
 public:
  /// `kind`: what comes before a name that does not begin with a letter.
  std::string of(const std::string& text, const std::string& kind) {
    constexpr size_t longest = 80;
    std::string name;
    for (const char c : text) {
      const auto byte = static_cast<unsigned char>(c);
      name += byte < 128 && std::isalnum(byte) ? static_cast<char>(std::toupper(byte)) : '_';
    }
    if (name.empty() || !std::isalpha(static_cast<unsigned char>(name[0]))) name = kind + name;
    name = name.substr(0, longest);
    std::string unique = name;
    for (int i = 2; !taken_.insert(unique).second; ++i) {
      const std::string suffix = "_" + std::to_string(i);
      unique = name.substr(0, longest - suffix.size()) + suffix;
    }
    return unique;
  }

 private:
  std::set<std::string> taken_{"ALL", "NALL"};
};

/// The names of lines, each once, region after region: runs, then embedded lines.
std::vector<std::string> line_names(const Regions& regions) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const SkinnedRegion* region : regions) {
    for (const EdgeAlignedLine& aligned_line : region->edge_aligned) add(aligned_line.line.name);
    for (const EmbeddedLine& embedded : region->embedded) add(embedded.line.name);
  }
  return names;
}

/// The nearest name, or all of them behind `what`.
std::string not_among(const std::string& found, const std::vector<std::string>& names,
                      const std::string& what) {
  const std::string nearest = closest_match(found, names);
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
  return nearest.empty() ? what + all : "did you mean '" + nearest + "'?";
}

void check(const Regions& regions, const ShellDeck& deck) {
  if (regions.empty()) throw InputError("stress deck: found no region, expected one or more");
  const bool one = regions.size() == 1;
  const std::string who = one ? "stress deck of region '" + regions[0]->name + "': "
                              : "stress deck of " + std::to_string(regions.size()) + " regions: ";
  const auto expect = [&](bool good, const std::string& what, double found,
                          const std::string& expected) {
    if (!good)
      throw InputError(who + "found " + what + " " + format_number(found) + ", expected " +
                       expected);
  };
  const auto above_zero = [](double x) { return std::isfinite(x) && x > 0; };
  expect(above_zero(deck.thickness), "thickness", deck.thickness, "a length above 0");
  expect(above_zero(deck.young), "Young's modulus", deck.young, "a number above 0");
  expect(deck.poisson > -1 && deck.poisson < 0.5, "Poisson's ratio", deck.poisson,
         "a number between -1 and 0.5");
  expect(std::isfinite(deck.density) && deck.density >= 0, "density", deck.density,
         "0 or a number above it");
  expect(deck.gravity.isZero(0) || deck.density > 0, "gravity but density", deck.density,
         "a density above 0");
  expect(std::isfinite(deck.pressure), "pressure", deck.pressure, "a finite number");
  for (const auto& t : deck.thicknesses)
    expect(above_zero(t.thickness), "thickness", t.thickness, "a length above 0");
  bool finite = deck.gravity.allFinite();
  for (const auto& f : deck.line_forces) finite = finite && f.per_length.allFinite();
  for (const auto& f : deck.point_forces)
    finite = finite && f.at.allFinite() && f.force.allFinite();
  for (const auto& p : deck.pressures) finite = finite && std::isfinite(p.pressure);
  if (!finite) throw InputError(who + "found a load that is not finite");
  if (deck.supports.empty())
    throw InputError(who + "found no support, expected at least one line that is held");
  const auto expect_line = [&](const std::string& line, const std::string& what) {
    const std::vector<std::string> lines = line_names(regions);
    if (std::find(lines.begin(), lines.end(), line) == lines.end())
      throw InputError(who + "found a " + what + " on the line '" + line + "', which " +
                       (one ? "the region does not have; " : "no region has; ") +
                       not_among(line, lines, one ? "its lines are: " : "their lines are: "));
  };
  const auto expect_region = [&](const std::string& region, const std::string& what) {
    std::vector<std::string> names;
    for (const SkinnedRegion* r : regions) names.push_back(r->name);
    if (std::find(names.begin(), names.end(), region) == names.end())
      throw InputError(who + "found a " + what + " on the region '" + region +
                       "', which the model does not have; " +
                       not_among(region, names, "its regions are: "));
  };
  for (const auto& support : deck.supports) {
    if (!support.line.empty()) expect_line(support.line, "support");
    if (!support.region.empty()) expect_region(support.region, "support");
  }
  for (const auto& f : deck.line_forces) expect_line(f.line, "force");
  for (const auto& p : deck.pressures) expect_region(p.region, "pressure");
  for (const auto& t : deck.thicknesses) expect_region(t.region, "thickness");
}

/// Where several pressures are on an element, ccx takes the last one: each element gets one sum.
void write_pressures(std::ostream& out, const Regions& regions,
                     const std::vector<std::string>& sets, const ShellDeck& deck) {
  if (deck.pressures.empty()) {
    if (deck.pressure != 0) out << "*DLOAD\nALL,P," << ccx_number(deck.pressure) << '\n';
    return;
  }
  for (size_t r = 0; r < regions.size(); ++r) {
    double sum = deck.pressure;
    for (const auto& p : deck.pressures)
      if (p.region == regions[r]->name) sum += p.pressure;
    if (sum != 0) out << "*DLOAD\n" << sets[r] << ",P," << ccx_number(sum) << '\n';
  }
}

void write_loads(std::ostream& out, const Regions& regions, const ModelElements& model,
                 const std::vector<std::string>& sets, const ShellDeck& deck) {
  const auto forces = deck_forces(regions, model, deck);
  if (!forces.empty()) {
    out << "*CLOAD\n";
    for (const auto& [node, force] : forces)
      for (int i = 0; i < 3; ++i)
        if (force[i] != 0) out << node + 1 << ',' << i + 1 << ',' << ccx_number(force[i]) << '\n';
  }
  write_pressures(out, regions, sets, deck);
  if (const double g = deck.gravity.norm(); g > 0)
    out << "*DLOAD\nALL,GRAV," << ccx_number(g) << ',' << ccx_vector(deck.gravity / g) << '\n';
}

const char* type_name(ShellDeck::Element element) {
  return element == ShellDeck::Element::S3    ? "S3"
         : element == ShellDeck::Element::S8R ? "S8R"
                                              : "S6";
}

/// The nodes of a support that is not all of a line.
std::vector<int> supported_nodes(const Regions& regions, const ModelElements& model,
                                 const DeckDiscretization& elements,
                                 const ShellDeck::Support& support) {
  if (!support.line.empty() && !support.box) return {};
  std::set<int> nodes;
  const auto add = [&](int node) {
    if (!support.box || support.box->contains(elements.positions[node])) nodes.insert(node);
  };
  for (const auto& line : model.lines)
    if (line.name == support.line)
      for (const int node : elements.nodes_on(line.edges)) add(node);
  for (size_t r = 0; r < regions.size() && support.line.empty(); ++r)
    if (support.region.empty() || regions[r]->name == support.region)
      for (const auto& element : elements.by_region[r])
        for (const int node : element) add(node);
  if (nodes.empty())
    throw InputError("stress deck: found a support that holds no node, expected a larger box");
  return {nodes.begin(), nodes.end()};
}

void write_support(std::ostream& out, const std::string& set, const ShellDeck::Support& support) {
  const bool clamped = support.kind == ShellDeck::Support::Kind::Clamped;
  if (support.constrained == std::array<bool, 3>{true, true, true} &&
      support.displacement.isZero(0)) {
    out << set << ",1," << (clamped ? 6 : 3) << '\n';
    return;
  }
  for (int c = 0; c < 3; ++c) {
    if (!support.constrained[c]) continue;
    out << set << ',' << c + 1 << ',' << c + 1;
    if (support.displacement[c] != 0) out << ',' << ccx_number(support.displacement[c]);
    out << '\n';
  }
  if (clamped) out << set << ",4,6\n";
}

void write_sections(std::ostream& out, const Regions& regions, const std::vector<std::string>& sets,
                    const ShellDeck& deck) {
  const auto write = [&](const std::string& set, double thickness) {
    out << "*SHELL SECTION,ELSET=" << set << ",MATERIAL=SHELL\n" << ccx_number(thickness) << '\n';
  };
  if (deck.thicknesses.empty()) return write("ALL", deck.thickness);
  for (size_t r = 0; r < regions.size(); ++r) {
    double thickness = deck.thickness;
    for (const auto& t : deck.thicknesses)
      if (t.region == regions[r]->name) thickness = t.thickness;
    write(sets[r], thickness);
  }
}

}  // namespace

void write_calculix(const fs::path& path, const Regions& regions, const ShellDeck& deck) {
  check(regions, deck);
  const ModelElements model = model_elements(regions);
  const DeckDiscretization elements = deck_elements(regions, model, deck.element);
  std::vector<std::vector<int>> constrained;
  for (const auto& support : deck.supports)
    constrained.push_back(supported_nodes(regions, model, elements, support));
  const bool one = regions.size() == 1;
  SetNames names;
  std::vector<std::string> line_sets, region_sets;
  for (const auto& line : model.lines) line_sets.push_back(names.of(line.name, "LINE_"));
  for (const SkinnedRegion* region : regions)
    region_sets.push_back(one ? "ALL" : names.of(region->name, "REGION_"));
  write_file_atomically(path, [&](std::ostream& out) {
    out << "** "
        << (one ? "Region " + one_line(regions[0]->name)
                : "Model of " + std::to_string(regions.size()) + " regions")
        << ", written by Batten\n";
    if (!deck.units.empty()) out << "** Units: " << one_line(deck.units) << '\n';
    out << "*NODE,NSET=NALL\n";
    for (size_t i = 0; i < elements.positions.size(); ++i)
      out << i + 1 << ',' << ccx_vector(elements.positions[i]) << '\n';
    out << "*ELEMENT,TYPE=" << type_name(deck.element) << ",ELSET=ALL\n";
    std::vector<size_t> first{1};  // element of each region, and behind the last
    for (const auto& of_region : elements.by_region) {
      for (size_t e = 0; e < of_region.size(); ++e) {
        out << first.back() + e << ',';
        write_ccx_ids(out, of_region[e]);
      }
      first.push_back(first.back() + of_region.size());
    }
    for (size_t r = 0; r < regions.size() && !one; ++r)
      out << "** Region " << one_line(regions[r]->name) << "\n*ELSET,ELSET=" << region_sets[r]
          << ",GENERATE\n"
          << first[r] << ',' << first[r + 1] - 1 << ",1\n";
    for (size_t l = 0; l < model.lines.size(); ++l) {
      out << "** Line " << one_line(model.lines[l].name) << "\n*NSET,NSET=" << line_sets[l] << '\n';
      write_ccx_ids(out, elements.nodes_on(model.lines[l].edges));
    }
    out << "*MATERIAL,NAME=SHELL\n*ELASTIC\n"
        << ccx_number(deck.young) << ',' << ccx_number(deck.poisson) << '\n';
    if (deck.density > 0) out << "*DENSITY\n" << ccx_number(deck.density) << '\n';
    write_sections(out, regions, region_sets, deck);
    for (size_t k = 0; k < constrained.size(); ++k) {
      if (constrained[k].empty()) continue;
      out << "*NSET,NSET=SUPPORT_" << k + 1 << '\n';
      write_ccx_ids(out, constrained[k]);
    }
    out << "*BOUNDARY\n";
    for (size_t k = 0; k < deck.supports.size(); ++k) {
      if (!constrained[k].empty())
        write_support(out, "SUPPORT_" + std::to_string(k + 1), deck.supports[k]);
      for (size_t l = 0; l < model.lines.size() && constrained[k].empty(); ++l)
        if (model.lines[l].name == deck.supports[k].line)
          write_support(out, line_sets[l], deck.supports[k]);
    }
    out << "*STEP\n*STATIC\n";
    write_loads(out, regions, model, region_sets, deck);
    out << "*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n";
  });
}

}  // namespace batten
