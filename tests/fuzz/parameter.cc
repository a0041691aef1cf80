// `-P key=text`, `-P key:=json`, and the lists of SoAR's options.
#include "vda5050/catalogue/parameter.h"

#include "base/json.h"
#include "fuzz/fuzz.h"
#include "soar/field.h"

using namespace fleetpub;

FUZZ(text) {
  if (text.find('@') != std::string_view::npos) return;  // would read that file
  if (const auto parameter = vda5050::ParseAssignment(text))
    fuzz::Require(base::ParseJson(parameter->json).has_value());
  for (const auto type : {vda5050::ParameterType::kString, vda5050::ParameterType::kLength,
                          vda5050::ParameterType::kAngle, vda5050::ParameterType::kStringArray}) {
    const auto parameter = vda5050::ParseParameter({"x", type, true, ""}, text);
    if (parameter) fuzz::Require(base::ParseJson(parameter->json).has_value());
  }
  for (const auto fields : {soar::WaypointFields(), soar::PointFields()}) {
    const auto item = soar::ParseItem(fields, text);
    if (item) fuzz::Require(base::ParseJson(soar::ItemsJson(std::span(&*item, 1))).has_value());
  }
}
