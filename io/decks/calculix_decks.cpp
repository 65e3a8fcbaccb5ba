// SPDX-License-Identifier: MPL-2.0
#include "batten/io/decks/calculix_decks.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <optional>
#include <ostream>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/elements/quadrature.h"
#include "batten/fem/triangle_locator.h"
#include "batten/io/files/atomic_file.h"
#include "batten/skinning/facets/model_elements.h"

namespace batten {
namespace {

// Numbers and lists of CalculiX decks.

/// Formats a number with as many digits as fit into 20 characters; the relative error is at most
/// 1e-13. (ccx reads 20 characters and silently ignores the rest, exponents included.)
std::string ccx_number(double value) {
  constexpr int most_characters = 20;
  char text[40];
  const auto shortest = std::to_chars(text, text + sizeof text, value);
  if (shortest.ptr - text <= most_characters) return {text, shortest.ptr};
  for (int precision = 16;; --precision) {
    const auto rounded =
        std::to_chars(text, text + sizeof text, value, std::chars_format::general, precision);
    if (rounded.ptr - text <= most_characters) return {text, rounded.ptr};
  }
}

/// Formats a vector as "x,y,z".
std::string ccx_vector(const Vec3& v) {
  return ccx_number(v.x()) + "," + ccx_number(v.y()) + "," + ccx_number(v.z());
}

/// A text for a comment line: control characters such as line ends are replaced by blanks.
std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32) c = ' ';
  return text;
}

/// Writes node or element numbers, up to 16 per row. `ids` are 0-based; ccx numbers are 1-based.
void write_ccx_ids(std::ostream& out, std::span<const int> ids) {
  constexpr size_t most_a_row = 16;
  for (size_t i = 0; i < ids.size(); ++i)
    out << ids[i] + 1 << ((i + 1) % most_a_row == 0 || i + 1 == ids.size() ? '\n' : ',');
}

}  // namespace

// Elements and nodal forces of CalculiX decks.

/// Elements of one type, built on the nodes of six-node triangles and additional nodes if the type
/// needs them.
struct DeckDiscretization {
  std::vector<Vec3> positions;  ///< positions of the nodes; those of the triangles come first
  std::vector<std::vector<std::vector<int>>> by_region;  ///< nodes of each element, by face
  /// S8R: the node halfway between a triangle corner (first) and the midpoint of its edge (second).
  std::map<std::pair<int, int>, int> quarters;

  /// The end nodes of a curve's edges, then the nodes in between, each once.
  std::vector<int> nodes_on(const std::vector<std::array<int, 3>>& edges) const;
};
/// Builds the elements of a deck from six-node triangles.
DeckDiscretization deck_elements(const std::vector<const SkinnedRegion*>& regions,
                                 const ModelElements& model, ShellDeck::Element element);

/// Nodal loads equivalent to the area, line and point forces, by 0-based node index.
std::map<int, Vec3> deck_forces(const std::vector<const SkinnedRegion*>& regions,
                                const ModelElements& model, const ShellDeck& deck);

namespace {

// Splits each triangle into three quads between its corners, edge midpoints and centre.
class TriangleToQuads {
 public:
  explicit TriangleToQuads(DeckDiscretization& elements) : elements_(elements) {}

