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
#include "batten/elements/quadrature.h"
#include "batten/fem/triangle_locator.h"
#include "batten/io/decks/ccx_deck.h"
#include "batten/io/files/whole_file.h"
#include "batten/skinning/facets/model_facets.h"

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
    for (const LineRun& run : region->runs) add(run.line.name);
    for (const EmbeddedLine& embedded : region->embedded) add(embedded.line.name);
  }
  return names;
}

/// The nearest name, or all of them behind `what`.
std::string not_among(const std::string& found, const std::vector<std::string>& names,
                      const std::string& what) {
  const std::string nearest = nearest_word(found, names);
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
      throw InputError(who + "found " + what + " " + number(found) + ", expected " + expected);
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
  bool finite = deck.area_force.allFinite() && deck.gravity.allFinite();
  for (const auto& f : deck.point_forces)
    finite = finite && f.at.allFinite() && f.force.allFinite();
  for (const auto& p : deck.pressures) finite = finite && std::isfinite(p.pressure);
  if (!finite) throw InputError(who + "found a load that is not finite");
  if (deck.supports.empty())
    throw InputError(who + "found no support, expected at least one line that is held");
  const std::vector<std::string> lines = line_names(regions);
  for (const auto& support : deck.supports)
    if (std::find(lines.begin(), lines.end(), support.line) == lines.end())
      throw InputError(
          who + "found a support on the line '" + support.line + "', which " +
          (one ? "the region does not have; " : "no region has; ") +
          not_among(support.line, lines, one ? "its lines are: " : "their lines are: "));
  std::vector<std::string> names;
  for (const SkinnedRegion* region : regions) names.push_back(region->name);
  for (const auto& p : deck.pressures)
    if (std::find(names.begin(), names.end(), p.region) == names.end())
      throw InputError(who + "found a pressure on the region '" + p.region +
                       "', which the model does not have; " +
                       not_among(p.region, names, "its regions are: "));
}

/// ∬ N dA of each node, N the quadratic shape functions, dA of the true surface.
VecX node_areas(const Surface& surface, const QuadraticFacets& facets) {
  static const TriangleRule split = split_triangle(6), whole = symmetric_triangle(8);
  const TriangleRule& rule = facets.of_elements ? split : whole;
  std::optional<TriangleLocator> locator;
  if (!facets.of_elements) locator.emplace(surface.mesh());
  VecX area = VecX::Zero(static_cast<long>(facets.nodes.size()));
  for (size_t t = 0; t < facets.triangles.size(); ++t) {
    const auto& n = facets.triangles[t];
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Vec3 L = rule.L.row(p).transpose();
      const double N[6] = {L[0] * (2 * L[0] - 1), L[1] * (2 * L[1] - 1), L[2] * (2 * L[2] - 1),
                           4 * L[0] * L[1],       4 * L[1] * L[2],       4 * L[2] * L[0]};
      Location where{static_cast<int>(t), L};
      double parametric;
      if (locator) {
        // The element's place in (u, v) is quadratic as well.
        Vec2 at = Vec2::Zero(), d0 = Vec2::Zero(), d1 = Vec2::Zero();  // along L0 - L2, L1 - L2
        const double N0[6] = {4 * L[0] - 1, 0,         1 - 4 * L[2],
                              4 * L[1],     -4 * L[1], 4 * (L[2] - L[0])},
                     N1[6] = {0,        4 * L[1] - 1,      1 - 4 * L[2],
                              4 * L[0], 4 * (L[2] - L[1]), -4 * L[0]};
        for (int a = 0; a < 6; ++a) {
          const Vec2 uv = surface.mesh().image_near(facets.uv[n[a]], facets.uv[n[0]]);
          at += N[a] * uv;
          d0 += N0[a] * uv;
          d1 += N1[a] * uv;
        }
        parametric = 0.5 * (d0.x() * d1.y() - d0.y() * d1.x());
        where = locator->locate(at);
      } else {
        parametric = surface.mesh().shape(where.triangle).area;
      }
      const double dA = rule.weights[p] * parametric * surface.jet(where).area_vector().norm();
      for (int a = 0; a < 6; ++a) area[n[a]] += N[a] * dA;
    }
  }
  return area;
}

