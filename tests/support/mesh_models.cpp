// SPDX-License-Identifier: MPL-2.0
#include "batten/tests/support/mesh_models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace batten_test {
namespace {

using std::numbers::pi;
using Ring = SheetLayout::Ring;

/// A point of a form's outline: `core` displaced by the ring's offset along `direction`.
struct OutlinePoint {
  Vec2 core, direction;
};

/// Outline of a rectangle (half sides `core`) rounded by `radius`, divided into nx, ny, nx, ny
/// segments of equal length between the middles of its four corners, from the lower left one
/// counter-clockwise.
std::vector<OutlinePoint> rounded_outline(const Vec2& core, double radius, int nx, int ny) {
  const std::array<Vec2, 4> corners{-core, Vec2(core.x(), -core.y()), core,
                                    Vec2(-core.x(), core.y())};
  std::vector<OutlinePoint> points;
  for (int side = 0; side < 4; ++side) {
    const Vec2 &from = corners[side], &to = corners[(side + 1) % 4];
    const double middle = (side - 1) * pi / 2;  // direction of the side's normal
    const double arc = radius * pi / 4, straight = (to - from).norm();
    const int n = side % 2 ? ny : nx;
    for (int i = 0; i < n; ++i) {
      const double s = (2 * arc + straight) * i / n;
      const double along = std::clamp(s - arc, 0.0, straight);
      const double turned = (s < arc ? s - arc : std::max(0.0, s - arc - straight)) / radius;
      points.push_back({straight > 0 ? Vec2(from + along / straight * (to - from)) : from,
                        {std::cos(middle + turned), std::sin(middle + turned)}});
    }
  }
  return points;
}

class SheetMaker {
 public:
  explicit SheetMaker(const SheetLayout& layout) : layout_(layout) {
    cut(layout.columns, u_, first_column_);
    cut(layout.rows, v_, first_row_);
    grid_.assign(u_.size() * v_.size(), -1);
    model_.parts.push_back({"sheet", {}});
  }

  MeshModel make() {
    for (int row = 0; row + 1 < static_cast<int>(first_row_.size()); ++row)
      for (int column = 0; column + 1 < static_cast<int>(first_column_.size()); ++column) {
        const auto here = [&](const SheetLayout::Form& f) {
          return f.column == column && f.row == row;
        };
        const auto form = std::find_if(layout_.forms.begin(), layout_.forms.end(), here);
        const Box cell{first_column_[column], first_row_[row], first_column_[column + 1],
                       first_row_[row + 1]};
        if (form == layout_.forms.end())
          add_squares(cell, {});
        else
          add_form(*form, cell);
      }
    for (const int row : layout_.creases) {
      NamedSet line{"line " + std::to_string(model_.lines.size() + 1), {}};
      for (int i = 0; i < static_cast<int>(u_.size()); ++i)
        line.items.push_back(grid_vertex(i, first_row_[row]));
      model_.lines.push_back(line);
    }
    bend();
    return std::move(model_);
  }

 private:
  struct Box {
    int i0 = 0, j0 = 0, i1 = 0, j1 = 0;
    bool holds(int i, int j) const { return i >= i0 && i < i1 && j >= j0 && j < j1; }
  };
  /// A vertex before the sheet is bent: in the tangent plane of a form (blend 0), on the sheet
  /// (blend 1), or between them.
  struct FlatPosition {
    Vec2 flat;
    int form = -1;
    double blend = 1, height = 0;
  };

  static void cut(const std::vector<SheetLayout::Span>& spans, std::vector<double>& at,
                  std::vector<int>& first) {
    double start = 0;
    at.push_back(0);
    first.push_back(0);
    for (const auto& span : spans) {
      for (int i = 1; i <= span.elements; ++i)
        at.push_back(start + span.length * i / span.elements);
      start += span.length;
      first.push_back(static_cast<int>(at.size()) - 1);
    }
  }

  int add(const FlatPosition& place) {
    places_.push_back(place);
    return static_cast<int>(places_.size()) - 1;
  }

  int grid_vertex(int i, int j) {
    int& vertex = grid_[static_cast<size_t>(j) * u_.size() + i];
    if (vertex < 0) vertex = add({{u_[i], v_[j]}});
    return vertex;
  }

  void add_quad(const std::array<int, 4>& quad, NamedSet& part) {
    part.items.push_back(model_.shells.face_count());
    model_.shells.add_face(quad);
  }

