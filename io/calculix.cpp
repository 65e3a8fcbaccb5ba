#include "batten/io/calculix.h"

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
#include "batten/io/ccx_deck.h"
#include "batten/io/whole_file.h"
#include "batten/skinning/facets.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// Set names for the lines of a region, unlike each other and unlike NALL and ALL.
std::vector<std::string> set_names(const std::vector<std::string>& lines) {
  constexpr size_t longest = 80;
  std::set<std::string> taken{"ALL", "NALL"};
  std::vector<std::string> names;
  for (const std::string& line : lines) {
    std::string name;
    for (const char c : line) {
      const auto byte = static_cast<unsigned char>(c);
      name += byte < 128 && std::isalnum(byte) ? static_cast<char>(std::toupper(byte)) : '_';
    }
    if (name.empty() || !std::isalpha(static_cast<unsigned char>(name[0]))) name = "LINE_" + name;
    name = name.substr(0, longest);
    std::string unique = name;
    for (int i = 2; !taken.insert(unique).second; ++i) {
      const std::string suffix = "_" + std::to_string(i);
      unique = name.substr(0, longest - suffix.size()) + suffix;
    }
    names.push_back(unique);
  }
  return names;
}

/// Runs, then embedded lines.
std::vector<std::string> line_names(const SkinnedRegion& region) {
  std::vector<std::string> names;
  for (const LineRun& run : region.runs) names.push_back(run.line.name);
  for (const EmbeddedLine& embedded : region.embedded) names.push_back(embedded.line.name);
  return names;
}

void check(const SkinnedRegion& region, const ShellDeck& deck) {
  const std::string who = "stress deck of region '" + region.name + "': ";
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
  if (!finite) throw InputError(who + "found a load that is not finite");
  if (deck.supports.empty())
    throw InputError(who + "found no support, expected at least one line that is held");
  const std::vector<std::string> names = line_names(region);
  for (const auto& support : deck.supports) {
    if (std::find(names.begin(), names.end(), support.line) != names.end()) continue;
    const std::string nearest = nearest_word(support.line, names);
    std::string all;
    for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
    throw InputError(
        who + "found a support on the line '" + support.line +
        "', which the region does not have; " +
        (nearest.empty() ? "its lines are: " + all : "did you mean '" + nearest + "'?"));
  }
}

/// The six-node triangles of a region.
struct Shell {
  QuadraticFacets facets;
  std::vector<Vec3> nodes;

  explicit Shell(const SkinnedRegion& region) : facets(quadratic_facets(region)) {
    if (facets.of_elements)  // the last element at a node says where it is
      for (size_t t = 0; t < facets.triangles.size(); ++t)
        for (int i = 0; i < 3; ++i) {
          const auto& n = facets.triangles[t];
          const int here = static_cast<int>(t), middle = n[3 + (i + 1) % 3];  // opposite corner i
          facets.nodes[n[i]] = {here, Vec3::Unit(i)};
          facets.nodes[middle] = {here, (Vec3::Ones() - Vec3::Unit(i)) / 2};
        }
    for (const Location& where : facets.nodes) nodes.push_back(region.surface.position(where));
  }

  int nearest_node(const Vec3& p) const {
    return static_cast<int>(std::min_element(nodes.begin(), nodes.end(),
                                             [&](const Vec3& a, const Vec3& b) {
                                               return (a - p).squaredNorm() < (b - p).squaredNorm();
                                             }) -
                            nodes.begin());
  }
};

/// ∬ N dA of each node, N the quadratic shape functions, dA of the true surface.
VecX node_areas(const Surface& surface, const Shell& shell) {
  static const TriangleRule split = split_triangle(6), whole = symmetric_triangle(8);
  const TriangleRule& rule = shell.facets.of_elements ? split : whole;
  std::optional<TriangleLocator> locator;
  if (!shell.facets.of_elements) locator.emplace(surface.mesh());
  VecX area = VecX::Zero(static_cast<long>(shell.nodes.size()));
  for (size_t t = 0; t < shell.facets.triangles.size(); ++t) {
    const auto& n = shell.facets.triangles[t];
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
          const Vec2 uv =
              surface.mesh().image_near(shell.facets.uv[n[a]], shell.facets.uv[n[0]]);
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
std::map<int, Vec3> node_forces(const Surface& surface, const Shell& shell, const ShellDeck& deck) {
  std::map<int, Vec3> force;
  if (!deck.area_force.isZero(0)) {
    const VecX area = node_areas(surface, shell);
    // At vertices of flat triangles the integral is zero; what is left there is rounding.
    const double rounding = 1e-14 * area.cwiseAbs().maxCoeff();
    for (long i = 0; i < area.size(); ++i)
      if (std::abs(area[i]) > rounding) force[static_cast<int>(i)] = area[i] * deck.area_force;
  }
  for (const auto& f : deck.point_forces)
    force.try_emplace(shell.nearest_node(f.at), Vec3::Zero()).first->second += f.force;
  return force;
}

void write_loads(std::ostream& out, const Surface& surface, const Shell& shell,
                 const ShellDeck& deck) {
  const auto forces = node_forces(surface, shell, deck);
  if (!forces.empty()) {
    out << "*CLOAD\n";
    for (const auto& [node, force] : forces)
      for (int i = 0; i < 3; ++i)
        if (force[i] != 0) out << node + 1 << ',' << i + 1 << ',' << ccx_number(force[i]) << '\n';
  }
  if (deck.pressure != 0) out << "*DLOAD\nALL,P," << ccx_number(deck.pressure) << '\n';
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
std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32) c = ' ';
  return text;
}

}  // namespace

void write_calculix(const fs::path& path, const SkinnedRegion& region, const ShellDeck& deck) {
  check(region, deck);
  const Shell shell(region);
  const std::vector<std::string> lines = line_names(region), names = set_names(lines);
  write_whole_file(path, [&](std::ostream& out) {
    out << "** Region " << one_line(region.name) << ", written by Batten\n";
    if (!deck.units.empty()) out << "** Units: " << one_line(deck.units) << '\n';
    out << "*NODE,NSET=NALL\n";
    for (size_t i = 0; i < shell.nodes.size(); ++i)
      out << i + 1 << ',' << ccx_vector(shell.nodes[i]) << '\n';
    out << "*ELEMENT,TYPE=S6,ELSET=ALL\n";
    for (size_t t = 0; t < shell.facets.triangles.size(); ++t) {
      out << t + 1 << ',';
      write_ccx_ids(out, shell.facets.triangles[t]);
    }
    for (size_t l = 0; l < lines.size(); ++l) {
      out << "** Line " << one_line(lines[l]) << "\n*NSET,NSET=" << names[l] << '\n';
      write_ccx_ids(out, nodes_on(shell.facets.lines[l]));
    }
    out << "*MATERIAL,NAME=SHELL\n*ELASTIC\n"
        << ccx_number(deck.young) << ',' << ccx_number(deck.poisson) << '\n';
    if (deck.density > 0) out << "*DENSITY\n" << ccx_number(deck.density) << '\n';
    out << "*SHELL SECTION,ELSET=ALL,MATERIAL=SHELL\n" << ccx_number(deck.thickness) << '\n';
    out << "*BOUNDARY\n";
    for (const auto& support : deck.supports)
      for (size_t l = 0; l < lines.size(); ++l)
        if (lines[l] == support.line)
          out << names[l] << ",1," << (support.kind == ShellDeck::Support::Kind::Clamped ? 6 : 3)
              << '\n';
    out << "*STEP\n*STATIC\n";
    write_loads(out, region.surface, shell, deck);
    out << "*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n";
  });
}

}  // namespace batten
