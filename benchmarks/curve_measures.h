// SPDX-License-Identifier: MPL-2.0
// Shared by the benchmarks of curves: distances computed independently of the fits, exact curves,
// SciPy.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/tests/support/test_data.h"

namespace batten::bench {

using Stroke = std::vector<Vec3>;

inline double size_of(const Stroke& points) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) box.extend(p);
  return box.diagonal().norm();
}

// ---- measurement, the same for all sides and independent of the fits --------------------------

constexpr int kSamplesPerSpan = 64, kNewtonSteps = 6;  // as in scipy_curves.py
constexpr double kLongestGap = 1 / 300.0;              // between samples, as a fraction of the size

// A curve with derivatives, and its samples.
struct Sampled {
  std::function<Vec3(double, int)> at;
  std::vector<double> u;
  Stroke x;

  // Parameters may be uneven along a curve: gaps between samples are subdivided until they are
  // short.
  Sampled(std::function<Vec3(double, int)> curve, const std::vector<double>& knots)
      : at(std::move(curve)) {
    for (size_t k = 0; k + 1 < knots.size(); ++k)
      for (int i = 0; i < kSamplesPerSpan; ++i)
        u.push_back(knots[k] + (knots[k + 1] - knots[k]) * i / kSamplesPerSpan);
    u.push_back(knots.back());
    for (const double t : u) x.push_back(at(t, 0));
    const double gap = kLongestGap * size_of(x);
    for (int pass = 0; pass < 3; ++pass) {
      std::vector<double> finer;
      for (size_t i = 0; i + 1 < u.size(); ++i) {
        const double length = (x[i + 1] - x[i]).norm();
        const int parts = length > gap ? static_cast<int>(std::ceil(length / gap)) : 1;
        for (int k = 0; k < parts; ++k) finer.push_back(u[i] + (u[i + 1] - u[i]) * k / parts);
      }
      finer.push_back(u.back());
      if (finer.size() == u.size()) break;
      u = std::move(finer);
      x.clear();
      for (const double t : u) x.push_back(at(t, 0));
    }
  }

  // Newton's method from the nearest sample, limited to the interval of its neighbours.
  double distance(const Vec3& p) const {
    size_t nearest = 0;
    double best = 1e300;
    for (size_t i = 0; i < x.size(); ++i)
      if (const double d = (x[i] - p).squaredNorm(); d < best) {
        best = d;
        nearest = i;
      }
    const double low = u[nearest > 0 ? nearest - 1 : 0],
                 high = u[std::min(nearest + 1, u.size() - 1)];
    double t = u[nearest];
    for (int i = 0; i < kNewtonSteps; ++i) {
      const Vec3 d = at(t, 0) - p, d1 = at(t, 1);
      const double slope = d1.squaredNorm() + d.dot(at(t, 2));
      if (slope > 0) t = std::clamp(t - d.dot(d1) / slope, low, high);
      best = std::min(best, (at(t, 0) - p).squaredNorm());
    }
    return std::sqrt(best);
  }
  double largest_distance(const Stroke& points) const {
    double largest = 0;
    for (const Vec3& p : points) largest = std::max(largest, distance(p));
    return largest;
  }
  // Distance of the curve from the polyline through the points: reveals loops and bulges between
  // points.
  double max_polyline_distance(const Stroke& points) const {
    double largest = 0;
    for (const Vec3& p : x) {
      double nearest = (p - points[0]).squaredNorm();
      for (size_t i = 0; i + 1 < points.size(); ++i) {
        const Vec3 a = points[i], d = points[i + 1] - a;
        const double s = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (a + s * d - p).squaredNorm());
      }
      largest = std::max(largest, nearest);
    }
    return std::sqrt(largest);
  }
  double rms_distance(const Stroke& points) const {
    double sum = 0;
    for (const Vec3& p : points) sum += std::pow(distance(p), 2);
    return std::sqrt(sum / static_cast<double>(points.size()));
  }

  Stroke even_samples(int count) const {
    std::vector<double> arc = {0};
    for (size_t i = 1; i < x.size(); ++i) arc.push_back(arc.back() + (x[i] - x[i - 1]).norm());
    Stroke even;
    size_t i = 0;
    for (int k = 0; k < count; ++k) {
      const double s = arc.back() * k / (count - 1);
      while (i + 2 < arc.size() && arc[i + 1] < s) ++i;
      const double part = std::clamp((s - arc[i]) / (arc[i + 1] - arc[i]), 0.0, 1.0);
      even.push_back(at(u[i] + part * (u[i + 1] - u[i]), 0));
    }
    return even;
  }
};

inline Sampled sampled(const HermiteCurve& curve) {
  return {[&curve](double u, int order) { return curve.evaluate(u, order); }, curve.parameters()};
}
// ---- SciPy, in a separate process -----------------------------------------------------------