  void add_region(const SkinnedRegion& region, const QuadraticElements& facets,
                  const std::vector<int>& node) {
    surface_ = &region.surface;
    const TriangleLocator locator(surface_->mesh());
    locator_ = &locator;
    std::vector<std::vector<int>> quads;
    for (const auto& t : facets.triangles) {
      std::array<Vec2, 6> uv;
      for (int i = 0; i < 6; ++i)
        uv[i] = surface_->mesh().image_near(facets.uv[t[i]], facets.uv[t[0]]);
      // The map to (u, v) is quadratic, like the edges on curves.
      const auto at = [&](const Vec3& L) -> Vec2 {
        Vec2 p = Vec2::Zero();
        for (int i = 0; i < 3; ++i)
          p += L[i] * (2 * L[i] - 1) * uv[i] + 4 * L[i] * L[(i + 1) % 3] * uv[3 + i];
        return p;
      };
      const auto middle = [&](int i) -> Vec3 {  // midpoint of the edge that starts at corner i
        return 0.5 * (Vec3::Unit(i) + Vec3::Unit((i + 1) % 3));
      };
      const Vec3 centre = Vec3::Constant(1.0 / 3);
      const int at_centre = added(at(centre));
      std::array<int, 3> spoke;  // halfway between the centre and an edge midpoint
      for (int i = 0; i < 3; ++i) spoke[i] = added(at(0.5 * (centre + middle(i))));
      for (int i = 0; i < 3; ++i) {
        const int before = (i + 2) % 3;  // the edge that ends at corner i
        const int corner = node[t[i]], next = node[t[3 + i]], last = node[t[3 + before]];
        quads.push_back({corner, next, at_centre, last,
                         quarter(corner, next, at(0.5 * (Vec3::Unit(i) + middle(i)))), spoke[i],
                         spoke[before],
                         quarter(corner, last, at(0.5 * (Vec3::Unit(i) + middle(before))))});
      }
    }
    elements_.by_region.push_back(std::move(quads));
  }

 private:
  int added(const Vec2& uv) {
    elements_.positions.push_back(
        surface_->position(locator_->locate(surface_->mesh().wrapped(uv))));
    return static_cast<int>(elements_.positions.size()) - 1;
  }
  // Shared by both triangles, and both faces, of an edge.
  int quarter(int corner, int middle, const Vec2& uv) {
    const auto known = elements_.quarters.find({corner, middle});
    if (known != elements_.quarters.end()) return known->second;
    return elements_.quarters[{corner, middle}] = added(uv);
  }

  DeckDiscretization& elements_;
  const Surface* surface_ = nullptr;
  const TriangleLocator* locator_ = nullptr;
};

}  // namespace

std::vector<int> DeckDiscretization::nodes_on(const std::vector<std::array<int, 3>>& edges) const {
  std::vector<int> nodes;
  const auto add = [&](int node) {
    if (std::find(nodes.begin(), nodes.end(), node) == nodes.end()) nodes.push_back(node);
  };
  for (const auto& edge : edges) {
    add(edge[0]);
    add(edge[1]);
  }
  for (const auto& edge : edges) {
    add(edge[2]);
    for (const int end : {edge[0], edge[1]}) {
      const auto between = quarters.find({end, edge[2]});
      if (between != quarters.end()) add(between->second);
    }
  }
  return nodes;
}

DeckDiscretization deck_elements(const std::vector<const SkinnedRegion*>& regions,
                                 const ModelElements& model, ShellDeck::Element element) {
  DeckDiscretization elements;
  elements.positions = model.positions;
  TriangleToQuads quads(elements);
  for (size_t r = 0; r < regions.size(); ++r) {
    if (element == ShellDeck::Element::S8R) {
      quads.add_region(*regions[r], model.regions[r], model.node[r]);
      continue;
    }
    std::vector<std::vector<int>> all;
    for (const auto& t : model.regions[r].triangles) {
      std::vector<int> n;
      for (const int i : t) n.push_back(model.node[r][i]);
      if (element == ShellDeck::Element::S6) {
        all.push_back(n);
      } else {
        for (int i = 0; i < 3; ++i) all.push_back({n[i], n[3 + i], n[3 + (i + 2) % 3]});
        all.push_back({n[3], n[4], n[5]});
      }
    }
    elements.by_region.push_back(std::move(all));
  }
  return elements;
}