  void add_squares(const Box& box, const Box& without) {
    for (int j = box.j0; j < box.j1; ++j)
      for (int i = box.i0; i < box.i1; ++i)
        if (!without.holds(i, j))
          add_quad({grid_vertex(i, j), grid_vertex(i + 1, j), grid_vertex(i + 1, j + 1),
                    grid_vertex(i, j + 1)},
                   model_.parts[0]);
  }

  void add_band(const std::vector<int>& inner, const std::vector<int>& outer, NamedSet& part) {
    for (size_t i = 0; i < inner.size(); ++i) {
      const size_t next = (i + 1) % inner.size();
      add_quad({inner[i], outer[i], outer[next], inner[next]}, part);
    }
  }

  /// Vertices around a box of squares, counter-clockwise from its lower left corner.
  template <class VertexAt>
  static std::vector<int> around(const Box& box, const VertexAt& at) {
    std::vector<int> loop;
    for (int i = box.i0; i < box.i1; ++i) loop.push_back(at(i, box.j0));
    for (int j = box.j0; j < box.j1; ++j) loop.push_back(at(box.i1, j));
    for (int i = box.i1; i > box.i0; --i) loop.push_back(at(i, box.j1));
    for (int j = box.j1; j > box.j0; --j) loop.push_back(at(box.i0, j));
    return loop;
  }

  // Squares along the cell's border; an O-grid from there to the form's outline; bands along its
  // profile; its floor.
  void add_form(const SheetLayout::Form& form, const Box& cell) {
    const int number = static_cast<int>(&form - layout_.forms.data()), m = layout_.margin;
    const Box block{cell.i0 + m, cell.j0 + m, cell.i1 - m, cell.j1 - m};
    const int nx = block.i1 - block.i0, ny = block.j1 - block.j0;
    const int first_face = model_.shells.face_count();
    const Vec2 middle = middle_of(form);
    const double outermost = form.profile.back().offset;
    const auto outline = rounded_outline(form.core, outermost, nx, ny);

    const auto border = around(block, [this](int i, int j) { return grid_vertex(i, j); });
    const auto first_vertex = static_cast<int>(places_.size());
    std::vector<std::vector<int>> rings;
    for (const Ring& ring : form.profile) {
      rings.emplace_back();
      for (const auto& [core, direction] : outline) {
        const Vec2 p = middle + core + ring.offset * direction;
        rings.back().push_back(add({p, number, 0, ring.height}));
      }
    }
    NamedSet part{form.name, {}};
    for (size_t r = 0; r + 1 < rings.size(); ++r) add_band(rings[r], rings[r + 1], part);
    std::vector<int> free;  // to be smoothed
    if (form.floor) free = add_floor(form, number, middle, rings.front(), nx, ny, part);
    NamedSet feature{form.name, {}};
    for (auto v = first_vertex; v < static_cast<int>(places_.size()); ++v)
      feature.items.push_back(v);
    model_.features.push_back(feature);
    model_.rims.push_back({form.name, form.floor ? rings.back() : rings.front()});
    model_.parts.push_back(part);

    const Vec2 half((u_[block.i1] - u_[block.i0]) / 2, (v_[block.j1] - v_[block.j0]) / 2);
    const double size = std::sqrt(4 * half.prod() / (nx * ny));
    const double gap = 1.08 * half.sum() / 2 - form.core.sum() / 2 - outermost;
    add_o_grid(number, rings.back(), border, static_cast<int>(std::round(gap / size)), free);
    add_squares(cell, block);
    for (int j = cell.j0 + 1; j < cell.j1; ++j)
      for (int i = cell.i0 + 1; i < cell.i1; ++i)
        if (i <= block.i0 || j <= block.j0 || i >= block.i1 || j >= block.j1)
          free.push_back(grid_vertex(i, j));
    smooth(free, first_face);
  }

  // Bands from a form's outline to the border of squares around it.
  void add_o_grid(int form, const std::vector<int>& outline, const std::vector<int>& border,
                  int layers, std::vector<int>& free) {
    layers = std::max(1, layers);
    std::vector<int> inner = outline;
    for (int l = 1; l <= layers; ++l) {
      const double t = static_cast<double>(l) / layers;
      std::vector<int> outer = border;
      for (size_t i = 0; l < layers && i < outer.size(); ++i) {
        const Vec2 p = (1 - t) * places_[outline[i]].flat + t * places_[border[i]].flat;
        outer[i] = add({p, form, t * t * (3 - 2 * t)});
        free.push_back(outer[i]);
      }
      add_band(inner, outer, model_.parts[0]);
      inner = outer;
    }
  }

