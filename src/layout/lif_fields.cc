#include "layout/lif_fields.h"

#include <fmt/format.h>

#include <cmath>

#include "base/text.h"

namespace fleetpub::layout {
namespace {

constexpr double kMaxAngle = 3.14159265359;  // π as the published schemas write it
constexpr double kMostMetres = 1e9;          // farther than any site reaches, and far from overflow

}  // namespace

std::string Place::ToString() const {
  if (above == nullptr) return "";
  return above->ToString() +
         (name.empty() ? fmt::format("/{}", index) : "/" + base::PointerToken(name));
}

void FindingLog::Add(LayoutFinding::Level level, const Place& place, std::string text) {
  if (findings_.size() == kMost) {
    ++further_;
    return;
  }
  findings_.push_back({level, place.ToString(), std::move(text)});
}

void FindingLog::Error(const Place& place, std::string text) {
  Add(LayoutFinding::Level::kError, place, std::move(text));
}

void FindingLog::Warn(const Place& place, std::string text) {
  Add(LayoutFinding::Level::kWarning, place, std::move(text));
}

void FindingLog::NoteUnknown(const Place& object, std::string_view name) {
  if (const auto known = unknown_.find(name); known != unknown_.end()) {
    ++known->second.second;
    return;
  }
  if (findings_.size() >= kMost) return;
  unknown_.emplace(name, std::pair(findings_.size(), 1));
  Warn({&object, name}, fmt::format("'{}' is no member of the format", base::Printable(name)));
}

std::vector<LayoutFinding> FindingLog::Take() {
  for (const auto& [name, noted] : unknown_) {
    const auto& [index, count] = noted;
    if (count > 1) findings_[index].text += fmt::format(", here and in {} more places", count - 1);
  }
  if (further_ > 0) {
    findings_.push_back({LayoutFinding::Level::kError, "",
                         fmt::format("{} more findings are not listed", further_)});
  }
  return std::move(findings_);
}

std::string_view NameOfType(const base::JsonValue& value) {
  if (value.IsNull()) return "null";
  if (value.IsBool()) return "true or false";
  if (value.IsNumber()) return "a number";
  if (value.IsString()) return "a text";
  return value.IsArray() ? "an array" : "an object";
}

void Fields::Error(std::string_view name, std::string text) {
  is_faulty_ = true;
  log_.Error(At(name), std::move(text));
}

const base::JsonValue* Fields::Take(std::string_view name) {
  std::size_t index = 0;
  for (const auto& member : object_.GetObject()) {
    if (base::ToView(member.name) == name) {
      if (index < 64) taken_ |= std::uint64_t{1} << index;
      return member.value.IsNull() ? nullptr : &member.value;
    }
    ++index;
  }
  return nullptr;
}

const base::JsonValue* Fields::TakeArray(std::string_view name, bool is_required) {
  const auto* const value = Take(name);
  if (value != nullptr && value->IsArray()) return value;
  if (value != nullptr) {
    Error(name, fmt::format("must be an array, not {}", NameOfType(*value)));
  } else if (is_required) {
    is_faulty_ = true;
    log_.Error(place_, fmt::format("{} is missing", name));
  }
  return nullptr;
}

const base::JsonValue* Fields::TakeObject(std::string_view name) {
  const auto* const value = Take(name);
  if (value == nullptr || value->IsObject()) return value;
  Error(name, fmt::format("must be an object, not {}", NameOfType(*value)));
  return nullptr;
}

std::string Fields::TakeText(std::string_view name, bool is_required) {
  const auto* const value = Take(name);
  if (value != nullptr && value->IsString()) {
    if (is_required && value->GetStringLength() == 0) Error(name, "must not be empty");
    return std::string(base::ToView(*value));
  }
  if (value != nullptr) {
    Error(name, fmt::format("must be a text, not {}", NameOfType(*value)));
  } else if (is_required) {
    is_faulty_ = true;
    log_.Error(place_, fmt::format("{} is missing", name));
  }
  return {};
}

std::vector<std::string> Fields::TakeTexts(std::string_view name) {
  std::vector<std::string> texts;
  const auto* const array = TakeArray(name, false);
  if (array == nullptr) return texts;
  for (const auto& item : array->GetArray()) {
    if (item.IsString()) {
      texts.emplace_back(base::ToView(item));
    } else {
      Error(name, fmt::format("holds texts, not {}", NameOfType(item)));
    }
  }
  return texts;
}

std::optional<double> Fields::ReadNumber(std::string_view name, const base::JsonValue& value) {
  if (!value.IsNumber()) {
    Error(name, fmt::format("must be a number, not {}", NameOfType(value)));
    return std::nullopt;
  }
  const double number = value.GetDouble();
  if (std::abs(number) <= kMostMetres) return number;
  Error(name, fmt::format("{} is too large to be meant", number));
  return std::nullopt;
}

std::optional<double> Fields::TakeNumber(std::string_view name, bool is_required) {
  const auto* const value = Take(name);
  if (value != nullptr) return ReadNumber(name, *value);
  if (is_required) {
    is_faulty_ = true;
    log_.Error(place_, fmt::format("{} is missing", name));
  }
  return std::nullopt;
}

void Fields::CheckAngle(std::string_view name, double angle) {
  if (std::abs(angle) <= kMaxAngle) return;
  log_.Error(At(name), fmt::format("{} is no angle between -π and π{}", angle,
                                   std::abs(angle) > 6.3 ? ": angles are in radians" : ""));
}

std::optional<double> Fields::TakeAngle(std::string_view name) {
  const auto angle = TakeNumber(name);
  if (angle) CheckAngle(name, *angle);
  return angle;
}

std::optional<double> Fields::TakeNonNegative(std::string_view name) {
  const auto number = TakeNumber(name);
  if (number && *number < 0) Error(name, fmt::format("{} must not be negative", *number));
  return number;
}

std::optional<bool> Fields::TakeFlag(std::string_view name, bool is_required) {
  const auto* const value = Take(name);
  if (value != nullptr && value->IsBool()) return value->GetBool();
  if (value != nullptr) {
    Error(name, fmt::format("must be true or false, not {}", NameOfType(*value)));
  } else if (is_required) {
    log_.Error(place_, fmt::format("{} is missing", name));
  }
  return std::nullopt;
}

void Fields::Finish() {
  std::size_t index = 0;
  for (const auto& member : object_.GetObject()) {
    if (index < 64 && (taken_ >> index & 1U) == 0) {
      log_.NoteUnknown(place_, base::ToView(member.name));
    }
    ++index;
  }
}

}  // namespace fleetpub::layout
