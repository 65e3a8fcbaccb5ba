// What curves of least curvature minimise.
#pragma once

namespace batten {

/// What a curve minimises. Both depend on the shape alone, not on its parameter.
enum class CurveFunctional {
  /// ∫ κ² ds, unit 1/length: the minimum energy curve, a thin elastic rod that may slide through
  /// its points. Its length is free, and where the ends have to turn back (a U-turn, a loop) ever
  /// larger curves cost ever less: then there is no minimum, and fair_curvature() says so. A
  /// `length_weight` gives it one.
  Energy,
  /// ∫ κ'² + κ²τ² ds, unit 1/length³: the minimum variation curve (Moreton, Séquin 1992), κ' the
  /// change of curvature along the curve, τ its torsion. That is the part of d(κN)/ds normal to the
  /// curve: (dκ/ds)² of a plane curve, 0 for circles and lines only, and smooth through inflections
  /// where κ and N alone are not. (All of d(κN)/ds would cost κ⁴ more, also on circles.)
  Variation
};

}  // namespace batten
