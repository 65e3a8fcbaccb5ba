#include <dl_creationadapter.h>
#include <dl_dxf.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/lines/named_lines.h"
#include "batten/io/lines/text_rows.h"

namespace batten {
namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

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

struct Insert {
  std::string block, layer;
  AffineTransform transform;
};
struct Block {
  Vec3 base = Vec3::Zero();
  std::vector<DrawnLine> lines;
  std::vector<Insert> inserts;
};

// Collects the entities that dxflib finds. dxflib reports polylines and splines in parts; they end
// where the next entity begins.
class Collector : public DL_CreationAdapter {
 public:
  std::map<std::string, Block> blocks;
  Block model;
  SkippedEntities passed_over;
  double unit_in_metres = 0;

  void finish() {
    if (polyline_) add_polyline();
    if (spline_) add_spline();
    polyline_ = spline_ = false;
    vertices_.clear();
    bulges_.clear();
    poles_.clear();
    weights_.clear();
    knots_.clear();
    fit_.clear();
  }

  void setVariableInt(const std::string& key, int value, int) override {
    static const std::map<int, double> units = {{1, 0.0254}, {2, 0.3048}, {4, 0.001},
                                                {5, 0.01},   {6, 1},      {14, 0.1}};
    const auto unit = key == "$INSUNITS" ? units.find(value) : units.end();
    if (unit != units.end()) unit_in_metres = unit->second;
  }

  void addBlock(const DL_BlockData& b) override {
    finish();
    block_ = &blocks[b.name];
    block_->base = {b.bpx, b.bpy, b.bpz};
  }
  void endBlock() override {
    finish();
    block_ = &model;
  }
  void endSequence() override { finish(); }

  void addLine(const DL_LineData& l) override {
    finish();
    add({Vec3(l.x1, l.y1, l.z1), Vec3(l.x2, l.y2, l.z2)});
  }
  void addArc(const DL_ArcData& a) override {
    finish();
    const double to = a.angle2 > a.angle1 ? a.angle2 : a.angle2 + 360;
    add(round(Vec3(a.cx, a.cy, a.cz), a.radius, a.angle1, to));
  }
  void addCircle(const DL_CircleData& c) override {
    finish();
    add(round(Vec3(c.cx, c.cy, c.cz), c.radius, 0, 360));
  }
  void addEllipse(const DL_EllipseData& e) override {
    finish();
    const Vec3 major(e.mx, e.my, e.mz);
    if (!(major.norm() > 0) || !(e.ratio > 0)) return passed_over.add("ELLIPSE of zero size");
    const Vec3 x = major.normalized();
    const CurvePlane plane{Vec3(e.cx, e.cy, e.cz), x, own_plane().normal().cross(x)};
    const double full = 2 * std::numbers::pi;
    double to = e.angle2 > e.angle1 ? e.angle2 : e.angle2 + full;
    if (std::abs(to - e.angle1 - full) < 1e-9) to = e.angle1 + full;
    add(ellipse_arc(plane, major.norm(), e.ratio * major.norm(), e.angle1, to));
  }

  void addPolyline(const DL_PolylineData& p) override {
    finish();
    constexpr int surface = 16 | 64;
    if (p.flags & surface) return passed_over.add("POLYLINE that is a mesh");
    polyline_ = true;
    closed_ = p.flags & 1;
    in_space_ = p.flags & 8;
    elevation_ = p.elevation;
    plane_ = placement_in(own_plane());
    layer_ = layer();
  }
  void addVertex(const DL_VertexData& v) override {
    if (!polyline_) return;
    const Vec3 p(v.x, v.y, in_space_ || v.z != 0 ? v.z : elevation_);
    vertices_.push_back(p);
    bulges_.push_back(v.bulge);
  }

  void addSpline(const DL_SplineData& s) override {
    finish();
    spline_ = true;
    degree_ = static_cast<int>(s.degree);
    closed_ = s.flags & 1;
    layer_ = layer();
  }
  void addControlPoint(const DL_ControlPointData& p) override {
    poles_.push_back({p.x, p.y, p.z});
    weights_.push_back(p.w);
  }
  void addFitPoint(const DL_FitPointData& p) override { fit_.push_back({p.x, p.y, p.z}); }
  void addKnot(const DL_KnotData& k) override { knots_.push_back(k.k); }

  void addInsert(const DL_InsertData& i) override {
    finish();
    AffineTransform p;
    p.A = placement_in(own_plane()).A *
          Eigen::AngleAxisd(radians(i.angle), Vec3::UnitZ()).toRotationMatrix() *
          Vec3(i.sx, i.sy, i.sz).asDiagonal();
    p.b = placement_in(own_plane())(Vec3(i.ipx, i.ipy, i.ipz));
    block_->inserts.push_back({i.name, layer(), p});
    if (i.cols > 1 || i.rows > 1) passed_over.add("INSERT in rows and columns, except the first");
  }

