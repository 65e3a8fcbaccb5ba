// SPDX-License-Identifier: MPL-2.0
#include "batten/io/decks/calculix_decks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <ostream>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/decks/ccx_text.h"
#include "batten/io/decks/deck_elements.h"
#include "batten/io/decks/deck_loads.h"
#include "batten/io/decks/deck_supports.h"
#include "batten/io/files/atomic_file.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

using Regions = std::vector<const SkinnedRegion*>;

/// Generates distinct set names, also distinct from NALL and ALL.
class SetNames {
 public:
  /// `kind`: prefix for names that do not begin with a letter.
  std::string of(const std::string& text, const std::string& kind) {
    constexpr size_t longest = 80;
    std::string name;
    for (const char c : text) {
      const auto byte = static_cast<unsigned char>(c);
      name += byte < 128 && std::isalnum(byte) ? static_cast<char>(std::toupper(byte)) : '_';
    }
    const bool reserved = std::any_of(kReserved.begin(), kReserved.end(), [&](const char* prefix) {
      return name.rfind(prefix, 0) == 0;
    });
    if (reserved || name.empty() || !std::isalpha(static_cast<unsigned char>(name[0])))
      name = kind + name;
    name = name.substr(0, longest);
    std::string unique = name;
    for (int i = 2; !taken_.insert(unique).second; ++i) {
      const std::string suffix = "_" + std::to_string(i);
      unique = name.substr(0, longest - suffix.size()) + suffix;
    }
    return unique;
  }

 private:
  // Beginnings of the names of the writer's own sets.
  static constexpr std::array<const char*, 5> kReserved = {"SUPPORT_", "SYSTEM_", "SPRINGS_",
                                                           "MASS_", "SECTION_"};
  std::set<std::string> taken_{"ALL", "NALL", "GROUND"};
};

/// The names of all curves, without duplicates, face after face: edge-aligned curves, then embedded
/// ones.
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

/// The end of a message: the most similar name, or else `what` followed by all names.
std::string not_among(const std::string& found, const std::vector<std::string>& names,
                      const std::string& what) {
  const std::string nearest = closest_match(found, names);
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
  return nearest.empty() ? what + all : "did you mean '" + nearest + "'?";
}

