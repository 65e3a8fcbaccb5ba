#include "batten/mesh/prepare.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/index.h"

namespace batten {
namespace {

constexpr size_t kListed = 8;
constexpr double kFlat = 1e-12;  // height over longest edge: below, a triangle has no area

std::string counted(int count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// The corners of a face with each run of equal nodes as one.
std::vector<int> distinct(std::span<const int> corners) {
  std::vector<int> kept;
  for (const int v : corners)
    if (kept.empty() || kept.back() != v) kept.push_back(v);
  while (kept.size() > 1 && kept.front() == kept.back()) kept.pop_back();
  return kept;
}

bool simple(std::vector<int> corners) {
  std::sort(corners.begin(), corners.end());
  return corners.size() >= 3 && std::adjacent_find(corners.begin(), corners.end()) == corners.end();
}

/// Faces into triangles.
class Splitter {
 public:
  explicit Splitter(const Points& points) : points_(points) {}

  void split(std::span<const int> face, bool second_order, std::vector<std::array<int, 3>>& out) {
    if (second_order) {
      const size_t n = face.size() / 2;
      const auto middle = [&](size_t i) { return face[n + i % n]; };
      for (size_t i = 0; i < n; ++i) out.push_back({face[i], middle(i), middle(i + n - 1)});
      std::vector<int> inner;
      for (size_t i = 0; i < n; ++i) inner.push_back(middle(i));
      split_polygon(inner, out);
      return;
    }
    split_polygon(distinct(face), out);
  }

 private:
  double quality(int a, int b, int c) const {
    const Vec3 p = points_.row(a), q = points_.row(b), r = points_.row(c);
    const double longest =
        std::max({(q - p).squaredNorm(), (r - q).squaredNorm(), (p - r).squaredNorm()});
    return longest > 0 ? (q - p).cross(r - p).norm() / longest : 0;
  }

  void split_polygon(const std::vector<int>& v, std::vector<std::array<int, 3>>& out) const {
    const size_t n = v.size();
    if (n == 3) {
      out.push_back({v[0], v[1], v[2]});
      return;
    }
    if (n == 4) {
      const auto length = [&](int i, int j) {
        return (points_.row(v[i]) - points_.row(v[j])).squaredNorm();
      };
      if (length(0, 2) <= length(1, 3)) {
        out.push_back({v[0], v[1], v[2]});
        out.push_back({v[0], v[2], v[3]});
      } else {
        out.push_back({v[0], v[1], v[3]});
        out.push_back({v[1], v[2], v[3]});
      }
      return;
    }
    constexpr size_t most_sides = 10'000;
    if (n > most_sides)
      throw InputError("found a face of " + std::to_string(n) + " corners, expected at most " +
                       std::to_string(most_sides));
    // Cut off the best ear against the polygon's own normal, again and again: O(n²).
    Vec3 normal = Vec3::Zero();
    const Vec3 origin = points_.row(v[0]);
    for (size_t i = 1; i + 1 < n; ++i)
      normal += (points_.row(v[i]).transpose() - origin)
                    .cross(points_.row(v[i + 1]).transpose() - origin);
    std::vector<Ear> left(n);
    for (size_t i = 0; i < n; ++i) left[i].corner = v[i];
    for (size_t i = 0; i < n; ++i) measure(left, i, normal);
    while (left.size() > 3) {
      const size_t count = left.size();
      const size_t best = static_cast<size_t>(
          std::max_element(left.begin(), left.end(),
                           [](const Ear& x, const Ear& y) { return x.score < y.score; }) -
          left.begin());
      const int gone = left[best].corner;
      out.push_back(
          {left[(best + count - 1) % count].corner, gone, left[(best + 1) % count].corner});
      left.erase(left.begin() + static_cast<long>(best));
      const size_t next = best % left.size(), before = (next + left.size() - 1) % left.size();
      for (size_t i = 0; i < left.size(); ++i)
        if (i == next || i == before || left[i].held == gone) measure(left, i, normal);
    }
    out.push_back({left[0].corner, left[1].corner, left[2].corner});
  }

  // A corner of what is left of a polygon, as the tip of a triangle that may be cut off.
  struct Ear {
    int corner;
    double score = 0;
    int held = -1;  // a corner inside of it: it becomes better when that one is gone
  };

  void measure(std::vector<Ear>& left, size_t i, const Vec3& normal) const {
    const size_t n = left.size();
    const int a = left[(i + n - 1) % n].corner, b = left[i].corner, c = left[(i + 1) % n].corner;
    const Vec3 p = points_.row(a), q = points_.row(b), r = points_.row(c);
    const bool outwards = (q - p).cross(r - p).dot(normal) <= 0;
    left[i].held = outwards ? -1 : held_corner(left, i, normal);
    left[i].score = quality(a, b, c) - (outwards || left[i].held >= 0 ? 10 : 0);
  }

  int held_corner(const std::vector<Ear>& left, size_t i, const Vec3& normal) const {
    const size_t n = left.size();
    const Vec3 corner[3] = {points_.row(left[(i + n - 1) % n].corner), points_.row(left[i].corner),
                            points_.row(left[(i + 1) % n].corner)};
    for (size_t k = 0; k < n; ++k) {
      if (k == i || k == (i + 1) % n || k == (i + n - 1) % n) continue;
      const Vec3 p = points_.row(left[k].corner);
      bool inside = true;
      for (int e = 0; e < 3; ++e)
        inside = inside && (corner[(e + 1) % 3] - corner[e]).cross(p - corner[e]).dot(normal) >= 0;
      if (inside) return left[k].corner;
    }
    return -1;
  }

  const Points& points_;
};

/// The triangles that are left after repairs, and what was found on the way.
struct Work {
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> face_of;
  MeshDiagnosis found;
};

template <class T>
void note(std::vector<T>& list, const T& item) {
  if (list.size() < kListed) list.push_back(item);
}

/// The triangle across an edge.
struct Link {
  int other;
  bool turned;  ///< it runs through the edge in the same direction
};
using Links = std::vector<std::vector<Link>>;  // of each triangle

/// Who lies across which edge; boundary and non-manifold edges are counted.
Links find_links(Work& work) {
  struct Side {
    std::array<int, 2> edge;
    int triangle;
    bool forward;
  };
  std::vector<Side> sides;
  for (int t = 0; t < count_of(work.triangles); ++t)
    for (int c = 0; c < 3; ++c) {
      const int a = work.triangles[t][c], b = work.triangles[t][(c + 1) % 3];
      sides.push_back({{std::min(a, b), std::max(a, b)}, t, a < b});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
    return std::pair(x.edge, x.triangle) < std::pair(y.edge, y.triangle);
  });
  Links links(work.triangles.size());
  MeshDiagnosis& found = work.found;
  for (size_t i = 0; i < sides.size();) {
    size_t end = i + 1;
    while (end < sides.size() && sides[end].edge == sides[i].edge) ++end;
    if (end - i == 2) {
      const bool turned = sides[i].forward == sides[i + 1].forward;
      links[sides[i].triangle].push_back({sides[i + 1].triangle, turned});
      links[sides[i + 1].triangle].push_back({sides[i].triangle, turned});
    }
    if (end - i > 2) {
      ++found.non_manifold_edge_count;
      note(found.non_manifold_edges, sides[i].edge);
    }
    i = end;
  }
  return links;
}

/// Faces turned so that neighbours run through their common edge in opposite directions.
void orient(Work& work, const Links& links) {
  MeshDiagnosis& found = work.found;
  std::vector<int> turn(work.triangles.size(), -1), stack;
  for (size_t seed = 0; seed < turn.size(); ++seed) {
    if (turn[seed] >= 0) continue;
    ++found.components;
    turn[seed] = 0;
    stack.push_back(static_cast<int>(seed));
    while (!stack.empty()) {
      const int t = stack.back();
      stack.pop_back();
      for (const Link& link : links[t]) {
        const int wanted = turn[t] ^ static_cast<int>(link.turned);
        if (turn[link.other] < 0) {
          turn[link.other] = wanted;
          stack.push_back(link.other);
        } else if (turn[link.other] != wanted) {
          found.orientable = false;
        }
      }
    }
  }
  std::vector<char> face_turned(
      work.face_of.empty() ? 0 : *std::max_element(work.face_of.begin(), work.face_of.end()) + 1,
      0);
  for (size_t t = 0; t < turn.size(); ++t)
    if (turn[t] == 1) {
      std::swap(work.triangles[t][1], work.triangles[t][2]);
      face_turned[work.face_of[t]] = 1;
    }
  found.turned_faces = static_cast<int>(std::count(face_turned.begin(), face_turned.end(), 1));
}

/// Whether two linked triangles x and y have a common edge that ends at v.
bool share_edge_at(int v, const std::array<int, 3>& x, const std::array<int, 3>& y) {
  const auto in_y = [&](int w) { return std::find(y.begin(), y.end(), w) != y.end(); };
  return in_y(v) && std::any_of(x.begin(), x.end(), [&](int w) { return w != v && in_y(w); });
}

/// Fans: triangles around a vertex that are linked by edges at it. Vertices with several are noted.
void count_fans(Work& work, const Links& links, int node_count) {
  std::vector<std::vector<int>> around(node_count);
  for (int t = 0; t < count_of(work.triangles); ++t)
    for (const int v : work.triangles[t]) around[v].push_back(t);
  std::vector<int> stack;
  std::vector<char> seen(work.triangles.size(), 0);
  for (int v = 0; v < node_count; ++v) {
    int fans = 0;
    for (const int seed : around[v]) {
      if (seen[seed]) continue;
      ++fans;
      seen[seed] = 1;
      stack.push_back(seed);
      while (!stack.empty()) {
        const int t = stack.back();
        stack.pop_back();
        for (const Link& link : links[t]) {
          if (seen[link.other] || !share_edge_at(v, work.triangles[t], work.triangles[link.other]))
            continue;
          seen[link.other] = 1;
          stack.push_back(link.other);
        }
      }
    }
    for (const int t : around[v]) seen[t] = 0;
    if (fans > 1) {
      ++work.found.non_manifold_vertex_count;
      note(work.found.non_manifold_vertices, v);
    }
  }
}

/// Throws InputError for indices out of range; notes nodes of no face, and bad ones.
void look_at_nodes(const ShellMesh& shells, MeshDiagnosis& found) {
  const int n = shells.node_count();
  std::vector<char> used(n, 0);
  for (int f = 0; f < shells.face_count(); ++f)
    for (const int v : shells.face(f)) {
      if (v < 0 || v >= n)
        throw InputError("face " + std::to_string(f) + " names node " + std::to_string(v) + " of " +
                         std::to_string(n));
      used[v] = 1;
    }
  found.unused_nodes = static_cast<int>(std::count(used.begin(), used.end(), 0));
  for (int v = 0; v < n; ++v)
    if (used[v] && !shells.points.row(v).allFinite()) note(found.bad_nodes, v);
  if (!found.bad_nodes.empty()) return;
  std::vector<std::array<double, 4>> places;
  for (int v = 0; v < n; ++v)
    if (used[v])
      places.push_back({shells.points(v, 0), shells.points(v, 1), shells.points(v, 2), 1.0 * v});
  std::sort(places.begin(), places.end());
  for (size_t i = 1; i < places.size(); ++i)
    found.coincident_nodes +=
        std::equal(places[i].begin(), places[i].begin() + 3, places[i - 1].begin());
}

/// Which faces are collapsed, or have the nodes of an earlier one.
std::vector<char> faces_to_drop(const ShellMesh& shells, MeshDiagnosis& found) {
  std::vector<char> dropped(shells.face_count(), 0);
  std::vector<std::pair<std::vector<int>, int>> keys;
  for (int f = 0; f < shells.face_count(); ++f) {
    if (!simple(distinct(shells.corners(f)))) {
      dropped[f] = 1;
      ++found.collapsed_faces;
    }
    std::vector<int> key(shells.corners(f).begin(), shells.corners(f).end());
    std::sort(key.begin(), key.end());
    key.erase(std::unique(key.begin(), key.end()), key.end());
    keys.emplace_back(std::move(key), f);
  }
  std::sort(keys.begin(), keys.end());
  for (size_t i = 1; i < keys.size(); ++i)
    if (keys[i].first == keys[i - 1].first && !dropped[keys[i].second]) {
      dropped[keys[i].second] = 1;
      ++found.duplicate_faces;
    }
  return dropped;
}

/// Whether a triangle is too flat to have an area.
bool has_no_area(const Points& points, const std::array<int, 3>& t) {
  const Vec3 p = points.row(t[0]), q = points.row(t[1]), r = points.row(t[2]);
  const double longest =
      std::max({(q - p).squaredNorm(), (r - q).squaredNorm(), (p - r).squaredNorm()});
  return !((q - p).cross(r - p).norm() > kFlat * longest);
}

Work examine(const ShellMesh& shells) {
  Work work;
  MeshDiagnosis& found = work.found;
  look_at_nodes(shells, found);
  if (!found.bad_nodes.empty()) return work;
  const std::vector<char> dropped = faces_to_drop(shells, found);
  Splitter splitter(shells.points);
  for (int f = 0; f < shells.face_count(); ++f) {
    if (dropped[f]) continue;
    // A second-order element that lost a corner or a middle node is taken by its corners.
    const std::vector<int> all(shells.face(f).begin(), shells.face(f).end());
    const bool second = shells.second_order(f) && simple(all);
    splitter.split(second ? shells.face(f) : shells.corners(f), second, work.triangles);
    work.face_of.resize(work.triangles.size(), f);
  }
  for (const auto& t : work.triangles) found.zero_area_triangles += has_no_area(shells.points, t);
  const Links links = find_links(work);
  orient(work, links);
  count_fans(work, links, shells.node_count());
  return work;
}

}  // namespace

MeshDiagnosis diagnose(const ShellMesh& shells) { return examine(shells).found; }

PreparedMesh prepare(const ShellMesh& shells, const std::function<std::string(int)>& node_name) {
  const auto name = [&](int v) { return node_name ? node_name(v) : std::to_string(v); };
  Work work = examine(shells);
  const MeshDiagnosis& d = work.found;
  if (shells.face_count() == 0) throw InputError("found no faces, expected a surface mesh");
  if (!d.bad_nodes.empty())
    throw InputError("node " + name(d.bad_nodes[0]) + " has a coordinate that is not finite");
  if (work.triangles.empty())
    throw InputError("all " + counted(shells.face_count(), "face") +
                     " have fewer than three different corners");
  if (d.non_manifold_edge_count > 0) {
    const auto& [a, b] = d.non_manifold_edges[0];
    throw InputError("found " + counted(d.non_manifold_edge_count, "edge") +
                     " of more than two faces (the first between nodes " + name(a) + " and " +
                     name(b) + "), expected a manifold surface");
  }
  if (!d.orientable)
    throw InputError("the mesh cannot be oriented, it has one side only (as a Möbius strip)");
  if (d.non_manifold_vertex_count > 0)
    throw InputError("found " + counted(d.non_manifold_vertex_count, "node") +
                     " where parts of the mesh touch without a common edge (the first is node " +
                     name(d.non_manifold_vertices[0]) + "), expected a manifold surface");
  if (d.zero_area_triangles > 0) {
    const auto& t = *std::find_if(work.triangles.begin(), work.triangles.end(),
                                  [&](const auto& x) { return has_no_area(shells.points, x); });
    throw InputError("found " + counted(d.zero_area_triangles, "triangle") +
                     " without area (the first has nodes " + name(t[0]) + ", " + name(t[1]) + ", " +
                     name(t[2]) + ")");
  }

  std::vector<std::string> notes;
  const auto say = [&](int count, const std::string& noun, const std::string& what) {
    if (count > 0) notes.push_back(counted(count, noun) + " " + what);
  };
  say(d.collapsed_faces, "face", "with fewer than three different corners left out");
  say(d.duplicate_faces, "face", "with the nodes of another face left out");
  say(d.turned_faces, "face", "turned to run as the neighbours do (in the computation only)");
  say(d.unused_nodes, "node", "of no face");
  say(d.coincident_nodes, "node", "at the place of another one: the surface is open there");
  if (d.components > 1) notes.push_back("the mesh has " + std::to_string(d.components) + " parts");
  TriangleMesh mesh(shells.points, std::move(work.triangles));
  return {std::move(mesh), std::move(work.face_of), d, std::move(notes)};
}

}  // namespace batten
