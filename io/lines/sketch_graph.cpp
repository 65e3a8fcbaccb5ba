// SPDX-License-Identifier: MPL-2.0
// Reads sketches of connected strokes.
#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "batten/core/geometry.h"
#include "batten/fem/curves/cubic.h"
#include "batten/io/files/input_file.h"
#include "batten/io/lines/drawing.h"

namespace batten {
namespace {

using Json = nlohmann::json;
using Bezier = BezierCubic<Vec3>;

/// A piecewise cubic Bézier curve, with piece i over [i, i+1].
class PolyBezier final : public InputCurve {
 public:
  explicit PolyBezier(std::vector<Bezier> pieces) : pieces_(std::move(pieces)) {}
  double start() const override { return 0; }
  double end() const override { return static_cast<double>(pieces_.size()); }
  Vec3 evaluate(double t, int order) const override {
    const size_t i = std::min(static_cast<size_t>(std::max(t, 0.0)), pieces_.size() - 1);
    const Bezier& piece = pieces_[i];
    const double s = t - static_cast<double>(i);
    return order == 0 ? piece.at(s) : order == 1 ? piece.slope(s) : piece.second(s);
  }
  std::vector<double> breaks() const override {
    std::vector<double> all;
    for (size_t i = 0; i <= pieces_.size(); ++i) all.push_back(static_cast<double>(i));
    return all;
  }
  bool piecewise_cubic() const override { return true; }

 private:
  std::vector<Bezier> pieces_;
};

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : file_(path.string() + ": ") {
    const std::string text = read_input_file(path, "a sketch (.json)");
    check_nesting_depth(text, path.string());
    try {
      json_ = Json::parse(text);
    } catch (const Json::exception& e) {
      // Strips the prefix of e.g. "[json.exception.parse_error.101] parse error at line 1, column
      // 2: …".
      const std::string what = e.what();
      const size_t close = what.find("] ");
      fail("", "found invalid JSON: " + (close == what.npos ? what : what.substr(close + 2)));
    }
  }

  std::vector<CharacterLine> lines() {
    read_segments();
    // In sketches, each segment belongs to one stroke.
    constexpr size_t most_uses = 16, always = 100000;
    size_t uses = 0;
    std::vector<CharacterLine> lines;
    std::map<long, bool> seen;
    for (const Json& stroke : list(json_, "strokes", "the file")) {
      const long id = id_of(stroke, "a stroke");
      const std::string what = "stroke " + std::to_string(id);
      if (!seen.emplace(id, true).second) fail(what, "found its id twice, expected unique ids");
      std::vector<Bezier> pieces;
      for (const Json& segment : list(stroke, "segments", what)) {
        if (!segment.is_number_integer())
          fail(what, "found " + shown(segment) + ", expected segment ids");
        const auto found = segments_.find(segment.get<long>());
        if (found == segments_.end())
          fail(what, "found segment " + shown(segment) +
                         ", which is not in the file, expected the id of a segment");
        uses += found->second.size();
        if (uses > always + most_uses * piece_count_)
          fail(what, "found " + std::to_string(uses) + " pieces of segments in the strokes, but " +
                         std::to_string(piece_count_) +
                         " in the file, expected segments that are used once");
        for (const Bezier& piece : found->second) {
          if (!pieces.empty() && (pieces.back().b[3] - piece.b[0]).norm() > 1e-6 * size_)
            fail(what, "found segment " + shown(segment) + " starting at " +
                           format_point(piece.b[0]) + ", expected " +
                           format_point(pieces.back().b[3]) + ", the end of the previous segment");
          if (length_of(piece) > 1e-12 * size_) pieces.push_back(piece);
        }
      }
      if (!pieces.empty()) lines.push_back({what, std::make_shared<PolyBezier>(std::move(pieces))});
    }
    if (lines.empty()) fail("", "found no stroke, expected at least one");
    return lines;
  }

 private:
  [[noreturn]] void fail(const std::string& where, const std::string& message) const {
    throw InputError(file_ + (where.empty() ? "" : where + ": ") + message);
  }

  static std::string shown(const Json& json) {
    const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    constexpr size_t most = 40;
    return text.size() <= most ? text : text.substr(0, most) + "…";
  }

  static double length_of(const Bezier& piece) {
    const auto& [p, q, r, s] = piece.b;
    return (q - p).norm() + (r - q).norm() + (s - r).norm();
  }

  const Json& list(const Json& object, const char* key, const std::string& where) const {
    if (!object.is_object() || !object.contains(key) || !object[key].is_array())
      fail(where, std::string("found no list \"") + key + "\"");
    return object[key];
  }

  long id_of(const Json& object, const std::string& what) const {
    if (!object.is_object() || !object.contains("id") || !object["id"].is_number_integer())
      fail(what, "found " + shown(object) + ", expected an object with an \"id\"");
    return object["id"].get<long>();
  }

  Vec3 point(const Json& json, const std::string& what) const {
    Vec3 p = Vec3::Zero();
    bool fits = json.is_array() && json.size() == 3;
    for (size_t i = 0; fits && i < 3; ++i) {
      fits = json[i].is_number();
      if (fits) p[static_cast<long>(i)] = json[i].get<double>();
    }
    if (!fits || !p.allFinite())
      fail(what, "found " + shown(json) + " for a point, expected three finite numbers");
    return p;
  }

  void read_segments() {
    Box3 box;
    for (const Json& segment : list(json_, "segments", "the file")) {
      const long id = id_of(segment, "a segment");
      const std::string what = "segment " + std::to_string(id);
      std::vector<Bezier> pieces;
      for (const Json& piece : list(segment, "ctrl_pts", what)) {
        if (!piece.is_array() || (piece.size() != 2 && piece.size() != 4))
          fail(what, "found " + shown(piece) +
                         ", expected 4 control points, or 2 for a straight segment");
        const Vec3 a = point(piece.front(), what), b = point(piece.back(), what);
        if (piece.size() == 2)
          pieces.push_back({{a, (2 * a + b) / 3, (a + 2 * b) / 3, b}});
        else
          pieces.push_back({{a, point(piece[1], what), point(piece[2], what), b}});
        box.extend(bounding_box(pieces.back().b));
      }
      piece_count_ += pieces.size();
      if (!segments_.emplace(id, std::move(pieces)).second)
        fail(what, "found its id twice, expected unique ids");
    }
    size_ = segments_.empty() ? 0 : box.diagonal().norm();
  }

  std::string file_;
  Json json_;
  std::map<long, std::vector<Bezier>> segments_;
  size_t piece_count_ = 0;
  double size_ = 0;
};

}  // namespace

std::vector<CharacterLine> read_sketch_graph(const std::filesystem::path& path) {
  return Reader(path).lines();
}

}  // namespace batten
