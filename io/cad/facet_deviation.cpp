#include "batten/io/cad/facet_deviation.h"
#include "batten/io/cad/occ_values.h"

#include <BRep_Tool.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace batten {
namespace {

/// A surface within its own range of parameters.
struct Sheet {
  Handle(Geom_Surface) surface;
  double u0 = 0, u1 = 0, v0 = 0, v1 = 0;

  explicit Sheet(const TopoDS_Face& face) : surface(BRep_Tool::Surface(face)) {
    if (!surface.IsNull()) surface->Bounds(u0, u1, v0, v1);
  }

  /// Of unit length; zero where the surface is singular.
  Vec3 normal(const Vec2& uv) const {
    gp_Pnt at;
    gp_Vec du, dv;
    surface->D1(uv[0], uv[1], at, du, dv);
    return from_occ(du.XYZ()).cross(from_occ(dv.XYZ())).normalized();
  }

  /// Distance from `p` to the surface near (u, v): Gauss-Newton steps, shorter and steeper ones
  /// where they lead away (the parameters of many CAD surfaces are far from even).
  double distance(Vec2 uv, const Vec3& p) const {
    gp_Pnt at;
    gp_Vec du, dv;
    surface->D1(uv[0], uv[1], at, du, dv);
    double best = (p - from_occ(at.XYZ())).norm(), damping = 0;
    for (int step = 0; step < 30; ++step) {
      const Vec3 miss = p - from_occ(at.XYZ()), a = from_occ(du.XYZ()), b = from_occ(dv.XYZ());
      Mat2 I;
      I << a.dot(a), a.dot(b), a.dot(b), b.dot(b);
      I.diagonal() *= 1 + damping;
      if (!(I.determinant() > 1e-20 * I.trace() * I.trace()))
        I.diagonal().array() += 1e-8 * I.trace();
      if (!(I.determinant() > 0)) return best;
      const Vec2 move = I.inverse() * Vec2(a.dot(miss), b.dot(miss));
      const Vec2 next(std::clamp(uv[0] + move[0], u0, u1), std::clamp(uv[1] + move[1], v0, v1));
      gp_Pnt there;
      gp_Vec there_u, there_v;
      surface->D1(next[0], next[1], there, there_u, there_v);
      const double distance = (p - from_occ(there.XYZ())).norm();
      if (distance < best) {
        const bool settled = distance > best * (1 - 1e-3);
        best = distance;
        uv = next;
        at = there;
        du = there_u;
        dv = there_v;
        damping /= 10;
        if (settled) return best;
      } else if (damping < 1e4 && next != uv) {
        damping = std::max(10 * damping, 1e-2);
      } else {
        return best;
      }
    }
    return best;
  }
};

/// The corners of a triangle.
struct Facet {
  std::array<Vec3, 3> point;
  std::array<Vec2, 3> uv;

  Facet(const Poly_Triangulation& mesh, int t, const std::vector<Vec3>& at) {
    std::array<int, 3> n{};
    mesh.Triangle(t).Get(n[0], n[1], n[2]);
    for (size_t c = 0; c < 3; ++c) {
      point[c] = at[static_cast<size_t>(n[c]) - 1];
      uv[c].setZero();
      if (mesh.HasUVNodes()) uv[c] = {mesh.UVNode(n[c]).X(), mesh.UVNode(n[c]).Y()};
    }
  }
};

/// Barycentric coordinates of the points that are looked at.
constexpr std::array<std::array<double, 3>, 7> kPoints = {{{1 / 3.0, 1 / 3.0, 1 / 3.0},
                                                           {0.5, 0.5, 0},
                                                           {0, 0.5, 0.5},
                                                           {0.5, 0, 0.5},
                                                           {2 / 3.0, 1 / 6.0, 1 / 6.0},
                                                           {1 / 6.0, 2 / 3.0, 1 / 6.0},
                                                           {1 / 6.0, 1 / 6.0, 2 / 3.0}}};

}  // namespace

std::vector<PnTriangle::Corners> corner_normals(const TopoDS_Face& face,
                                                const Poly_Triangulation& mesh,
                                                const std::vector<Vec3>& at) {
  constexpr double inwards = 1e-6;  // of the way to the triangle's middle
  const Sheet sheet(face);
  const bool known = !sheet.surface.IsNull() && mesh.HasUVNodes();
  std::vector<PnTriangle::Corners> normals;
  for (int t = 1; t <= mesh.NbTriangles(); ++t) {
    const Facet facet(mesh, t, at);
    const Vec3 flat =
        (facet.point[1] - facet.point[0]).cross(facet.point[2] - facet.point[0]).normalized();
    PnTriangle::Corners& corners = normals.emplace_back();
    for (size_t c = 0; c < 3; ++c) {
      Vec3 n = flat;
      if (known) {
        const Vec2 middle = (facet.uv[0] + facet.uv[1] + facet.uv[2]) / 3;
        n = sheet.normal(facet.uv[c] + inwards * (middle - facet.uv[c]));
        if (n.dot(flat) < 0) n = -n;
        if (!(n.squaredNorm() > 0.5)) n = flat;
      }
      corners[c] = n;
    }
  }
  return normals;
}

double surface_deviation(const TopoDS_Face& face, const Poly_Triangulation& mesh,
                         const std::vector<Vec3>& at,
                         const std::vector<PnTriangle::Corners>& normals) {
  const Sheet sheet(face);
  if (sheet.surface.IsNull() || !mesh.HasUVNodes()) return 0;
  if (GeomAdaptor_Surface(sheet.surface).GetType() == GeomAbs_Plane) return 0;
  double largest = 0;
  for (int t = 1; t <= mesh.NbTriangles(); ++t) {
    const Facet facet(mesh, t, at);
    std::optional<PnTriangle> curved;
    if (!normals.empty()) curved.emplace(facet.point, normals[static_cast<size_t>(t) - 1]);
    for (const auto& w : kPoints) {
      Vec3 p = Vec3::Zero();
      Vec2 uv = Vec2::Zero();
      for (size_t c = 0; c < 3; ++c) {
        p += w[c] * facet.point[c];
        uv += w[c] * facet.uv[c];
      }
      if (curved) p = curved->at({w[0], w[1], w[2]});
      double distance = sheet.distance(uv, p);
      // A search may end where the surface comes near only there: corners lead elsewhere.
      for (size_t c = 0; c < 3 && distance > largest; ++c)
        distance = std::min(distance, sheet.distance(facet.uv[c], p));
      largest = std::max(largest, distance);
    }
  }
  return largest;
}

double chord_deviation(const TopoDS_Edge& edge, const Poly_PolygonOnTriangulation& chain,
                       const std::vector<Vec3>& at) {
  double first = 0, last = 0, largest = 0;
  const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
  if (curve.IsNull() || !chain.HasParameters()) return 0;
  for (int k = 1; k < chain.NbNodes(); ++k) {
    const Vec3 &a = at[static_cast<size_t>(chain.Node(k)) - 1],
               &b = at[static_cast<size_t>(chain.Node(k + 1)) - 1];
    const double from = chain.Parameter(k), to = chain.Parameter(k + 1);
    const double length = (b - a).squaredNorm();
    for (int i = 1; i <= 3; ++i) {
      const Vec3 p = from_occ(curve->Value(from + (to - from) * i / 4).XYZ());
      const double fraction = length > 0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0;
      largest = std::max(largest, (a + fraction * (b - a) - p).norm());
    }
  }
  return largest;
}

}  // namespace batten
