#include "vda5050/robot_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>

#include "base/text.h"

namespace fleetpub::vda5050 {
namespace {

// `order.action.actionId` and `action_id` both end in `actionid`.
std::string LettersOf(std::string_view key) {
  std::string letters = base::ToLower(key);
  letters.erase(std::remove_if(letters.begin(), letters.end(),
                               [](char c) { return c == '_' || c == '-' || c == '.' || c == ' '; }),
                letters.end());
  return letters;
}

// A UUID cannot be anything else's id by chance; a short number can.
bool IsDistinctive(std::string_view action_id) {
  constexpr std::size_t kLongEnough = 16;
  return action_id.size() >= kLongEnough;
}

bool NamesAnotherThing(std::string_view letters) {
  constexpr std::array<std::string_view, 10> kOthers = {
      "headerid",   "orderid", "orderupdateid", "nodeid",    "edgeid",
      "sequenceid", "mapid",   "mapversion",    "zonesetid", "loadid"};
  return std::any_of(kOthers.begin(), kOthers.end(),
                     [&](std::string_view other) { return letters.ends_with(other); });
}

// What an error's references say, taken together.
struct Named {
  bool our_action = false;
  bool another_action = false;
  bool our_header_id = false;
  bool topic = false;
  bool instant_actions = false;  ///< the topic is ours
  bool something = false;        ///< any id at all
};

bool IsInstantActions(std::string_view topic) {
  const std::string_view name = topic.substr(topic.rfind('/') + 1);  // npos + 1 is 0
  return base::EqualsIgnoringCase(name, "instantActions") ||
         base::EqualsIgnoringCase(name, "instantAction");
}

void Note(const ErrorReference& reference, std::string_view action_id,
          std::span<const std::uint32_t> header_ids, Named& named) {
  const std::string letters = LettersOf(reference.key);
  if (letters.ends_with("id")) named.something = true;
  if (reference.value == action_id && (IsDistinctive(action_id) || !NamesAnotherThing(letters))) {
    named.our_action = true;
  } else if (letters.ends_with("actionid")) {
    named.another_action = true;
  }
  if (letters.ends_with("headerid")) {
    named.our_header_id |= std::any_of(
        header_ids.begin(), header_ids.end(),
        [&](std::uint32_t header_id) { return reference.value == fmt::to_string(header_id); });
  }
  if (letters.ends_with("topic")) {
    named.topic = true;
    named.instant_actions |= IsInstantActions(reference.value);
  }
}

// `validationError`, `VALIDATION_FAILURE`, `InvalidHeader`: about a message as a whole.
bool IsAboutAMessage(std::string_view type) {
  const std::string letters = LettersOf(type);
  return letters.find("validation") != std::string::npos ||
         letters.find("header") != std::string::npos;
}

}  // namespace

Attribution AttributionOf(const RobotError& error, std::string_view action_id,
                          std::span<const std::uint32_t> header_ids) {
  Named named;
  for (const ErrorReference& reference : error.references) {
    Note(reference, action_id, header_ids, named);
  }
  if (named.our_action) return Attribution::kAction;
  const bool is_our_topic = named.topic ? named.instant_actions : IsAboutAMessage(error.type);
  if (named.our_header_id && is_our_topic && !named.another_action) return Attribution::kHeaderId;
  return named.something ? Attribution::kOther : Attribution::kUnnamed;
}

std::size_t FingerprintOf(const RobotError& error) {
  std::string text = error.type + '\n' + error.description;
  for (const ErrorReference& reference : error.references) {
    text += '\n' + reference.key + '=' + reference.value;
  }
  return std::hash<std::string>()(text);
}

std::string Told(const RobotError& error) {
  constexpr std::size_t kType = 60;
  std::string told = error.type.empty() ? "error" : Shown(error.type, kType);
  if (!error.description.empty()) told += ": " + Shown(error.description);
  if (!error.hint.empty()) told += "; hint: " + Shown(error.hint);
  return told;
}

}  // namespace fleetpub::vda5050
