// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/network/contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/skinning/network/sampled_curve.h"

namespace batten::detail {
namespace {

// Near misses: at most this many tolerances apart, and at most this fraction of the network size.
constexpr double kNearMiss = 5, kNearMissOfSize = 0.04;

class ContactSearch {
 public:
  ContactSearch(const std::vector<SampledCurve>& sampled_curves, double tolerance, double size)
      : sampled_curves_(sampled_curves),
        tolerance_(tolerance),
        size_(size),
        tree_(sampled_curves) {}

  Contacts run() {
    std::vector<Contact> found = between_chords();
    for (const Contact& c : at_ends()) found.push_back(c);
    std::erase_if(found, [this](const Contact& c) { return is_narrow_part(c); });
    std::sort(found.begin(), found.end(), [](const Contact& p, const Contact& q) {
      return std::tie(p.a, p.b, p.sa, p.sb, p.ea, p.eb) <
             std::tie(q.a, q.b, q.sa, q.sb, q.ea, q.eb);
    });
    std::vector<std::pair<size_t, size_t>> groups;
    for (size_t begin = 0, end; begin < found.size(); begin = end) {
      for (end = begin;
           end < found.size() && found[end].a == found[begin].a && found[end].b == found[begin].b;)
        ++end;
      groups.emplace_back(begin, end);
    }
    std::vector<Contacts> parts(groups.size());
    parallel_for(isize(groups), [&](int g) {
      parts[g] = of_pair({found.begin() + static_cast<long>(groups[g].first),
                          found.begin() + static_cast<long>(groups[g].second)});
    });
    Contacts all;
    for (const Contacts& part : parts) {
      all.joined.insert(all.joined.end(), part.joined.begin(), part.joined.end());
      all.near_misses.insert(all.near_misses.end(), part.near_misses.begin(),
                             part.near_misses.end());
    }
    return all;
  }

 private:
  double reach() const {
    return std::max(tolerance_, std::min(kNearMiss * tolerance_, kNearMissOfSize * size_));
  }

  // For points of one curve: true if they are far enough apart along it, and the curve bends back
  // enough, to count as two points.
  bool apart(const Contact& c) const {
    if (c.a != c.b) return true;
    const double along = sampled_curves_[c.a].between(c.sa, c.sb);
    return along >= 10 * tolerance_ && along > 3 * c.distance;
  }

  // True if two parts of one input curve come close between its corners without touching: they are
  // a thin part of the curve, such as the tail of a profile, not a gap.
  bool is_narrow_part(const Contact& c) const {
    constexpr double kTouching = 1e-3;  // of the tolerance
    const SampledCurve &a = sampled_curves_[c.a], &b = sampled_curves_[c.b];
    const auto is_loose_end = [](const SampledCurve& curve, int end) {
      return end >= 0 && !curve.corner[static_cast<size_t>(end)];
    };
    return c.a != c.b && a.line == b.line && c.distance > kTouching * tolerance_ &&
           !is_loose_end(a, c.ea) && !is_loose_end(b, c.eb);
  }

  void set_lengths(Contact& c) const {
    c.sa = sampled_curves_[c.a].arc_length->length_at(c.ta);
    c.sb = sampled_curves_[c.b].arc_length->length_at(c.tb);
  }

  // Upper bound on nearby pairs of chords. Sketches have up to 35 pairs per chord.
  size_t most_pairs() const {
    size_t chords = 0;
    for (const SampledCurve& sampled_curve : sampled_curves_) chords += sampled_curve.sag.size();
    return 100 * chords + 100'000;
  }

