// SPDX-License-Identifier: MPL-2.0
// Writes DXF files.
#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <ostream>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/fem/curves/bspline.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/lines/dxf_text.h"
#include "batten/io/lines/named_lines.h"

namespace batten {
namespace {

// Writes groups of codes and values.
class DxfGroups {
 public:
  explicit DxfGroups(std::ostream& out) : out_(out) {}

  void add(int code, const std::string& value) const { out_ << code << '\n' << value << '\n'; }
  void add(int code, int value) const { add(code, std::to_string(value)); }
  void add(int code, double value) const {
    const std::string digits = exact_number(value);
    add(code, digits.find_first_of(".e") == digits.npos ? digits + ".0" : digits);
  }
  void add_point(int code, const Vec3& p) const {
    for (int i = 0; i < 3; ++i) add(code + 10 * i, p[i]);
  }
  void add_handle(int code, int handle) const {
    std::array<char, 16> digits;
    std::snprintf(digits.data(), digits.size(), "%X", static_cast<unsigned>(handle));
    add(code, std::string(digits.data()));
  }

 private:
  std::ostream& out_;
};

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

// Handles of objects that other objects name; the handles of all others follow from kFirstHandle.
enum Handle {
  kRootDictionary = 1,
  kGroups,
  kLayouts,
  kPlotStyles,
  kNormalPlotStyle,
  kModelSpace,
  kPaperSpace,
  kModelLayout,
  kPaperLayout,
  kFirstHandle
};

// Writes the drawing as AutoCAD 2000 does: with all tables, blocks and objects that CAD programs
// require, of which most are empty or have one entry.
class DxfWriter {
 public:
  DxfWriter(std::ostream& out, const std::vector<NamedCurve>& curves, int unit)
      : out_(out), curves_(curves), unit_(unit) {
    for (const NamedCurve& curve : curves) layers_.layer(curve.name);
  }

  void write() {
    header();
    tables();
    blocks();
    begin_section("ENTITIES");
    for (const NamedCurve& curve : curves_) entity_of(curve);
    end_section();
    objects();
    out_.add(0, "EOF");
  }

 private:
  void begin_section(const char* name) const {
    out_.add(0, "SECTION");
    out_.add(2, name);
  }
  void end_section() const { out_.add(0, "ENDSEC"); }
  void variable(const char* name, int code, const std::string& value) const {
    out_.add(9, name);
    out_.add(code, value);
  }

  void header() const {
    const Box3 box = drawing_box(curves_);
    begin_section("HEADER");
    variable("$ACADVER", 1, "AC1015");
    variable("$DWGCODEPAGE", 3, "ANSI_1252");
    variable("$HANDSEED", 5, "FFFFFFF");  // above the handles of all entities
    variable("$INSUNITS", 70, std::to_string(unit_));
    out_.add(9, "$EXTMIN");
    out_.add_point(10, box.min());
    out_.add(9, "$EXTMAX");
    out_.add_point(10, box.max());
    end_section();
  }

  // Tables. Each entry has a handle of its own.

  void tables() {
    begin_section("TABLES");
    viewports();
    begin_table("LTYPE", 3);
    for (const char* name : {"ByBlock", "ByLayer", "Continuous"}) line_type(name);
    end_table();
    begin_table("LAYER", isize(layers_.all()));
    for (const auto& [name, layer] : layers_.all()) layer_entry(layer);
    end_table();
    text_styles();
    empty_table("VIEW");
    empty_table("UCS");
    begin_table("APPID", 2);
    for (const char* name : {"ACAD", kXDataApplication})
      entry("APPID", "AcDbRegAppTableRecord", name);
    end_table();
    dimension_styles();
    begin_table("BLOCK_RECORD", 2);
    block_record("*Model_Space", kModelSpace, kModelLayout);
    block_record("*Paper_Space", kPaperSpace, kPaperLayout);
    end_table();
    end_section();
  }

  void begin_table(const char* name, int entries) {
    out_.add(0, "TABLE");
    out_.add(2, name);
    table_ = next_handle_++;
    out_.add_handle(5, table_);
    out_.add_handle(330, 0);
    out_.add(100, "AcDbSymbolTable");
    out_.add(70, entries);
  }
  void end_table() const { out_.add(0, "ENDTAB"); }
  void empty_table(const char* name) {
    begin_table(name, 0);
    end_table();
  }
  void entry_with(int handle, int code, const char* type, const char* subclass,
                  const std::string& name) const {
    out_.add(0, type);
    out_.add_handle(code, handle);
    out_.add_handle(330, table_);
    out_.add(100, "AcDbSymbolTableRecord");
    out_.add(100, subclass);
    out_.add(2, name);
    out_.add(70, 0);
  }
  void entry(const char* type, const char* subclass, const std::string& name) {
    entry_with(next_handle_++, 5, type, subclass, name);
  }

