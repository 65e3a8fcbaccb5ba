// SPDX-License-Identifier: MPL-2.0
// Reads and writes DXF files.
#include <dl_creationadapter.h>
#include <dl_dxf.h>
#include <dl_writer_ascii.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <ostream>
#include <set>
#include <sstream>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/curves/bspline.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/lines/named_lines.h"
#include "batten/io/lines/text_rows.h"

namespace batten {
namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

// Lengths in metres of the units that $INSUNITS declares by a number.
constexpr std::pair<int, double> kInsUnits[] = {
    {1, 0.0254}, {2, 0.3048},  {3, 1609.344}, {4, 1e-3},    {5, 0.01},   {6, 1},
    {7, 1e3},    {8, 2.54e-8}, {9, 2.54e-5},  {10, 0.9144}, {11, 1e-10}, {12, 1e-9},
    {13, 1e-6},  {14, 0.1},    {15, 10},      {16, 100}};

// Extended data (XDATA) of this application contain the names of curves that are not valid as names
// of layers: the layer, followed by the name in one or more parts.
constexpr const char* kXDataApplication = "BATTEN";

// The value of a code \U+XXXX at position i of a text; -1 if there is none.
long unicode_escape(std::u32string_view text, size_t i) {
  if (text.substr(std::min(i, text.size()), 3) != U"\\U+" || i + 7 > text.size()) return -1;
  long value = 0;
  for (const char32_t c : text.substr(i + 3, 4)) {
    const bool digit = c >= '0' && c <= '9', letter = (c | 32) >= 'a' && (c | 32) <= 'f';
    if (!digit && !letter) return -1;
    value = 16 * value + static_cast<long>(digit ? c - '0' : (c | 32) - 'a' + 10);
  }
  return value;
}

// The text of a DXF string in UTF-8. Characters that are not in the code page of the file are
// written as \U+XXXX, in UTF-16.
std::string dxf_decoded(const std::string& text) {
  const std::u32string given = code_points(text);
  std::u32string result;
  for (size_t i = 0; i < given.size(); ++i) {
    const long first = unicode_escape(given, i);
    if (first < 0) {
      result += given[i];
      continue;
    }
    i += 6;
    const long second = unicode_escape(given, i + 1);
    if (first >= 0xD800 && first < 0xDC00 && second >= 0xDC00 && second < 0xE000) {
      result += static_cast<char32_t>(0x10000 + ((first - 0xD800) << 10) + (second - 0xDC00));
      i += 7;
    } else {
      result += first >= 0xD800 && first < 0xE000 ? U'\uFFFD' : static_cast<char32_t>(first);
    }
  }
  return utf8(result);
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
    if (key != "$INSUNITS") return;
    for (const auto& [number, metres] : kInsUnits)
      if (number == value) unit_in_metres = metres;
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

  // The extended data of an entity precede the call for the entity. endSection() follows it.
  void addXDataApp(const std::string& application) override {
    in_own_data_ = application == kXDataApplication;
  }
  void addXDataString(int code, const std::string& text) override {
    if (in_own_data_ && code == 1000) own_data_.push_back(dxf_decoded(text));
  }
  void endSection() override {
    in_own_data_ = false;
    own_data_.clear();
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
  // The name of the present entity.
  std::string layer() {
    const std::string name = dxf_decoded(getAttributes().getLayer());
    if (own_data_.size() > 1 && own_data_[0] == name) {
      std::string whole;
      for (size_t i = 1; i < own_data_.size(); ++i) whole += own_data_[i];
      return whole;
    }
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
  bool in_own_data_ = false;
  std::vector<std::string> own_data_;
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

// Writes DXF files.

namespace {

// dxflib's writer, with output to a stream and with all digits of numbers.
class DxfStream final : public DL_WriterA {
 public:
  explicit DxfStream(std::ostream& out) : DL_WriterA("", DL_VERSION_2000), out_(out) {}

  void dxfString(int code, const char* value) const override {
    out_ << code << '\n' << value << '\n';
  }
  void dxfString(int code, const std::string& value) const override {
    dxfString(code, value.c_str());
  }
  void dxfInt(int code, int value) const override { dxfString(code, std::to_string(value)); }
  void dxfHex(int code, int value) const override {
    std::array<char, 16> digits;
    std::snprintf(digits.data(), digits.size(), "%X", static_cast<unsigned>(value));
    dxfString(code, digits.data());
  }
  void dxfReal(int code, double value) const override {
    const std::string digits = exact_number(value);
    dxfString(code, digits.find_first_of(".e") == digits.npos ? digits + ".0" : digits);
  }
  void point(int code, const Vec3& p) const {
    for (int i = 0; i < 3; ++i) dxfReal(code + 10 * i, p[i]);
  }

 private:
  std::ostream& out_;
};

std::string unicode_escapes(char32_t c) {
  const auto escape = [](unsigned value) {
    std::array<char, 16> text;
    std::snprintf(text.data(), text.size(), "\\U+%04X", value);
    return std::string(text.data());
  };
  if (c < 0x10000) return escape(c);
  return escape(0xD800 + ((c - 0x10000) >> 10)) + escape(0xDC00 + ((c - 0x10000) & 0x3FF));
}

// A character of a DXF string in ASCII. The escape codes and '^', which starts the code of a
// control character, are escaped too.
std::string dxf_character(char32_t c) {
  return c >= 32 && c < 127 && c != '\\' && c != '^' ? std::string(1, static_cast<char>(c))
                                                     : unicode_escapes(c);
}

// Names of layers. Curves with the same name have the same layer.
class Layers {
 public:
  // The layer, as written to the file, of the curves with this name.
  const std::string& layer(const std::string& name) {
    const auto [at, added] = layers_.try_emplace(name);
    if (!added) return at->second;
    const std::string valid = valid_layer(name);
    at->second = valid;
    // CAD programs do not distinguish between upper and lower case.
    for (int k = 2; !taken_.insert(lower_case(at->second)).second; ++k)
      at->second = valid + "_" + std::to_string(k);
    return at->second;
  }
  const std::map<std::string, std::string>& all() const { return layers_; }

 private:
  static std::string valid_layer(const std::string& name) {
    constexpr std::string_view forbidden = "<>/\\\":;?*|=,`'";
    constexpr size_t most = 240;  // characters, of the 255 that DXF permits
    std::string layer;
    for (const char32_t c : code_points(trimmed(name))) {
      const bool valid =
          c >= 32 && c != 127 &&
          (c > 127 || forbidden.find(static_cast<char>(c)) == std::string_view::npos);
      const std::string text = valid ? dxf_character(c) : "_";
      if (layer.size() + text.size() > most) break;
      layer += text;
    }
    const std::string_view kept = trimmed(layer);  // without a blank where the name was cut
    return kept.empty() ? "_" : std::string(kept);
  }

  // Layer 0 has the curves without a name. Curves in the layer "defpoints" are not printed.
  std::map<std::string, std::string> layers_ = {{"", "0"}};
  std::set<std::string> taken_ = {"0", "defpoints"};
};

class DxfWriter {
 public:
  DxfWriter(std::ostream& out, const std::vector<NamedCurve>& curves, int unit)
      : out_(out), curves_(curves), unit_(unit) {
    for (const NamedCurve& curve : curves) layers_.layer(curve.name);
  }

  void write() {
    header();
    tables();
    out_.sectionBlocks();
    for (const char* block : {"*Model_Space", "*Paper_Space", "*Paper_Space0"}) {
      dxf_.writeBlock(out_, DL_BlockData(block, 0, 0, 0, 0));
      dxf_.writeEndBlock(out_, block);
    }
    out_.sectionEnd();
    out_.sectionEntities();
    for (const NamedCurve& curve : curves_) entity_of(curve);
    out_.sectionEnd();
    dxf_.writeObjects(out_);
    dxf_.writeObjectsEnd(out_);
    out_.dxfEOF();
  }

 private:
  void variable(const char* name, int code, const char* value) const {
    out_.dxfString(9, name);
    out_.dxfString(code, value);
  }

  void header() const {
    const Box3 box = drawing_box(curves_);
    out_.sectionHeader();
    variable("$ACADVER", 1, "AC1015");
    variable("$DWGCODEPAGE", 3, "ANSI_1252");
    variable("$HANDSEED", 5, "FFFFFFF");  // above the handles of all entities
    variable("$INSUNITS", 70, std::to_string(unit_).c_str());
    out_.dxfString(9, "$EXTMIN");
    out_.point(10, box.min());
    out_.dxfString(9, "$EXTMAX");
    out_.point(10, box.max());
    out_.sectionEnd();
  }

  void tables() {
    out_.sectionTables();
    dxf_.writeVPort(out_);
    out_.tableLinetypes(3);
    for (const char* type : {"BYBLOCK", "BYLAYER", "CONTINUOUS"})
      dxf_.writeLinetype(out_, DL_LinetypeData(type, "", 0, 0, 0));
    out_.tableEnd();
    constexpr int black = 7;  // or white, whichever differs from the background
    const DL_Attributes attributes("", black, -1, "CONTINUOUS", 1);
    out_.tableLayers(isize(layers_.all()));
    for (const auto& [name, layer] : layers_.all())
      dxf_.writeLayer(out_, DL_LayerData(layer, 0), attributes);
    out_.tableEnd();
    out_.tableStyle(1);
    dxf_.writeStyle(out_, DL_StyleData("Standard", 0, 0, 1, 0, 0, 2.5, "txt", ""));
    out_.tableEnd();
    dxf_.writeView(out_);
    dxf_.writeUcs(out_);
    out_.tableAppid(2);
    dxf_.writeAppid(out_, "ACAD");
    dxf_.writeAppid(out_, kXDataApplication);
    out_.tableEnd();
    dxf_.writeDimStyle(out_, 1, 1, 1, 1, 1);
    dxf_.writeBlockRecord(out_);
    out_.tableEnd();
    out_.sectionEnd();
  }

  void entity_of(const NamedCurve& curve) {
    const std::string& layer = layers_.layer(curve.name);
    std::vector<Vec3> vertices = polyline_vertices(curve);
    if (vertices.empty())
      spline(layer, whole_spline(curve.name, curve.curve));
    else if (vertices.size() == 2)
      line(layer, vertices[0], vertices[1]);
    else
      polyline(layer, vertices);
    if (dxf_decoded(layer) != curve.name && !curve.name.empty()) own_data(layer, curve.name);
    // The vertices of a POLYLINE are entities of their own.
    if (in_space_) space_vertices(layer, vertices);
    in_space_ = false;
  }

  void begin(const char* type, const std::string& layer, const char* subclass) const {
    out_.entity(type);
    out_.subClass("AcDbEntity");
    out_.dxfString(8, layer);
    if (subclass) out_.subClass(subclass);
  }

  void line(const std::string& layer, const Vec3& a, const Vec3& b) const {
    begin("LINE", layer, "AcDbLine");
    out_.point(10, a);
    out_.point(11, b);
  }

  // Removes the last of the `vertices` of a closed polyline.
  void polyline(const std::string& layer, std::vector<Vec3>& vertices) {
    const bool closed = vertices.front() == vertices.back();
    if (closed) vertices.pop_back();
    const double z = vertices[0].z();
    in_space_ =
        !std::all_of(vertices.begin(), vertices.end(), [&](const Vec3& p) { return p.z() == z; });
    if (in_space_) {
      begin("POLYLINE", layer, "AcDb3dPolyline");
      out_.dxfInt(66, 1);
      out_.point(10, Vec3::Zero());
      out_.dxfInt(70, closed + 8);
      return;
    }
    begin("LWPOLYLINE", layer, "AcDbPolyline");
    out_.dxfInt(90, isize(vertices));
    out_.dxfInt(70, closed);
    out_.dxfReal(38, z);
    for (const Vec3& p : vertices) {
      out_.dxfReal(10, p.x());
      out_.dxfReal(20, p.y());
    }
  }

  void space_vertices(const std::string& layer, const std::vector<Vec3>& vertices) const {
    for (const Vec3& p : vertices) {
      begin("VERTEX", layer, "AcDbVertex");
      out_.subClass("AcDb3dPolylineVertex");
      out_.point(10, p);
      out_.dxfInt(70, 32);
    }
    begin("SEQEND", layer, nullptr);
  }

  // The flag of closed splines is not set: readers would repeat the first poles.
  void spline(const std::string& layer, const CubicSpline& spline) const {
    begin("SPLINE", layer, "AcDbSpline");
    out_.dxfInt(70, 0);
    out_.dxfInt(71, 3);
    out_.dxfInt(72, isize(spline.poles) + 4);
    out_.dxfInt(73, isize(spline.poles));
    out_.dxfInt(74, 0);
    for (size_t k = 0; k < spline.knots.size(); ++k)
      for (int i = 0; i < spline.multiplicities[k]; ++i) out_.dxfReal(40, spline.knots[k]);
    for (const Vec3& p : spline.poles) out_.point(10, p);
  }

  void own_data(const std::string& layer, const std::string& name) const {
    constexpr size_t most = 240;  // characters, of the 255 that DXF permits
    out_.dxfString(1001, kXDataApplication);
    out_.dxfString(1000, layer);
    std::string part;
    for (const char32_t c : code_points(name)) {
      // Readers remove blanks at the ends.
      const std::string text = c == ' ' ? unicode_escapes(c) : dxf_character(c);
      if (part.size() + text.size() > most) {
        out_.dxfString(1000, part);
        part.clear();
      }
      part += text;
    }
    out_.dxfString(1000, part);
  }

  DxfStream out_;
  DL_Dxf dxf_;
  const std::vector<NamedCurve>& curves_;
  int unit_;
  Layers layers_;
  bool in_space_ = false;
};

int ins_unit(const std::filesystem::path& path, double unit_in_metres) {
  for (const auto& [number, metres] : kInsUnits)
    if (std::abs(unit_in_metres - metres) <= 1e-9 * metres) return number;
  throw InputError(path.string() + ": found the length unit " + format_unit(unit_in_metres) +
                   ", which DXF files cannot declare; expected a unit such as mm, cm, m, in or ft");
}

}  // namespace

void write_dxf(const std::filesystem::path& path, const std::vector<NamedCurve>& curves,
               double unit_in_metres) {
  const int unit = ins_unit(path, unit_in_metres);
  write_file_atomically(path, [&](std::ostream& out) { DxfWriter(out, curves, unit).write(); });
}

}  // namespace batten
