// A file of waypoints: CSV, JSON or GeoJSON. What it makes is JSON.
#include "base/json.h"
#include "fuzz/fuzz.h"
#include "soar/plan_file.h"

using namespace fleetpub;

FUZZ(text) {
  for (const char* name : {"plan", "plan.csv"}) {
    const auto plan = soar::ReadPlan(text, name);
    if (!plan) continue;
    fuzz::Require(
        base::ParseJson(soar::ItemsJson(plan->waypoints), {.bytes = 1U << 30U}).has_value());
  }
}