  std::vector<Contact> between_chords() const {
    std::vector<std::pair<int, int>> pairs;
    const size_t most = most_pairs();
    tree_.for_each_near_pair(reach(), [&](int i, int j) {
      if (worth_looking(i, j)) pairs.emplace_back(i, j);
      if (pairs.size() > most)
        throw InputError("network: found too many segments of curves that are closer than " +
                         format_number(reach()) +
                         " to each other; check for curves that are drawn several times");
    });
    std::sort(pairs.begin(), pairs.end());
    constexpr size_t kChunk = 256;
    const size_t chunks = (pairs.size() + kChunk - 1) / kChunk;
    std::vector<std::vector<Contact>> parts(chunks);
    parallel_for(static_cast<int>(chunks), [&](int part) {
      const size_t begin = static_cast<size_t>(part) * kChunk;
      for (size_t k = begin; k < std::min(begin + kChunk, pairs.size()); ++k) {
        const Chord p = tree_.chord(pairs[k].first), q = tree_.chord(pairs[k].second);
        const SampledCurve &a = sampled_curves_[p.sampled_curve],
                           &b = sampled_curves_[q.sampled_curve];
        Contact c{p.sampled_curve, q.sampled_curve};
        double s = 0, t = 0;
        chord_distance(a.x[p.segment], a.x[p.segment + 1], b.x[q.segment], b.x[q.segment + 1], s,
                       t);
        c.ta = a.t[p.segment] + s * (a.t[p.segment + 1] - a.t[p.segment]);
        c.tb = b.t[q.segment] + t * (b.t[q.segment + 1] - b.t[q.segment]);
        c.distance = nearest(a, bracket(a, p.segment), c.ta, b, bracket(b, q.segment), c.tb);
        if (!(c.distance <= reach())) continue;
        set_lengths(c);
        if (c.a == c.b && c.sa > c.sb) std::swap(c.ta, c.tb), std::swap(c.sa, c.sb);
        if (apart(c)) parts[part].push_back(c);
      }
    });
    std::vector<Contact> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
  }

  bool worth_looking(int i, int j) const {
    const Chord p = tree_.chord(i), q = tree_.chord(j);
    const SampledCurve &a = sampled_curves_[p.sampled_curve], &b = sampled_curves_[q.sampled_curve];
    if (p.sampled_curve == q.sampled_curve) {
      const double most = std::max(a.between(a.s[p.segment], a.s[q.segment + 1]),
                                   a.between(a.s[p.segment + 1], a.s[q.segment]));
      if (std::abs(p.segment - q.segment) < 2 || most < 10 * tolerance_) return false;
    }
    double s = 0, t = 0;
    return chord_distance(a.x[p.segment], a.x[p.segment + 1], b.x[q.segment], b.x[q.segment + 1], s,
                          t) <= reach() + a.sag[p.segment] + b.sag[q.segment];
  }

  // Contacts between the ends of curves and all nearby chords.
  std::vector<Contact> at_ends() const {
    std::vector<Contact> all;
    for (int k = 0; k < isize(sampled_curves_); ++k)
      for (int end = 0; end < 2 && !sampled_curves_[k].closed; ++end) {
        const Vec3 p = sampled_curves_[k].end_point(end);
        for (const NearPoint& near_point : tree_.near_points(p, reach())) {
          if (!(near_point.distance <= reach())) continue;
          const SampledCurve& b = sampled_curves_[near_point.sampled_curve];
          Contact c{k, near_point.sampled_curve};
          c.ta = sampled_curves_[k].end_parameter(end);
          c.ea = end;
          c.tb = near_point.t;
          c.distance = near_point.distance;
          set_lengths(c);
          for (int e = 0; e < 2 && !b.closed; ++e)
            if (const double d = (p - b.end_point(e)).norm();
                d <= std::max(tolerance_, c.distance) &&
                std::abs(c.sb - (e ? b.length : 0)) <= 2 * tolerance_) {
              c.eb = e;
              c.tb = b.end_parameter(e);
              c.sb = e ? b.length : 0;
              c.distance = d;
              break;
            }
          if (!apart(c)) continue;
          if (c.a > c.b || (c.a == c.b && c.sa > c.sb)) {
            std::swap(c.a, c.b);
            std::swap(c.ta, c.tb);
            std::swap(c.sa, c.sb);
            std::swap(c.ea, c.eb);
          }
          all.push_back(c);
        }
      }
    return all;
  }

  // True if the curves stay within `limit` of each other between two contacts.
  bool linked(const Contact& p, const Contact& q, double limit) const {
    if (p.distance > limit || q.distance > limit) return false;
    const double along_a = std::abs(q.sa - p.sa), along_b = std::abs(q.sb - p.sb);
    if (std::abs(along_a - along_b) > 0.5 * std::max(along_a, along_b) + 4 * limit) return false;
    if (std::max(along_a, along_b) < 1e-6 * tolerance_) return true;
    const SampledCurve &a = sampled_curves_[p.a], &b = sampled_curves_[p.b];
    const double low = std::min(p.tb, q.tb), high = std::max(p.tb, q.tb);
    constexpr int kSamples = 6;
    for (int k = 1; k < kSamples; ++k) {
      const double f = static_cast<double>(k) / kSamples;
      const Vec3 x = a.point(p.ta + f * (q.ta - p.ta));
      const double t = b.closest_parameter(x, p.tb + f * (q.tb - p.tb), low, high);
      if ((b.point(t) - x).norm() > limit) return false;
    }
    return true;
  }