void check(const Regions& regions, const ShellDeck& deck) {
  if (regions.empty()) throw InputError("stress deck: found no face, expected at least one");
  const bool one = regions.size() == 1;
  const std::string who = one ? "stress deck of face '" + regions[0]->name + "': "
                              : "stress deck of " + std::to_string(regions.size()) + " faces: ";
  const auto expect = [&](bool good, const std::string& what, double found,
                          const std::string& expected) {
    if (!good)
      throw InputError(who + "found " + what + " " + format_number(found) + ", expected " +
                       expected);
  };
  const auto above_zero = [](double x) { return std::isfinite(x) && x > 0; };
  expect(above_zero(deck.thickness), "thickness", deck.thickness, "a length above 0");
  if (deck.plies.empty()) {
    expect(above_zero(deck.young), "Young's modulus", deck.young, "a number above 0");
    expect(deck.poisson > -1 && deck.poisson < 0.5, "Poisson's ratio", deck.poisson,
           "a number between -1 and 0.5");
  } else if (deck.element == ShellDeck::Element::S3) {
    throw DeckLimitError(who +
                         "found plies, which three-node triangles of CalculiX cannot have, "
                         "expected six-node triangles (S6) or eight-node quads (S8R)");
  }
  for (const ShellDeck::Ply& ply : deck.plies) {
    expect(above_zero(ply.thickness), "a ply of thickness", ply.thickness, "a length above 0");
    for (const double modulus : {ply.young, ply.young_across, ply.shear})
      expect(above_zero(modulus), "a ply with the modulus", modulus, "a number above 0");
  }
  expect(std::isfinite(deck.density) && deck.density >= 0, "density", deck.density,
         "a number of at least 0");
  expect(deck.gravity.isZero(0) || deck.density > 0 || !deck.plies.empty(),
         "gravity and a density of", deck.density, "a density above 0");
  expect(std::isfinite(deck.pressure), "pressure", deck.pressure, "a finite number");
  for (const auto& t : deck.thicknesses)
    expect(above_zero(t.thickness), "thickness", t.thickness, "a length above 0");
  bool finite = deck.gravity.allFinite();
  for (const auto& f : deck.point_forces)
    finite = finite && f.at.allFinite() && f.force.allFinite();
  for (const auto& p : deck.pressures) finite = finite && std::isfinite(p.pressure);
  if (!finite) throw InputError(who + "found a load that is not finite");
  if (deck.supports.empty() && deck.springs.empty() &&
      deck.analysis != ShellDeck::Analysis::Frequencies)
    throw InputError(who + "found no support, expected at least one");
  const auto expect_line = [&](const std::string& line, const std::string& what) {
    const std::vector<std::string> lines = line_names(regions);
    if (std::find(lines.begin(), lines.end(), line) == lines.end())
      throw InputError(who + "found a " + what + " on the curve '" + line + "', which " +
                       (one ? "the face does not have; " : "no face has; ") +
                       not_among(line, lines, one ? "its curves are: " : "their curves are: "));
  };
  const auto expect_region = [&](const std::string& region, const std::string& what) {
    std::vector<std::string> names;
    for (const SkinnedRegion* r : regions) names.push_back(r->name);
    if (std::find(names.begin(), names.end(), region) == names.end())
      throw InputError(who + "found a " + what + " on the face '" + region +
                       "', which the model does not have; " +
                       not_among(region, names, "its faces are: "));
  };
  for (const auto& support : deck.supports) {
    if (!support.line.empty()) expect_line(support.line, "support");
    if (!support.region.empty()) expect_region(support.region, "support");
  }
  for (const auto& load : deck.line_loads) expect_line(load.line, "force");
  for (const auto& load : deck.spread_loads) {
    for (const std::string& line : load.lines) expect_line(line, "force");
    if (!load.region.empty()) expect_region(load.region, "force");
  }
  for (const auto& spring : deck.springs) {
    if (!spring.line.empty()) expect_line(spring.line, "spring");
    if (!spring.region.empty()) expect_region(spring.region, "spring");
  }
  for (const auto& p : deck.pressures) expect_region(p.region, "pressure");
  for (const auto& t : deck.thicknesses) expect_region(t.region, "thickness");
}

/// If an element has several pressures, ccx uses the last one only, so write their sum.
void write_pressures(std::ostream& out, const Regions& regions,
                     const std::vector<std::string>& sets, const ShellDeck& deck) {
  if (deck.pressures.empty()) {
    if (deck.pressure != 0)
      out << "*DLOAD\nALL,P," << ccx_number(deck.load_factor * deck.pressure) << '\n';
    return;
  }
  for (size_t r = 0; r < regions.size(); ++r) {
    double sum = deck.pressure;
    for (const auto& p : deck.pressures)
      if (p.region == regions[r]->name) sum += p.pressure;
    if (sum != 0)
      out << "*DLOAD\n" << sets[r] << ",P," << ccx_number(deck.load_factor * sum) << '\n';
  }
}

const char* type_name(ShellDeck::Element element) {
  return element == ShellDeck::Element::S3    ? "S3"
         : element == ShellDeck::Element::S8R ? "S8R"
                                              : "S6";
}

/// Writes a deck section by section.
class DeckWriter {
 public:
  DeckWriter(const Regions& regions, const ShellDeck& deck)
      : regions_(regions),
        deck_(deck),
        model_(model_elements(regions)),
        elements_(deck_elements(regions, model_, deck.element)) {
    for (const auto& line : model_.lines) line_sets_.push_back(names_.of(line.name, "CURVE_"));
    for (const SkinnedRegion* region : regions)
      region_sets_.push_back(one() ? "ALL" : names_.of(region->name, "FACE_"));
    first_.push_back(1);
    for (const auto& of_region : elements_.by_region)
      first_.push_back(first_.back() + of_region.size());
  }

