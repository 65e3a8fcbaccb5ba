// Eigen types under one set of names, and infinity.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <limits>
#include <vector>

namespace batten {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using VecX = Eigen::VectorXd;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;
using MatX = Eigen::MatrixXd;

/// n points or n dof triples, one a row: columns are x, y, z. Column-major, so that the three
/// coordinates are three right-hand sides of one factor.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// Compressed columns, 32-bit indices. Symmetric matrices are kept by their lower triangle only,
/// and every function that takes one says so.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
using Triplet = Eigen::Triplet<double, int>;

/// Larger than every number.
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace batten