  // Groups the contacts of one pair of curves into intervals of proximity. Returns the index of
  // each contact's interval; -1: the contact's distance exceeds the limit.
  std::vector<int> intervals(const std::vector<Contact>& contacts, double limit) const {
    const int n = isize(contacts);
    DisjointSets groups(n);
    // Up to nine pairs of chords yield the same contact, and more at the sharp tail of a profile.
    constexpr int kLookAhead = 12;
    for (int i = 0; i < n; ++i)
      for (int j = i + 1;
           j < n && (j < i + kLookAhead || contacts[j].sa - contacts[i].sa <= tolerance_); ++j)
        if (groups.find(i) != groups.find(j) && linked(contacts[i], contacts[j], limit))
          groups.unite(i, j);
    std::vector<int> of(n);
    for (int i = 0; i < n; ++i) of[i] = contacts[i].distance <= limit ? groups.find(i) : -1;
    return of;
  }

  Contacts of_pair(const std::vector<Contact>& contacts) const {
    Contacts result;
    const std::vector<int> wide = intervals(contacts, reach()),
                           narrow = intervals(contacts, tolerance_);
    const int n = isize(contacts);
    std::vector<char> joined(n, 0);
    for (int i = 0; i < n; ++i) {
      if (narrow[i] >= 0) joined[wide[i]] = 1;
      if (narrow[i] != i) continue;
      std::vector<Contact> members;
      for (int j = i; j < n; ++j)
        if (narrow[j] == i) members.push_back(contacts[j]);
      add_interval(members, result.joined);
    }
    for (int i = 0; i < n; ++i) {
      if (wide[i] != i || joined[i]) continue;
      const Contact* best = nullptr;
      const auto rank = [&](const Contact& c) {  // contacts at ends first, then by distance
        return std::tuple(c.ea < 0 && c.eb < 0, std::llround(c.distance / tolerance_ * 1e6));
      };
      for (int j = i; j < n; ++j)
        if (wide[j] == i && (!best || rank(contacts[j]) < rank(*best))) best = &contacts[j];
      result.near_misses.push_back(*best);
    }
    return result;
  }

  // Reduces an interval of proximity to the contacts listed at find_contacts().
  void add_interval(const std::vector<Contact>& members, std::vector<Contact>& out) const {
    const size_t before = out.size();
    for (const Contact& c : members) {
      if (c.ea < 0 && c.eb < 0) continue;
      const auto same =
          std::find_if(out.begin() + static_cast<long>(before), out.end(), [&](const Contact& o) {
            return (c.ea >= 0 && o.ea == c.ea) || (c.eb >= 0 && o.eb == c.eb);
          });
      if (same == out.end())
        out.push_back(c);
      else if (better(c, *same))
        *same = c;
    }
    const auto [first, last] =
        std::minmax_element(members.begin(), members.end(),
                            [](const Contact& p, const Contact& q) { return p.sa < q.sa; });
    const Contact middle = nearest_of(members);
    Contact ends[2] = {middle, middle};
    if (nearly_parallel(middle)) ends[0] = departure(*first, -1), ends[1] = departure(*last, 1);
    if (run_along(ends[0], ends[1])) {
      for (const Contact& c : ends)
        if (std::none_of(out.begin() + static_cast<long>(before), out.end(), [&](const Contact& o) {
              return std::abs(o.sa - c.sa) < 3 * tolerance_ ||
                     std::abs(o.sb - c.sb) < 3 * tolerance_;
            }))
          out.push_back(c);
    } else if (out.size() == before) {
      out.push_back(middle);
    }
  }

  bool nearly_parallel(const Contact& c) const {
    const Vec3 a = sampled_curves_[c.a].curve->evaluate(c.ta, 1),
               b = sampled_curves_[c.b].curve->evaluate(c.tb, 1);
    constexpr double kParallelSine = 0.3;
    return a.cross(b).norm() <= kParallelSine * a.norm() * b.norm();
  }