namespace {

// Consistent nodal loads ∬ N f dA, with quadratic shape functions N and the area element dA of the
// true surface.
template <class Force>
Points area_forces(const Surface& surface, const QuadraticElements& facets, const Force& f) {
  static const TriangleRule split = split_triangle_rule(6), whole = symmetric_triangle_rule(8);
  const TriangleRule& rule = facets.is_element_mesh ? split : whole;
  std::optional<TriangleLocator> locator;
  if (!facets.is_element_mesh) locator.emplace(surface.mesh());
  Points forces = Points::Zero(static_cast<long>(facets.nodes.size()), 3);
  for (size_t t = 0; t < facets.triangles.size(); ++t) {
    const auto& n = facets.triangles[t];
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Vec3 L = rule.L.row(p).transpose();
      const double N[6] = {L[0] * (2 * L[0] - 1), L[1] * (2 * L[1] - 1), L[2] * (2 * L[2] - 1),
                           4 * L[0] * L[1],       4 * L[1] * L[2],       4 * L[2] * L[0]};
      Location where{static_cast<int>(t), L};
      double parametric;
      if (locator) {
        // The map of the element to (u, v) is quadratic as well.
        // Derivatives along L0 - L2, L1 - L2.
        Vec2 at = Vec2::Zero(), d0 = Vec2::Zero(), d1 = Vec2::Zero();
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
      const SurfaceJet jet = surface.jet(where);
      const Vec3 area = rule.weights[p] * parametric * jet.area_vector();
      if (!(area.norm() > 0)) continue;
      const Vec3 force = area.norm() * f(jet.x, area.normalized());
      for (int a = 0; a < 6; ++a) forces.row(n[a]) += N[a] * force.transpose();
    }
  }
  return forces;
}

// Adds a line force, integrated along the parabolic edges of the curve.
void add_line_force(const ModelElements& model, const ShellDeck::LineForce& force,
                    const std::function<Vec3&(int)>& at) {
  constexpr int points = 4;
  static const SegmentRule rule = gauss_legendre(points);
  for (const auto& line : model.lines) {
    if (line.name != force.line) continue;
    for (const auto& [a, b, m] : line.edges)
      for (int p = 0; p < points; ++p) {
        const double s = rule.s[p];
        const double N[3] = {(1 - s) * (1 - 2 * s), s * (2 * s - 1), 4 * s * (1 - s)},
                     d[3] = {4 * s - 3, 4 * s - 1, 4 - 8 * s};
        Vec3 x = Vec3::Zero(), along = Vec3::Zero();
        for (int k = 0; k < 3; ++k) {
          const Vec3& place = model.positions[k == 0 ? a : k == 1 ? b : m];
          x += N[k] * place;
          along += d[k] * place;
        }
        if (force.box && !force.box->contains(x)) continue;
        const Vec3 f = rule.weights[p] * along.norm() * force.per_length;
        at(a) += N[0] * f;
        at(b) += N[1] * f;
        at(m) += N[2] * f;
      }
  }
}

}  // namespace

std::map<int, Vec3> deck_forces(const std::vector<const SkinnedRegion*>& regions,
                                const ModelElements& model, const ShellDeck& deck) {
  std::map<int, Vec3> force;
  const auto at = [&](int node) -> Vec3& {
    return force.try_emplace(node, Vec3::Zero()).first->second;
  };
  for (size_t r = 0; r < regions.size() && deck.area_force; ++r) {
    const Points forces = area_forces(
        regions[r]->surface, model.regions[r],
        [&](const Vec3& x, const Vec3& n) { return deck.area_force(regions[r]->name, x, n); });
    // At the vertices of flat triangles the integral vanishes; drop the rounding error.
    const double rounding = 1e-14 * forces.cwiseAbs().maxCoeff();
    for (long i = 0; i < forces.rows(); ++i)
      if (forces.row(i).cwiseAbs().maxCoeff() > rounding)
        at(model.node[r][i]) += forces.row(i).transpose();
  }
  for (const auto& f : deck.line_forces) add_line_force(model, f, at);
  for (const auto& f : deck.point_forces) {
    const auto nearest = std::min_element(
        model.positions.begin(), model.positions.end(), [&](const Vec3& a, const Vec3& b) {
          return (a - f.at).squaredNorm() < (b - f.at).squaredNorm();
        });
    at(static_cast<int>(nearest - model.positions.begin())) += f.force;
  }
  return force;
}

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
  expect(above_zero(deck.young), "Young's modulus", deck.young, "a number above 0");
  expect(deck.poisson > -1 && deck.poisson < 0.5, "Poisson's ratio", deck.poisson,
         "a number between -1 and 0.5");
  expect(std::isfinite(deck.density) && deck.density >= 0, "density", deck.density,
         "a number of at least 0");
  expect(deck.gravity.isZero(0) || deck.density > 0, "gravity and a density of", deck.density,
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
  if (deck.supports.empty()) throw InputError(who + "found no support, expected at least one");
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
  for (const auto& f : deck.line_forces) expect_line(f.line, "force");
  for (const auto& p : deck.pressures) expect_region(p.region, "pressure");
  for (const auto& t : deck.thicknesses) expect_region(t.region, "thickness");
}

