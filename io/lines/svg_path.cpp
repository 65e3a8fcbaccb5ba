// SPDX-License-Identifier: MPL-2.0
#include "batten/io/lines/svg_path.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "batten/core/geometry.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

// Splits path data into commands, numbers and flags.
class Tokens {
 public:
  explicit Tokens(std::string_view data) : data_(data) { skip_spaces(); }

  bool at_end() const { return position_ == data_.size(); }
  /// True if a number follows, after an optional comma: the command is repeated.
  bool number_follows() const {
    const size_t i = after_comma();
    return i < data_.size() && (is_digit(data_[i]) || data_[i] == '.' || data_[i] == '+' ||
                                data_[i] == '-' || i != position_);
  }

  char command() {
    if (at_end() || std::string_view("MZLHVCSQTAmzlhvcsqta").find(data_[position_]) == npos)
      fail("a command (M, Z, L, H, V, C, S, Q, T or A)");
    const char letter = data_[position_++];
    skip_spaces();
    comma_allowed_ = false;
    return letter;
  }

  double number() {
    skip_comma();
    const size_t end = end_of_number();
    if (end == npos) fail("a number");
    const char* first = data_.data() + position_ + (data_[position_] == '+');
    double value = 0;
    const std::errc error = std::from_chars(first, data_.data() + end, value).ec;
    if (error != std::errc() || std::abs(value) > 1e100)
      fail("a number between -1e100 and 1e100, and not below 1e-307");
    advance_to(end);
    return value;
  }

  bool flag() {
    skip_comma();
    if (at_end() || (data_[position_] != '0' && data_[position_] != '1')) fail("a flag (0 or 1)");
    const bool value = data_[position_] == '1';
    advance_to(position_ + 1);
    return value;
  }

  [[noreturn]] void fail(const std::string& expected) const {
    const std::string found =
        at_end() ? "the end" : quoted_excerpt(data_.substr(position_, word_length()));
    throw SvgPathError(position_, "found " + found + ", expected " + expected);
  }

 private:
  static constexpr size_t npos = std::string_view::npos;
  static bool is_digit(char c) { return c >= '0' && c <= '9'; }
  static bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f';
  }

  void skip_spaces() {
    while (position_ < data_.size() && is_space(data_[position_])) ++position_;
  }
  // A comma may stand before each argument of a command except the first.
  size_t after_comma() const {
    size_t i = position_;
    if (comma_allowed_ && i < data_.size() && data_[i] == ',')
      for (++i; i < data_.size() && is_space(data_[i]);) ++i;
    return i;
  }
  void skip_comma() { position_ = after_comma(); }
  void advance_to(size_t end) {
    position_ = end;
    skip_spaces();
    comma_allowed_ = true;
  }

  // The end of the number that starts here: sign, digits with a point, exponent.
  size_t end_of_number() const {
    size_t i = position_;
    const auto digits = [&] {
      const size_t first = i;
      while (i < data_.size() && is_digit(data_[i])) ++i;
      return i - first;
    };
    const auto any_of = [&](std::string_view set) {
      return i < data_.size() && set.find(data_[i]) != npos;
    };
    if (any_of("+-")) ++i;
    size_t count = digits();
    if (any_of(".")) {
      ++i;
      count += digits();
    }
    if (count == 0) return npos;
    const size_t mantissa = i;
    if (any_of("eE")) {
      ++i;
      if (any_of("+-")) ++i;
      if (digits() == 0) i = mantissa;
    }
    return i;
  }

  size_t word_length() const {
    size_t i = position_ + 1;
    while (i < data_.size() && !is_space(data_[i]) && data_[i] != ',') ++i;
    return i - position_;
  }

  std::string_view data_;
  size_t position_ = 0;
  bool comma_allowed_ = false;
};

class PathParser {
 public:
  explicit PathParser(std::string_view data) : tokens_(data) {}

  std::vector<SvgSubpath> parse() {
    while (!tokens_.at_end()) {
      if (subpaths_.empty()) require_move();
      command(tokens_.command());
    }
    return std::move(subpaths_);
  }

 private:
  void require_move() {
    Tokens ahead = tokens_;
    const char letter = ahead.command();
    if (letter != 'M' && letter != 'm') tokens_.fail("the command M");
  }

  void command(char letter) {
    relative_ = letter >= 'a';
    const char type = relative_ ? static_cast<char>(letter - 'a' + 'A') : letter;
    if (type == 'Z') return close();
    if (type == 'M') {
      begin(point());
    } else {
      if (closed_) begin(start_);
      segment(type);
    }
    // Points after the first one of M are those of L.
    while (tokens_.number_follows()) segment(type == 'M' ? 'L' : type);
  }