  void write(const fs::path& path) {
    const DeckSupports supports(regions_, model_, elements_, deck_, line_sets_);
    write_file_atomically(path, [&](std::ostream& out) {
      out << "** "
          << (one() ? "Face " + one_line(regions_[0]->name)
                    : "Model of " + std::to_string(regions_.size()) + " faces")
          << ", written by Batten\n";
      if (!deck_.units.empty()) out << "** Units: " << one_line(deck_.units) << '\n';
      write_mesh(out);
      const size_t ground = write_springs(out);
      write_masses(out);
      if (deck_.plies.empty())
        write_isotropic(out);
      else
        write_plies(out);
      supports.write_sets(out);
      if (!deck_.supports.empty() || ground > 0) out << "*BOUNDARY\n";
      supports.write_boundary(out);
      if (ground > 0) out << "GROUND,1,3\n";
      write_step(out, supports);
    });
  }

 private:
  bool one() const { return regions_.size() == 1; }

  void write_mesh(std::ostream& out) const {
    out << "*NODE,NSET=NALL\n";
    for (size_t i = 0; i < elements_.positions.size(); ++i)
      out << i + 1 << ',' << ccx_vector(elements_.positions[i]) << '\n';
    out << "*ELEMENT,TYPE=" << type_name(deck_.element) << ",ELSET=ALL\n";
    size_t number = 1;
    for (const auto& of_region : elements_.by_region)
      for (const auto& nodes : of_region) {
        out << number++ << ',';
        write_ccx_ids(out, nodes);
      }
    for (size_t r = 0; r < regions_.size() && !one(); ++r)
      out << "** Face " << one_line(regions_[r]->name) << "\n*ELSET,ELSET=" << region_sets_[r]
          << ",GENERATE\n"
          << first_[r] << ',' << first_[r + 1] - 1 << ",1\n";
    for (size_t l = 0; l < model_.lines.size(); ++l) {
      out << "** Curve " << one_line(model_.lines[l].name) << "\n*NSET,NSET=" << line_sets_[l]
          << '\n';
      write_ccx_ids(out, elements_.nodes_on(model_.lines[l].edges));
    }
  }

  // SPRINGA elements to fixed nodes, one set for each stiffness. Returns the number of these nodes.
  size_t write_springs(std::ostream& out) {
    const std::vector<NodalSpring> springs = deck_springs(regions_, model_, elements_, deck_);
    if (springs.empty()) return 0;
    double size = 0;
    for (const Vec3& x : elements_.positions)
      size = std::max(size, (x - elements_.positions[0]).norm());
    out << "*NODE,NSET=GROUND\n";
    const size_t first_node = elements_.positions.size() + 1;
    std::map<double, std::vector<size_t>> by_stiffness;
    for (size_t k = 0; k < springs.size(); ++k) {
      const Vec3 end = elements_.positions[springs[k].node] + size * springs[k].direction;
      out << first_node + k << ',' << ccx_vector(end) << '\n';
      by_stiffness[springs[k].stiffness].push_back(k);
    }
    size_t set = 0;
    for (const auto& [stiffness, members] : by_stiffness) {
      const std::string name = "SPRINGS_" + std::to_string(++set);
      out << "*ELEMENT,TYPE=SPRINGA,ELSET=" << name << '\n';
      for (const size_t k : members)
        out << next_element() << ',' << springs[k].node + 1 << ',' << first_node + k << '\n';
      out << "*SPRING,ELSET=" << name << "\n\n" << ccx_decimal(stiffness) << '\n';
    }
    return springs.size();
  }

  void write_masses(std::ostream& out) {
    for (size_t k = 0; k < deck_.masses.size(); ++k) {
      const std::string name = "MASS_" + std::to_string(k + 1);
      out << "*ELEMENT,TYPE=MASS,ELSET=" << name << '\n'
          << next_element() << ',' << nearest_node(model_.positions, deck_.masses[k].at) + 1
          << "\n*MASS,ELSET=" << name << '\n'
          << ccx_number(deck_.masses[k].mass) << '\n';
    }
  }