  // Order of preference: contacts between two ends, then between an end and a curve, then by
  // distance.
  bool better(const Contact& p, const Contact& q) const {
    const auto rank = [&](const Contact& c) {
      return std::tuple(-((c.ea >= 0) + (c.eb >= 0)), std::llround(c.distance / tolerance_ * 1e6));
    };
    return rank(p) < rank(q);
  }

  bool run_along(const Contact& first, const Contact& last) const {
    const double along = std::min(last.sa - first.sa, std::abs(last.sb - first.sb));
    if (along >= 3 * std::sqrt(tolerance_ * size_)) return true;
    if (along < 5 * tolerance_) return false;
    const SampledCurve &a = sampled_curves_[first.a], &b = sampled_curves_[first.b];
    double mean = 0;
    constexpr int kSamples = 8;
    for (int k = 0; k < kSamples; ++k) {
      const double f = (k + 0.5) / kSamples;
      const Vec3 x = a.point(first.ta + f * (last.ta - first.ta));
      const double t =
          b.closest_parameter(x, first.tb + f * (last.tb - first.tb), std::min(first.tb, last.tb),
                              std::max(first.tb, last.tb));
      mean += (b.point(t) - x).norm() / kSamples;
    }
    constexpr double kCoinciding = 0.05;  // of the tolerance; half of a tangent parabola has 0.1
    return mean <= kCoinciding * tolerance_;
  }

  // Walks along a from a contact (`way` = ±1) to the last point at which b is within half the
  // tolerance.
  Contact departure(const Contact& from, int way) const {
    const SampledCurve &a = sampled_curves_[from.a], &b = sampled_curves_[from.b];
    const double limit = std::max(0.5 * tolerance_, from.distance);
    const double to = way > 0 ? a.t.back() : a.t.front();
    const auto closest_parameter = [&](double ta, double tb) {
      return b.closest_parameter(a.point(ta), tb, b.t.front(), b.t.back());
    };
    Contact inside = from;
    inside.ea = inside.eb = -1;
    const double step = (a.t.back() - a.t.front()) / 256;
    double outside = to;
    bool left = false;
    for (int k = 0; k < 512 && inside.ta != to && !left; ++k) {
      const double next = way > 0 ? std::min(inside.ta + step, to) : std::max(inside.ta - step, to);
      const double tb = closest_parameter(next, inside.tb);
      if ((a.point(next) - b.point(tb)).norm() > limit) {
        outside = next;
        left = true;
      } else {
        inside.ta = next;
        inside.tb = tb;
      }
    }
    for (int k = 0; k < 40 && left; ++k) {
      const double middle = 0.5 * (inside.ta + outside), tb = closest_parameter(middle, inside.tb);
      if ((a.point(middle) - b.point(tb)).norm() > limit) {
        outside = middle;
      } else {
        inside.ta = middle;
        inside.tb = tb;
      }
    }
    set_lengths(inside);
    inside.distance = (a.point(inside.ta) - b.point(inside.tb)).norm();
    return inside;
  }

  // The closest contact; if several are equally close, the one in the middle of them.
  Contact nearest_of(const std::vector<Contact>& members) const {
    double least = members[0].distance;
    for (const Contact& c : members) least = std::min(least, c.distance);
    const Contact *low = nullptr, *high = nullptr;
    for (const Contact& c : members) {
      if (c.distance > least + 1e-3 * tolerance_) continue;
      if (!low || c.sa < low->sa) low = &c;
      if (!high || c.sa > high->sa) high = &c;
    }
    if (high->sa - low->sa <= 1e-6 * tolerance_) return *low;
    Contact middle = *low;
    const SampledCurve& b = sampled_curves_[middle.b];
    middle.ta = 0.5 * (low->ta + high->ta);
    const Vec3 x = sampled_curves_[middle.a].point(middle.ta);
    middle.tb = b.closest_parameter(x, 0.5 * (low->tb + high->tb), std::min(low->tb, high->tb),
                                    std::max(low->tb, high->tb));
    set_lengths(middle);
    middle.distance = (b.point(middle.tb) - x).norm();
    return middle;
  }

