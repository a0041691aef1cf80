// A layout file: what is read can be checked and driven.
#include "layout/layout.h"

#include "fuzz/fuzz.h"
#include "layout/check.h"
#include "layout/route.h"

using namespace fleetpub;

FUZZ(text) {
  auto read = layout::ReadLayout(text);
  if (!read) return;
  const layout::Site& site = read->site;
  layout::CheckElements(site, read->findings);
  layout::CheckWays(site, read->findings);
  for (const layout::Station& station : site.stations) {
    for (const std::size_t node : station.nodes) fuzz::Require(node < site.nodes.size());
  }
  const auto types = site.VehicleTypes();
  if (types.empty() || site.nodes.empty()) return;
  const auto route = layout::FindRoute(
      site, {.vehicle_type = types.front(), .from = 0, .stops = {{site.nodes.size() - 1}}});
  if (route) fuzz::Require(route->nodes.size() == route->edges.size() + 1 && route->length >= 0);
}