  // The view when the drawing is opened: all curves, from above.
  void viewports() {
    const Box3 box = drawing_box(curves_);
    const Vec3 centre = box.center();
    const double height = 1.1 * std::max(box.sizes().x(), box.sizes().y());
    begin_table("VPORT", 1);
    entry("VPORT", "AcDbViewportTableRecord", "*Active");
    const auto pair = [&](int code, double x, double y) {
      out_.add(code, x);
      out_.add(code + 10, y);
    };
    pair(10, 0, 0);  // corners on the screen
    pair(11, 1, 1);
    pair(12, centre.x(), centre.y());
    pair(13, 0, 0);  // snap and grid
    pair(14, 10, 10);
    pair(15, 10, 10);
    out_.add_point(16, Vec3::UnitZ());  // from the target to the eye
    out_.add_point(17, Vec3::Zero());
    out_.add(40, height > 0 ? height : 1.0);
    out_.add(41, 1.0);   // width / height
    out_.add(42, 50.0);  // focal length
    end_table();
  }

  void line_type(const char* name) {
    entry("LTYPE", "AcDbLinetypeTableRecord", name);
    out_.add(3, "");
    out_.add(72, 65);
    out_.add(73, 0);
    out_.add(40, 0.0);
  }

  void layer_entry(const std::string& layer) {
    constexpr int black = 7;  // or white, whichever differs from the background
    entry("LAYER", "AcDbLayerTableRecord", layer);
    out_.add(62, black);
    out_.add(6, "Continuous");
    out_.add_handle(390, kNormalPlotStyle);
  }

  void text_styles() {
    begin_table("STYLE", 1);
    entry("STYLE", "AcDbTextStyleTableRecord", "Standard");
    out_.add(40, 0.0);
    out_.add(41, 1.0);
    out_.add(50, 0.0);
    out_.add(71, 0);
    out_.add(42, 2.5);
    out_.add(3, "txt");
    out_.add(4, "");
    end_table();
  }

  void dimension_styles() {
    begin_table("DIMSTYLE", 1);
    out_.add(100, "AcDbDimStyleTable");
    out_.add(71, 0);
    entry_with(next_handle_++, 105, "DIMSTYLE", "AcDbDimStyleTableRecord", "Standard");
    end_table();
  }

  void block_record(const char* name, int handle, int layout) const {
    entry_with(handle, 5, "BLOCK_RECORD", "AcDbBlockTableRecord", name);
    out_.add_handle(340, layout);
  }

  // Blocks.

  void blocks() {
    begin_section("BLOCKS");
    block("*Model_Space", kModelSpace);
    block("*Paper_Space", kPaperSpace);
    end_section();
  }

  void block(const char* name, int record) {
    block_entity("BLOCK", record, "AcDbBlockBegin");
    out_.add(2, name);
    out_.add(70, 0);
    out_.add_point(10, Vec3::Zero());
    out_.add(3, name);
    out_.add(1, "");
    block_entity("ENDBLK", record, "AcDbBlockEnd");
  }
  void block_entity(const char* type, int record, const char* subclass) {
    out_.add(0, type);
    out_.add_handle(5, next_handle_++);
    out_.add_handle(330, record);
    out_.add(100, "AcDbEntity");
    if (record == kPaperSpace) out_.add(67, 1);
    out_.add(8, "0");
    out_.add(100, subclass);
  }

  // Objects: dictionaries, a plot style, and one layout for each of the two blocks.

  void objects() {
    begin_section("OBJECTS");
    dictionary(
        kRootDictionary, 0,
        {{"ACAD_GROUP", kGroups}, {"ACAD_LAYOUT", kLayouts}, {"ACAD_PLOTSTYLENAME", kPlotStyles}});
    dictionary(kGroups, kRootDictionary, {});
    dictionary(kLayouts, kRootDictionary, {{"Layout1", kPaperLayout}, {"Model", kModelLayout}});
    dictionary(kPlotStyles, kRootDictionary, {{"Normal", kNormalPlotStyle}}, "ACDBDICTIONARYWDFLT");
    out_.add(100, "AcDbDictionaryWithDefault");
    out_.add_handle(340, kNormalPlotStyle);
    begin_object("ACDBPLACEHOLDER", kNormalPlotStyle, kPlotStyles);
    layout("Model", kModelLayout, 0, kModelSpace);
    layout("Layout1", kPaperLayout, 1, kPaperSpace);
    end_section();
  }