  const std::vector<SampledCurve>& sampled_curves_;
  double tolerance_, size_;
  ChordTree tree_;
};

}  // namespace

Contacts find_contacts(const std::vector<SampledCurve>& sampled_curves, double tolerance,
                       double size) {
  return ContactSearch(sampled_curves, tolerance, size).run();
}

std::vector<double> end_gaps(const std::vector<SampledCurve>& sampled_curves, double reach,
                             const std::vector<Contact>& contacts) {
  const ChordTree tree(sampled_curves);
  // Arc length, distance.
  std::vector<std::vector<std::pair<double, double>>> met(sampled_curves.size());
  for (const Contact& c : contacts) {
    met[c.a].emplace_back(c.sa, c.distance);
    met[c.b].emplace_back(c.sb, c.distance);
  }
  std::vector<double> gaps;
  for (const SampledCurve& sampled_curve : sampled_curves)
    for (int end = 0; end < 2 && !sampled_curve.closed; ++end) {
      if (sampled_curve.corner[end]) continue;
      double& gap = gaps.emplace_back(std::numeric_limits<double>::infinity());
      const double nearest = tree.distance(sampled_curve.end_point(end), sampled_curve.line);
      if (nearest <= reach) gap = nearest;
      for (const auto& [s, distance] : met[&sampled_curve - sampled_curves.data()])
        if (std::abs(s - (end ? sampled_curve.length : 0)) <= reach) gap = std::min(gap, distance);
    }
  return gaps;
}

namespace {

std::vector<Chord> chords_of(const std::vector<SampledCurve>& sampled_curves) {
  std::vector<Chord> chords;
  for (int k = 0; k < isize(sampled_curves); ++k)
    for (int i = 0; i < sampled_curves[k].segments(); ++i) chords.push_back({k, i});
  return chords;
}

BoxTree<3> tree_of(const std::vector<SampledCurve>& sampled_curves,
                   const std::vector<Chord>& chords) {
  std::vector<Box3> boxes;
  for (const Chord& c : chords) {
    const SampledCurve& sampled_curve = sampled_curves[c.sampled_curve];
    const Vec3 sag = Vec3::Constant(sampled_curve.sag[c.segment]);
    Box3& box = boxes.emplace_back();
    for (const Vec3& p : {sampled_curve.x[c.segment], sampled_curve.x[c.segment + 1]})
      box.extend(Box3(p - sag, p + sag));
  }
  return BoxTree<3>(boxes);
}

// Parameter of the point closest to p on the curve near one of its chords.
double closest_parameter_near(const SampledCurve& sampled_curve, int segment, const Vec3& p) {
  const Vec3 chord = sampled_curve.x[segment + 1] - sampled_curve.x[segment];
  const double along = std::clamp(
      (p - sampled_curve.x[segment]).dot(chord) / std::max(chord.squaredNorm(), 1e-300), 0.0, 1.0);
  const auto range = bracket(sampled_curve, segment);
  return sampled_curve.closest_parameter(
      p,
      sampled_curve.t[segment] + along * (sampled_curve.t[segment + 1] - sampled_curve.t[segment]),
      range[0], range[1]);
}

}  // namespace

ChordTree::ChordTree(const std::vector<SampledCurve>& sampled_curves)
    : sampled_curves_(sampled_curves),
      chords_(chords_of(sampled_curves)),
      tree_(tree_of(sampled_curves, chords_)) {}

double ChordTree::distance(const Vec3& p, int except) const {
  const auto distance2 = [&](int i) {
    const SampledCurve& curve = sampled_curves_[chords_[i].sampled_curve];
    if (curve.line == except) return std::numeric_limits<double>::infinity();
    return (curve.point(closest_parameter_near(curve, chords_[i].segment, p)) - p).squaredNorm();
  };
  return std::sqrt(tree_.nearest(p, distance2).distance2);
}

std::vector<NearPoint> ChordTree::near_points(const Vec3& p, double reach) const {
  std::vector<int> near;
  tree_.for_each_near(Box3(p), reach, [&](int i) { near.push_back(i); });
  std::sort(near.begin(), near.end());
  std::vector<NearPoint> points;
  for (const int i : near) {
    const SampledCurve& sampled_curve = sampled_curves_[chords_[i].sampled_curve];
    const double t = closest_parameter_near(sampled_curve, chords_[i].segment, p);
    points.push_back({chords_[i].sampled_curve, t, (sampled_curve.point(t) - p).norm()});
  }
  return points;
}

}  // namespace batten::detail
