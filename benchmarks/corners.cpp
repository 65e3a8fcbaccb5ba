// SPDX-License-Identifier: MPL-2.0
// Corners of curves given by points: 300 random curves with known corners, compared with the rule
// that every turn of more than 20 degrees is a corner.
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <random>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/fairing/corners/corners.h"
#include "bench.h"

namespace {

using namespace batten;
using namespace batten::bench;

struct Line {
  std::string kind;
  double noise = 0;  // as a fraction of the size
  std::vector<Vec3> points = {};
  std::vector<int> corners = {};
};

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

double size_of(const std::vector<Vec3>& points) {
  Vec3 low = points.front(), high = low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

class Lines {
 public:
  Line next() {
    const int kind = number_++ % 4;
    const int count = static_cast<int>(std::lround(std::exp(between(std::log(5), std::log(200)))));
    const double all[] = {0, 0, 1e-3, 3e-3, 1e-2}, noises = all[count < 12 ? whole(3) : whole(5)];
    Line line = kind == 0 ? arc(count) : kind == 1 ? bow(count) : polyline(count, noises);
    line.noise = noises;
    const double sigma = line.noise * size_of(line.points);
    for (Vec3& p : line.points) p += sigma * Vec3(normal_(random_), normal_(random_), 0);
    return line;
  }

 private:
  double between(double a, double b) { return a + (b - a) * uniform_(random_); }
  int whole(int below) { return std::min(below - 1, static_cast<int>(below * uniform_(random_))); }

  // Fractions from 0 to 1, uniform or with a ratio of steps up to 1.3 : 0.7.
  std::vector<double> steps(int count) {
    const double uneven = whole(2) * 0.3;
    std::vector<double> at{0};
    for (int i = 1; i < count; ++i) at.push_back(at.back() + 1 + between(-uneven, uneven));
    for (double& t : at) t /= at[static_cast<size_t>(count) - 1];
    return at;
  }

  Line arc(int count) {
    Line line{"arc"};
    const double angle = radians(std::min(between(20, 340), 60.0 * (count - 1)));
    for (const double t : steps(count))
      line.points.emplace_back(std::cos(angle * t), std::sin(angle * t), 0);
    return line;
  }

  // Its direction is a sum of three waves; it changes by less than 50 degrees between points.
  Line bow(int count) {
    for (;;) {
      double height[3], waves[3], phase[3];
      for (int k = 0; k < 3; ++k) {
        height[k] = 1.2 * normal_(random_) / (k + 1);
        waves[k] = (k + 1) * between(0.3, 1);
        phase[k] = between(0, 6.3);
      }
      constexpr int fine = 4000;
      std::vector<Vec3> all{Vec3::Zero()};
      std::vector<double> direction;
      for (int i = 0; i < fine; ++i) {
        double d = 0;
        for (int k = 0; k < 3; ++k)
          d += height[k] * std::sin(2 * std::numbers::pi * waves[k] * i / fine + phase[k]);
        direction.push_back(d);
        all.push_back(all.back() + Vec3(std::cos(d), std::sin(d), 0) / fine);
      }
      Line line{"bow"};
      double most = 0, before = direction.front();
      for (const double t : steps(count)) {
        const auto i = static_cast<size_t>(std::lround(t * (fine - 1)));
        line.points.push_back(all[i]);
        most = std::max(most, std::abs(direction[i] - before));
        before = direction[i];
      }
      if (most < radians(50)) return line;
    }
  }

  // Two to five sides of at least two chords, straight or bent by up to 34 degrees, 12 per chord.
  Line polyline(int count, double noise) {
    for (;;) {
      const int sides = 1 + std::max(1, std::min(1 + whole(4), (count - 1) / 2 - 1));
      if (2 * sides > count - 1) continue;
      std::vector<int> chords(static_cast<size_t>(sides), 2);
      for (int k = 2 * sides; k < count - 1; ++k) ++chords[static_cast<size_t>(whole(sides))];
      Line line{"polyline"};
      line.points.push_back(Vec3::Zero());
      std::vector<double> turning_angles, step;
      double heading = 0;
      for (int j = 0; j < sides; ++j) {
        const int m = chords[static_cast<size_t>(j)];
        step.push_back(between(0.7, 1.4));
        double bend = whole(3) == 0 ? between(-0.6, 0.6) / m : 0;
        if (std::abs(bend) > radians(12)) bend = 0;
        for (int k = 0; k < m; ++k) {
          heading += bend / 2;
          line.points.push_back(line.points.back() +
                                step.back() * Vec3(std::cos(heading), std::sin(heading), 0));
          heading += bend / 2;
        }
        if (j + 1 == sides) break;
        turning_angles.push_back(radians(between(10, 150)));
        line.corners.push_back(isize(line.points) - 1);
        heading += whole(2) ? turning_angles.back() : -turning_angles.back();
      }
      if (corners_detectable(turning_angles, chords, step, noise * size_of(line.points), count))
        return line;
    }
  }

  // Only detectable corners count: they turn by twenty standard errors of the direction of the line
  // through the points on either side, and by 20 degrees in a list of fewer than 12 points.
  static bool corners_detectable(const std::vector<double>& turning_angles,
                                 const std::vector<int>& chords, const std::vector<double>& step,
                                 double sigma, int count) {
    for (size_t c = 0; c < turning_angles.size(); ++c) {
      if (turning_angles[c] < radians(count < 12 ? 20 : 10)) return false;
      for (const size_t side : {c, c + 1})
        if (turning_angles[c] <
            20 * sigma * std::sqrt(12.0) / (step[side] * std::pow(chords[side], 1.5)))
          return false;
    }
    return true;
  }

  std::mt19937 random_{20};
  std::uniform_real_distribution<double> uniform_{0, 1};
  std::normal_distribution<double> normal_;
  int number_ = 0;
};

std::vector<int> every_kink(const std::vector<Vec3>& p) {
  std::vector<int> corners = {};
  for (size_t i = 1; i + 1 < p.size(); ++i)
    if (degrees_between(p[i] - p[i - 1], p[i + 1] - p[i]) > 20)
      corners.push_back(static_cast<int>(i));
  return corners;
}

struct Score {
  int correct = 0, wrong = 0, missed = 0;
  double precision() const { return correct + wrong > 0 ? 1.0 * correct / (correct + wrong) : 1; }
  double recall() const { return correct + missed > 0 ? 1.0 * correct / (correct + missed) : 1; }
};

// A corner must be found at its point; with noise, up to 3 % of all points away.
Score score_of(const Line& line, const std::vector<int>& found) {
  const int near = line.noise > 0 ? std::max(1, isize(line.points) * 3 / 100) : 0;
  Score score;
  std::vector<char> taken(line.corners.size(), 0);
  for (const int f : found) {
    size_t best = taken.size();
    for (size_t c = 0; c < taken.size(); ++c)
      if (!taken[c] && std::abs(line.corners[c] - f) <= near &&
          (best == taken.size() ||
           std::abs(line.corners[c] - f) < std::abs(line.corners[best] - f)))
        best = c;
    if (best == taken.size()) {
      ++score.wrong;
    } else {
      taken[best] = 1;
      ++score.correct;
    }
  }
  score.missed = isize(line.corners) - score.correct;
  return score;
}

std::string words_of(const std::vector<int>& numbers) {
  std::string all;
  for (const int n : numbers) all += (all.empty() ? "" : " ") + std::to_string(n);
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  const bool list = argc > 1 && std::string(argv[1]) == "list";
  std::map<std::string, std::array<Score, 2>> scores;
  Lines lines;
  double slowest = 0;
  for (int k = 0; k < 300; ++k) {
    const Line line = lines.next();
    std::vector<int> found;
    slowest =
        std::max(slowest, cpu_seconds_of([&] { found = find_corners(line.points, false, 8); }));
    const Score now[2] = {score_of(line, found), score_of(line, every_kink(line.points))};
    const std::string length = line.points.size() < 12 ? "below 12 points, " : "12 to 200 points, ";
    for (const std::string& row :
         {line.kind, length + (line.noise > 0 ? "noisy" : "exact"), std::string("total")})
      for (size_t heading = 0; heading < 2; ++heading) {
        scores[row][heading].correct += now[heading].correct;
        scores[row][heading].wrong += now[heading].wrong;
        scores[row][heading].missed += now[heading].missed;
      }
    if (list && now[0].wrong + now[0].missed > 0)
      std::printf("%d: %s, %zu points, noise %g: corners %s; found %s\n", k, line.kind.c_str(),
                  line.points.size(), line.noise, words_of(line.corners).c_str(),
                  words_of(found).c_str());
  }
  Table table;
  table.add({"curves", "corners", "precision", "recall", "every turn: precision", "recall"});
  for (const auto& [name, both] : scores)
    table.add({name, std::to_string(both[0].correct + both[0].missed),
               text("%.3f", both[0].precision()), text("%.3f", both[0].recall()),
               text("%.3f", both[1].precision()), text("%.3f", both[1].recall())});
  table.print();
  std::printf("Slowest curve: %.1f ms.\n\n", 1e3 * slowest);
  Checks checks;
  checks.at_least("precision on 300 curves", scores["total"][0].precision(), 0.97);
  checks.at_least("recall on 300 curves", scores["total"][0].recall(), 0.97);
  checks.print("corners");
}
