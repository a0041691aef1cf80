// Our routes beside those that NetworkX finds, with the rules written down a second time.
#include <gtest/gtest.h>

#include "base/json.h"
#include "layout/route.h"
#include "support/operator.h"
#include "support/process.h"

namespace fleetpub::layout {
namespace {

using base::FindMember;
using base::JsonValue;
using base::StringMember;

RouteRequest ReadRequest(const JsonValue& value, const Site& site) {
  const bool by_time = FindMember(value, "time")->GetBool();
  RouteRequest request{.vehicle_type = "T",
                       .loaded = FindMember(value, "loaded")->GetBool(),
                       .load_set = std::string(StringMember(value, "loadSet")),
                       .cost = by_time ? RouteCost::kTime : RouteCost::kLength,
                       .vehicle_speed = 1.5,
                       .from = site.FindNode(StringMember(value, "from")).value()};
  for (const auto& stop : FindMember(value, "stops")->GetArray()) {
    auto& nodes = request.stops.emplace_back();
    for (const auto& id : stop.GetArray()) nodes.push_back(site.FindNode(base::ToView(id)).value());
  }
  return request;
}

TEST(RouteEquality, CostsWhatNetworkXFinds) {
  const std::string script = std::string(FLEETPUB_SOURCE_DIR) + "/tests/peers/route_costs.py";
  const auto python = fleetpub::testing::Run(
      {.arguments = {"/usr/bin/python3", script, "10000", "5"}}, std::chrono::minutes(2));
  ASSERT_EQ(python.exit_code, 0) << python.errors;
  std::size_t count = 0;
  std::size_t found = 0;
  for (std::string_view rest = python.output; !rest.empty();) {
    const auto end = rest.find('\n');
    const auto line = base::ParseJson(rest.substr(0, end));
    rest.remove_prefix(end + 1);
    ASSERT_TRUE(line) << line.error().message;
    const std::string text(StringMember(*line, "layout"));
    const auto read = ReadLayout(text);
    ASSERT_TRUE(read) << read.error().message << text;
    const RouteRequest request = ReadRequest(*FindMember(*line, "request"), read->site);
    const auto route = FindRoute(read->site, request);
    const JsonValue& cost = *FindMember(*line, "cost");
    ASSERT_EQ(route.has_value(), !cost.IsNull()) << (route ? "" : route.error().message) << "\n"
                                                 << base::ToJson(*line);
    ++count;
    if (!route) continue;
    ++found;
    const double ours = request.cost == RouteCost::kTime ? route->seconds : route->length;
    ASSERT_NEAR(ours, cost.GetDouble(), 1e-3) << base::ToJson(*line);
  }
  EXPECT_EQ(count, 10'000U);
  EXPECT_GT(found, 2'000U);
}

}  // namespace
}  // namespace fleetpub::layout
