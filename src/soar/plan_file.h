// Waypoints from files: CSV, JSON and GeoJSON.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "soar/field.h"

namespace fleetpub::soar {

struct PlanFile {
  std::vector<Item> waypoints;
  std::vector<std::string> warnings;
};

/// Reads the content of a file of this name (`-`: standard input), which is
///
///   CSV       a row of column names, then a waypoint per row; a cell without text is no member;
///             every file called .csv, and every other that begins with neither { nor [
///   JSON      an array of waypoints, or an object with such an array as `plan`; members that the
///             format does not name are kept
///   GeoJSON   a LineString, as it is, as a Feature or as the only one of a FeatureCollection
///             (RFC 7946): longitude before latitude
///
/// Columns and members are named as the format names them, or shorter: lat, lon. Errors:
/// ErrorKind::kInvalid with the file's name and the line or the number of the waypoint.
[[nodiscard]] Result<PlanFile> ReadPlan(std::string_view content, std::string_view name);

}  // namespace fleetpub::soar
