// SPDX-License-Identifier: MPL-2.0
// Curves through points: Batten's fit and fairing compared with SciPy and OpenCASCADE.
// Noise: how much closer the faired curve is to the exact one than the points. Sketches: number of
// segments and time of a fit to a tolerance. Strokes: fit and fairing of every stroke of every
// sketch.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <random>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/tests/support/test_data.h"
#include "bench.h"
#include "curve_measures.h"
#include "occ_curve_fit.h"

namespace {

namespace fs = std::filesystem;
using namespace batten;
using namespace batten::bench;

using bench::sampled;
Sampled sampled(const OccCurveFit& fit) {
  return {[&fit](double u, int order) { return fit.evaluate(u, order); }, fit.knots()};
}

// Wall-clock time, as measured by the Python side; medians of single calls, robust against other
// load.
double call_time(const std::function<void()>& call) {
  const auto start = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// ---- noise -----------------------------------------------------------------------------------

void noise_table(const Scipy& scipy, Checks& checks) {
  struct Problem {
    size_t curve;
    double sigma;
    Stroke points;
    std::map<std::string, double> ratio;
  };
  const std::vector<TrueCurve> curves = true_curves();
  const std::vector<double> parts = {0.001, 0.003, 0.01};
  std::vector<Sampled> truth;
  std::vector<Problem> problems;
  for (size_t c = 0; c < curves.size(); ++c) {
    truth.push_back(sampled(curves[c]));
    const double size = size_of(truth[c].x);
    for (const double part : parts)
      for (int seed = 1; seed <= seeds; ++seed) {
        std::mt19937_64 random(static_cast<unsigned>(seed));
        std::normal_distribution<double> normal(0, part * size);
        Problem p{c, part * size, {}, {}};
        for (int i = 0; i < kNoisyPoints; ++i) {
          const Vec3 x = curves[c].at(static_cast<double>(i) / (kNoisyPoints - 1));
          const double dx = normal(random), dy = normal(random), dz = normal(random);
          p.points.push_back(x + Vec3(dx, dy, dz));
        }
        problems.push_back(std::move(p));
      }
  }

  std::vector<double> in = {static_cast<double>(problems.size()), kNoisyPoints, kNoiseSamples};
  for (const Problem& p : problems) {
    in.push_back(p.sigma);
    append(in, p.points);
  }
  const std::vector<double> theirs = scipy.run("noise", in);
  const bool has_scipy = theirs.size() == problems.size() * 2 * kNoiseSamples * 3;

  // Tol3D is three standard deviations of a coordinate.
  std::vector<std::pair<std::string, OccCurveFitSettings>> occ;
  if (!occ_curves_version().empty())
    for (const char* name : {"OCC approximation", "OCC variational"}) {
      OccCurveFitSettings s;
      s.variational = name == std::string("OCC variational");
      s.degree = s.variational ? 8 : 3;
      occ.emplace_back(name, s);
    }

  std::vector<std::vector<double>> extrema(problems.size());
  for (size_t k = 0; k < problems.size(); ++k) {
    Problem& p = problems[k];
    const Sampled& real = truth[p.curve];
    const double before = real.rms_distance(p.points);
    const FairCurve fair = fair_points("noisy", p.points);
    p.ratio["Batten"] = real.rms_distance(sampled(fair.curve).even_samples(kNoiseSamples)) / before;
    extrema[k] = {static_cast<double>(fairness(interpolating_spline("noisy", p.points)).extrema),
                  static_cast<double>(fairness(fair.curve).extrema)};
    for (int method = 0; has_scipy && method < 2; ++method) {
      const double* row = &theirs[(2 * k + static_cast<size_t>(method)) * kNoiseSamples * 3];
      Stroke x;
      for (int i = 0; i < kNoiseSamples; ++i)
        x.emplace_back(row[3 * i], row[3 * i + 1], row[3 * i + 2]);
      if (!std::isnan(row[0]))
        p.ratio[method == 0 ? "splprep" : "GCV"] = real.rms_distance(x) / before;
    }
    for (auto& [name, settings] : occ) {
      settings.tolerance = 3 * p.sigma;
      const OccCurveFit fit(p.points, settings);
      if (fit.done())
        p.ratio[name] = real.rms_distance(sampled(fit).even_samples(kNoiseSamples)) / before;
    }
  }

  std::printf(
      "Noise: %d points, %d seeds. rms distance of the faired curve from the exact one over that "
      "of "
      "the points,\nmedian (worst). splprep gets the true sigma; GCV is "
      "make_smoothing_spline.\n\n",
      kNoisyPoints, seeds);
  const std::vector<std::string> methods = {"Batten", "splprep", "GCV", "OCC approximation",
                                            "OCC variational"};
  Table table;
  table.add({"curve", "sigma/size", "Batten", "SciPy splprep", "SciPy GCV", "OCC approximation",
             "OCC variational", "curvature extrema: input", "faired", "exact"});
  double largest_median = 0, largest = 0;
  for (size_t first = 0; first < problems.size(); first += seeds) {
    const size_t c = problems[first].curve;
    std::vector<std::string> row = {curves[c].name,
                                    text("%.1f %%", 100 * parts[first / seeds % parts.size()])};
    for (const std::string& method : methods) {
      std::vector<double> ratios;
      for (size_t k = first; k < first + seeds; ++k)
        if (const auto it = problems[k].ratio.find(method); it != problems[k].ratio.end())
          ratios.push_back(it->second);
      if (ratios.empty()) {
        row.push_back("none");
        continue;
      }
      const double worst = *std::max_element(ratios.begin(), ratios.end());
      const std::string failed =
          ratios.size() < seeds ? text(", %zu failed", seeds - ratios.size()) : "";
      row.push_back(text("%.2f (%.2f%s)", median(ratios), worst, failed.c_str()));
      if (method != "Batten") continue;
      largest_median = std::max(largest_median, median(ratios));
      largest = std::max(largest, worst);
    }
    std::vector<double> given, fair;
    for (size_t k = first; k < first + seeds; ++k) {
      given.push_back(extrema[k][0]);
      fair.push_back(extrema[k][1]);
    }
    row.push_back(text("%.0f", median(given)));
    row.push_back(text("%.1f", median(fair)));
    row.push_back(text("%d", fairness(hermite(truth[c])).extrema));
    table.add(row);
  }
  table.print();
  checks.at_most("noise: largest median of rms after over before", largest_median, 0.5);
  checks.at_most("noise: largest ratio", largest, 1);
}

// ---- sketches --------------------------------------------------------------------------------

std::vector<Stroke> read_strokes(const fs::path& path) {
  std::vector<Stroke> strokes;
  std::ifstream in(path);
  for (std::string word; in >> word;) {
    if (word == "v") {
      in >> word;
      strokes.emplace_back();
      continue;
    }
    Vec3 p(std::stod(word), 0, 0);
    in >> p.y() >> p.z();
    strokes.back().push_back(p);
  }
  return strokes;
}

// Synthetic strokes: arcs, waves and straight strokes of 2 to 40 unevenly spaced points, with a
// jitter of half a percent.
std::vector<Stroke> synthetic_strokes(int count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> even(-1, 1);
  std::normal_distribution<double> normal(0, 1);
  std::vector<Stroke> strokes;
  for (int k = 0; k < count; ++k) {
    const double u = 0.5 + 0.5 * even(random);
    const int n = 2 + static_cast<int>(38 * u * u * u);
    const auto vector = [&] { return Vec3(even(random), even(random), even(random)); };
    const Vec3 a = vector(), b = vector(), c = vector(), d = vector();
    const double wave = 2 + 4 * std::abs(even(random));
    Stroke s;
    for (int i = 0; i < n; ++i) {
      const double t = (i + 0.3 * even(random)) / std::max(n - 1, 1), r = 1 - t;
      Vec3 p = r * r * r * a + 3 * r * r * t * b + 3 * r * t * t * c + t * t * t * d;
      if (k % 3 == 0) p += 0.1 * std::sin(wave * t) * b;
      const double x = normal(random), y = normal(random), z = normal(random);
      s.push_back(p + 0.005 * Vec3(x, y, z));
    }
    strokes.push_back(std::move(s));
  }
  return strokes;
}

// SciPy rejects points that repeat their predecessor.
Stroke distinct(const Stroke& points) {
  Stroke kept;
  for (const Vec3& p : points)
    if (kept.empty() || p != kept.back()) kept.push_back(p);
  return kept;
}

struct Total {
  std::string name;
  int spans = 0, over = 0, failed = 0;  // over: strokes outside the tolerance
  double seconds = 0, largest = 0;      // deviation over tolerance
  double max_polyline_distance = 0;     // as a fraction of the size
  int far = 0;                          // strokes that stray by more than a tenth of the size
  void add(int stroke_spans, double deviation, double stroke_straying, double stroke_seconds) {
    spans += stroke_spans;
    seconds += stroke_seconds;
    largest = std::max(largest, deviation);
    over += deviation > 1 + 1e-9;
    max_polyline_distance = std::max(max_polyline_distance, stroke_straying);
    far += stroke_straying > 0.1;
  }
};

// Median seconds of each call, in `rounds` rounds over all of them.
void time_rounds(const std::vector<std::function<void()>>& calls, int rounds,
                 std::vector<std::vector<double>>& seconds) {
  seconds.resize(calls.size());
  for (int round = -1; round < rounds; ++round)
    for (size_t k = 0; k < calls.size(); ++k) {
      call_time(calls[k]);  // brings code and points back into the caches, as in successive calls
      const double t = call_time(calls[k]);
      if (round >= 0) seconds[k].push_back(t);
    }
}

struct SketchResult {
  double over_scipy_spans = 0, over_occ_spans = 0;
  double scipy_time = 0, occ_time = 0;  // relative to Batten's
  double deviation = 0;
};

SketchResult fit_sketch(const std::string& name, const std::vector<Stroke>& all, double part,
                        const Scipy& scipy) {
  std::vector<Stroke> strokes;
  for (const Stroke& s : all)
    if (distinct(s).size() > 1) strokes.push_back(distinct(s));

  const size_t n = strokes.size();
  std::vector<FitOptions> smooth(n), corners(n);
  std::vector<double> reached(n);
  Total ours{"Batten"}, with_corners{"Batten, default corners"};
  std::vector<std::function<void()>> calls, corner_calls;
  for (size_t k = 0; k < n; ++k) {
    smooth[k].tolerance = corners[k].tolerance = part * size_of(strokes[k]);
    smooth[k].closed = corners[k].closed = false;
    smooth[k].corner_angle = 180;
    calls.push_back([&, k] { fit_points("stroke", strokes[k], smooth[k]); });
    corner_calls.push_back([&, k] { fit_points("stroke", strokes[k], corners[k]); });
  }
  constexpr int rounds = 15;
  std::vector<std::vector<double>> seconds, corner_seconds;
  time_rounds(calls, rounds, seconds);

  // SciPy runs between the two halves of Batten's rounds.
  std::vector<double> in = {static_cast<double>(n)};
  for (size_t k = 0; k < n; ++k) {
    reached[k] =
        sampled(fit_points("stroke", strokes[k], smooth[k]).curve).largest_distance(strokes[k]);
    in.insert(in.end(), {static_cast<double>(strokes[k].size()), smooth[k].tolerance,
                         std::max(reached[k], 1e-9 * size_of(strokes[k]))});
    append(in, strokes[k]);
  }
  const std::vector<double> theirs = scipy.run("sketch", in);
  time_rounds(calls, rounds, seconds);
  time_rounds(corner_calls, 5, corner_seconds);

  const auto add = [&](Total& total, size_t k, int spans, const Sampled& curve, double time) {
    total.add(spans, curve.largest_distance(strokes[k]) / smooth[k].tolerance,
              curve.max_polyline_distance(strokes[k]) / size_of(strokes[k]), time);
  };
  std::vector<Total> totals;
  for (size_t k = 0; k < n; ++k) {
    const CurveFit fit = fit_points("stroke", strokes[k], smooth[k]);
    add(ours, k, fit.curve.segment_count(), sampled(fit.curve), median(seconds[k]));
    const CurveFit cut = fit_points("stroke", strokes[k], corners[k]);
    add(with_corners, k, cut.curve.segment_count(), sampled(cut.curve), median(corner_seconds[k]));
  }
  totals = {ours, with_corners};

  SketchResult result;
  result.deviation = std::max(ours.largest, with_corners.largest);
  if (theirs.size() == 8 * n) {
    Total scipy_tolerance{"SciPy"}, scipy_equal{"SciPy, to Batten's deviations"};
    for (size_t k = 0; k < n; ++k) {
      const double* row = &theirs[8 * k];
      const double size = size_of(strokes[k]);
      scipy_tolerance.add(static_cast<int>(row[0]), row[1] / smooth[k].tolerance, row[2] / size,
                          row[3]);
      scipy_equal.add(static_cast<int>(row[4]), row[5] / smooth[k].tolerance, row[6] / size,
                      row[7]);
    }
    totals.push_back(scipy_tolerance);
    totals.push_back(scipy_equal);
    result.over_scipy_spans = static_cast<double>(ours.spans) / scipy_tolerance.spans;
    result.scipy_time = scipy_tolerance.seconds / ours.seconds;
  }
  for (const int continuity : {1, 2}) {
    if (occ_curves_version().empty()) break;
    Total occ{text("OpenCASCADE C%d", continuity)};
    std::vector<std::function<void()>> works;
    std::vector<OccCurveFitSettings> settings(n);
    for (size_t k = 0; k < n; ++k) {
      settings[k].tolerance = smooth[k].tolerance;
      settings[k].continuity = continuity;
      // If it misses its tolerance, a tighter one is requested.
      for (int tries = 0; tries < 12; ++tries) {
        const OccCurveFit fit(strokes[k], settings[k]);
        if (!fit.done() ||
            sampled(fit).largest_distance(strokes[k]) <= smooth[k].tolerance * (1 + 1e-9))
          break;
        settings[k].tolerance *= 0.7;
      }
      works.push_back([&, k] { OccCurveFit(strokes[k], settings[k]); });
    }
    std::vector<std::vector<double>> occ_seconds;
    time_rounds(works, 5, occ_seconds);
    for (size_t k = 0; k < n; ++k) {
      const OccCurveFit fit(strokes[k], settings[k]);
      if (!fit.done()) {
        ++occ.failed;
        continue;
      }
      add(occ, k, static_cast<int>(fit.knots().size()) - 1, sampled(fit), median(occ_seconds[k]));
    }
    totals.push_back(occ);
    const double spans = static_cast<double>(ours.spans) / occ.spans,
                 time = occ.seconds / ours.seconds;
    result.over_occ_spans = std::max(result.over_occ_spans, spans);
    result.occ_time = continuity == 1 ? time : std::min(result.occ_time, time);
  }

  Table table;
  table.add({text("%s, %.1f %%, %zu strokes", name.c_str(), 100 * part, n), "segments",
             "milliseconds", "largest deviation/tolerance", "strokes outside", "straying/size",
             "strokes over 10 %", "failed"});
  for (const Total& t : totals)
    table.add({t.name, std::to_string(t.spans), text("%.2f", 1e3 * t.seconds),
               text("%.3f", t.largest), std::to_string(t.over),
               text("%.1f %%", 100 * t.max_polyline_distance), std::to_string(t.far),
               std::to_string(t.failed)});
  table.print();
  return result;
}

// ---- every stroke ----------------------------------------------------------------------------

void stroke_table(const std::vector<std::pair<std::string, std::vector<Stroke>>>& sketches,
                  Checks& checks) {
  std::printf(
      "Every stroke: fitted to 0.5 %% of its size, and faired with default options. Times are "
      "means "
      "per stroke.\n\n");
  Table table;
  table.add({"sketch", "strokes", "points", "segments", "deviation/size", "fit us", "fair us",
             "extrema before", "after", "inflections before", "after", "straying", "failed"});
  int failures = 0;
  std::vector<std::string> single;
  for (const auto& [name, strokes] : sketches) {
    int points = 0, segments = 0, failed = 0, stray = 0, extrema[2] = {}, inflections[2] = {},
        used = 0;
    double deviation = 0, fit_seconds = 0, fair_seconds = 0;
    for (size_t k = 0; k < strokes.size(); ++k) {
      const Stroke& s = strokes[k];
      const std::string stroke = name + " " + std::to_string(k + 1);
      points += static_cast<int>(s.size());
      if (distinct(s).size() < 2) {
        single.push_back(stroke);
        continue;
      }
      try {
        const double size = size_of(s);
        FitOptions options;
        options.tolerance = 0.005 * size;
        CurveFit fit;
        FairCurve fair;
        std::vector<std::vector<double>> seconds;
        time_rounds(
            {[&] { fit = fit_points(stroke, s, options); }, [&] { fair = fair_points(stroke, s); }},
            3, seconds);
        const double off = sampled(fit.curve).largest_distance(s);
        if (off > options.tolerance * (1 + 1e-9) || !fair.curve.dofs().allFinite()) {
          std::printf("failed: %s, %.3g of the size from its points\n", stroke.c_str(), off / size);
          ++failed;
        }
        stray += fit.deviation.between > options.tolerance;
        ++used;
        segments += fit.curve.segment_count();
        deviation = std::max(deviation, off / size);
        fit_seconds += median(seconds[0]);
        fair_seconds += median(seconds[1]);
        const Fairness as_given = fairness(interpolating_spline(stroke, s)),
                       after = fairness(fair.curve);
        extrema[0] += as_given.extrema;
        extrema[1] += after.extrema;
        inflections[0] += as_given.inflections;
        inflections[1] += after.inflections;
      } catch (const std::exception& e) {
        std::printf("failed: %s: %s\n", stroke.c_str(), e.what());
        ++failed;
      }
    }
    failures += failed;
    table.add({name, std::to_string(strokes.size()), std::to_string(points),
               std::to_string(segments), text("%.3f %%", 100 * deviation),
               text("%.0f", 1e6 * fit_seconds / std::max(used, 1)),
               text("%.0f", 1e6 * fair_seconds / std::max(used, 1)), std::to_string(extrema[0]),
               std::to_string(extrema[1]), std::to_string(inflections[0]),
               std::to_string(inflections[1]), std::to_string(stray), std::to_string(failed)});
  }
  table.print();
  std::printf("Strokes without two distinct points, skipped: %zu.", single.size());
  for (const std::string& s : single) std::printf(" %s", s.c_str());
  std::printf("\n\n");
  checks.at_most("strokes that fail", failures, 0);
}

}  // namespace

int main() {
  one_thread();
  const Scipy scipy;
  const std::string occ = occ_curves_version();
  std::printf("%s, %s. Wall-clock medians on one thread.\n\n",
              scipy.version().empty() ? "SciPy is missing" : ("SciPy " + scipy.version()).c_str(),
              occ.empty() ? "OpenCASCADE is missing" : ("OpenCASCADE " + occ).c_str());

  Checks checks;
  noise_table(scipy, checks);

  std::vector<std::pair<std::string, std::vector<Stroke>>> sketches, drawn;
  if (const fs::path folder = batten_test::optional_data("sketch-cassie/curves"); !folder.empty()) {
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".curves")
        sketches.emplace_back(entry.path().stem().string(), read_strokes(entry.path()));
    std::sort(sketches.begin(), sketches.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& s : sketches)
      if (s.first == "guitar" || s.first == "vintage_car") drawn.push_back(s);
  }
  if (drawn.size() < 2) {
    std::printf("No sketches (BATTEN_TEST_DATA): synthetic strokes instead.\n\n");
    drawn = {{"synthetic 1", synthetic_strokes(150, 1)},
             {"synthetic 2", synthetic_strokes(150, 2)}};
    sketches = drawn;
  }
  std::printf(
      "Sketches: open, without corners, degree 3. SciPy: splprep with the largest s within the "
      "tolerance.\nStraying: of the curve from the polyline through the points.\n\n");
  SketchResult worst{0, 0, 1e300, 1e300, 0};
  bool has_scipy = !scipy.version().empty();
  for (const auto& [name, strokes] : drawn)
    for (const double part : {0.01, 0.002}) {
      const SketchResult r = fit_sketch(name, strokes, part, scipy);
      has_scipy = has_scipy && r.over_scipy_spans > 0;
      worst.over_scipy_spans = std::max(worst.over_scipy_spans, r.over_scipy_spans);
      worst.over_occ_spans = std::max(worst.over_occ_spans, r.over_occ_spans);
      worst.scipy_time = std::min(worst.scipy_time, r.scipy_time);
      worst.occ_time = std::min(worst.occ_time, r.occ_time);
      worst.deviation = std::max(worst.deviation, r.deviation);
    }
  const auto with = [](bool there, double value) {
    return there && value > 0 ? std::optional(value) : std::nullopt;
  };
  const bool has_occ = !occ.empty();
  checks.at_most("sketches: largest deviation over the tolerance", worst.deviation, 1 + 1e-9);
  checks.at_most("sketches: segments over SciPy's", with(has_scipy, worst.over_scipy_spans), 1);
  checks.at_most("sketches: segments over OpenCASCADE's", with(has_occ, worst.over_occ_spans), 1);
  checks.at_least("sketches: SciPy's time over Batten's", with(has_scipy, worst.scipy_time), 1);
  checks.at_least("sketches: OpenCASCADE's time over Batten's", with(has_occ, worst.occ_time), 1);

  stroke_table(sketches, checks);
  checks.print("curves");
}
