#include "simulator/path.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace fleetpub::simulator {
namespace {

double Distance(const Point& a, const Point& b) { return std::hypot(b.x - a.x, b.y - a.y); }

}  // namespace

Path::Path(std::vector<Point> points) : points_(std::move(points)) {
  for (std::size_t i = 1; i < points_.size(); ++i) length_ += Distance(points_[i - 1], points_[i]);
}

Path::Spot Path::At(double distance) const {
  Spot spot{points_.front()};
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const Point& a = points_[i - 1];
    const Point& b = points_[i];
    const double length = Distance(a, b);
    if (length == 0) continue;
    spot.tangent = std::atan2(b.y - a.y, b.x - a.x);
    const double share = distance >= length ? 1 : distance / length;
    spot.point = {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)};
    if (distance <= length) break;
    distance -= length;
  }
  return spot;
}

double NormalizeAngle(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

}  // namespace fleetpub::simulator