  void write_isotropic(std::ostream& out) const {
    out << "*MATERIAL,NAME=SHELL\n*ELASTIC\n"
        << ccx_number(deck_.young) << ',' << ccx_number(deck_.poisson) << '\n';
    if (deck_.density > 0) out << "*DENSITY\n" << ccx_number(deck_.density) << '\n';
    if (deck_.temperature) out << "*EXPANSION\n" << ccx_number(deck_.expansion) << '\n';
    const auto section = [&](const std::string& set, double thickness) {
      out << "*SHELL SECTION,ELSET=" << set << ",MATERIAL=SHELL\n" << ccx_number(thickness) << '\n';
    };
    if (deck_.thicknesses.empty()) return section("ALL", deck_.thickness);
    for (size_t r = 0; r < regions_.size(); ++r) {
      double thickness = deck_.thickness;
      for (const auto& t : deck_.thicknesses)
        if (t.region == regions_[r]->name) thickness = t.thickness;
      section(region_sets_[r], thickness);
    }
  }

  // One material for each ply, and one section for each direction of the material in the elements.
  void write_plies(std::ostream& out) const {
    for (size_t k = 0; k < deck_.plies.size(); ++k) {
      const ShellDeck::Ply& ply = deck_.plies[k];
      // In thin shells, the moduli across the thickness have no influence.
      out << "*MATERIAL,NAME=PLY_" << k + 1 << "\n*ELASTIC,TYPE=ENGINEERING CONSTANTS\n"
          << ccx_number(ply.young) << ',' << ccx_number(ply.young_across) << ','
          << ccx_number(ply.young_across) << ',' << ccx_number(ply.poisson) << ",0.,0.,"
          << ccx_number(ply.shear) << ',' << ccx_number(ply.shear) << '\n'
          << ccx_number(ply.shear) << '\n';
      if (ply.density > 0) out << "*DENSITY\n" << ccx_number(ply.density) << '\n';
      if (deck_.temperature)
        out << "*EXPANSION,TYPE=ORTHO\n"
            << ccx_number(ply.expansion) << ',' << ccx_number(ply.expansion_across) << ','
            << ccx_number(ply.expansion_across) << '\n';
    }
    // Directions that differ by rounding are one.
    std::map<std::array<long, 6>, std::pair<Mat3, std::vector<int>>> groups;
    int number = 0;
    for (const auto& of_region : elements_.by_region)
      for (const auto& nodes : of_region) {
        const Mat3 axes = material_axes(nodes);
        constexpr double step = 1e-9;
        std::array<long, 6> key;
        for (size_t i = 0; i < 6; ++i)
          key[i] = std::lround(axes(static_cast<long>(i % 3), static_cast<long>(i / 3)) / step);
        auto& group = groups.try_emplace(key, axes, std::vector<int>()).first->second;
        group.second.push_back(number++);
      }
    size_t section = 0;
    for (const auto& [key, group] : groups)
      write_composite(out, group.first, group.second, ++section);
  }

  void write_composite(std::ostream& out, const Mat3& axes, const std::vector<int>& members,
                       size_t section) const {
    const std::string name = std::to_string(section);
    out << "*ELSET,ELSET=SECTION_" << name << '\n';
    write_ccx_ids(out, members);
    for (size_t k = 0; k < deck_.plies.size(); ++k) {
      const double c = std::cos(deck_.plies[k].angle), s = std::sin(deck_.plies[k].angle);
      out << "*ORIENTATION,NAME=ORIENTATION_" << name << '_' << k + 1 << ",SYSTEM=RECTANGULAR\n"
          << ccx_vector(c * axes.col(0) + s * axes.col(1)) << ','
          << ccx_vector(c * axes.col(1) - s * axes.col(0)) << '\n';
    }
    out << "*SHELL SECTION,ELSET=SECTION_" << name << ",COMPOSITE\n";
    for (size_t k = 0; k < deck_.plies.size(); ++k)
      out << ccx_number(deck_.plies[k].thickness) << ",,PLY_" << k + 1 << ",ORIENTATION_" << name
          << '_' << k + 1 << '\n';
  }