/// If an element has several pressures, ccx uses the last one only, so write their sum.
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

/// The nodes of a support that does not cover a whole curve.
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
    throw InputError("stress deck: found a support without nodes, expected a larger box");
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

// Temperature and its gradient through the thickness at each node.
void write_temperatures(std::ostream& out, const std::vector<Vec3>& positions,
                        const ShellDeck& deck) {
  out << "*TEMPERATURE\n";
  for (size_t i = 0; i < positions.size(); ++i) {
    const auto [middle, difference] = deck.temperature(positions[i]);
    out << i + 1 << ',' << ccx_number(middle) << ',' << ccx_number(difference / deck.thickness)
        << '\n';
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
  for (const auto& line : model.lines) line_sets.push_back(names.of(line.name, "CURVE_"));
  for (const SkinnedRegion* region : regions)
    region_sets.push_back(one ? "ALL" : names.of(region->name, "FACE_"));
  write_file_atomically(path, [&](std::ostream& out) {
    out << "** "
        << (one ? "Face " + one_line(regions[0]->name)
                : "Model of " + std::to_string(regions.size()) + " faces")
        << ", written by Batten\n";
    if (!deck.units.empty()) out << "** Units: " << one_line(deck.units) << '\n';
    out << "*NODE,NSET=NALL\n";
    for (size_t i = 0; i < elements.positions.size(); ++i)
      out << i + 1 << ',' << ccx_vector(elements.positions[i]) << '\n';
    out << "*ELEMENT,TYPE=" << type_name(deck.element) << ",ELSET=ALL\n";
    std::vector<size_t> first{1};  // first element number of each face, and one past the last
    for (const auto& of_region : elements.by_region) {
      for (size_t e = 0; e < of_region.size(); ++e) {
        out << first.back() + e << ',';
        write_ccx_ids(out, of_region[e]);
      }
      first.push_back(first.back() + of_region.size());
    }
    for (size_t r = 0; r < regions.size() && !one; ++r)
      out << "** Face " << one_line(regions[r]->name) << "\n*ELSET,ELSET=" << region_sets[r]
          << ",GENERATE\n"
          << first[r] << ',' << first[r + 1] - 1 << ",1\n";
    for (size_t l = 0; l < model.lines.size(); ++l) {
      out << "** Curve " << one_line(model.lines[l].name) << "\n*NSET,NSET=" << line_sets[l]
          << '\n';
      write_ccx_ids(out, elements.nodes_on(model.lines[l].edges));
    }
    out << "*MATERIAL,NAME=SHELL\n*ELASTIC\n"
        << ccx_number(deck.young) << ',' << ccx_number(deck.poisson) << '\n';
    if (deck.density > 0) out << "*DENSITY\n" << ccx_number(deck.density) << '\n';
    if (deck.temperature)
      out << "*EXPANSION\n"
          << ccx_number(deck.expansion) << "\n*INITIAL CONDITIONS,TYPE=TEMPERATURE\nNALL,0.\n";
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
    if (deck.temperature) write_temperatures(out, elements.positions, deck);
    out << "*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n";
  });
}

// Decks of natural frequencies.

namespace {

void expect(bool good, const std::string& found, const std::string& expected) {
  if (!good) throw InputError("modal deck: found " + found + ", expected " + expected);
}

void check(const ShellMesh& mesh, const ModalDeck& modes) {
  const auto above_zero = [](const std::string& what, double x) {
    expect(std::isfinite(x) && x > 0, what + " " + format_number(x), "a number above 0");
  };
  above_zero("thickness", modes.thickness);
  above_zero("Young's modulus", modes.young);
  above_zero("density", modes.density);
  expect(modes.poisson > -1 && modes.poisson < 0.5,
         "Poisson's ratio " + format_number(modes.poisson), "a number between -1 and 0.5");
  expect(modes.count > 0, std::to_string(modes.count) + " requested frequencies", "1 or more");
  const auto in_range = [&](int node) { return node >= 0 && node < mesh.node_count(); };
  const std::string range = "nodes from 0 to " + std::to_string(mesh.node_count() - 1);
  for (const int node : modes.clamped)
    expect(in_range(node), "clamped node " + std::to_string(node), range);
  for (int f = 0; f < mesh.face_count(); ++f) {
    const std::string name = "face " + std::to_string(f) + " (counted from 0)";
    const size_t corners = mesh.corners(f).size();
    expect(corners == 3 || corners == 4, name + " of " + std::to_string(corners) + " corners",
           "triangles and quads");
    for (const int node : mesh.face(f)) {
      expect(in_range(node), "node " + std::to_string(node) + " in " + name, range);
      expect(mesh.points.row(node).allFinite(),
             "a coordinate of node " + std::to_string(node) + " that is not finite",
             "finite coordinates");
    }
  }
}

/// The nodes and elements of the deck.
class Elements {
 public:
  Elements(const ShellMesh& mesh, const ModalDeck& modes) : points_(mesh.points) {
    // Collect existing mid-side nodes first, because adjacent linear faces must use them too.
    for (int f = 0; f < mesh.face_count(); ++f) {
      const auto nodes = mesh.face(f);
      const size_t k = nodes.size() / 2;
      for (size_t i = 0; mesh.second_order(f) && i < k; ++i)
        middle_[std::minmax({nodes[i], nodes[(i + 1) % k]})] = nodes[k + i];
    }
    for (int f = 0; f < mesh.face_count(); ++f) {
      std::vector<int> nodes{mesh.face(f).begin(), mesh.face(f).end()};
      if (!mesh.second_order(f)) {
        drop_repeated(nodes);
        if (nodes.size() < 3) continue;
        if (modes.elements == ModalDeck::Elements::Quadratic) add_middles(nodes);
      }
      by_type_[nodes.size()].push_back({f, nodes});
    }
    for (const auto& [size, list] : by_type_)
      for (const auto& element : list)
        used_.insert(used_.end(), element.nodes.begin(), element.nodes.end());
    std::sort(used_.begin(), used_.end());
    used_.erase(std::unique(used_.begin(), used_.end()), used_.end());
    expect(!used_.empty(), "no faces", "triangles or quads");
    find_clamped(modes.clamped);
  }

  void write(std::ostream& out) const {
    static const std::map<size_t, const char*> types{{3, "S3"}, {4, "S4"}, {6, "S6"}, {8, "S8R"}};
    out << "*NODE,NSET=NALL\n";
    for (const int v : used_) out << v + 1 << ',' << ccx_vector(point(v)) << '\n';
    for (const auto& [size, list] : by_type_) {
      out << "*ELEMENT,TYPE=" << types.at(size) << ",ELSET=ALL\n";
      for (const auto& element : list) {
        out << element.face + 1 << ',';
        write_ccx_ids(out, element.nodes);
      }
    }
  }

  const std::vector<int>& clamped() const { return clamped_; }

  /// Number of rigid-body modes: six for each connected component without a clamped node.
  int rigid_body_modes() const {
    DisjointSets pieces(static_cast<size_t>(node_count()));
    for (const auto& [size, list] : by_type_)
      for (const auto& element : list)
        for (const int v : element.nodes) pieces.unite(v, element.nodes[0]);
    std::vector<char> constrained(static_cast<size_t>(node_count()), 0);
    for (const int v : clamped_) constrained[pieces.find(v)] = 1;
    return 6 * static_cast<int>(std::count_if(used_.begin(), used_.end(), [&](int v) {
             return pieces.find(v) == v && !constrained[v];
           }));
  }

 private:
  struct Element {
    int face;
    std::vector<int> nodes;
  };

  static void drop_repeated(std::vector<int>& nodes) {
    std::vector<int> kept;
    for (const int v : nodes)
      if (std::find(kept.begin(), kept.end(), v) == kept.end()) kept.push_back(v);
    nodes = kept;
  }

  int node_count() const { return static_cast<int>(points_.rows() + added_.size()); }
  Vec3 point(int v) const {
    return v < points_.rows() ? Vec3(points_.row(v).transpose()) : added_[v - points_.rows()];
  }

  void add_middles(std::vector<int>& nodes) {
    const size_t k = nodes.size();
    for (size_t i = 0; i < k; ++i) {
      const int a = nodes[i], b = nodes[(i + 1) % k];
      const auto [found, fresh] = middle_.try_emplace(std::minmax({a, b}), node_count());
      if (fresh) added_.push_back((point(a) + point(b)) / 2);
      nodes.push_back(found->second);
    }
  }

  void find_clamped(const std::vector<int>& wanted) {
    std::vector<char> constrained(static_cast<size_t>(node_count()), 0);
    for (const int v : wanted) constrained[v] = 1;
    for (const auto& [ends, v] : middle_)
      if (v >= points_.rows() && constrained[ends.first] && constrained[ends.second])
        constrained[v] = 1;
    std::copy_if(used_.begin(), used_.end(), std::back_inserter(clamped_),
                 [&](int v) { return constrained[v]; });
  }

  const Points& points_;
  std::vector<Vec3> added_;
  // Mid-side node of each edge (lower node, higher node).
  std::map<std::pair<int, int>, int> middle_;
  std::map<size_t, std::vector<Element>> by_type_;  // by number of nodes
  std::vector<int> used_, clamped_;
};

}  // namespace

void write_modal_deck(const fs::path& path, const ShellMesh& mesh, const ModalDeck& modes) {
  check(mesh, modes);
  const Elements elements(mesh, modes);
  const int rigid = elements.rigid_body_modes();
  write_file_atomically(path, [&](std::ostream& out) {
    out << "** Natural frequencies of a shell, written by Batten\n";
    if (!modes.units.empty()) out << "** Units: " << one_line(modes.units) << '\n';
    out << "** Rigid-body modes: " << rigid << '\n';
    elements.write(out);
    out << "*MATERIAL,NAME=SHELL\n*ELASTIC\n"
        << ccx_number(modes.young) << ',' << ccx_number(modes.poisson) << "\n*DENSITY\n"
        << ccx_number(modes.density) << "\n*SHELL SECTION,ELSET=ALL,MATERIAL=SHELL\n"
        << ccx_number(modes.thickness) << '\n';
    if (!elements.clamped().empty()) {
      out << "*NSET,NSET=CLAMPED\n";
      write_ccx_ids(out, elements.clamped());
      out << "*BOUNDARY\nCLAMPED,1,6\n";
    }
    out << "*STEP\n*FREQUENCY\n" << modes.count + rigid << "\n*NODE FILE,OUTPUT=2D\nU\n*END STEP\n";
  });
}

}  // namespace batten
