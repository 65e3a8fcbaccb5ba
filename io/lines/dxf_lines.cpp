// SPDX-License-Identifier: MPL-2.0
// Reads the curves of DXF files.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/lines/dxf_reader.h"
#include "batten/io/lines/dxf_text.h"

namespace batten {
namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

// The end angle of an arc in (from, from + full], with `full` for a full turn.
double end_angle(double from, double to, double full) {
  if (std::abs(to - from - full) < 1e-9) return from + full;
  if (to > from && to < from + full) return to;
  const double sweep = std::fmod(to - from, full);
  return from + (sweep > 0 ? sweep : sweep + full);
}

// The x axis of a plane given by its normal only: AutoCAD's arbitrary axis algorithm.
CurvePlane plane_with_normal(const Vec3& given) {
  const Vec3 n = given.norm() > 0 ? given.normalized() : Vec3::UnitZ();
  const bool near_z = std::abs(n.x()) < 1.0 / 64 && std::abs(n.y()) < 1.0 / 64;
  const Vec3 x = (near_z ? Vec3::UnitY() : Vec3::UnitZ()).cross(n).normalized();
  return {Vec3::Zero(), x, n.cross(x)};
}

AffineTransform placement_in(const CurvePlane& plane) {
  AffineTransform p;
  p.A << plane.x, plane.y, plane.normal();
  return p;
}

// The cubic spline through points with continuous second derivative, with the chord length as
// parameter. `first`, `last`: tangents at the ends of an open spline; zero: the second derivative
// is zero there (natural spline). A closed spline ends with its first point. Reference: [deBoor2001].
std::shared_ptr<const InputCurve> spline_through(const std::vector<Vec3>& given, const Vec3& first,
                                                 const Vec3& last, bool closed) {
  std::vector<Vec3> p;
  for (const Vec3& point : given)
    if (p.empty() || point != p.back()) p.push_back(point);
  if (p.size() < 2) throw InputError("found a SPLINE whose points are equal, expected two or more");
  // The ends of an open spline influence a closed one no more after this number of points.
  constexpr size_t kWithoutInfluence = 40;
  const size_t period = p.size() - 1, wraps = closed ? kWithoutInfluence : 0;
  const auto point = [&](size_t i) { return p[(i + period * wraps - wraps) % period]; };
  if (closed) {
    std::vector<Vec3> longer;
    for (size_t i = 0; i <= period + 2 * wraps; ++i) longer.push_back(point(i));
    p = std::move(longer);
  }
  // Tridiagonal equations for the derivatives m, solved without pivoting (diagonally dominant).
  const size_t n = p.size();
  std::vector<double> h(n - 1), diagonal(n), above(n);
  std::vector<Vec3> m(n);
  for (size_t i = 0; i + 1 < n; ++i) h[i] = (p[i + 1] - p[i]).norm();
  const auto slope = [&](size_t i) -> Vec3 { return 3 * (p[i + 1] - p[i]) / (h[i] * h[i]); };
  for (size_t i = 0; i < n; ++i) {
    const bool clamped = (i == 0 && first.norm() > 0) || (i + 1 == n && last.norm() > 0);
    const double left = i > 0 ? 1 / h[i - 1] : 0, right = i + 1 < n ? 1 / h[i] : 0;
    diagonal[i] = 2 * (left + right);
    above[i] = right;
    m[i] = (i > 0 ? slope(i - 1) : Vec3::Zero()) + (i + 1 < n ? slope(i) : Vec3::Zero());
    double below = left;
    if (clamped) {
      diagonal[i] = 1;
      above[i] = below = 0;
      m[i] = (i == 0 ? first : last).normalized();
    }
    if (i == 0) continue;
    const double factor = below / diagonal[i - 1];
    diagonal[i] -= factor * above[i - 1];
    m[i] -= factor * m[i - 1];
  }
  for (size_t i = n; i-- > 0;) {
    if (i + 1 < n) m[i] -= above[i] * m[i + 1];
    m[i] /= diagonal[i];
  }
  // Double inner knots: each segment contributes its two inner Bézier points.
  std::vector<Vec3> poles = {p[wraps]};
  std::vector<double> knots(4, 0.0);
  for (size_t i = wraps; i + 1 + wraps < n; ++i) {
    poles.push_back(p[i] + h[i] / 3 * m[i]);
    poles.push_back(p[i + 1] - h[i] / 3 * m[i + 1]);
    knots.insert(knots.end(), 2, knots.back() + h[i]);
  }
  poles.push_back(p[n - 1 - wraps]);
  knots.insert(knots.end(), 2, knots.back());
  return nurbs_curve(3, poles, std::vector<double>(poles.size(), 1), knots);
}

struct Insert {
  std::string block, layer;
  AffineTransform transform;
};
struct Block {
  Vec3 base = Vec3::Zero();
  std::vector<DrawnLine> lines;
  std::vector<Insert> inserts;
};

// Collects the curves of the entities of a file, block by block.
class DxfCollector {
 public:
  std::map<std::string, Block> blocks;
  Block model;
  SkippedEntities skipped;
  double unit_in_metres = 0;