  void addText(const DL_TextData&) override { passed("TEXT"); }
  void addMText(const DL_MTextData&) override { passed("MTEXT"); }
  void addHatch(const DL_HatchData&) override { passed("HATCH"); }
  void addPoint(const DL_PointData&) override { passed("POINT"); }
  void addXLine(const DL_XLineData&) override { passed("XLINE"); }
  void addRay(const DL_RayData&) override { passed("RAY"); }
  void add3dFace(const DL_3dFaceData&) override { passed("3DFACE"); }
  void addSolid(const DL_SolidData&) override { passed("SOLID"); }
  void addTrace(const DL_TraceData&) override { passed("TRACE"); }
  void addImage(const DL_ImageData&) override { passed("IMAGE"); }
  void addLeader(const DL_LeaderData&) override { passed("LEADER"); }

 private:
  void passed(const std::string& kind) {
    finish();
    passed_over.add(kind);
  }
  std::string layer() {
    const std::string name = getAttributes().getLayer();
    return name == "0" ? "" : name;
  }
  CurvePlane own_plane() {
    const double* n = getExtrusion()->getDirection();
    return plane_with_normal(Vec3(n[0], n[1], n[2]));
  }
  std::shared_ptr<const InputCurve> round(const Vec3& centre, double radius, double from,
                                          double to) {
    if (!(radius > 0)) {
      passed_over.add("ARC without radius");
      return nullptr;
    }
    CurvePlane plane = own_plane();
    plane.centre = placement_in(plane)(centre);
    return ellipse_arc(plane, radius, radius, radians(from), radians(to));
  }

  void add(std::vector<Vec3> points) { block_->lines.push_back({layer(), std::move(points)}); }
  void add(std::shared_ptr<const InputCurve> curve) {
    if (curve) block_->lines.push_back({layer(), {}, std::move(curve)});
  }

  void add_polyline() {
    if (vertices_.empty()) return;
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

  void add_spline() {
    if (poles_.size() > 1) {
      block_->lines.push_back({layer_, {}, nurbs_curve(degree_, poles_, weights_, knots_)});
    } else if (fit_.size() > 1) {
      if (closed_ && fit_.front() != fit_.back()) fit_.push_back(fit_.front());
      block_->lines.push_back({layer_, fit_});
    } else {
      passed_over.add("SPLINE without points");
    }
  }

  Block* block_ = &model;
  bool polyline_ = false, spline_ = false, closed_ = false, in_space_ = false;
  double elevation_ = 0;
  int degree_ = 3;
  AffineTransform plane_;
  std::string layer_;
  std::vector<Vec3> vertices_, poles_, fit_;
  std::vector<double> bulges_, weights_, knots_;
};

constexpr size_t kMostLines = 1000000;

// Adds the curves of a block and of the blocks that it inserts, recursively.
void collect(const Collector& all, const Block& block, const AffineTransform& transform,
             const std::string& layer, int depth, std::vector<DrawnLine>& lines) {
  constexpr int deepest = 16;
  if (depth > deepest)
    throw InputError("found blocks that contain each other, expected nested blocks");
  for (const DrawnLine& line : block.lines) {
    lines.push_back(depth > 0 ? transformed(line, transform) : line);
    if (lines.back().name.empty()) lines.back().name = layer;
  }
  if (lines.size() > kMostLines)
    throw InputError("found more than " + std::to_string(kMostLines) + " curves, expected fewer");
  for (const Insert& insert : block.inserts) {
    const auto found = all.blocks.find(insert.block);
    if (found == all.blocks.end()) continue;
    const AffineTransform from_base{Mat3::Identity(), -found->second.base};
    collect(all, found->second, from_base.then(insert.transform).then(transform),
            insert.layer.empty() ? layer : insert.layer, depth + 1, lines);
  }
}

std::string text_of(const std::filesystem::path& path) {
  std::string text = read_input_file(path, "a drawing");
  if (text.starts_with("AutoCAD Binary DXF"))
    throw InputError(path.string() + ": found a binary DXF file, expected one in text form");
  if (text.starts_with("AC10"))
    throw InputError(path.string() + ": found a DWG file, expected DXF");
  // dxflib loops forever on a line that is longer than its buffer.
  size_t row = 1, begin = 0;
  for (; begin < text.size(); ++row) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    if (end - begin >= DL_DXF_MAXLINE - 1)
      throw InputError(path.string() + ":" + std::to_string(row) + ": found a line of " +
                       std::to_string(end - begin) + " characters, expected less than " +
                       std::to_string(DL_DXF_MAXLINE - 1));
    begin = end + 1;
  }
  const size_t last = text.find_last_not_of(" \t\r\n");
  if (text.find("SECTION") == text.npos)
    throw InputError(path.string() + ": found no section, expected a DXF file");
  if (last == text.npos || last < 3 || text.substr(last - 2, 3) != "EOF")
    throw InputError(path.string() +
                     ": found the end of the file, expected EOF: the file is truncated");
  return text;
}

}  // namespace

Drawing read_dxf(const std::filesystem::path& path) {
  std::istringstream in(text_of(path));
  Collector all;
  Drawing drawing;
  try {
    DL_Dxf reader;
    reader.in(in, &all);
    all.finish();
    collect(all, all.model, {}, "", 0, drawing.lines);
  } catch (const std::exception& e) {
    throw InputError(path.string() + ": " + e.what());
  }
  drawing.unit_in_metres = all.unit_in_metres;
  all.passed_over.report_to(drawing);
  return drawing;
}

}  // namespace batten
