// SPDX-License-Identifier: MPL-2.0
#include "batten/core/box_tree.h"

#include <cmath>
#include <limits>
#include <mutex>
#include <random>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten;
using namespace batten_test;

namespace {

using Pairs = std::vector<std::pair<int, int>>;

// Numbers in [0, 1), the same on all platforms.
class Numbers {
 public:
  explicit Numbers(unsigned seed) : bits_(seed) {}
  double operator()() { return std::ldexp(static_cast<double>(bits_()), -32); }
  template <int Dim>
  Eigen::Matrix<double, Dim, 1> point() {
    Eigen::Matrix<double, Dim, 1> p;
    for (int d = 0; d < Dim; ++d) p[d] = (*this)();
    return p;
  }

 private:
  std::mt19937 bits_;
};

// Boxes of sizes up to `size` in the unit cube; every third one is a point, every fifth one flat.
template <int Dim>
std::vector<Eigen::AlignedBox<double, Dim>> random_boxes(int count, double size, unsigned seed) {
  Numbers random(seed);
  std::vector<Eigen::AlignedBox<double, Dim>> boxes;
  for (int i = 0; i < count; ++i) {
    const Eigen::Matrix<double, Dim, 1> low = random.point<Dim>();
    Eigen::Matrix<double, Dim, 1> extent = size * random.point<Dim>();
    if (i % 3 == 0) extent.setZero();
    if (i % 5 == 0) extent[i % Dim] = 0;
    boxes.emplace_back(low, low + extent);
  }
  return boxes;
}

template <int Dim>
bool near(const Eigen::AlignedBox<double, Dim>& a, const Eigen::AlignedBox<double, Dim>& b,
          double reach) {
  for (int d = 0; d < Dim; ++d)
    if (a.min()[d] - b.max()[d] > reach || b.min()[d] - a.max()[d] > reach) return false;
  return true;
}

template <int Dim>
Pairs all_pairs(const std::vector<Eigen::AlignedBox<double, Dim>>& boxes, double reach) {
  Pairs pairs;
  for (int i = 0; i < isize(boxes); ++i)
    for (int j = i + 1; j < isize(boxes); ++j)
      if (near(boxes[i], boxes[j], reach)) pairs.emplace_back(i, j);
  return pairs;
}

template <int Dim>
Pairs found_pairs(const BoxTree<Dim>& tree, double reach) {
  Pairs pairs;
  tree.for_each_near_pair(reach, [&](int i, int j) { pairs.emplace_back(i, j); });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

template <int Dim>
std::vector<int> found_near(const BoxTree<Dim>& tree, const Eigen::AlignedBox<double, Dim>& box,
                            double reach) {
  std::vector<int> elements;
  tree.for_each_near(box, reach, [&](int i) { elements.push_back(i); });
  std::sort(elements.begin(), elements.end());
  return elements;
}

// Nearest box to random points, compared with all boxes.
template <int Dim>
void check_nearest(const std::vector<Eigen::AlignedBox<double, Dim>>& boxes,
                   const BoxTree<Dim>& tree, unsigned seed) {
  Numbers random(seed);
  for (int k = 0; k < 200; ++k) {
    const Eigen::Matrix<double, Dim, 1> p = 2 * random.point<Dim>().array() - 0.5;
    const auto distance2 = [&](int i) { return boxes[i].squaredExteriorDistance(p); };
    int expected = -1;
    for (int i = 0; i < isize(boxes); ++i)
      if (expected < 0 || distance2(i) < distance2(expected)) expected = i;
    const auto found = tree.nearest(p, distance2);
    REQUIRE(found.element == expected);
    CHECK(found.distance2 == distance2(expected));
  }
}

template <int Dim>
void check_all_queries(int count, double size, unsigned seed) {
  INFO(count << " boxes of size " << size << " in " << Dim << " dimensions");
  const auto boxes = random_boxes<Dim>(count, size, seed);
  const BoxTree<Dim> tree(boxes);
  CHECK(tree.size() == count);
  check_nearest(boxes, tree, seed + 1);
  for (const double reach : {0.0, 0.01, 0.3}) {
    CHECK(found_pairs(tree, reach) == all_pairs(boxes, reach));
    const auto queries = random_boxes<Dim>(20, size, seed + 2);
    for (const auto& query : queries) {
      std::vector<int> expected;
      for (int i = 0; i < count; ++i)
        if (near(boxes[i], query, reach)) expected.push_back(i);
      CHECK(found_near(tree, query, reach) == expected);
    }
  }
}

}  // namespace

TEST_CASE("all queries of a box tree agree with the comparison of all boxes", "[core][box_tree]") {
  for (const int count : {1, 2, 3, 4, 5, 6, 7, 8, 9, 16, 17, 31, 33, 100, 700})
    for (const double size : {0.0, 0.02, 0.5}) {
      check_all_queries<2>(count, size, static_cast<unsigned>(count));
      check_all_queries<3>(count, size, static_cast<unsigned>(count) + 1000);
    }
}

TEST_CASE("of equally near elements, the one with the lowest index is nearest",
          "[core][box_tree]") {
  // A point is at the same distance from all corners of a cube of which each corner occurs ten
  // times, in any order of the elements.
  std::vector<Box3> boxes;
  for (int copy = 0; copy < 10; ++copy)
    for (int corner = 0; corner < 8; ++corner)
      boxes.emplace_back(Vec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1));
  std::mt19937 bits(5);
  for (int k = 0; k < 50; ++k) {
    std::shuffle(boxes.begin(), boxes.end(), bits);
    const BoxTree<3> tree(boxes);
    const auto distance2_from = [&](const Vec3& p) {
      return [&, p](int i) { return boxes[i].squaredExteriorDistance(p); };
    };
    const Vec3 centre = Vec3::Constant(0.5);
    CHECK(tree.nearest(centre, distance2_from(centre)).element == 0);
    for (const Vec3& p : {Vec3(1, 1, 0), Vec3(0, 0, 2), Vec3(0.5, 0, 0)}) {
      const auto distance2 = distance2_from(p);
      int expected = 0;
      for (int i = 1; i < isize(boxes); ++i)
        if (distance2(i) < distance2(expected)) expected = i;
      CHECK(tree.nearest(p, distance2).element == expected);
    }
  }
}

