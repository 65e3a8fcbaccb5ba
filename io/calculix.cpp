#include "batten/io/calculix.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>
#include <ostream>
#include <set>

#include "batten/core/errors.h"
#include "batten/elements/quadrature.h"
#include "batten/io/ccx_deck.h"
#include "batten/io/whole_file.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// Set names for the lines of a region, unlike each other and unlike NALL and ALL.
std::vector<std::string> set_names(const std::vector<LineRun>& runs) {
  constexpr size_t longest = 80;
  std::set<std::string> taken{"ALL", "NALL"};
  std::vector<std::string> names;
  for (const LineRun& run : runs) {
    std::string name;
    for (const char c : run.line.name) {
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
  std::vector<std::string> names;
  for (const LineRun& run : region.runs) names.push_back(run.line.name);
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
  std::vector<Vec3> nodes;  // vertices, then edge midpoints
  std::vector<std::array<int, 6>> elements;

  explicit Shell(const Surface& surface) {
    const ParametricMesh& mesh = surface.mesh();
    const int vertices = mesh.vertex_count();
    nodes.resize(static_cast<size_t>(vertices + mesh.edge_count()));
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const auto &v = mesh.triangles()[t], &e = mesh.edges_of(t);
      elements.push_back({v[0], v[1], v[2], vertices + e[2], vertices + e[0], vertices + e[1]});
      for (int i = 0; i < 3; ++i) {
        nodes[v[i]] = surface.position({t, Vec3::Unit(i)});
        nodes[vertices + e[i]] = surface.position({t, (Vec3::Ones() - Vec3::Unit(i)) / 2});
      }
    }
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
  static const TriangleRule rule = split_triangle(6);
  VecX area = VecX::Zero(static_cast<long>(shell.nodes.size()));
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    const double parametric = surface.mesh().shape(t).area;
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Vec3 L = rule.L.row(p).transpose();
      const double dA = rule.weights[p] * parametric * surface.jet({t, L}).area_vector().norm();
      const double N[6] = {L[0] * (2 * L[0] - 1), L[1] * (2 * L[1] - 1), L[2] * (2 * L[2] - 1),
                           4 * L[0] * L[1],       4 * L[1] * L[2],       4 * L[2] * L[0]};
      for (int a = 0; a < 6; ++a) area[shell.elements[t][a]] += N[a] * dA;
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

/// Comments must not break out of their line.
std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32) c = ' ';
  return text;
}

}  // namespace

void write_calculix(const fs::path& path, const SkinnedRegion& region, const ShellDeck& deck) {
  check(region, deck);
  const Shell shell(region.surface);
  const std::vector<std::string> names = set_names(region.runs);
  write_whole_file(path, [&](std::ostream& out) {
    out << "** Region " << one_line(region.name) << ", written by Batten\n";
    if (!deck.units.empty()) out << "** Units: " << one_line(deck.units) << '\n';
    out << "*NODE,NSET=NALL\n";
    for (size_t i = 0; i < shell.nodes.size(); ++i)
      out << i + 1 << ',' << ccx_vector(shell.nodes[i]) << '\n';
    out << "*ELEMENT,TYPE=S6,ELSET=ALL\n";
    for (size_t t = 0; t < shell.elements.size(); ++t) {
      out << t + 1 << ',';
      write_ccx_ids(out, shell.elements[t]);
    }
    for (size_t r = 0; r < region.runs.size(); ++r) {
      const LineRun& run = region.runs[r];
      out << "** Line " << one_line(run.line.name) << "\n*NSET,NSET=" << names[r] << '\n';
      std::vector<int> ids = run.vertices;
      for (const int e : run.edges) ids.push_back(region.surface.mesh().vertex_count() + e);
      write_ccx_ids(out, ids);
    }
    out << "*MATERIAL,NAME=SHELL\n*ELASTIC\n"
        << ccx_number(deck.young) << ',' << ccx_number(deck.poisson) << '\n';
    if (deck.density > 0) out << "*DENSITY\n" << ccx_number(deck.density) << '\n';
    out << "*SHELL SECTION,ELSET=ALL,MATERIAL=SHELL\n" << ccx_number(deck.thickness) << '\n';
    out << "*BOUNDARY\n";
    for (const auto& support : deck.supports)
      for (size_t r = 0; r < region.runs.size(); ++r)
        if (region.runs[r].line.name == support.line)
          out << names[r] << ",1," << (support.kind == ShellDeck::Support::Kind::Clamped ? 6 : 3)
              << '\n';
    out << "*STEP\n*STATIC\n";
    write_loads(out, region.surface, shell, deck);
    out << "*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n";
  });
}

}  // namespace batten
