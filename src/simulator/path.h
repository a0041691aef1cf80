// The way along an edge, in metres and radians.
#pragma once

#include <vector>

#include "simulator/robot_state.h"

namespace fleetpub::simulator {

class Path {
 public:
  Path() = default;
  /// Straight from point to point; two of them or more.
  explicit Path(std::vector<Point> points);

  [[nodiscard]] bool IsEmpty() const { return points_.empty(); }
  [[nodiscard]] double length() const { return length_; }

  struct Spot {
    Point point;
    double tangent = 0;  ///< rad
  };
  /// So far along it, from 0 to length().
  [[nodiscard]] Spot At(double distance) const;

 private:
  std::vector<Point> points_;
  double length_ = 0;
};

/// The same angle between -π and π.
[[nodiscard]] double NormalizeAngle(double angle);

}  // namespace fleetpub::simulator
