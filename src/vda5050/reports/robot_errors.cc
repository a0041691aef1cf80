#include "vda5050/reports/robot_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <functional>

#include "base/text.h"

namespace fleetpub::vda5050 {
namespace {

// `order.action.actionId` and `action_id` both end in `actionid`.
std::string KeepLetters(std::string_view key) {
  std::string letters = base::ToLower(key);
  letters.erase(std::remove_if(letters.begin(), letters.end(),
                               [](char c) { return c == '_' || c == '-' || c == '.' || c == ' '; }),
                letters.end());
  return letters;
}

// A UUID cannot be anything else's id by chance; a short number can.
bool IsDistinctive(std::string_view id) {
  constexpr std::size_t kLongEnough = 16;
  return id.size() >= kLongEnough;
}

// `own_key` is lower case.
bool NamesAnotherThing(std::string_view letters, std::string_view own_key) {
  constexpr std::array<std::string_view, 12> kOthers = {
      "headerid", "orderid",    "orderupdateid", "nodeid", "edgeid",    "sequenceid",
      "mapid",    "mapversion", "zonesetid",     "loadid", "requestid", "actionid"};
  return std::any_of(kOthers.begin(), kOthers.end(), [&](std::string_view other) {
    return other != own_key && letters.ends_with(other);
  });
}

// What an error's references say, taken together.
struct Named {
  bool our_item = false;
  bool another_item = false;
  bool our_update = false;
  bool another_update = false;
  bool our_part = false;
  bool our_header_id = false;
  bool topic = false;
  bool our_topic = false;
  bool something = false;  ///< any id at all
};

// Some write the topic whole, some its last level, some `instantAction` or `orders`.
bool IsTopic(std::string_view written, std::string_view topic) {
  const std::string_view name = written.substr(written.rfind('/') + 1);  // npos + 1 is 0
  return base::EqualsIgnoringCase(name, topic) ||
         base::EqualsIgnoringCase(std::string(name) + "s", topic) ||
         base::EqualsIgnoringCase(name, std::string(topic) + "s");
}

void AddReference(const ErrorReference& reference, const SentItem& item, Named& named) {
  const std::string letters = KeepLetters(reference.key);
  const std::string own_key = base::ToLower(item.id_key);
  if (letters.ends_with("id")) named.something = true;
  if (reference.value == item.id &&
      (IsDistinctive(item.id) || !NamesAnotherThing(letters, own_key))) {
    named.our_item = true;
  } else if (letters.ends_with(own_key)) {
    named.another_item = true;
  }
  if (item.update_id && letters.ends_with("orderupdateid")) {
    const bool is_ours = reference.value == fmt::to_string(*item.update_id);
    (is_ours ? named.our_update : named.another_update) = true;
  }
  named.our_part |=
      std::any_of(item.parts.begin(), item.parts.end(), [&](const ErrorReference& part) {
        return reference.value == part.value && letters.ends_with(base::ToLower(part.key));
      });
  if (letters.ends_with("headerid")) {
    named.our_header_id |= std::any_of(
        item.header_ids.begin(), item.header_ids.end(),
        [&](std::uint32_t header_id) { return reference.value == fmt::to_string(header_id); });
  }
  if (letters.ends_with("topic")) {
    named.topic = true;
    named.our_topic |= IsTopic(reference.value, item.topic);
  }
}

// `validationError`, `VALIDATION_FAILURE`, `InvalidHeader`: about a message as a whole.
bool IsAboutAMessage(std::string_view type) {
  const std::string letters = KeepLetters(type);
  return letters.find("validation") != std::string::npos ||
         letters.find("header") != std::string::npos;
}

// The same for the same error in a later state.
std::size_t ComputeFingerprint(const RobotError& error) {
  std::string text = error.type + '\n' + error.description;
  for (const ErrorReference& reference : error.references) {
    text += '\n' + reference.key + '=' + reference.value;
  }
  return std::hash<std::string>()(text);
}

// 3.0: CRITICAL stops the robot, FATAL needs a person.
bool IsSevere(const RobotError& error) {
  return error.level == "FATAL" || error.level == "CRITICAL";
}

void AddNew(std::vector<std::string>& texts, std::string text) {
  constexpr std::size_t kEnough = 3;
  const bool known = std::find(texts.begin(), texts.end(), text) != texts.end();
  if (!known && texts.size() < kEnough) texts.push_back(std::move(text));
}

}  // namespace

Attribution Attribute(const RobotError& error, const SentItem& item) {
  Named named;
  for (const ErrorReference& reference : error.references) AddReference(reference, item, named);
  const bool another_update = named.another_update && !named.our_update;
  if (named.our_item && !another_update) return Attribution::kItem;
  const bool another = named.another_item || another_update;
  if (named.our_part && !another) return Attribution::kPart;
  const bool is_our_topic = named.topic ? named.our_topic : IsAboutAMessage(error.type);
  if (named.our_header_id && is_our_topic && !another) return Attribution::kHeaderId;
  return named.something ? Attribution::kOther : Attribution::kUnnamed;
}

bool IsNoOrder(const RobotError& error) { return KeepLetters(error.type) == "noordertocancel"; }

bool IsInstantActionListFull(const std::vector<RobotError>& errors) {
  return std::any_of(errors.begin(), errors.end(), [](const RobotError& error) {
    return KeepLetters(error.type) == "instantactionstatesfull";
  });
}

std::optional<std::uint32_t> HighestHeaderId(const std::vector<RobotError>& errors,
                                             std::string_view topic) {
  std::optional<std::uint32_t> highest;
  for (const RobotError& error : errors) {
    std::optional<std::uint32_t> id;
    bool is_of_topic = false;
    for (const auto& [key, value] : error.references) {
      const std::string letters = KeepLetters(key);
      is_of_topic = is_of_topic || (letters.ends_with("topic") && IsTopic(value, topic));
      std::uint32_t number = 0;
      const auto [end, wrong] = std::from_chars(value.data(), value.data() + value.size(), number);
      const bool is_number = wrong == std::errc() && end == value.data() + value.size();
      if (letters.ends_with("headerid") && is_number) id = number;
    }
    if (is_of_topic && id) highest = std::max(highest.value_or(0), *id);
  }
  return highest;
}

std::string FormatError(const RobotError& error) {
  constexpr std::size_t kType = 60;
  std::string told = error.type.empty() ? "error" : Shown(error.type, kType);
  if (!error.description.empty()) told += ": " + Shown(error.description);
  if (!error.hint.empty()) told += "; hint: " + Shown(error.hint);
  return told;
}

void RelatedErrors::Remember(const std::vector<RobotError>& errors, bool retained) {
  knows_before_ = knows_before_ || !retained;
  for (const RobotError& error : errors) old_.push_back(ComputeFingerprint(error));
}

Attribution RelatedErrors::Add(const std::vector<RobotError>& errors, const SentItem& item) {
  id_is_fresh_ = item.topic == "instantActions";
  auto nearest = Attribution::kOther;
  for (const RobotError& error : errors) {
    const Attribution attribution = Attribute(error, item);
    const bool is_old =
        std::find(old_.begin(), old_.end(), ComputeFingerprint(error)) != old_.end();
    if (is_old || attribution == Attribution::kOther) continue;
    nearest = std::max(nearest, attribution);
    say_no_order_ = say_no_order_ || IsNoOrder(error);
    constexpr std::size_t kEnough = 10;
    if (IsSevere(error) && told_.size() < kEnough &&
        told_.insert(ComputeFingerprint(error)).second) {
      severe_.push_back((attribution == Attribution::kUnnamed ? "possibly related: " : "") +
                        fmt::format("{} ({})", FormatError(error), Shown(error.level)));
    }
    AddNew(attribution >= Attribution::kPart       ? item_
           : attribution == Attribution::kHeaderId ? header_id_
                                                   : unnamed_,
           FormatError(error));
  }
  return nearest;
}

std::string RelatedErrors::Text() const {
  const auto& texts = !item_.empty() ? item_ : !header_id_.empty() ? header_id_ : unnamed_;
  if (texts.empty()) return "";
  const bool is_certain = knows_before_ || (id_is_fresh_ && !item_.empty());
  return fmt::format("{}{}{}",
                     !item_.empty()        ? ""
                     : !header_id_.empty() ? "probably ours, by its header id: "
                                           : "possibly related: ",
                     base::Join(texts, "; "),
                     is_certain ? "" : " (perhaps there before: no earlier state is known)");
}

}  // namespace fleetpub::vda5050
