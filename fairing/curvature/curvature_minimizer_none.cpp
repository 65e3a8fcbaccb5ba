#include "batten/core/errors.h"
#include "batten/fairing/curvature/curvature_minimizer.h"

namespace batten {

bool have_curvature_fairing() { return false; }

CurvatureMinimizationResult minimize(const CurvatureMinimization&) {
  throw InputError(
      "minimum-energy and minimum-variation curves need Ceres: build Batten with "
      "BATTEN_WITH_CERES");
}

}  // namespace batten