  // Directions 1 and 2 of the material in an element, and its normal.
  Mat3 material_axes(const std::vector<int>& nodes) const {
    const auto& x = elements_.positions;
    const size_t last = nodes.size() / 2 - 1;  // last corner
    const Vec3 n = (x[nodes[1]] - x[nodes[0]]).cross(x[nodes[last]] - x[nodes[0]]).normalized();
    const Vec3 along = deck_.along - deck_.along.dot(n) * n;
    if (!(along.norm() > 1e-6 * deck_.along.norm()))
      throw DeckLimitError(
          "found an element perpendicular to the material direction, expected a "
          "direction along the surface");
    Mat3 axes;
    axes << along.normalized(), n.cross(along.normalized()), n;
    return axes;
  }

  void write_step(std::ostream& out, const DeckSupports& supports) const {
    if (deck_.temperature) out << "*INITIAL CONDITIONS,TYPE=TEMPERATURE\nNALL,0.\n";
    switch (deck_.analysis) {
      case ShellDeck::Analysis::Static:
        out << "*STEP\n*STATIC\n";
        write_loads(out, supports);
        out << "*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n";
        return;
      case ShellDeck::Analysis::Buckling:
        if (deck_.load_factor != 1)
          out << "** All loads times " << ccx_number(deck_.load_factor) << '\n';
        out << "*STEP\n*BUCKLE\n" << deck_.count << '\n';
        write_loads(out, supports);
        out << "*NODE FILE\nU\n*END STEP\n";
        return;
      case ShellDeck::Analysis::Frequencies:
        out << "*STEP\n*FREQUENCY\n" << deck_.count << "\n*NODE FILE\nU\n*END STEP\n";
        return;
    }
  }

  void write_loads(std::ostream& out, const DeckSupports& supports) const {
    const auto loads = deck_forces(regions_, model_, elements_, deck_);
    if (!loads.empty()) {
      out << "*CLOAD\n";
      for (const auto& [node, load] : loads) {
        write_components(out, node, 1, deck_.load_factor * supports.local(node, load.force));
        write_components(out, node, 4, deck_.load_factor * supports.local(node, load.moment));
      }
    }
    write_pressures(out, regions_, region_sets_, deck_);
    if (const double g = deck_.gravity.norm(); g > 0)
      out << "*DLOAD\nALL,GRAV," << ccx_number(deck_.load_factor * g) << ','
          << ccx_vector(deck_.gravity / g) << '\n';
    for (const ShellDeck::Rotation& of : deck_.rotations)
      out << "*DLOAD\nALL,CENTRIF,"
          << ccx_number(deck_.load_factor * of.angular_velocity * of.angular_velocity) << ','
          << ccx_vector(of.origin) << ',' << ccx_vector(of.axis.normalized()) << '\n';
    if (deck_.temperature) write_temperatures(out);
  }

  static void write_components(std::ostream& out, int node, int first, const Vec3& v) {
    for (int i = 0; i < 3; ++i)
      if (v[i] != 0) out << node + 1 << ',' << first + i << ',' << ccx_number(v[i]) << '\n';
  }

  // Temperature and its gradient through the thickness at each node.
  void write_temperatures(std::ostream& out) const {
    out << "*TEMPERATURE\n";
    for (size_t i = 0; i < elements_.positions.size(); ++i) {
      const auto [middle, difference] = deck_.temperature(elements_.positions[i]);
      out << i + 1 << ',' << ccx_number(deck_.load_factor * middle) << ','
          << ccx_number(deck_.load_factor * difference / deck_.thickness) << '\n';
    }
  }

  size_t next_element() { return first_.back() + added_elements_++; }

  const Regions& regions_;
  const ShellDeck& deck_;
  ModelElements model_;
  DeckDiscretization elements_;
  SetNames names_;
  std::vector<std::string> line_sets_, region_sets_;
  std::vector<size_t> first_;  // first element number of each face, and one past the last
  size_t added_elements_ = 0;
};

}  // namespace

void write_calculix(const fs::path& path, const Regions& regions, const ShellDeck& deck) {
  check(regions, deck);
  DeckWriter(regions, deck).write(path);
}

}  // namespace batten