  // A grid of nx × ny squares in the middle, bands from there to the boundary.
  std::vector<int> add_floor(const SheetLayout::Form& form, int number, const Vec2& middle,
                             const std::vector<int>& rim, int nx, int ny, NamedSet& part) {
    constexpr double fraction = 0.55;
    const double radius = form.profile.front().offset, z = form.profile.front().height;
    const Vec2 half = form.core + Vec2::Constant(fraction * radius);
    std::vector<int> added;
    const auto put = [&](const Vec2& p) {
      added.push_back(add({p, number, 0, z}));
      return added.back();
    };
    std::vector<int> grid;
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        grid.push_back(
            put(middle + Vec2(half.x() * (2.0 * i / nx - 1), half.y() * (2.0 * j / ny - 1))));
    const auto at = [&](int i, int j) { return grid[j * (nx + 1) + i]; };
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        add_quad({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}, part);
    const std::vector<int> core = around({0, 0, nx, ny}, at);
    const double size = 2 * std::sqrt(half.prod() / (nx * ny));
    const int layers =
        std::max(1, static_cast<int>(std::round(0.7 * (1 - fraction) * radius / size)));
    std::vector<int> inner = core;
    for (int l = 1; l <= layers; ++l) {
      const double t = static_cast<double>(l) / layers;
      std::vector<int> outer = rim;
      if (l < layers)
        for (size_t i = 0; i < rim.size(); ++i)
          outer[i] = put((1 - t) * places_[core[i]].flat + t * places_[rim[i]].flat);
      add_band(inner, outer, part);
      inner = outer;
    }
    return added;
  }

