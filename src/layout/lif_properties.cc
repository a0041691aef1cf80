#include "layout/lif_properties.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/choice.h"
#include "base/text.h"
#include "layout/curve.h"

namespace fleetpub::layout {
namespace {

using base::JsonValue;

constexpr auto kRequirements = std::to_array<base::Choice<Requirement>>({
    {"REQUIRED", Requirement::kRequired},
    {"CONDITIONAL", Requirement::kConditional},
    {"OPTIONAL", Requirement::kOptional},
});
constexpr auto kTurnings = std::to_array<base::Choice<Turning>>({
    {"BOTH", Turning::kBoth},
    {"NONE", Turning::kNone},
    {"CCW", Turning::kCcw},
    {"CW", Turning::kCw},
});
constexpr auto kOrientationTypes = std::to_array<base::Choice<bool>>({
    {"TANGENTIAL", true},
    {"GLOBAL", false},
});
constexpr auto kBlockingTypes = std::to_array<base::Choice<int>>({
    {"NONE", 1}, {"SOFT", 1}, {"HARD", 1}, {"SINGLE", 2},  // from 2.0
});

template <class T, std::size_t N>
std::optional<T> TakeChoice(Fields& fields, std::string_view name,
                            const std::array<base::Choice<T>, N>& choices) {
  const std::string text = fields.TakeText(name);
  if (text.empty()) return std::nullopt;
  for (const auto& choice : choices) {
    if (choice.text == text) return choice.value;
  }
  std::vector<std::string> words;
  words.reserve(std::size(choices));
  for (const auto& choice : choices) words.emplace_back(choice.text);
  fields.Error(name, fmt::format("must be one of {}, not {}", base::Join(words, ", "),
                                 base::Printable(text)));
  return std::nullopt;
}

// ── actions ──

ActionParameter ReadParameter(Fields& fields, const Terms& terms) {
  ActionParameter parameter{.key = fields.TakeText("key", true), .value = {}};
  const JsonValue* const value = fields.Take("value");
  if (value == nullptr) {
    fields.log().Error(fields.place(), "value is missing");
  } else if (terms.major > 1) {
    parameter.value = base::ToJson(*value);
    parameter.is_json = true;
  } else if (value->IsString()) {
    parameter.value = base::ToView(*value);
  } else {
    parameter.value = base::ToJson(*value);
    fields.log().Warn(fields.At("value"),
                      fmt::format("is {}, and texts only are foreseen", NameOfType(*value)));
  }
  return parameter;
}

LayoutAction ReadAction(Fields& fields, const Terms& terms, std::optional<Requirement> implied) {
  LayoutAction action;
  action.type = fields.TakeText("actionType", true);
  action.description = fields.TakeText(terms.action_description);
  const auto requirement = TakeChoice(fields, "requirementType", kRequirements);
  if (!requirement && !implied && fields.Take("requirementType") == nullptr) {
    fields.log().Error(fields.place(), "requirementType is missing: whether it always goes along");
  }
  action.requirement = implied.value_or(requirement.value_or(Requirement::kOptional));
  action.blocking_type = fields.TakeText("blockingType", true);
  const auto blocking = base::ParseChoice<int>(kBlockingTypes, action.blocking_type);
  if (!action.blocking_type.empty() && blocking.value_or(9) > terms.major) {
    fields.Error("blockingType", fmt::format("must be one of NONE, SOFT, HARD{}, not {}",
                                             terms.major > 1 ? ", SINGLE" : "",
                                             base::Printable(action.blocking_type)));
  }
  EachObject(fields, "actionParameters", false, [&](Fields& inner, std::size_t /*index*/) {
    ActionParameter parameter = ReadParameter(inner, terms);
    const bool is_twice =
        std::any_of(action.parameters.begin(), action.parameters.end(),
                    [&](const ActionParameter& other) { return other.key == parameter.key; });
    if (is_twice) {
      inner.Error("key", fmt::format("'{}' stands there twice", base::Printable(parameter.key)));
    } else {
      action.parameters.push_back(std::move(parameter));
    }
  });
  return action;
}

std::vector<LayoutAction> ReadActions(Fields& fields, const Terms& terms) {
  std::vector<LayoutAction> actions;
  const auto read = [&](std::string_view name, std::optional<Requirement> implied) {
    EachObject(fields, name, false, [&](Fields& inner, std::size_t /*index*/) {
      actions.push_back(ReadAction(inner, terms, implied));
    });
  };
  read("actions", std::nullopt);
  if (terms.major > 1) {
    read("requiredActions", Requirement::kRequired);
    read("feasibleActions", Requirement::kOptional);
  }
  const auto required = std::count_if(actions.begin(), actions.end(), [](const auto& action) {
    return action.requirement == Requirement::kRequired;
  });
  if (required > 1 && terms.major == 1) {
    fields.log().Warn(fields.At("actions"),
                      fmt::format("{} actions are REQUIRED: what that means is to be agreed, all "
                                  "are sent",
                                  required));
  }
  return actions;
}

// ── trajectories ──

// What is wrong with the knots, or "".
std::string FaultOfKnots(const Trajectory& curve) {
  const auto& knots = curve.knots;
  const auto degree = static_cast<std::size_t>(curve.degree);
  if (knots.size() != curve.points.size() + degree + 1) {
    return fmt::format("has {} knots: {} points and degree {} need {}", knots.size(),
                       curve.points.size(), degree, curve.points.size() + degree + 1);
  }
  for (std::size_t i = 0; i < knots.size(); ++i) {
    if (knots[i] < 0 || knots[i] > 1) return fmt::format("knot {} is not within 0 and 1", knots[i]);
    if (i > 0 && knots[i] < knots[i - 1]) return "its knots must not fall";
  }
  if (knots[degree] > knots.front() || knots[knots.size() - 1 - degree] < knots.back() ||
      knots.front() == knots.back()) {
    return fmt::format("is not clamped: its first {0} knots are alike, and its last {0}",
                       degree + 1);
  }
  std::size_t alike = 1;
  for (std::size_t i = degree + 2; i + degree + 1 < knots.size(); ++i) {
    alike = knots[i] == knots[i - 1] ? alike + 1 : 1;
    if (alike > degree)
      return fmt::format("knot {} stands there more than {} times", knots[i], degree);
  }
  // An inner knot that is an outer one makes that one stand there too often.
  for (std::size_t i = degree + 1; i + degree + 1 < knots.size(); ++i) {
    if (knots[i] == knots.front() || knots[i] == knots.back()) {
      return fmt::format("knot {} stands there more than {} times", knots[i], degree + 1);
    }
  }
  return {};
}

int ReadDegree(Fields& fields) {
  const auto degree = fields.TakeNumber("degree");
  if (!degree) return 1;
  if (*degree != std::floor(*degree) || *degree < 1 || *degree > kMaxDegree) {
    fields.Error("degree",
                 fmt::format("must be a whole number from 1 to {}, not {}", kMaxDegree, *degree));
    return 1;
  }
  return static_cast<int>(*degree);
}

// Nothing: it is faulty.
std::optional<Trajectory> ReadTrajectory(const JsonValue& value, const Place& place,
                                         FindingLog& log) {
  Fields fields(value, place, log);
  Trajectory curve;
  curve.degree = ReadDegree(fields);
  bool is_faulty = false;
  EachObject(fields, "controlPoints", true, [&](Fields& point, std::size_t /*index*/) {
    const auto x = point.TakeNumber("x", true);
    const auto y = point.TakeNumber("y", true);
    const auto weight = point.TakeNumber("weight");
    constexpr double kLeastWeight = 1e-6;
    if (weight && (*weight < kLeastWeight || *weight > 1 / kLeastWeight)) {
      point.Error("weight", fmt::format("{} is no weight: it is above 0, and mostly 1", *weight));
    }
    is_faulty = is_faulty || point.is_faulty();
    curve.points.push_back({x.value_or(0), y.value_or(0), weight.value_or(1)});
  });
  if (const JsonValue* const knots = fields.TakeArray("knotVector", true)) {
    for (const auto& knot : knots->GetArray()) {
      curve.knots.push_back(fields.ReadNumber("knotVector", knot).value_or(0));
    }
  }
  fields.Finish();
  if (is_faulty || fields.is_faulty()) return std::nullopt;
  if (curve.points.size() < static_cast<std::size_t>(curve.degree) + 1) {
    fields.Error("controlPoints", fmt::format("has {} points: degree {} needs {}",
                                              curve.points.size(), curve.degree, curve.degree + 1));
  } else if (const std::string fault = FaultOfKnots(curve); !fault.empty()) {
    fields.Error("knotVector", fault);
  }
  if (fields.is_faulty()) return std::nullopt;
  return curve;
}

// ── properties ──

std::optional<LoadRestriction> ReadLoad(Fields& fields) {
  const JsonValue* const value = fields.TakeObject("loadRestriction");
  if (value == nullptr) return LoadRestriction();
  const Place place = fields.At("loadRestriction");
  Fields inner(*value, place, fields.log());
  LoadRestriction load;
  load.unloaded = inner.TakeFlag("unloaded", true).value_or(false);
  load.loaded = inner.TakeFlag("loaded", true).value_or(false);
  load.load_sets = inner.TakeTexts("loadSetNames");
  inner.Finish();
  if (!load.unloaded && !load.loaded) {
    inner.log().Warn(place, "admits neither unloaded vehicles nor loaded ones");
  } else if (!load.loaded && !load.load_sets.empty()) {
    inner.log().Warn(inner.At("loadSetNames"), "means nothing where no loaded vehicle may be");
  }
  if (inner.is_faulty()) return std::nullopt;
  return load;
}

// The vehicle types that a property is for.
std::vector<std::string> ReadTypes(Fields& fields, const Terms& terms) {
  std::vector<std::string> types;
  if (terms.major == 1) {
    types.push_back(fields.TakeText("vehicleTypeId", true));
    if (types.front().empty()) types.clear();
    return types;
  }
  EachObject(fields, "mobileRobotTypes", true, [&](Fields& inner, std::size_t /*index*/) {
    const std::string manufacturer = inner.TakeText("manufacturer", true);
    const std::string series = inner.TakeText("seriesName", true);
    if (!inner.is_faulty()) types.push_back(fmt::format("{}.{}", manufacturer, series));
  });
  return types;
}

// Reads an array of properties. `read` returns nothing where one is faulty.
template <class Properties, class Read>
std::vector<Properties> ReadProperties(Fields& element, std::string_view name, const Terms& terms,
                                       Read read) {
  std::vector<Properties> all;
  bool is_empty = true;
  EachObject(element, name, true, [&](Fields& fields, std::size_t /*index*/) {
    is_empty = false;
    const auto types = ReadTypes(fields, terms);
    auto properties = read(fields);
    const bool is_faulty = fields.is_faulty();
    for (const std::string& type : types) {
      const bool is_twice = std::any_of(all.begin(), all.end(), [&](const Properties& other) {
        return other.vehicle_type == type;
      });
      if (is_twice) {
        fields.log().Error(fields.place(), fmt::format("is the second one for vehicles of type {}",
                                                       base::Printable(type)));
      } else if (!is_faulty) {
        all.push_back(properties);
        all.back().vehicle_type = type;
      }
    }
  });
  if (is_empty && !element.is_faulty()) {
    element.log().Error(element.At(name),
                        "must not be empty: it says which vehicle types may be "
                        "there");
  }
  return all;
}

void ReadDeviation(Fields& fields, NodeProperties& properties) {
  const JsonValue* const value = fields.TakeObject("allowedDeviationXY");
  if (value == nullptr) return;
  const Place place = fields.At("allowedDeviationXY");
  Fields inner(*value, place, fields.log());
  DeviationRange range;
  range.a_minimum = inner.TakeNonNegative("aMinimum").value_or(0);
  range.a_maximum = inner.TakeNonNegative("aMaximum");
  range.b_minimum = inner.TakeNonNegative("bMinimum").value_or(0);
  range.b_maximum = inner.TakeNonNegative("bMaximum");
  range.theta = inner.TakeAngle("theta").value_or(0);
  inner.Finish();
  if (!inner.is_faulty()) properties.deviation = range;
}

NodeProperties ReadNodeProperty(Fields& fields, const Terms& terms) {
  NodeProperties properties;
  properties.theta = fields.TakeAngle("theta");
  properties.actions = ReadActions(fields, terms);
  if (terms.major == 1) return properties;
  if (const auto load = ReadLoad(fields)) {
    properties.load = *load;
  } else {
    fields.Error("loadRestriction", "is faulty, so no vehicle of this type drives here");
  }
  properties.forbidden_actions = fields.TakeTexts("forbiddenActionTypes");
  ReadDeviation(fields, properties);
  return properties;
}

void ReadOrientation(Fields& fields, const Terms& terms, EdgeProperties& properties) {
  properties.is_tangential =
      TakeChoice(fields, "orientationType", kOrientationTypes).value_or(true);
  if (terms.major == 1) {
    properties.orientation = fields.TakeAngle("vehicleOrientation");
    properties.rotation_allowed = fields.TakeFlag("rotationAllowed", true).value_or(false);
    return;
  }
  properties.rotation_allowed = !fields.TakeFlag("reachOrientationBeforeEntering").value_or(true);
  const JsonValue* const orientations = fields.TakeArray("mobileRobotOrientations", false);
  if (orientations == nullptr) return;
  for (const auto& value : orientations->GetArray()) {
    const auto angle = fields.ReadNumber("mobileRobotOrientations", value);
    if (!angle) continue;
    fields.CheckAngle("mobileRobotOrientations", *angle);
    if (properties.orientation) {
      properties.other_orientations.push_back(*angle);
    } else {
      properties.orientation = angle;
    }
  }
}

void ReadLine(Fields& fields, EdgeProperties& properties) {
  if (const JsonValue* const value = fields.TakeObject("corridor")) {
    const Place place = fields.At("corridor");
    Fields inner(*value, place, fields.log());
    const auto left = inner.TakeNonNegative("maximumLeftWidth");
    const auto right = inner.TakeNonNegative("maximumRightWidth");
    inner.Finish();
    if (!inner.is_faulty()) properties.corridor = {left.value_or(0), right.value_or(0)};
  }
  if (const JsonValue* const value = fields.TakeObject("physicalLineGuidedProperty")) {
    const Place place = fields.At("physicalLineGuidedProperty");
    Fields inner(*value, place, fields.log());
    properties.line_direction = inner.TakeText("direction");
    properties.line_length = inner.TakeNonNegative("length");
    inner.Finish();
    if (properties.trajectory) {
      fields.Error("physicalLineGuidedProperty", "stands beside a trajectory: one of them only");
    }
  }
}

EdgeProperties ReadEdgeProperty(Fields& fields, const Terms& terms) {
  EdgeProperties properties;
  ReadOrientation(fields, terms, properties);
  properties.turning_at_start =
      TakeChoice(fields, "rotationAtStartNodeAllowed", kTurnings).value_or(Turning::kBoth);
  properties.turning_at_end =
      TakeChoice(fields, "rotationAtEndNodeAllowed", kTurnings).value_or(Turning::kBoth);
  properties.max_speed = fields.TakeNonNegative(terms.max_speed);
  properties.max_rotation_speed = fields.TakeNonNegative(terms.max_rotation_speed);
  properties.min_height = fields.TakeNumber(terms.min_height);
  properties.max_height = fields.TakeNumber(terms.max_height);
  if (const auto load = ReadLoad(fields)) {
    properties.load = *load;
  } else {
    fields.Error("loadRestriction", "is faulty, so no vehicle of this type drives here");
  }
  properties.actions = ReadActions(fields, terms);
  if (const JsonValue* const value = fields.TakeObject("trajectory")) {
    properties.trajectory = ReadTrajectory(*value, fields.At("trajectory"), fields.log());
    if (!properties.trajectory) {
      fields.Error("trajectory", "is faulty, so no vehicle of this type drives here");
    }
  }
  properties.reentry_allowed = fields.TakeFlag("reentryAllowed").value_or(true);
  if (terms.major > 1) {
    properties.forbidden_actions = fields.TakeTexts("forbiddenActionTypes");
    ReadLine(fields, properties);
  }
  if (properties.max_speed == 0.0) {
    fields.log().Warn(fields.At(terms.max_speed), "is 0: no vehicle of this type drives here");
  }
  return properties;
}

}  // namespace

std::vector<NodeProperties> ReadNodeProperties(Fields& node, const Terms& terms) {
  return ReadProperties<NodeProperties>(node, terms.node_properties, terms, [&](Fields& fields) {
    return ReadNodeProperty(fields, terms);
  });
}

std::vector<EdgeProperties> ReadEdgeProperties(Fields& edge, const Terms& terms) {
  return ReadProperties<EdgeProperties>(edge, terms.edge_properties, terms, [&](Fields& fields) {
    return ReadEdgeProperty(fields, terms);
  });
}

}  // namespace fleetpub::layout
