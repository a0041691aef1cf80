// The geometry of trajectories: NURBS curves.
#pragma once

#include <optional>

#include "layout/layout.h"

namespace fleetpub::layout {

/// Higher ones are refused: no vehicle has them, and they cost what their square is.
inline constexpr int kMaxDegree = 10;

/// Along the curve, m. The trajectory is one that the reader took.
[[nodiscard]] double CurveLength(const Trajectory& trajectory);

/// In which direction it begins and ends, rad; nothing: it is a point.
[[nodiscard]] std::optional<double> StartTangent(const Trajectory& trajectory);
[[nodiscard]] std::optional<double> EndTangent(const Trajectory& trajectory);

}  // namespace fleetpub::layout