  // Laplacian smoothing of free vertices, several passes.
  void smooth(const std::vector<int>& free, int first_face) {
    constexpr int sweeps = 40;
    std::vector<std::pair<int, int>> edges;
    for (int f = first_face; f < model_.shells.face_count(); ++f) {
      const auto quad = model_.shells.face(f);
      for (size_t a = 0; a < 4; ++a) {
        edges.emplace_back(quad[a], quad[(a + 1) % 4]);
        edges.emplace_back(quad[(a + 1) % 4], quad[a]);
      }
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    const auto first = [&](int v) {
      return std::lower_bound(edges.begin(), edges.end(), std::pair(v, 0)) - edges.begin();
    };
    std::vector<std::pair<long, long>> ranges;
    for (const int v : free) ranges.emplace_back(first(v), first(v + 1));
    for (int sweep = 0; sweep < sweeps; ++sweep)
      for (size_t i = 0; i < free.size(); ++i) {
        const auto [begin, end] = ranges[i];
        Vec2 sum = Vec2::Zero();
        for (long e = begin; e < end; ++e) sum += places_[edges[e].second].flat;
        places_[free[i]].flat = sum / static_cast<double>(end - begin);
      }
  }

  Vec3 on_sheet(const Vec2& p) const {
    return layout_.shape ? layout_.shape(p.x(), p.y()) : Vec3(p.x(), p.y(), 0);
  }

  Vec2 middle_of(const SheetLayout::Form& form) const {
    const auto middle = [](const std::vector<double>& at, const std::vector<int>& first, int i) {
      return (at[first[i]] + at[first[i + 1]]) / 2;
    };
    return {middle(u_, first_column_, form.column), middle(v_, first_row_, form.row)};
  }

  /// The sheet's tangent plane under a form, with the origin in the form's middle.
  Eigen::Isometry3d frame_of(const SheetLayout::Form& form) const {
    const Vec2 middle = middle_of(form);
    const Vec2 du(1e-4 * u_.back(), 0), dv(0, 1e-4 * v_.back());
    const Vec3 along_u = on_sheet(middle + du) - on_sheet(middle - du);
    const Vec3 along_v = on_sheet(middle + dv) - on_sheet(middle - dv);
    const Vec3 x = along_u.normalized(), normal = x.cross(along_v).normalized();
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    frame.linear() << x, normal.cross(x), normal;
    frame.translation() = on_sheet(middle);
    return frame;
  }

  void bend() {
    std::vector<Vec2> middles;
    std::vector<Eigen::Isometry3d> frames;
    for (const auto& form : layout_.forms) {
      middles.push_back(middle_of(form));
      frames.push_back(frame_of(form));
    }
    model_.shells.points.resize(static_cast<long>(places_.size()), 3);
    for (size_t v = 0; v < places_.size(); ++v) {
      const FlatPosition& p = places_[v];
      Vec3 x = Vec3::Zero();
      if (p.blend > 0) x += p.blend * on_sheet(p.flat);
      if (p.blend < 1) {
        const Vec2 local = p.flat - middles[p.form];
        x += (1 - p.blend) * (frames[p.form] * Vec3(local.x(), local.y(), p.height));
      }
      model_.shells.points.row(static_cast<long>(v)) = x.transpose();
      model_.flat.push_back(p.flat);
    }
  }

  const SheetLayout& layout_;
  MeshModel model_;
  std::vector<double> u_, v_;                  // of grid lines
  std::vector<int> first_column_, first_row_;  // grid line where a cell begins
  std::vector<int> grid_;                      // vertex at each grid point, or -1
  std::vector<FlatPosition> places_;
};

/// A polyline of rings with segments divided into elements of at most `h`.
std::vector<Ring> finer(const std::vector<Ring>& coarse, double h) {
  std::vector<Ring> fine{coarse.front()};
  for (size_t i = 1; i < coarse.size(); ++i) {
    const Ring &a = coarse[i - 1], &b = coarse[i];
    const double length = std::hypot(b.offset - a.offset, b.height - a.height);
    const int n = std::max(1, static_cast<int>(std::ceil(length / h - 1e-9)));
    for (int k = 1; k < n; ++k) {
      const double t = static_cast<double>(k) / n;
      fine.push_back({(1 - t) * a.offset + t * b.offset, (1 - t) * a.height + t * b.height});
    }
    fine.push_back(b);
  }
  return fine;
}

double square(double x) { return x * x; }

}  // namespace

std::vector<int> MeshModel::where(const std::function<bool(const Vec2&)>& wanted) const {
  std::vector<int> found;
  for (size_t v = 0; v < flat.size(); ++v)
    if (wanted(flat[v])) found.push_back(static_cast<int>(v));
  return found;
}

std::vector<Ring> plain_hole(double radius) { return {{radius, 0}}; }

std::vector<Ring> flanged_hole(double radius, double depth, double fillet, double h) {
  std::vector<Ring> profile = finer({{radius, -depth}, {radius, -fillet}}, h);
  const int pieces = std::max(2, static_cast<int>(std::ceil(fillet * pi / 2 / h)));
  for (int k = 1; k <= pieces; ++k) {
    const double angle = pi / 2 * k / pieces;
    profile.push_back(
        {radius + fillet * (1 - std::cos(angle)), k < pieces ? fillet * (std::sin(angle) - 1) : 0});
  }
  return profile;
}

std::vector<Ring> pocket(double outline, double depth, double run, double h) {
  return finer({{outline - run, -depth}, {outline, 0}}, h);
}

MeshModel make_sheet(const SheetLayout& layout) { return SheetMaker(layout).make(); }

MeshModel plate_with_holes() {
  SheetLayout layout;
  layout.columns = layout.rows = {{90, 15}, {120, 20}, {90, 15}};
  for (const int row : {0, 2})
    for (const int column : {0, 2})
      layout.forms.push_back(
          {"hole " + std::to_string(layout.forms.size() + 1), column, row, plain_hole(18)});
  layout.forms.push_back({"centre", 1, 1, plain_hole(42)});
  MeshModel model = make_sheet(layout);
  model.fixed = model.where([](const Vec2& p) { return p.x() < 7; });
  model.handle = model.where([](const Vec2& p) { return p.x() > 293; });
  return model;
}

MeshModel door_panel() {
  SheetLayout layout;
  layout.columns = {{640, 40}, {220, 16}, {140, 9}};
  layout.rows = {{210, 14}, {160, 11}, {230, 15}};
  layout.creases = {1, 2};
  // A crowned sheet; the curves rise along it, with a step between them.
  layout.shape = [](double u, double v) {
    const double crown = 45 * (1 - square(u / 500 - 1)) + 70 * (1 - square(v / 300 - 1));
    const double below = 0.16 * std::max(0.0, 210 - v), above = 0.22 * std::max(0.0, v - 370);
    return Vec3(u, v + 0.05 * u, crown - below - above);
  };
  layout.forms = {{"recess", 1, 1, pocket(34, 14, 12, 8), true, {50, 0}}};
  MeshModel model = make_sheet(layout);
  model.fixed = model.where([](const Vec2& p) { return p.y() < 30; });
  model.handle =
      model.where([](const Vec2& p) { return p.x() > 880 && p.y() > 480 && p.y() < 560; });
  return model;
}

MeshModel grill() {
  SheetLayout layout;
  layout.columns.assign(7, {160, 10});
  layout.rows.assign(3, {90, 7});
  layout.shape = [](double u, double v) {
    constexpr double radius = 1100;
    const double angle = (u - 560) / radius, lean = 0.0009 * square(v - 135);
    return Vec3((radius - lean) * std::sin(angle), v, (radius - lean) * std::cos(angle) - radius);
  };
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 7; ++column)
      layout.forms.push_back({"cavity " + std::to_string(layout.forms.size() + 1),
                              column,
                              row,
                              pocket(26, 18, 8, 30),
                              true,
                              {32, 0}});
  MeshModel model = make_sheet(layout);
  model.fixed = model.where([](const Vec2& p) { return p.x() < 18; });
  model.handle = model.where([](const Vec2& p) { return p.x() > 1102; });
  return model;
}