  explicit DxfCollector(const std::filesystem::path& path) : dxf_(path) {}

  void read() {
    std::string section;
    while (dxf_.next()) {
      if (dxf_.type() == "SECTION" || dxf_.type() == "ENDSEC") {
        finish_polyline();
        block_ = &model;
        section = dxf_.type() == "SECTION" ? section_name() : "";
        if (section == "HEADER") read_unit();
      } else if (section == "TABLES") {
        if (dxf_.type() == "LAYER") read_layer();
      } else if (section == "ENTITIES" || section == "BLOCKS") {
        read_entity();
      }
    }
    finish_polyline();
  }

 private:
  // The first group with code 2; variables of the header have the code, too.
  std::string section_name() const {
    for (const DxfGroup& group : dxf_.groups())
      if (group.code == 2) return std::string(trimmed(group.value));
    return "";
  }

  void read_unit() {
    std::string_view variable;
    for (const DxfGroup& group : dxf_.groups()) {
      if (group.code == 9) variable = trimmed(group.value);
      if (group.code != 70 || variable != "$INSUNITS") continue;
      for (const auto& [number, metres] : kInsUnits)
        if (number == dxf_.integer(group)) unit_in_metres = metres;
    }
  }

  void read_layer() {
    constexpr int frozen = 1;  // and a negative colour: switched off
    if (dxf_.integer(70) & frozen || dxf_.integer(62, 1) < 0)
      hidden_layers_.insert(lower_case(dxf_decoded(dxf_.text(2))));
  }

  void read_entity() {
    try {
      const std::string_view type = dxf_.type();
      if (type == "VERTEX") return vertex();
      finish_polyline();
      if (type == "BLOCK") return block();
      if (type == "ENDBLK") return end_block();
      if (type != "SEQEND" && type != "VIEWPORT") read_curve(std::string(type));
    } catch (const InputError& e) {
      const std::string path = dxf_.path().string(), message = e.what();
      if (message.starts_with(path)) throw;
      throw InputError(path + ":" + std::to_string(dxf_.line()) + ": " + message);
    }
  }

  void read_curve(const std::string& type) {
    static const std::map<std::string, void (DxfCollector::*)()> readers = {
        {"LINE", &DxfCollector::line},         {"ARC", &DxfCollector::arc},
        {"CIRCLE", &DxfCollector::circle},     {"ELLIPSE", &DxfCollector::ellipse},
        {"POLYLINE", &DxfCollector::polyline}, {"LWPOLYLINE", &DxfCollector::light_polyline},
        {"SPLINE", &DxfCollector::spline},     {"HELIX", &DxfCollector::helical},
        {"INSERT", &DxfCollector::insert}};
    const auto reader = readers.find(type);
    if (reader == readers.end()) return skipped.add(type);
    const bool in_paper_space = block_ == &model && dxf_.integer(67) == 1;
    if (in_paper_space) return skipped.add(type + " in paper space");
    if (hidden_layers_.contains(lower_case(dxf_decoded(dxf_.text(8)))))
      return skipped.add(type + " on layers that are off or frozen");
    if (dxf_.integer(60) == 1) return skipped.add(type + " that is invisible");
    (this->*reader->second)();
  }

  void block() {
    block_ = &blocks[std::string(dxf_.text(2))];
    block_->base = dxf_.point(10);
  }
  void end_block() { block_ = &model; }

