// SPDX-License-Identifier: MPL-2.0
#include "batten/elements/hermite_segment.h"

#include "batten/core/errors.h"

namespace batten {
namespace {

using Matrix = HermiteSegment::Matrix;

// Matrix for the weight that increases towards the other end: nodes swapped, signs of slopes
// reversed.
Matrix reversed(const Matrix& K) {
  Matrix R;
  constexpr int other[4] = {2, 3, 0, 1};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) R(i, j) = ((i + j) % 2 ? -1 : 1) * K(other[i], other[j]);
  return R;
}

}  // namespace

HermiteSegment::HermiteSegment(double h) : h_(h) {
  if (!(h > 0))
    throw InputError("found a Hermite segment of length " + format_number(h) +
                     ", expected a length above 0");
}

HermiteSegment::Vector HermiteSegment::evaluate(double s, int order) const {
  const double h = h_;
  switch (order) {
    case 0:
      return {1 + s * s * (2 * s - 3), h * s * (1 + s * (s - 2)), s * s * (3 - 2 * s),
              h * s * s * (s - 1)};
    case 1:
      return {6 * s * (s - 1) / h, 1 + s * (3 * s - 4), 6 * s * (1 - s) / h, s * (3 * s - 2)};
    case 2:
      return {(12 * s - 6) / (h * h), (6 * s - 4) / h, (6 - 12 * s) / (h * h), (6 * s - 2) / h};
    case 3:
      return {12 / (h * h * h), 6 / (h * h), -12 / (h * h * h), 6 / (h * h)};
    default:
      throw InputError("a cubic segment has derivatives of order 0 to 3, not " +
                       std::to_string(order));
  }
}

Matrix HermiteSegment::stretching(Linear alpha) const {
  const double h = h_;
  Matrix at_start;
  at_start << 36, 0, -36, 6 * h,  //
      0, 6 * h * h, 0, -h * h,    //
      -36, 0, 36, -6 * h,         //
      6 * h, -h * h, -6 * h, 2 * h * h;
  at_start /= 60 * h;
  return alpha.start * at_start + alpha.end * reversed(at_start);
}

Matrix HermiteSegment::bending(Linear beta) const {
  const double h = h_;
  Matrix at_start;
  at_start << 6, 4 * h, -6, 2 * h,      //
      4 * h, 3 * h * h, -4 * h, h * h,  //
      -6, -4 * h, 6, -2 * h,            //
      2 * h, h * h, -2 * h, h * h;
  at_start /= h * h * h;
  return beta.start * at_start + beta.end * reversed(at_start);
}

Matrix HermiteSegment::mass() const {
  const double h = h_;
  Matrix M;
  M << 156, 22 * h, 54, -13 * h,              //
      22 * h, 4 * h * h, 13 * h, -3 * h * h,  //
      54, 13 * h, 156, -22 * h,               //
      -13 * h, -3 * h * h, -22 * h, 4 * h * h;
  return M * (h / 420);
}

HermiteSegment::Vector HermiteSegment::load(Linear f) const {
  const double h = h_;
  return h / 60 *
         Vector(21 * f.start + 9 * f.end, h * (3 * f.start + 2 * f.end), 9 * f.start + 21 * f.end,
                -h * (2 * f.start + 3 * f.end));
}

}  // namespace batten