MeshModel sheet_with_cavities() {
  SheetLayout layout;
  layout.columns.assign(4, {100, 8});
  layout.rows.assign(4, {100, 8});
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      layout.forms.push_back({"cavity " + std::to_string(layout.forms.size() + 1), column, row,
                              pocket(28, 14, 7, 8), true});
  MeshModel model = make_sheet(layout);
  model.fixed = model.where([](const Vec2& p) { return p.x() < 14; });
  model.handle = model.where([](const Vec2& p) { return p.x() > 386; });
  return model;
}

MeshModel holed_panel(int vertices) {
  const auto with = [](int n) {
    SheetLayout layout;
    layout.columns.assign(4, {100, n});
    layout.rows.assign(4, {100, n});
    layout.margin = std::max(1, n / 10);
    layout.shape = [](double u, double v) {
      return Vec3(u, v, 20 * std::sin(u / 130) * std::cos(v / 160) - 1e-4 * square(v - 200));
    };
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column)
        layout.forms.push_back({"hole " + std::to_string(layout.forms.size() + 1), column, row,
                                flanged_hole(20, 10, 5, 100.0 / n)});
    return make_sheet(layout);
  };
  // The count is approximately 24 n² for large n.
  int n = std::max(6, static_cast<int>(std::sqrt(vertices / 28.0)));
  MeshModel model = with(n);
  for (MeshModel finer = model; model.shells.node_count() < vertices; model = std::move(finer)) {
    finer = with(++n);
    const int below = vertices - model.shells.node_count();
    if (finer.shells.node_count() - vertices > below) break;
  }
  const double strip = std::max(8.0, 210.0 / n);  // at least two rings
  model.fixed = model.where([&](const Vec2& p) { return p.x() < strip || p.x() > 400 - strip; });
  model.handle = model.where([](const Vec2& p) { return (p - Vec2(200, 200)).norm() < 24; });
  return model;
}

MeshModel panel() {
  SheetLayout layout;
  layout.columns = {{110, 14}, {190, 24}, {190, 24}, {110, 14}};
  layout.rows = {{110, 14}, {110, 14}, {180, 22}};
  layout.creases = {2};
  layout.shape = [](double u, double v) {
    const double crown = 18 * (1 - square(u / 300 - 1)) + 30 * (1 - square(v / 200 - 1));
    return Vec3(u, v, crown - 0.18 * std::max(0.0, v - 220));
  };
  const auto rim = flanged_hole(20, 8, 4, 5);
  const auto wide = flanged_hole(38, 8, 4, 5);
  layout.forms = {{"hole 1", 0, 0, rim},
                  {"hole 2", 3, 0, rim},
                  {"hole 3", 0, 1, rim},
                  {"hole 4", 3, 1, rim},
                  {"bead", 1, 0, pocket(18, -7, 7, 5), true, {60, 0}},
                  {"slot", 2, 1, flanged_hole(14, 8, 4, 5), false, {45, 0}},
                  {"opening", 1, 2, wide, false, {20, 10}}};
  MeshModel model = make_sheet(layout);
  model.fixed = model.where([](const Vec2& p) { return p.x() < 16; });
  model.handle = model.where([](const Vec2& p) { return p.x() > 584; });
  return model;
}

}  // namespace batten_test