  void line() { add(std::vector<Vec3>{dxf_.point(10), dxf_.point(11)}); }
  void arc() {
    const double from = dxf_.number(50);
    circular("ARC", from, end_angle(from, dxf_.number(51), 360));
  }
  void circle() { circular("CIRCLE", 0, 360); }
  void circular(const std::string& type, double from, double to) {
    const double radius = dxf_.number(40);
    if (!(radius > 0)) return skipped.add(type + " of zero size");
    CurvePlane plane = own_plane();
    plane.centre = placement_in(plane)(dxf_.point(10));
    add(ellipse_arc(plane, radius, radius, radians(from), radians(to)));
  }
  void ellipse() {
    constexpr double full = 2 * std::numbers::pi;
    const Vec3 major = dxf_.point(11);
    const double a = major.norm(), ratio = dxf_.number(40, 1);
    if (!(a > 0) || !(ratio > 0)) return skipped.add("ELLIPSE of zero size");
    const Vec3 x = major.normalized();
    const CurvePlane plane{dxf_.point(10), x, own_plane().normal().cross(x)};
    const double from = dxf_.number(41);
    add(ellipse_arc(plane, a, ratio * a, from, end_angle(from, dxf_.number(42, full), full)));
  }

  void polyline() {
    constexpr int closed = 1, in_space = 8, mesh = 16 | 64;
    const int flags = dxf_.integer(70);
    if (flags & mesh) return skipped.add("POLYLINE that is a mesh");
    begin_polyline(flags & closed, flags & in_space, dxf_.number(30));
  }
  void vertex() {
    constexpr int spline_frame = 16;  // control point of the curve through the other vertices
    if (!polyline_ || dxf_.integer(70) & spline_frame) return;
    Vec3 p = dxf_.point(10);
    if (!in_space_ && p.z() == 0) p.z() = elevation_;
    vertices_.push_back(p);
    bulges_.push_back(dxf_.number(42));
  }
  void light_polyline() {
    begin_polyline(dxf_.integer(70) & 1, false, dxf_.number(38));
    for (const DxfGroup& group : dxf_.groups()) {
      if (group.code == 10) {
        vertices_.push_back({dxf_.number(group), 0, elevation_});
        bulges_.push_back(0);
      } else if (!vertices_.empty() && group.code == 20) {
        vertices_.back().y() = dxf_.number(group);
      } else if (!vertices_.empty() && group.code == 42) {
        bulges_.back() = dxf_.number(group);
      }
    }
    finish_polyline();
  }
  void begin_polyline(bool closed, bool in_space, double elevation) {
    polyline_ = true;
    closed_ = closed;
    in_space_ = in_space;
    elevation_ = elevation;
    plane_ = placement_in(own_plane());
    layer_ = layer();
  }

  void finish_polyline() {
    if (polyline_ && !vertices_.empty()) add_polyline();
    polyline_ = false;
    vertices_.clear();
    bulges_.clear();
  }
  void add_polyline() {
    if (closed_ && vertices_.back() != vertices_.front()) {
      vertices_.push_back(vertices_.front());
      bulges_.push_back(0);
    }
    DrawnLine line{layer_, {}};
    std::vector<std::shared_ptr<const InputCurve>> pieces;
    bool any_round = false;
    for (size_t i = 0; i + 1 < vertices_.size(); ++i) {
      const Vec3 &a = vertices_[i], &b = vertices_[i + 1];
      if (a == b) continue;
      // A bulge is tan(angle / 4). If it is positive, the arc turns left, so it lies to the right
      // of its chord.
      const Vec3 right(b.y() - a.y(), a.x() - b.x(), 0);
      const bool bent = std::abs(bulges_[i]) > 1e-9;
      any_round = any_round || bent;
      pieces.push_back(bent ? arc_through(a, (a + b) / 2 + bulges_[i] / 2 * right, b)
                            : straight_segment(a, b));
    }
    if (any_round) {
      line.curve = concatenated(std::move(pieces));
    } else {
      for (const Vec3& p : vertices_)
        if (line.points.empty() || p != line.points.back()) line.points.push_back(p);
    }
    block_->lines.push_back(in_space_ ? line : transformed(line, plane_));
  }