class Scipy {
 public:
  Scipy() {
    // The first python3 in PATH may be without SciPy.
    for (const char* python : {"python3", "/usr/bin/python3"}) {
      python_ = python;
      version_ = output("version");
      if (!version_.empty()) break;
    }
    folder_ = batten_test::scratch("curves");
  }
  ~Scipy() { std::filesystem::remove_all(folder_.parent_path()); }
  const std::string& version() const { return version_; }

  /// Output of the script for rows of doubles; nothing if it fails.
  std::vector<double> run(const std::string& work, const std::vector<double>& in) const {
    if (version_.empty()) return {};
    const std::filesystem::path from = folder_ / "in", to = folder_ / "out";
    std::filesystem::remove(to);
    std::ofstream(from, std::ios::binary)
        .write(reinterpret_cast<const char*>(in.data()),
               static_cast<std::streamsize>(in.size() * sizeof(double)));
    output(work + " '" + from.string() + "' '" + to.string() + "'");
    std::vector<double> out;
    if (!std::filesystem::exists(to)) return out;
    out.resize(std::filesystem::file_size(to) / sizeof(double));
    std::ifstream(to, std::ios::binary)
        .read(reinterpret_cast<char*>(out.data()),
              static_cast<std::streamsize>(out.size() * sizeof(double)));
    return out;
  }

 private:
  std::string output(const std::string& words) const {
    const std::string errors = words == "version" ? " 2>/dev/null" : "";
    FILE* pipe =
        popen((python_ + " '" BATTEN_BENCH_SCIPY_CURVES_PY "' " + words + errors).c_str(), "r");
    if (!pipe) return {};
    std::string all;
    char buffer[256];
    while (std::fgets(buffer, sizeof buffer, pipe)) all += buffer;
    pclose(pipe);
    while (!all.empty() && all.back() == '\n') all.pop_back();
    return all;
  }
  std::string python_, version_;
  std::filesystem::path folder_;
};

inline void append(std::vector<double>& row, const Stroke& points) {
  for (const Vec3& p : points) row.insert(row.end(), {p.x(), p.y(), p.z()});
}

// ---- exact curves -----------------------------------------------------------------------------

constexpr int kNoisyPoints = 200, seeds = 20, kNoiseSamples = 500;

struct TrueCurve {
  std::string name;
  std::function<Vec3(double)> at;  // for parameters in [0, 1]
};

inline std::vector<TrueCurve> true_curves() {
  const auto helix = [](double t) {
    const double a = 1.75 * 2 * std::numbers::pi * t;
    return Vec3(std::cos(a), std::sin(a), 1.2 * t);
  };
  const auto cubic = [](double t) {
    const double s = 1 - t;
    return Vec3(s * s * s * Vec3(0, 0, 0) + 3 * s * s * t * Vec3(0.4, 1.1, 0.3) +
                3 * s * t * t * Vec3(1.4, -0.6, 0.9) + t * t * t * Vec3(2, 0.5, 0.2));
  };
  // Windscreen, roof and rear window: a soft minimum of three arcs, in metres, slightly non-planar.
  const auto roof = [](double t) {
    const double x = 3.2 * t, sharp = 14;
    const double screen = 0.05 + 0.62 * x - 0.06 * x * x,
                 top = 0.62 - 0.035 * (x - 1.5) * (x - 1.5),
                 rear = 0.12 + 0.42 * (3.2 - x) - 0.03 * (3.2 - x) * (3.2 - x);
    const double z =
        -std::log(std::exp(-sharp * screen) + std::exp(-sharp * top) + std::exp(-sharp * rear)) /
        sharp;
    return Vec3(x, 0.02 * (x - 1.6) * (x - 1.6), z);
  };
  return {{"helix, 1.75 turns", helix}, {"space cubic", cubic}, {"roof line", roof}};
}

// Finite differences are sufficient: the derivatives are only used by Newton's method.
inline Sampled sampled(const TrueCurve& curve) {
  std::vector<double> knots;
  for (int i = 0; i <= 32; ++i) knots.push_back(i / 32.0);
  return {[at = curve.at](double t, int order) -> Vec3 {
            constexpr double h = 1e-4;
            if (order == 0) return at(t);
            if (order == 1) return (at(t + h) - at(t - h)) / (2 * h);
            return (at(t + h) - 2 * at(t) + at(t - h)) / (h * h);
          },
          knots};
}

// Hermite interpolation with the slopes of the curve itself.
inline HermiteCurve hermite(const Sampled& curve) {
  constexpr int nodes = 401;
  std::vector<double> u;
  Points x(nodes, 3), slope(nodes, 3);
  for (int i = 0; i < nodes; ++i) {
    u.push_back(static_cast<double>(i) / (nodes - 1));
    x.row(i) = curve.at(u.back(), 0);
    slope.row(i) = curve.at(u.back(), 1);
  }
  return {u, x, slope};
}

}  // namespace batten::bench
