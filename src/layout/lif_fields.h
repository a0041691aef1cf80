// Takes the members of a file's objects one by one, and notes what is wrong with them.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/json.h"
#include "layout/layout.h"

namespace fleetpub::layout {

/// Where a value stands. Written out only when something is wrong with it.
struct Place {
  const Place* above = nullptr;
  std::string_view name;
  std::size_t index = 0;  ///< of an element; it has no name then

  [[nodiscard]] std::string ToString() const;
};

class FindingLog {
 public:
  void Error(const Place& place, std::string text);
  void Warn(const Place& place, std::string text);
  /// A member that the format does not know: told once for each name, at the first.
  void NoteUnknown(const Place& object, std::string_view name);

  [[nodiscard]] std::vector<LayoutFinding> Take();

 private:
  static constexpr std::size_t kMost = 10'000;

  void Add(LayoutFinding::Level level, const Place& place, std::string text);

  std::vector<LayoutFinding> findings_;
  std::map<std::string, std::pair<std::size_t, std::size_t>, std::less<>> unknown_;
  std::size_t further_ = 0;
};

/// An object whose members are taken.
class Fields {
 public:
  Fields(const base::JsonValue& object, const Place& place, FindingLog& log)
      : object_(object), place_(place), log_(log) {}
  Fields(const Fields&) = delete;
  Fields& operator=(const Fields&) = delete;

  [[nodiscard]] const Place& place() const { return place_; }
  [[nodiscard]] FindingLog& log() const { return log_; }
  [[nodiscard]] Place At(std::string_view name) const { return {&place_, name}; }
  /// Whether something was wrong with a member so far.
  [[nodiscard]] bool is_faulty() const { return is_faulty_; }
  void Error(std::string_view name, std::string text);

  /// Null: it is not there, or null.
  const base::JsonValue* Take(std::string_view name);
  /// It is missing, or of another type: null, and an error where it must be there.
  const base::JsonValue* TakeArray(std::string_view name, bool is_required);
  const base::JsonValue* TakeObject(std::string_view name);
  std::string TakeText(std::string_view name, bool is_required = false);
  std::vector<std::string> TakeTexts(std::string_view name);
  std::optional<double> TakeNumber(std::string_view name, bool is_required = false);
  std::optional<double> TakeAngle(std::string_view name);
  std::optional<double> TakeNonNegative(std::string_view name);
  std::optional<bool> TakeFlag(std::string_view name, bool is_required = false);
  /// A number; an angle of more than ±π is an error, and read.
  std::optional<double> ReadNumber(std::string_view name, const base::JsonValue& value);
  void CheckAngle(std::string_view name, double angle);

  /// Once all are taken: the others are not known.
  void Finish();

 private:
  const base::JsonValue& object_;
  const Place& place_;
  FindingLog& log_;
  std::uint64_t taken_ = 0;
  bool is_faulty_ = false;
};

/// What a value is, for messages: `a text`, `null`.
[[nodiscard]] std::string_view NameOfType(const base::JsonValue& value);

enum class Reading { kOnce, kAgain };  ///< again: what is not known was told before

/// Calls `read` with the fields of each object of an array, and its place in it.
template <class Read>
void EachObject(Fields& fields, std::string_view name, bool is_required, Read read,
                Reading reading = Reading::kOnce) {
  const base::JsonValue* const array = fields.TakeArray(name, is_required);
  if (array == nullptr) return;
  const Place above = fields.At(name);
  for (rapidjson::SizeType i = 0; i < array->Size(); ++i) {
    const Place place{&above, {}, i};
    const base::JsonValue& item = (*array)[i];
    if (item.IsObject()) {
      Fields inner(item, place, fields.log());
      read(inner, i);
      if (reading == Reading::kOnce) inner.Finish();
    } else if (reading == Reading::kOnce) {
      fields.log().Error(place, fmt::format("must be an object, not {}", NameOfType(item)));
    }
  }
}

}  // namespace fleetpub::layout