  // The points with the group codes `code`, `code` + 10 and `code` + 20, in order.
  std::vector<Vec3> points(int code) const {
    std::vector<Vec3> points;
    for (const DxfGroup& group : dxf_.groups()) {
      if (group.code == code) points.push_back({dxf_.number(group), 0, 0});
      for (int axis = 1; axis < 3 && !points.empty(); ++axis)
        if (group.code == code + 10 * axis) points.back()[axis] = dxf_.number(group);
    }
    return points;
  }
  std::vector<double> numbers(int code) const {
    std::vector<double> numbers;
    for (const DxfGroup& group : dxf_.groups())
      if (group.code == code) numbers.push_back(dxf_.number(group));
    return numbers;
  }
  void spline() {
    const std::vector<Vec3> poles = points(10);
    std::vector<Vec3> fit = points(11);
    if (poles.size() > 1) {
      std::vector<double> weights = numbers(41);
      weights.resize(poles.size(), 1);
      add(nurbs_curve(dxf_.integer(71, 3), poles, weights, numbers(40)));
    } else if (fit.size() > 1) {
      const bool closed = dxf_.integer(70) & 1;
      if (closed && fit.front() != fit.back()) fit.push_back(fit.front());
      add(spline_through(fit, dxf_.point(12), dxf_.point(13), closed));
    } else {
      skipped.add("SPLINE without points");
    }
  }

  // The exact helix of the subclass AcDbHelix, not the spline that approximates it.
  void helical() {
    const auto& groups = dxf_.groups();
    auto at = std::find_if(groups.begin(), groups.end(), [](const DxfGroup& group) {
      return group.code == 100 && trimmed(group.value) == "AcDbHelix";
    });
    Vec3 base = Vec3::Zero(), start = Vec3::Zero(), axis = Vec3::UnitZ();
    double radius = 0, turns = 0, height = 0;
    bool right_handed = true;
    for (; at != groups.end(); ++at) {
      const int c = at->code % 10, k = at->code / 10 - 1;
      if (k >= 0 && k < 3 && c < 3) (c == 0 ? base : c == 1 ? start : axis)[k] = dxf_.number(*at);
      if (at->code == 40) radius = dxf_.number(*at);
      if (at->code == 41) turns = dxf_.number(*at);
      if (at->code == 42) height = dxf_.number(*at);
      if (at->code == 290) right_handed = dxf_.integer(*at) != 0;
    }
    if (!(axis.norm() > 0) || !(radius > 0) || !(turns > 0))
      return skipped.add("HELIX of zero size");
    axis.normalize();
    const Vec3 arm = start - base - axis.dot(start - base) * axis;
    if (std::abs(arm.norm() - radius) > 1e-6 * radius)
      return skipped.add("HELIX on a cone or plane");
    const CurvePlane plane{start - arm, arm / arm.norm(), axis.cross(arm / arm.norm())};
    if (right_handed) return add(helix(plane, arm.norm(), height, turns));
    const CurvePlane mirrored{plane.centre, plane.x, -plane.y};  // turns and rises the other way
    add(helix(mirrored, arm.norm(), -height, turns));
  }

  void insert() {
    const AffineTransform plane = placement_in(own_plane());
    AffineTransform p;
    p.A = plane.A * Eigen::AngleAxisd(radians(dxf_.number(50)), Vec3::UnitZ()).toRotationMatrix() *
          Vec3(dxf_.number(41, 1), dxf_.number(42, 1), dxf_.number(43, 1)).asDiagonal();
    p.b = plane(dxf_.point(10));
    block_->inserts.push_back({std::string(dxf_.text(2)), layer(), p});
    if (dxf_.integer(70, 1) > 1 || dxf_.integer(71, 1) > 1)
      skipped.add("INSERT in rows and columns, except the first");
  }

  // The name of the present entity.
  std::string layer() const {
    const std::string name = dxf_decoded(dxf_.text(8));
    std::vector<std::string> own_data;
    bool own = false;
    for (const DxfGroup& group : dxf_.groups()) {
      if (group.code == 1001) own = trimmed(group.value) == kXDataApplication;
      if (own && group.code == 1000) own_data.push_back(dxf_decoded(group.value));
    }
    if (own_data.size() > 1 && own_data[0] == name) {
      std::string whole;
      for (size_t i = 1; i < own_data.size(); ++i) whole += own_data[i];
      return whole;
    }
    return name == "0" ? "" : name;
  }
  CurvePlane own_plane() const { return plane_with_normal(dxf_.point(210, Vec3::UnitZ())); }

