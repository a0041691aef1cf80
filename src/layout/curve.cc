#include "layout/curve.h"

#include <array>
#include <cmath>

namespace fleetpub::layout {
namespace {

struct Homogeneous {
  double x = 0;
  double y = 0;
  double w = 0;
};

Homogeneous Mixed(const Homogeneous& a, const Homogeneous& b, double t) {
  return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.w + (b.w - a.w) * t};
}

// One span of a curve, between the knots `span` and `span` + 1.
class Span {
 public:
  Span(const Trajectory& curve, std::size_t span)
      : knots_(curve.knots), degree_(static_cast<std::size_t>(curve.degree)), span_(span) {
    for (std::size_t i = 0; i <= degree_; ++i) {
      const ControlPoint& p = curve.points[span - degree_ + i];
      points_[i] = {p.x * p.weight, p.y * p.weight, p.weight};
    }
  }

  // |dC/du|: the last step of de Boor's algorithm has the derivative beside the point.
  [[nodiscard]] double Speed(double u) const {
    auto d = points_;
    for (std::size_t r = 1; r < degree_; ++r) {
      for (std::size_t j = degree_; j >= r; --j) d[j] = Mixed(d[j - 1], d[j], Ratio(u, j, r));
    }
    const Homogeneous& a = d[degree_ - 1];
    const Homogeneous& b = d[degree_];
    const double scale = static_cast<double>(degree_) / (knots_[span_ + 1] - knots_[span_]);
    const Homogeneous at = Mixed(a, b, Ratio(u, degree_, degree_));
    const Homogeneous slope = {(b.x - a.x) * scale, (b.y - a.y) * scale, (b.w - a.w) * scale};
    return std::hypot(slope.x - at.x / at.w * slope.w, slope.y - at.y / at.w * slope.w) / at.w;
  }

  [[nodiscard]] double Length() const {
    const double from = knots_[span_];
    const double to = knots_[span_ + 1];
    return Refined(from, to, Gauss(from, to), 8);
  }

 private:
  [[nodiscard]] double Ratio(double u, std::size_t j, std::size_t r) const {
    const std::size_t i = span_ - degree_ + j;
    return (u - knots_[i]) / (knots_[i + 1 + degree_ - r] - knots_[i]);
  }

  // Gauss-Legendre quadrature with five points.
  [[nodiscard]] double Gauss(double from, double to) const {
    static constexpr std::array<std::pair<double, double>, 3> kNodes = {
        {{0, 128.0 / 225},
         {0.5384693101056831, 0.4786286704993665},
         {0.9061798459386640, 0.2369268850561891}}};
    const double middle = (from + to) / 2;
    const double half = (to - from) / 2;
    double sum = kNodes[0].second * Speed(middle);
    for (std::size_t i = 1; i < kNodes.size(); ++i) {
      const auto& [at, weight] = kNodes[i];
      sum += weight * (Speed(middle - half * at) + Speed(middle + half * at));
    }
    return sum * half;
  }

  [[nodiscard]] double Refined(double from, double to, double whole, int depth) const {
    const double middle = (from + to) / 2;
    const double left = Gauss(from, middle);
    const double right = Gauss(middle, to);
    constexpr double kTolerance = 1e-7;
    if (depth == 0 || std::abs(left + right - whole) <= kTolerance * (1 + whole)) {
      return left + right;
    }
    return Refined(from, middle, left, depth - 1) + Refined(middle, to, right, depth - 1);
  }

  const std::vector<double>& knots_;
  std::size_t degree_;
  std::size_t span_;
  std::array<Homogeneous, kMaxDegree + 1> points_;
};

template <class Iterator>
std::optional<double> Direction(Iterator from, Iterator end, double turn) {
  for (Iterator to = from; to != end; ++to) {
    const double dx = to->x - from->x;
    const double dy = to->y - from->y;
    if (std::hypot(dx, dy) > 1e-9) return std::atan2(dy * turn, dx * turn);
  }
  return std::nullopt;
}

}  // namespace

double CurveLength(const Trajectory& trajectory) {
  double length = 0;
  if (trajectory.degree == 1) {  // weights bend nothing
    for (std::size_t i = 1; i < trajectory.points.size(); ++i) {
      length += std::hypot(trajectory.points[i].x - trajectory.points[i - 1].x,
                           trajectory.points[i].y - trajectory.points[i - 1].y);
    }
    return length;
  }
  const auto degree = static_cast<std::size_t>(trajectory.degree);
  for (std::size_t span = degree; span < trajectory.points.size(); ++span) {
    if (trajectory.knots[span + 1] <= trajectory.knots[span]) continue;
    length += Span(trajectory, span).Length();
  }
  return length;
}

std::optional<double> StartTangent(const Trajectory& trajectory) {
  return Direction(trajectory.points.begin(), trajectory.points.end(), 1);
}

std::optional<double> EndTangent(const Trajectory& trajectory) {
  return Direction(trajectory.points.rbegin(), trajectory.points.rend(), -1);
}

}  // namespace fleetpub::layout