TEST_CASE("a callback excludes elements by a distance that is infinite or not a number",
          "[core][box_tree]") {
  const auto boxes = random_boxes<2>(300, 0.05, 7);
  const BoxTree<2> tree(boxes);
  for (const double excluded : {kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
    const Vec2 p(0.4, 0.6);
    const auto odd = [&](int i) { return i % 2 ? boxes[i].squaredExteriorDistance(p) : excluded; };
    int expected = 1;
    for (int i = 1; i < 300; i += 2)
      if (odd(i) < odd(expected)) expected = i;
    CHECK(tree.nearest(p, odd).element == expected);
    const auto none = tree.nearest(p, [&](int) { return excluded; });
    CHECK(none.element == -1);
    CHECK(none.distance2 == kInfinity);
  }
}

TEST_CASE("an empty box tree finds nothing", "[core][box_tree]") {
  const Box3 everywhere(Vec3::Constant(-1e300), Vec3::Constant(1e300));
  for (const BoxTree<3>& tree :
       {BoxTree<3>(), BoxTree<3>(std::vector<Box3>()), BoxTree<3>(std::vector<Box3>(7))}) {
    CHECK(tree.size() == 0);
    CHECK(tree.nearest(Vec3::Zero(), [](int) { return 0.0; }).element == -1);
    CHECK(found_near(tree, everywhere, 1).empty());
    CHECK(found_pairs(tree, 1).empty());
    CHECK(tree.pair_parts(1, 100).empty());
  }
}

TEST_CASE("a box tree does not find elements with empty boxes", "[core][box_tree]") {
  auto boxes = random_boxes<3>(60, 0.1, 11);
  std::vector<int> left;
  for (int i = 0; i < isize(boxes); ++i)
    if (i % 4 == 1)
      boxes[i].setEmpty();
    else
      left.push_back(i);
  const BoxTree<3> tree(boxes);
  CHECK(tree.size() == isize(left));
  CHECK(found_near(tree, Box3(Vec3::Constant(-9), Vec3::Constant(9)), 0) == left);
  Pairs expected = all_pairs(boxes, 0.05);
  std::erase_if(expected, [](const auto& p) { return p.first % 4 == 1 || p.second % 4 == 1; });
  CHECK(found_pairs(tree, 0.05) == expected);
}

TEST_CASE("boxes that touch are near at reach 0, and a gap equal to the reach counts",
          "[core][box_tree]") {
  const BoxTree<2> tree(
      {Box2(Vec2(0, 0), Vec2(1, 1)), Box2(Vec2(1, 1), Vec2(2, 2)), Box2(Vec2(2.5, 0), Vec2(3, 2))});
  CHECK(found_pairs(tree, 0) == Pairs{{0, 1}});
  CHECK(found_pairs(tree, 0.4375) == Pairs{{0, 1}});
  CHECK(found_pairs(tree, 0.5) == Pairs{{0, 1}, {1, 2}});
  CHECK(found_near(tree, Box2(Vec2(1, 1)), 0) == std::vector<int>{0, 1});
}

TEST_CASE("equal boxes and boxes on a line or in a plane make a tree like others",
          "[core][box_tree]") {
  std::vector<Box3> same(100, Box3(Vec3(1, 2, 3), Vec3(2, 3, 4)));
  const BoxTree<3> of_same(same);
  CHECK(found_pairs(of_same, 0) == all_pairs(same, 0));
  CHECK(of_same.nearest(Vec3::Zero(), [](int) { return 14.0; }).element == 0);
  auto flat = random_boxes<3>(200, 0.05, 13);
  for (Box3& box : flat) box.min().z() = box.max().z() = 1;
  const BoxTree<3> in_plane(flat);
  check_nearest(flat, in_plane, 14);
  CHECK(found_pairs(in_plane, 0.01) == all_pairs(flat, 0.01));
  for (Box3& box : flat) box.min().y() = box.max().y() = -2;
  const BoxTree<3> on_line(flat);
  check_nearest(flat, on_line, 15);
  CHECK(found_pairs(on_line, 0.01) == all_pairs(flat, 0.01));
}

TEST_CASE("the keys of a box tree change no result", "[core][box_tree]") {
  const auto boxes = random_boxes<3>(400, 0.1, 17);
  Numbers random(18);
  std::vector<Vec3> keys;
  for (size_t i = 0; i < boxes.size(); ++i) keys.push_back(random.point<3>());
  const BoxTree<3> tree(boxes, keys);
  check_nearest(boxes, tree, 19);
  CHECK(found_pairs(tree, 0.02) == all_pairs(boxes, 0.02));
}

TEST_CASE("the parts of the search for pairs contain each pair once", "[core][box_tree]") {
  const auto boxes = random_boxes<3>(900, 0.08, 23);
  const BoxTree<3> tree(boxes);
  for (const double reach : {0.0, 0.05})
    for (const int size : {1, 10, 100, 1000}) {
      const auto parts = tree.pair_parts(reach, size);
      CHECK((size < 1000 ? parts.size() > 1 : parts.size() == 1));
      Pairs pairs;
      std::mutex one_at_a_time;
      parallel_for(isize(parts), [&](int part) {
        tree.for_each_near_pair(parts[part], reach, [&](int i, int j) {
          const std::lock_guard lock(one_at_a_time);
          pairs.emplace_back(i, j);
        });
      });
      std::sort(pairs.begin(), pairs.end());
      CHECK(pairs == all_pairs(boxes, reach));
    }
}

TEST_CASE("a box tree does not depend on the number of threads", "[core][box_tree]") {
  const ThreadGuard guard;
  const auto boxes = random_boxes<3>(20'000, 0.04, 29);
  Pairs first;
  for (const int threads : {1, 2, 5}) {
    set_thread_count(threads);
    const BoxTree<3> tree(boxes);
    Pairs pairs;  // in the order of the calls
    tree.for_each_near_pair(0, [&](int i, int j) { pairs.emplace_back(i, j); });
    if (threads == 1) first = pairs;
    CHECK(pairs == first);
  }
  CHECK(first.size() > 1000);
  CHECK(std::set(first.begin(), first.end()).size() == first.size());
}

TEST_CASE("a query of a box tree calls few callbacks", "[core][box_tree]") {
  const auto boxes = random_boxes<3>(20'000, 0.01, 31);
  const BoxTree<3> tree(boxes);
  Numbers random(32);
  int calls = 0;
  for (int k = 0; k < 100; ++k) {
    const Vec3 p = random.point<3>();
    tree.nearest(p, [&](int i) {
      ++calls;
      return boxes[i].squaredExteriorDistance(p);
    });
  }
  CHECK(calls < 100 * 100);
}

TEST_CASE("a box tree rejects coordinates that are not finite, and a wrong number of keys",
          "[core][box_tree]") {
  const auto boxes = random_boxes<3>(9, 0.1, 37);
  for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity}) {
    auto broken = boxes;
    broken[4].min().y() = wrong;
    CHECK_THROWS_AS(BoxTree<3>(broken), InputError);
    broken = boxes;
    broken[8].max().z() = wrong;
    CHECK_THROWS_AS(BoxTree<3>(broken), InputError);
    std::vector<Vec3> keys(9, Vec3::Zero());
    keys[2].x() = wrong;
    CHECK_THROWS_AS(BoxTree<3>(boxes, keys), InputError);
  }
  CHECK_THROWS_AS(BoxTree<3>(boxes, std::vector<Vec3>(8, Vec3::Zero())), InputError);
}

TEST_CASE("a point that is not a number is near nothing", "[core][box_tree]") {
  const auto boxes = random_boxes<2>(50, 0.1, 41);
  const BoxTree<2> tree(boxes);
  const Vec2 nowhere(0.5, std::numeric_limits<double>::quiet_NaN());
  const auto distance2 = [&](int i) { return (boxes[i].center() - nowhere).squaredNorm(); };
  CHECK(tree.nearest(nowhere, distance2).element == -1);
  CHECK(found_near(tree, Box2(nowhere), 1).empty());
}