  void begin_object(const char* type, int handle, int owner) const {
    out_.add(0, type);
    out_.add_handle(5, handle);
    out_.add_handle(330, owner);
  }

  void dictionary(int handle, int owner, const std::map<std::string, int>& entries,
                  const char* type = "DICTIONARY") const {
    begin_object(type, handle, owner);
    out_.add(100, "AcDbDictionary");
    out_.add(281, 1);
    for (const auto& [name, entry] : entries) {
      out_.add(3, name);
      out_.add_handle(350, entry);
    }
  }

  void layout(const char* name, int handle, int tab, int block) const {
    constexpr int no_paper_units_mm = 1, model = 1024;
    begin_object("LAYOUT", handle, kLayouts);
    out_.add(100, "AcDbPlotSettings");
    out_.add(1, "");
    out_.add(2, "");
    out_.add(4, "");
    out_.add(6, "");
    out_.add(70, tab == 0 ? model : 0);
    out_.add(72, no_paper_units_mm);
    out_.add(100, "AcDbLayout");
    out_.add(1, name);
    out_.add(70, 1);
    out_.add(71, tab);
    const Box3 box = drawing_box(curves_);
    out_.add_point(14, box.min());
    out_.add_point(15, box.max());
    out_.add_handle(330, block);
  }

  // Entities.

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

  void begin(const char* type, const std::string& layer, const char* subclass) {
    out_.add(0, type);
    out_.add_handle(5, next_handle_++);
    out_.add_handle(330, kModelSpace);
    out_.add(100, "AcDbEntity");
    out_.add(8, layer);
    if (subclass) out_.add(100, subclass);
  }

  void line(const std::string& layer, const Vec3& a, const Vec3& b) {
    begin("LINE", layer, "AcDbLine");
    out_.add_point(10, a);
    out_.add_point(11, b);
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
      out_.add(66, 1);
      out_.add_point(10, Vec3::Zero());
      out_.add(70, closed + 8);
      return;
    }
    begin("LWPOLYLINE", layer, "AcDbPolyline");
    out_.add(90, isize(vertices));
    out_.add(70, closed);
    out_.add(38, z);
    for (const Vec3& p : vertices) {
      out_.add(10, p.x());
      out_.add(20, p.y());
    }
  }

  void space_vertices(const std::string& layer, const std::vector<Vec3>& vertices) {
    for (const Vec3& p : vertices) {
      begin("VERTEX", layer, "AcDbVertex");
      out_.add(100, "AcDb3dPolylineVertex");
      out_.add_point(10, p);
      out_.add(70, 32);
    }
    begin("SEQEND", layer, nullptr);
  }

  // The flag of closed splines is not set: readers would repeat the first poles.
  void spline(const std::string& layer, const CubicSpline& spline) {
    begin("SPLINE", layer, "AcDbSpline");
    out_.add(70, 0);
    out_.add(71, 3);
    out_.add(72, isize(spline.poles) + 4);
    out_.add(73, isize(spline.poles));
    out_.add(74, 0);
    for (size_t k = 0; k < spline.knots.size(); ++k)
      for (int i = 0; i < spline.multiplicities[k]; ++i) out_.add(40, spline.knots[k]);
    for (const Vec3& p : spline.poles) out_.add_point(10, p);
  }

  void own_data(const std::string& layer, const std::string& name) const {
    constexpr size_t most = 240;  // characters, of the 255 that DXF permits
    out_.add(1001, kXDataApplication);
    out_.add(1000, layer);
    std::string part;
    for (const char32_t c : code_points(name)) {
      // Readers remove blanks at the ends.
      const std::string text = c == ' ' ? unicode_escapes(c) : dxf_character(c);
      if (part.size() + text.size() > most) {
        out_.add(1000, part);
        part.clear();
      }
      part += text;
    }
    out_.add(1000, part);
  }

  DxfGroups out_;
  const std::vector<NamedCurve>& curves_;
  int unit_;
  Layers layers_;
  int next_handle_ = kFirstHandle, table_ = 0;
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
