// SPDX-License-Identifier: MPL-2.0
// Fairing of typical user curves: waves of curvature, outliers, jitter, airfoils.
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "batten/fairing/curves/fair_curve.h"
#include "bench.h"
#include "curve_measures.h"

namespace {

using namespace batten;
using namespace batten::bench;

using Random = std::mt19937_64;
using std::numbers::pi;
const std::vector<double> parts = {0.001, 0.003, 0.01};  // noise as a fraction of the size

Stroke points_on(const TrueCurve& curve) {
  Stroke points;
  for (int i = 0; i < kNoisyPoints; ++i)
    points.push_back(curve.at(static_cast<double>(i) / (kNoisyPoints - 1)));
  return points;
}

Vec3 gauss(Random& random, double sigma) {
  std::normal_distribution<double> normal(0, sigma);
  const double x = normal(random), y = normal(random), z = normal(random);
  return {x, y, z};
}

double percentile(std::vector<double> values, double fraction) {
  const auto at =
      values.begin() + static_cast<long>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// ---- waves of curvature ----------------------------------------------------------------------

void waves_table(Checks& checks) {
  const TrueCurve sine{"sine",
                       [](double t) { return Vec3(10 * t, 0.6 * std::sin(8 * pi * t), 0); }};
  std::vector<TrueCurve> curves = true_curves();
  curves.push_back(sine);
  Table table;
  table.add({"curvature extrema", "sigma/size", "input", "faired", "exact"});
  double worst = 0;
  for (const TrueCurve& curve : curves) {
    const int truth = fairness(hermite(sampled(curve))).extrema;
    for (const double part : parts) {
      std::vector<double> given, faired;
      for (int seed = 1; seed <= seeds; ++seed) {
        Random random(static_cast<unsigned>(seed));
        Stroke points = points_on(curve);
        const double sigma = part * size_of(points);
        for (Vec3& p : points) {
          p += gauss(random, sigma);
          if (curve.name == sine.name) p.z() = 0;
        }
        given.push_back(fairness(interpolating_spline("noisy", points)).extrema);
        faired.push_back(fairness(fair_points("noisy", points).curve).extrema);
      }
      table.add({curve.name, text("%.1f %%", 100 * part), text("%.0f", median(given)),
                 text("%.0f", median(faired)), text("%d", truth)});
      // A helix has no waves: every wave found in noise is a false positive.
      if (truth > 0 && curve.name != true_curves().front().name)
        worst = std::max(worst, median(faired) / truth);
    }
  }
  table.print();
  checks.at_most("curvature extrema over the exact ones (sine, cubic, roof line)", worst, 2);
}

// ---- outliers and jitter ---------------------------------------------------------------------

// 3 % of the points are displaced by another ten standard deviations, in random directions.
Stroke with_outliers(const TrueCurve& curve, double part, Random& random) {
  Stroke points = points_on(curve);
  const double sigma = part * size_of(points);
  std::uniform_real_distribution<double> uniform;
  for (size_t i = 0; i < points.size(); ++i) {
    points[i] += gauss(random, sigma);
    if (i > 1 && i + 2 < points.size() && uniform(random) < 0.03)
      points[i] += 10 * sigma * gauss(random, 1).normalized();
  }
  return points;
}

// Eight waves per coordinate, with wavelengths of 1/40 to 1/20 of the curve's length.
Stroke with_jitter(const TrueCurve& curve, double part, Random& random) {
  Stroke points = points_on(curve);
  const double sigma = part * size_of(points);
  std::uniform_real_distribution<double> uniform;
  for (int wave = 0; wave < 8; ++wave)
    for (int axis = 0; axis < 3; ++axis) {
      const double length = kNoisyPoints / 40.0 * (1 + uniform(random)),
                   phase = 2 * pi * uniform(random);
      for (size_t i = 0; i < points.size(); ++i)
        points[i][axis] += sigma / 2 * std::sin(2 * pi * static_cast<double>(i) / length + phase);
    }
  return points;
}

void robustness_table(Checks& checks) {
  Table table;
  table.add({"rms after over before", "sigma/size", "3 % outliers: median (worst)", "kept",
             "jitter, noise level given", "wavelength given", "nothing given"});
  std::map<std::string, double> worst;
  for (const TrueCurve& curve : true_curves()) {
    const Sampled real = sampled(curve);
    double length = 0;
    for (size_t i = 1; i < real.x.size(); ++i) length += (real.x[i] - real.x[i - 1]).norm();
    for (const double part : parts) {
      std::map<std::string, std::vector<double>> ratio;
      for (int seed = 1; seed <= seeds; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const auto fair = [&](const std::string& kind, const Stroke& points,
                              const FairOptions& options) {
          const HermiteCurve made = fair_points("noisy", points, options).curve;
          ratio[kind].push_back(real.rms_distance(sampled(made).even_samples(kNoiseSamples)) /
                                real.rms_distance(points));
        };
        const Stroke off = with_outliers(curve, part, random);
        FairOptions options;
        fair("outliers", off, options);
        options.reject_outliers = false;
        fair("kept", off, options);
        const Stroke jittered = with_jitter(curve, part, random);
        options = {};
        fair("nothing", jittered, options);
        options.smoothing = FairOptions::Smoothing::Noise;
        options.noise = real.rms_distance(jittered);
        fair("size", jittered, options);
        options.smoothing = FairOptions::Smoothing::Wavelength;
        options.wavelength = length / 8;
        fair("wavelength", jittered, options);
      }
      std::vector<std::string> row = {curve.name, text("%.1f %%", 100 * part)};
      for (const char* kind : {"outliers", "kept", "size", "wavelength", "nothing"}) {
        const auto& r = ratio[kind];
        row.push_back(text("%.2f (%.2f)", median(r), *std::max_element(r.begin(), r.end())));
        worst[kind] = std::max(worst[kind], median(r));
      }
      table.add(row);
    }
  }
  table.print();
  checks.at_most("outliers: largest median of rms after over before", worst["outliers"], 0.5);
  checks.at_most("jitter, given noise level: the same ratio", worst["size"], 0.5);
  checks.at_most("jitter, given wavelength: the same ratio", worst["wavelength"], 0.5);
}

// ---- airfoils --------------------------------------------------------------------------------

// NACA's four-digit section of chord 1, from the trailing edge over the upper side and back.
struct Section {
  double camber, at, thickness;
  int side;  // points per side
  Vec3 point(double t) const {
    const double x = 0.5 * (1 + std::cos(2 * pi * t)), root = std::abs(std::cos(pi * t));
    const double y =
        5 * thickness *
        (0.2969 * root - 0.126 * x - 0.3516 * x * x + 0.2843 * x * x * x - 0.1036 * x * x * x * x);
    const bool front = x < at;
    const double a = front ? at : 1 - at,
                 mean = front ? 2 * at * x - x * x : 1 - 2 * at + 2 * at * x - x * x;
    const double c = camber / (a * a) * mean, slope = 2 * camber / (a * a) * (at - x);
    return Vec3(x, c, 0) + (t < 0.5 ? y : -y) * Vec3(-slope, 1, 0).normalized();
  }
  Stroke points() const {
    Stroke all;
    for (int i = 0; i <= 2 * side; ++i) all.push_back(point(i / (2.0 * side)));
    all.back() = all.front();
    return all;
  }
  // Radius of curvature of the parabola at the nose, perpendicular to the mean line.
  double nose_radius() const {
    return 1.1019 * thickness * thickness / std::hypot(1, 2 * camber / at);
  }
};

std::vector<Section> sections() {
  Random random(5);
  std::uniform_real_distribution<double> uniform;
  std::vector<Section> all;
  for (int k = 0; k < 200; ++k) {
    const double camber = 0.06 * uniform(random), at = 0.2 + 0.4 * uniform(random),
                 thickness = 0.06 + 0.18 * uniform(random);
    all.push_back({camber, at, thickness, 26 + static_cast<int>(54 * uniform(random))});
  }
  return all;
}

// Relative error of the nose radius: osculating circle at the foremost point over the exact radius,
// minus 1.
double nose_error(const HermiteCurve& curve, const Section& section) {
  const CurvePoint nose = curve.closest_point(section.point(0.5));
  const Vec3 d = curve.evaluate(nose.u, 1), dd = curve.evaluate(nose.u, 2);
  const double radius = std::pow(d.norm(), 3) / d.cross(dd).norm();
  return std::abs(radius / section.nose_radius() - 1);
}

void airfoil_table(const Scipy& scipy, Checks& checks) {
  constexpr double sigma = 5e-4;
  std::vector<double> moves, noses, noisy_noses, ratios, theirs;
  unsigned seed = 0;
  for (const Section& section : sections()) {
    const Stroke exact = section.points();
    const FairCurve clean = fair_points("clean", exact);
    moves.push_back(clean.deviation.max);
    noses.push_back(nose_error(clean.curve, section));
    Random random(++seed);
    Stroke points = exact;
    for (Vec3& p : points) {
      p += gauss(random, sigma);
      p.z() = 0;
    }
    const FairCurve fair = fair_points("noisy", points);
    noisy_noses.push_back(nose_error(fair.curve, section));
    std::vector<double> knots;
    for (int i = 0; i <= 64; ++i) knots.push_back(i / 64.0);
    const Sampled real(
        [&section](double t, int order) -> Vec3 {
          constexpr double h = 1e-4;
          const auto at = [&](double u) { return section.point(std::clamp(u, 0.0, 1.0)); };
          if (order == 0) return at(t);
          if (order == 1) return (at(t + h) - at(t - h)) / (2 * h);
          return (at(t + h) - 2 * at(t) + at(t - h)) / (h * h);
        },
        knots);
    const double ours = real.rms_distance(sampled(fair.curve).even_samples(kNoiseSamples));
    ratios.push_back(ours / real.rms_distance(points));
    std::vector<double> in = {1, static_cast<double>(points.size()), kNoiseSamples, sigma};
    append(in, points);
    const std::vector<double> out = scipy.run("noise", in);
    if (out.size() != 2 * kNoiseSamples * 3) continue;
    Stroke x;
    for (size_t i = kNoiseSamples; i < 2 * kNoiseSamples; ++i)
      x.emplace_back(out[3 * i], out[3 * i + 1], out[3 * i + 2]);
    if (!std::isnan(x.front().x())) theirs.push_back(ours / real.rms_distance(x));
  }
  Table table;
  table.add({"200 sections", "median", "90 %", "worst"});
  const auto row = [&](const char* name, const std::vector<double>& v, double factor,
                       const char* format) {
    table.add({name, text(format, factor * median(v)), text(format, factor * percentile(v, 0.9)),
               text(format, factor * percentile(v, 1))});
  };
  row("displacement of exact points over the chord", moves, 1, "%.1e");
  row("error of the nose radius, exact points", noses, 100, "%.1f %%");
  row("error of the nose radius, noise of 0.05 %", noisy_noses, 100, "%.1f %%");
  row("noise: rms after over before", ratios, 1, "%.2f");
  if (!theirs.empty()) row("noise: rms over that of SciPy's GCV spline", theirs, 1, "%.2f");
  table.print();
  checks.at_most("airfoils: largest displacement of exact points over the chord",
                 percentile(moves, 1), 1e-4);
  checks.at_most("airfoils: rms over that of SciPy's GCV spline, median",
                 theirs.empty() ? std::nullopt : std::optional(median(theirs)), 1);
  checks.at_most("airfoils: nose radius of exact points, median error", median(noses), 0.02);
  checks.at_most("airfoils: nose radius of noisy points, median error", median(noisy_noses), 0.02);
}

}  // namespace

int main() {
  one_thread();
  const Scipy scipy;
  std::printf("%s. %d points per curve, %d seeds.\n\n",
              scipy.version().empty() ? "SciPy is missing" : ("SciPy " + scipy.version()).c_str(),
              kNoisyPoints, seeds);
  Checks checks;
  waves_table(checks);
  robustness_table(checks);
  airfoil_table(scipy, checks);
  checks.print("fairing");
}
