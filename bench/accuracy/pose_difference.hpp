// Two poses compared in the five parameters that a cylinder has.
#pragma once

#include <Eigen/Core>
#include <cylpose/cylinder.hpp>
#include <cylpose/pose.hpp>

namespace cylpose::bench {

/// x y z of the centre in metres, then rotations in radians about the two directions of a TangentBasis.
using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

/// Two unit vectors across an axis; the rotation about the axis itself cannot be seen.
struct TangentBasis {
  Eigen::Vector3d first;
  Eigen::Vector3d second;

  explicit TangentBasis(const Eigen::Vector3d& axis) : first(axis.unitOrthogonal()), second(axis.cross(first)) {}
};

/// The move that leads from `from` to `to`, in the basis of `from`'s axis; the axes' signs do not matter.
[[nodiscard]] Vector5d difference(const CylinderPose& from, const CylinderPose& to);

/// The same as difference(from, to) for small moves: `from` after it.
[[nodiscard]] CylinderPose moved(const CylinderPose& from, const Vector5d& move);

/// An estimate's covariance without the roll, in the basis of the estimated axis.
[[nodiscard]] Matrix5d covariance_in_basis(const PoseEstimate& estimate);

}  // namespace cylpose::bench