/// Forces on the nodes, from 0.
std::map<int, Vec3> node_forces(const Regions& regions, const ModelFacets& model,
                                const ShellDeck& deck) {
  std::map<int, Vec3> force;
  const auto at = [&](int node) -> Vec3& {
    return force.try_emplace(node, Vec3::Zero()).first->second;
  };
  if (!deck.area_force.isZero(0))
    for (size_t r = 0; r < regions.size(); ++r) {
      const VecX area = node_areas(regions[r]->surface, model.regions[r]);
      // At vertices of flat triangles the integral is zero; what is left there is rounding.
      const double rounding = 1e-14 * area.cwiseAbs().maxCoeff();
      for (long i = 0; i < area.size(); ++i)
        if (std::abs(area[i]) > rounding) at(model.node[r][i]) += area[i] * deck.area_force;
    }
  for (const auto& f : deck.point_forces) {
    const auto nearest = std::min_element(
        model.places.begin(), model.places.end(), [&](const Vec3& a, const Vec3& b) {
          return (a - f.at).squaredNorm() < (b - f.at).squaredNorm();
        });
    at(static_cast<int>(nearest - model.places.begin())) += f.force;
  }
  return force;
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

void write_loads(std::ostream& out, const Regions& regions, const ModelFacets& model,
                 const std::vector<std::string>& sets, const ShellDeck& deck) {
  const auto forces = node_forces(regions, model, deck);
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

/// The ends of a line's edges, then their middles, each once.
std::vector<int> nodes_on(const std::vector<std::array<int, 3>>& edges) {
  std::vector<int> nodes;
  const auto add = [&](int node) {
    if (std::find(nodes.begin(), nodes.end(), node) == nodes.end()) nodes.push_back(node);
  };
  for (const auto& edge : edges) {
    add(edge[0]);
    add(edge[1]);
  }
  for (const auto& edge : edges) add(edge[2]);
  return nodes;
}

/// Comments must not break out of their line.
}  // namespace

void write_calculix(const fs::path& path, const Regions& regions, const ShellDeck& deck) {
  check(regions, deck);
  const ModelFacets model = model_facets(regions);
  const bool one = regions.size() == 1;
  SetNames names;
  std::vector<std::string> line_sets, region_sets;
  for (const auto& line : model.lines) line_sets.push_back(names.of(line.name, "LINE_"));
  for (const SkinnedRegion* region : regions)
    region_sets.push_back(one ? "ALL" : names.of(region->name, "REGION_"));
  write_whole_file(path, [&](std::ostream& out) {
    out << "** "
        << (one ? "Region " + one_line(regions[0]->name)
                : "Model of " + std::to_string(regions.size()) + " regions")
        << ", written by Batten\n";
    if (!deck.units.empty()) out << "** Units: " << one_line(deck.units) << '\n';
    out << "*NODE,NSET=NALL\n";
    for (size_t i = 0; i < model.places.size(); ++i)
      out << i + 1 << ',' << ccx_vector(model.places[i]) << '\n';
    out << "*ELEMENT,TYPE=S6,ELSET=ALL\n";
    std::vector<size_t> first{1};  // element of each region, and behind the last
    for (size_t r = 0; r < regions.size(); ++r) {
      const auto& triangles = model.regions[r].triangles;
      for (size_t t = 0; t < triangles.size(); ++t) {
        std::array<int, 6> nodes;
        for (size_t i = 0; i < 6; ++i) nodes[i] = model.node[r][triangles[t][i]];
        out << first[r] + t << ',';
        write_ccx_ids(out, nodes);
      }
      first.push_back(first[r] + triangles.size());
    }
    for (size_t r = 0; r < regions.size() && !one; ++r)
      out << "** Region " << one_line(regions[r]->name) << "\n*ELSET,ELSET=" << region_sets[r]
          << ",GENERATE\n"
          << first[r] << ',' << first[r + 1] - 1 << ",1\n";
    for (size_t l = 0; l < model.lines.size(); ++l) {
      out << "** Line " << one_line(model.lines[l].name) << "\n*NSET,NSET=" << line_sets[l] << '\n';
      write_ccx_ids(out, nodes_on(model.lines[l].edges));
    }
    out << "*MATERIAL,NAME=SHELL\n*ELASTIC\n"
        << ccx_number(deck.young) << ',' << ccx_number(deck.poisson) << '\n';
    if (deck.density > 0) out << "*DENSITY\n" << ccx_number(deck.density) << '\n';
    out << "*SHELL SECTION,ELSET=ALL,MATERIAL=SHELL\n" << ccx_number(deck.thickness) << '\n';
    out << "*BOUNDARY\n";
    for (const auto& support : deck.supports)
      for (size_t l = 0; l < model.lines.size(); ++l)
        if (model.lines[l].name == support.line)
          out << line_sets[l] << ",1,"
              << (support.kind == ShellDeck::Support::Kind::Clamped ? 6 : 3) << '\n';
    out << "*STEP\n*STATIC\n";
    write_loads(out, regions, model, region_sets, deck);
    out << "*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n";
  });
}

}  // namespace batten
