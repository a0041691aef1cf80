#include "vda5050/rules/preflight.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <random>

#include "base/text.h"
#include "base/uuid.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/reports/discovery.h"

namespace fleetpub::vda5050 {
namespace {

constexpr std::string_view kOverride = "--no-check sends it anyway";

// What a robot in this mode may be sent, by the specification's table of operatingMode. Any other
// mode is no reason to refuse.
enum class Obeys { kNothing, kCancelOrder };

struct ModeRule {
  std::string_view mode;
  Obeys obeys;
};

constexpr std::array<ModeRule, 5> kModes = {{
    {"STARTUP", Obeys::kNothing},
    {"INTERVENED", Obeys::kCancelOrder},
    {"MANUAL", Obeys::kNothing},
    {"SERVICE", Obeys::kNothing},
    {"TEACH_IN", Obeys::kNothing},
}};

// One robot's check: what it is about, and what was found so far.
struct Check {
  const RobotAddress& robot;
  const Dialect& dialect;
  std::span<const InstantAction> actions;
  const KnownRobot& known;
  std::string name{};  ///< the robot's, printable
  PreflightFindings findings{};

  void Refuse(std::string_view sentence) {
    findings.refusals.push_back(fmt::format("{}; {}", sentence, kOverride));
  }
  /// With another remedy than --no-check.
  void RefuseUnless(std::string_view sentence, std::string_view remedy) {
    findings.refusals.push_back(fmt::format("{}: {}, or --no-check", sentence, remedy));
  }
  void Warn(std::string sentence) { findings.warnings.push_back(std::move(sentence)); }
};

bool IsOnly(std::span<const InstantAction> actions, std::string_view type) {
  return !actions.empty() && std::all_of(actions.begin(), actions.end(),
                                         [&](const auto& action) { return action.type == type; });
}

// Which every robot shall support (3.0 §6.2.3), or which stands in no factsheet as it asks for it:
// a factsheet that leaves them out must not stand in the way of stopping.
bool IsRequiredOfAll(std::string_view type) {
  constexpr std::array<std::string_view, 4> kTypes = {"startPause", "stopPause", "cancelOrder",
                                                      "factsheetRequest"};
  return std::find(kTypes.begin(), kTypes.end(), type) != kTypes.end();
}

// ── connection ──

void CheckStopHibernation(Check& check, const ConnectionMessage& connection) {
  if (connection.connection_state == "HIBERNATING") return;
  if (connection.connection_state == "ONLINE") {
    check.Warn(check.name + " is ONLINE: there is no hibernation to stop");
  } else {
    check.findings.unreachable = true;
    check.Refuse(fmt::format("{} is {}, not HIBERNATING", check.name, ConnectionText(connection)));
  }
}

// Nothing tells whether a robot is there that has left no connection message and sends no state.
void CheckWithoutConnection(Check& check) {
  if (check.known.speaks) {
    return check.Warn(check.name + " has left no connection message, but sends states");
  }
  const std::string sentence =
      check.name + " left no connection message, and sent no state during the look";
  if (IsOnlyStartPause(check.actions)) {
    check.Warn(sentence + "; startPause is sent anyway");
  } else {
    check.Refuse(sentence);
  }
}

void CheckConnection(Check& check) {
  if (!check.known.connection) return CheckWithoutConnection(check);
  const ConnectionMessage& connection = *check.known.connection;
  if (IsOnly(check.actions, "stopHibernation")) return CheckStopHibernation(check, connection);
  if (connection.connection_state == "ONLINE") return;
  if (check.known.speaks && connection.connection_state != "HIBERNATING") {
    // A last will that was left behind, or a robot that does not say when it comes back.
    return check.Warn(fmt::format("the broker has {} as {}, but it sends states", check.name,
                                  ConnectionText(connection)));
  }
  check.findings.unreachable = true;
  const std::string sentence =
      connection.fault.empty()
          ? fmt::format("{} is {}", check.name, ConnectionText(connection))
          : fmt::format("{}'s connection message cannot be read: {}", check.name, connection.fault);
  if (IsOnlyStartPause(check.actions)) {
    check.Warn(sentence + "; startPause is sent anyway");
  } else if (connection.connection_state == "HIBERNATING") {
    check.RefuseUnless(sentence, "wake it with stopHibernation");
  } else {
    check.Refuse(sentence);
  }
}

// ── version and topics ──

bool HasDigit(std::string_view text) {
  return std::any_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// `v2` says no more than the major version.
bool Fits(std::string_view spoken, Version theirs, Version ours) {
  const bool is_release = spoken.find('.') != std::string_view::npos;
  return theirs == ours || (!is_release && GetFacts(theirs).major == GetFacts(ours).major);
}

// Whether the robot's connection message is where the version's topics are.
bool IsFoundAt(const Check& check, Version version) {
  const std::size_t last = check.known.topic.rfind('/') + 1;
  const auto topic =
      TopicFor(check.dialect.topics, version, check.robot, check.known.topic.substr(last));
  return check.known.topic.empty() || !topic || *topic == check.known.topic;
}

// False when the robot speaks another version.
bool CheckVersion(Check& check, const std::string& spoken) {
  const std::string sentence = fmt::format("{} speaks {}", check.name, Shown(spoken));
  const auto levels = ReadTopic(check.dialect.topics, check.known.topic);
  const auto theirs = VersionSpoken(spoken, levels ? levels->major : "");
  if (!theirs || !HasDigit(spoken)) {
    if (!HasDigit(spoken)) return true;  // a text that says nothing is no contradiction
    check.Refuse(sentence + ", which fleetpub does not");
    return false;
  }
  if (Fits(spoken, theirs->version, check.dialect.version)) {
    if (!theirs->is_release) {
      check.Warn(fmt::format("{}: its version {}", check.name,
                             NoReleaseText(spoken, check.dialect.version)));
    }
    return true;
  }
  check.RefuseUnless(sentence, "use --vda auto");  // others of the command may speak another
  return false;
}

// The robot's connection message stands where we would not have looked: it would not hear us.
void CheckTopics(Check& check) {
  if (IsFoundAt(check, check.dialect.version)) return;
  check.RefuseUnless(fmt::format("{} is at {}, which is not where the command would go", check.name,
                                 Shown(check.known.topic)),
                     "use --vda auto, or --interface and --topic-template");
}

// ── operating mode ──

void CheckMode(Check& check, std::string_view mode) {
  const auto* const rule = std::find_if(kModes.begin(), kModes.end(),
                                        [&](const ModeRule& entry) { return entry.mode == mode; });
  if (rule == kModes.end()) return;
  const bool is_allowed =
      rule->obeys == Obeys::kCancelOrder && IsOnly(check.actions, "cancelOrder");
  if (is_allowed) return;
  const std::string_view what = rule->obeys == Obeys::kCancelOrder ? "cancelOrder only"
                                : check.actions.empty()            ? "no command"
                                                                   : "no instant action";
  std::string sentence = fmt::format("{} is in {} and obeys {}", check.name, rule->mode, what);
  if (IsOnlyStartPause(check.actions)) return check.Warn(std::move(sentence));
  check.Refuse(sentence);
}

// ── factsheet ──

bool Lists(const std::vector<std::string>& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

void CheckParameters(Check& check, const InstantAction& action, const FactsheetAction& listed) {
  if (!listed.has_parameters) return;
  const auto is_given = [&](std::string_view key) {
    return std::any_of(action.parameters.begin(), action.parameters.end(),
                       [&](const Parameter& given) { return given.key == key; });
  };
  for (const auto& [key, type, is_optional] : listed.parameters) {
    if (is_given(key) || is_optional.value_or(false)) continue;
    const std::string sentence = fmt::format("{}'s factsheet has the parameter {} for {}",
                                             check.name, Shown(key), Shown(action.type));
    // Many robots leave isOptional out.
    if (is_optional) {
      check.Refuse(sentence + " and requires it");
    } else {
      check.Warn(sentence + " and does not call it optional");
    }
  }
  for (const Parameter& given : action.parameters) {
    const bool is_listed = std::any_of(listed.parameters.begin(), listed.parameters.end(),
                                       [&](const auto& spec) { return spec.key == given.key; });
    if (is_listed) continue;
    check.Warn(fmt::format("{}'s factsheet has no parameter {} for {}", check.name,
                           Shown(given.key), Shown(action.type)));
  }
}

void CheckBlockingType(Check& check, const InstantAction& action, const FactsheetAction& listed) {
  const std::string type = action.blocking_type.empty() ? "NONE" : action.blocking_type;
  if (listed.blocking_types.empty() || Lists(listed.blocking_types, type)) return;
  const std::string sentence =
      fmt::format("{}'s factsheet does not list the blocking type {} for {}", check.name,
                  Shown(type), Shown(action.type));
  // From 3.0 an instant action has no other; the list is meant for orders then.
  if (GetFacts(check.dialect.version).only_blocking_type_none) return check.Warn(sentence);
  check.RefuseUnless(sentence,
                     "use --blocking-type " + Shown(base::Join(listed.blocking_types, " or ")));
}

void CheckListing(Check& check, const Factsheet& factsheet, const InstantAction& action) {
  if (factsheet.actions.empty()) return;
  const auto type = NameIn(check.dialect.version, action.type);
  const FactsheetAction* listed = FindAction(factsheet, type);
  if (listed == nullptr && IsRequiredOfAll(action.type)) {
    return check.Warn(fmt::format("{}'s factsheet does not list {}, which every robot must know",
                                  check.name, Shown(type)));
  }
  if (listed == nullptr) {
    return check.Refuse(fmt::format("{}'s factsheet does not list {}", check.name, Shown(type)));
  }
  if (!listed->scopes.empty() && !Lists(listed->scopes, "INSTANT")) {
    return check.Refuse(fmt::format("{}'s factsheet lists {} for {} only, not INSTANT", check.name,
                                    Shown(type), Shown(base::Join(listed->scopes, ", "))));
  }
  CheckParameters(check, action, *listed);
  CheckBlockingType(check, action, *listed);
}

bool IsNumber(std::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

bool Exceeds(std::size_t size, std::size_t limit) { return limit != 0 && size > limit; }

void CheckActionLimits(Check& check, const FactsheetLimits& limits, const InstantAction& action) {
  const bool is_long = Exceeds(action.id.size(), limits.id_length);
  const bool is_no_number = limits.id_numerical_only && !IsNumber(action.id);
  if (is_long || is_no_number) {
    const std::string fitting =
        fmt::format("{}{}", limits.id_numerical_only ? "only digits" : "any characters",
                    limits.id_length == 0 ? "" : fmt::format(", at most {}", limits.id_length));
    check.RefuseUnless(fmt::format("{} does not take the actionId {}: its factsheet allows {}",
                                   check.name, Shown(action.id), fitting),
                       "give another --id, or none");
  }
  if (Exceeds(action.parameters.size(), limits.action_parameters)) {
    check.Refuse(fmt::format("{}'s factsheet allows {} parameters for an action, {} has {}",
                             check.name, limits.action_parameters, Shown(action.type),
                             action.parameters.size()));
  }
}

void CheckLimits(Check& check, const FactsheetLimits& limits, std::size_t payload_bytes) {
  for (const InstantAction& action : check.actions) CheckActionLimits(check, limits, action);
  if (Exceeds(check.actions.size(), limits.instant_actions)) {
    check.Refuse(fmt::format("{}'s factsheet allows {} actions in a message, there are {}",
                             check.name, limits.instant_actions, check.actions.size()));
  }
  if (Exceeds(payload_bytes, limits.message_length)) {
    check.Refuse(fmt::format("{}'s factsheet allows messages of {} bytes, this one has {}",
                             check.name, limits.message_length, payload_bytes));
  }
}

}  // namespace

PreflightFindings CheckRobot(const RobotAddress& robot, const Dialect& dialect,
                             std::span<const InstantAction> actions, const KnownRobot& known,
                             std::size_t payload_bytes) {
  Check check{robot, dialect, actions, known, base::Printable(robot.ToString())};
  CheckConnection(check);
  const bool is_exempt = !dialect.header_version.empty() || !dialect.version_said.empty();
  const std::string& said =
      known.connection ? known.connection->header.version : known.said_version;
  if (is_exempt || CheckVersion(check, said)) CheckTopics(check);
  if (auto rival = RivalText(robot, known)) check.Warn(*std::move(rival));
  CheckMode(check, known.operating_mode);
  if (!known.factsheet_fault.empty()) {
    check.Warn(fmt::format("{}'s factsheet cannot be read, so its limits are not checked: {}",
                           check.name, known.factsheet_fault));
  }
  if (known.factsheet) {
    for (const InstantAction& action : actions) CheckListing(check, *known.factsheet, action);
    CheckLimits(check, known.factsheet->limits, payload_bytes);
  }
  return std::move(check.findings);
}

bool IsOnlyStartPause(std::span<const InstantAction> actions) {
  return IsOnly(actions, "startPause");
}

bool NeedsFactsheet(std::span<const InstantAction> actions) {
  return actions.empty() || !std::all_of(actions.begin(), actions.end(), [](const auto& action) {
           return IsRequiredOfAll(action.type);
         });
}

std::optional<std::string> RivalText(const RobotAddress& robot, const KnownRobot& known) {
  if (known.other_topic.empty()) return std::nullopt;
  return fmt::format("{} is ONLINE at {} and at {}: the first one is used",
                     base::Printable(robot.ToString()), Shown(known.topic),
                     Shown(known.other_topic));
}

std::string MakeActionId(const Factsheet* factsheet) {
  constexpr std::size_t kUuid = 36;
  constexpr std::size_t kDigits = 18;  // fits a signed 64-bit integer
  const FactsheetLimits limits = factsheet == nullptr ? FactsheetLimits() : factsheet->limits;
  if (!limits.id_numerical_only && !Exceeds(kUuid, limits.id_length)) return base::RandomUuid();
  const std::size_t digits = limits.id_length == 0 ? kDigits : std::min(kDigits, limits.id_length);
  std::random_device random;
  std::string id(1, static_cast<char>('1' + random() % 9));  // no leading zero
  while (id.size() < digits) id += static_cast<char>('0' + random() % 10);
  return id;
}

}  // namespace fleetpub::vda5050