  void begin(const Vec2& start) {
    start_ = current_ = start;
    closed_ = false;
    last_type_ = 0;
    subpaths_.push_back({start, {}});
  }

  void close() {
    if (!closed_) line_to(start_);
    closed_ = true;
    last_type_ = 0;
  }

  void segment(char type) {
    switch (type) {
      case 'L':
        line_to(point());
        break;
      case 'H':
        line_to({coordinate(0), current_.y()});
        break;
      case 'V':
        line_to({current_.x(), coordinate(1)});
        break;
      case 'A':
        arc();
        break;
      case 'C': {
        const Vec2 first = point();
        cubic_to(first, point());
        break;
      }
      case 'S':
        cubic_to(last_type_ == 'C' || last_type_ == 'S' ? reflected() : current_, point());
        break;
      case 'Q':
        quadratic_to(point());
        break;
      default:
        quadratic_to(last_type_ == 'Q' || last_type_ == 'T' ? reflected() : current_);
        break;
    }
    last_type_ = type;
  }

  double coordinate(int axis) { return tokens_.number() + (relative_ ? current_[axis] : 0); }
  Vec2 point() {
    const double x = coordinate(0);
    return {x, coordinate(1)};
  }
  Vec2 reflected() const { return 2 * current_ - control_; }

  void line_to(const Vec2& end) {
    if (end != current_) add({SvgSegment::Type::line, {current_, current_, end, end}, {}});
  }
  void cubic_to(const Vec2& first, const Vec2& second) {
    add_cubic(first, second, point());
    control_ = second;
  }
  void quadratic_to(const Vec2& control) {
    const Vec2 end = point();
    add_cubic((current_ + 2 * control) / 3, (2 * control + end) / 3, end);
    control_ = control;
  }
  void add_cubic(const Vec2& first, const Vec2& second, const Vec2& end) {
    if (first != current_ || second != current_ || end != current_)
      add({SvgSegment::Type::cubic, {current_, first, second, end}, {}});
  }
  void arc() {
    const double rx = tokens_.number(), ry = tokens_.number();
    const double rotation = tokens_.number() * std::numbers::pi / 180;
    const bool large = tokens_.flag(), sweep = tokens_.flag();
    const Vec2 end = point();
    if (rx == 0 || ry == 0) return line_to(end);
    if (end != current_)
      add({SvgSegment::Type::arc,
           {current_, current_, end, end},
           svg_arc(current_, end, {rx, ry}, rotation, large, sweep)});
  }
  void add(const SvgSegment& segment) {
    subpaths_.back().segments.push_back(segment);
    current_ = segment.end();
  }

  Tokens tokens_;
  std::vector<SvgSubpath> subpaths_;
  Vec2 start_ = Vec2::Zero(), current_ = Vec2::Zero(), control_ = Vec2::Zero();
  bool relative_ = false, closed_ = false;
  char last_type_ = 0;
};

}  // namespace

SvgArc svg_arc(const Vec2& a, const Vec2& b, Vec2 radii, double rotation, bool large, bool sweep) {
  radii = radii.cwiseAbs();
  Eigen::Matrix2d R;
  R << std::cos(rotation), -std::sin(rotation), std::sin(rotation), std::cos(rotation);
  // Half of the chord, mapped to the unit circle. Its length is at most the radius 1.
  Vec2 half = (R.transpose() * (a - b) / 2).cwiseQuotient(radii);
  const double length = std::hypot(half.x(), half.y());
  if (length > 1) {
    radii *= length;
    half /= length;
  }
  const double sine = std::min(length, 1.0);  // of half of the arc's angle
  const Vec2 centre =
      (large == sweep ? -1 : 1) * std::sqrt(1 - sine * sine) / length * Vec2(half.y(), -half.x());
  const double turn = 2 * std::asin(sine), angle = large ? 2 * std::numbers::pi - turn : turn;
  SvgArc arc;
  arc.centre = R * centre.cwiseProduct(radii) + (a + b) / 2;
  arc.radii = radii;
  arc.rotation = rotation;
  arc.from = std::atan2(half.y() - centre.y(), half.x() - centre.x());
  arc.to = sweep ? arc.from + angle : arc.from - angle;
  return arc;
}

std::vector<SvgSubpath> parse_svg_path(std::string_view data) { return PathParser(data).parse(); }

}  // namespace batten