  void add(std::vector<Vec3> points) { block_->lines.push_back({layer(), std::move(points)}); }
  void add(std::shared_ptr<const InputCurve> curve) {
    block_->lines.push_back({layer(), {}, std::move(curve)});
  }

  DxfReader dxf_;
  Block* block_ = &model;
  bool polyline_ = false, closed_ = false, in_space_ = false;
  double elevation_ = 0;
  AffineTransform plane_;
  std::string layer_;
  std::vector<Vec3> vertices_;
  std::set<std::string> hidden_layers_;  // in lower case
  std::vector<double> bulges_;
};

// Curves, vertices and inserted blocks of a block, including those of the blocks that it inserts.
struct BlockSize {
  double curves = 0, vertices = 0, inserts = 0;
  int levels = 0;  // of blocks inside of it

  void add(const BlockSize& inner) {
    curves += inner.curves;
    vertices += inner.vertices;
    inserts += inner.inserts;
    levels = std::max(levels, inner.levels + 1);
  }
};

// Collects the curves of a block and of the blocks that it inserts, recursively. A few blocks that
// insert each other several times can expand to any number of curves, so they are counted first.
class BlockExpansion {
 public:
  explicit BlockExpansion(const std::map<std::string, Block>& blocks) : blocks_(blocks) {}

  std::vector<DrawnLine> run(const Block& model) {
    constexpr double most_curves = 250000, most_vertices = 2500000;
    const BlockSize all = size_of(model, 0);
    if (all.curves - isize(model.lines) > most_curves || all.inserts > most_curves)
      throw InputError("found more than " + format_number(most_curves) +
                       " curves of inserted blocks, or inserted blocks, expected fewer");
    if (all.vertices - own_size(model).vertices > most_vertices)
      throw InputError("found more than " + format_number(most_vertices) +
                       " vertices of curves of inserted blocks, expected fewer");
    add(model, {}, "", 0);
    return std::move(lines_);
  }

 private:
  static BlockSize own_size(const Block& block) {
    BlockSize size{static_cast<double>(block.lines.size()), 0,
                   static_cast<double>(block.inserts.size()), 0};
    for (const DrawnLine& line : block.lines) size.vertices += isize(line.points);
    return size;
  }

  BlockSize size_of(const Block& block, int depth) {
    constexpr int deepest = 16;
    const auto known = sizes_.find(&block);
    BlockSize size = known == sizes_.end() ? own_size(block) : known->second;
    if (depth + size.levels > deepest)
      throw InputError("found blocks that contain each other, or are nested more than " +
                       std::to_string(deepest) + " levels deep, expected fewer levels");
    if (known != sizes_.end()) return size;
    for (const Insert& insert : block.inserts)
      if (const auto found = blocks_.find(insert.block); found != blocks_.end())
        size.add(size_of(found->second, depth + 1));
    return sizes_[&block] = size;
  }

  void add(const Block& block, const AffineTransform& transform, const std::string& layer,
           int depth) {
    for (const DrawnLine& line : block.lines) {
      lines_.push_back(depth > 0 ? transformed(line, transform) : line);
      if (lines_.back().name.empty()) lines_.back().name = layer;
    }
    for (const Insert& insert : block.inserts) {
      const auto found = blocks_.find(insert.block);
      if (found == blocks_.end()) continue;
      const AffineTransform from_base{Mat3::Identity(), -found->second.base};
      add(found->second, from_base.then(insert.transform).then(transform),
          insert.layer.empty() ? layer : insert.layer, depth + 1);
    }
  }

  const std::map<std::string, Block>& blocks_;
  std::map<const Block*, BlockSize> sizes_;
  std::vector<DrawnLine> lines_;
};

}  // namespace

Drawing read_dxf(const std::filesystem::path& path) {
  DxfCollector all(path);
  all.read();
  Drawing drawing;
  try {
    drawing.lines = BlockExpansion(all.blocks).run(all.model);
  } catch (const InputError& e) {
    throw InputError(path.string() + ": " + e.what());
  }
  drawing.unit_in_metres = all.unit_in_metres;
  all.skipped.report_to(drawing);
  return drawing;
}

}  // namespace batten
