// The members of payloads as data: what they are called, what they hold. Options, columns of files
// and keys of `key=value` lists are made from these tables.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/rapidjson.h"
#include "base/result.h"
#include "soar/message_type.h"

namespace fleetpub::soar {

enum class FieldType { kInteger, kNumber, kBoolean, kText, kDateTime, kJson };

struct Field {
  std::string_view name;  ///< exactly as the format spells it
  FieldType type;
  std::string_view meaning;  ///< for the help, without a full stop
  bool required = false;
  std::array<std::string_view, 2> short_names = {};  ///< what people may say instead
  std::string_view parent = {};                      ///< the object that it is a member of
  std::array<std::string_view, 4> choices = {};      ///< of an enumeration; for the help
};

/// The payload's members that are single values, `message_type` aside.
[[nodiscard]] std::span<const Field> ListFields(MessageType type);
/// Of one waypoint of a mission plan.
[[nodiscard]] std::span<const Field> WaypointFields();
/// Of one point of interest of an observation.
[[nodiscard]] std::span<const Field> PointFields();

/// The field that somebody means: its name or a short one, in any letter case, with `-` for `_`.
[[nodiscard]] const Field* FindField(std::span<const Field> fields, std::string_view word);

/// A member of a payload with its value as JSON text.
struct Member {
  std::string name;
  std::string json;
  std::string parent = {};

  friend bool operator==(const Member&, const Member&) = default;
};

/// Reads the text as what the field holds. Errors: ErrorKind::kInvalid that name the field.
[[nodiscard]] Result<Member> ParseField(const Field& field, std::string_view text);

/// The same for a value of a JSON file.
[[nodiscard]] Result<Member> TakeField(const Field& field, const base::JsonValue& value);

/// The members of one object, in the order of its table.
using Item = std::vector<Member>;

enum class Completeness { kWhole, kPart };

/// Puts pairs of key and text together to one item. An unknown key, one that is there twice, a
/// value that cannot be read, a required member that is missing from a whole
/// item: ErrorKind::kInvalid.
[[nodiscard]] Result<Item> ItemFrom(
    std::span<const Field> fields,
    std::span<const std::pair<std::string_view, std::string_view>> pairs,
    Completeness completeness = Completeness::kWhole);

/// `lat=50.37,lon=-4.19,depth=15`: as ItemFrom. Values hold no comma.
[[nodiscard]] Result<Item> ParseItem(std::span<const Field> fields, std::string_view text,
                                     Completeness completeness = Completeness::kWhole);

/// That the item has what is required. Errors: ErrorKind::kInvalid.
[[nodiscard]] Status CheckComplete(std::span<const Field> fields, const Item& item);

/// Gives the items what they do not have themselves.
void AddDefaults(const Item& defaults, std::vector<Item>& items);

/// `[{…},{…}]`
[[nodiscard]] std::string ItemsJson(std::span<const Item> items);

}  // namespace fleetpub::soar
