// Writes members of JSON objects, one after the other.
#pragma once

#include <cstdint>
#include <string_view>

#include "base/rapidjson.h"

namespace fleetpub::base {

inline void PutText(JsonWriter& json, std::string_view text) {
  json.String(text.data(), static_cast<rapidjson::SizeType>(text.size()));
}

inline void Put(JsonWriter& json, std::string_view key, std::string_view text) {
  PutText(json, key);
  PutText(json, text);
}

inline void Put(JsonWriter& json, std::string_view key, bool value) {
  PutText(json, key);
  json.Bool(value);
}

inline void Put(JsonWriter& json, std::string_view key, std::uint32_t value) {
  PutText(json, key);
  json.Uint(value);
}

inline void Put(JsonWriter& json, std::string_view key, double value) {
  PutText(json, key);
  json.Double(value);
}

/// `put_members` writes the members.
template <typename PutMembers>
void PutObject(JsonWriter& json, std::string_view key, PutMembers put_members) {
  PutText(json, key);
  json.StartObject();
  put_members();
  json.EndObject();
}

/// `put_item` writes the members of an item's object.
template <typename Items, typename PutItem>
void PutArray(JsonWriter& json, std::string_view key, const Items& items, PutItem put_item) {
  PutText(json, key);
  json.StartArray();
  for (const auto& item : items) {
    json.StartObject();
    put_item(item);
    json.EndObject();
  }
  json.EndArray();
}

}  // namespace fleetpub::base
