// SPDX-License-Identifier: MPL-2.0
// Points of a shell at which results are evaluated.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// A point on a curve of a model.
struct CurveSample {
  Location where;     ///< location in the mesh of the model, on the first face of the curve
  double length = 0;  ///< distance from the start of the curve, along it
  Vec3 at = Vec3::Zero();
  Vec3 tangent = Vec3::Zero();  ///< unit vector
};

/// Points along a curve, in its direction: its ends, and `per_element` points for each element edge or
/// collocation interval. `shape`: absolute dofs. Throws InputError if the curve does not exist.
std::vector<CurveSample> sample_curve(const ModelLayout& model, const Points& shape,
                                      const std::string& line, int per_element = 2);

/// A point of a face and the area that it represents.
struct AreaSample {
  Location where;
  double area = 0;
};

/// Integration points on a face, inside of its trim. `region`: index of the face.
std::vector<AreaSample> sample_face(const ModelLayout& model, const Points& shape, int region);

}  // namespace batten
