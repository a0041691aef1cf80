#include "soar/field.h"

#include <gmock/gmock.h>

#include <array>

#include "base/json.h"
#include "schema/schema.h"
#include "soar/message.h"

namespace fleetpub::soar {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const Field& Named(std::span<const Field> fields, std::string_view word) {
  const Field* field = FindField(fields, word);
  EXPECT_NE(field, nullptr) << word;
  return *field;
}

std::string Json(std::span<const Field> fields, std::string_view word, std::string_view text) {
  const auto member = ParseField(Named(fields, word), text);
  return member ? member->json : "error: " + member.error().message;
}

TEST(SoarFields, AreFoundByAnyNameThatPeopleSay) {
  const auto fields = WaypointFields();
  for (const char* word : {"latitude_waypoint", "lat", "LAT", "latitude", "latitude-waypoint"}) {
    EXPECT_EQ(Named(fields, word).name, "latitude_waypoint");
  }
  for (const char* word : {"", "latitude_", "x"}) EXPECT_EQ(FindField(fields, word), nullptr);
}

// Each name and type is held against the schema, so that a slip in the table is found.
TEST(SoarFields, AreThoseOfTheSchema) {
  schema::Registry registry;
  for (const auto& [name, type] : kMessageTypes) {
    const auto document = base::ParseJson(registry.Text("soar/1.0/messages").value());
    const auto& schemas = (*document)["components"]["schemas"];
    for (const Field& field : ListFields(type)) {
      const std::string owner(field.parent.empty() ? GetName(type) : field.parent);
      const auto& schema = schemas[owner];
      const auto* property = base::FindMember(schema["properties"], field.name);
      ASSERT_NE(property, nullptr) << field.name;
      constexpr std::array<std::string_view, 6> kTypes = {"integer", "number", "boolean",
                                                          "string",  "string", ""};
      EXPECT_EQ(base::StringMember(*property, "type"), kTypes[static_cast<std::size_t>(field.type)])
          << field.name;
      EXPECT_EQ(base::StringMember(*property, "format") == "date-time",
                field.type == FieldType::kDateTime);
      std::vector<std::string> choices;
      for (const auto choice : field.choices) {
        if (!choice.empty()) choices.emplace_back(choice);
      }
      const auto* known = base::FindMember(*property, "enum");
      ASSERT_EQ(known == nullptr ? 0 : known->Size(), choices.size()) << field.name;
      for (rapidjson::SizeType i = 0; i < choices.size(); ++i) EXPECT_EQ((*known)[i], choices[i]);
    }
  }
}

TEST(SoarFields, ReadTypedValues) {
  const auto status = ListFields(MessageType::kPlatformStatus);
  EXPECT_EQ(Json(status, "platform_ID", "7"), "7");
  EXPECT_EQ(Json(status, "platform_ID", "-9223372036854775808"), "-9223372036854775808");
  EXPECT_EQ(Json(status, "latitude", "50.37072283932642"), "50.37072283932642");
  EXPECT_EQ(Json(status, "latitude", " 5e1 "), "50");
  EXPECT_EQ(Json(status, "sensor_on", "TRUE"), "true");
  EXPECT_EQ(Json(status, "platform_state", "say \"so\""), R"("say \"so\"")");
  EXPECT_EQ(Json(status, "status_source", "usbl"), R"("usbl")");
  EXPECT_EQ(Json(status, "platform_timestamp", "2026-01-02T03:04:05Z"),
            R"("2026-01-02T03:04:05Z")");
  EXPECT_EQ(Json(ListFields(MessageType::kObservation), "region_surveyed", " [1, null] "),
            "[1,null]");
}

TEST(SoarFields, RefuseWhatIsOfAnotherKindAndNameTheField) {
  struct Case {
    std::string_view field;
    std::string_view text;
    std::string_view why;
  };
  constexpr std::array kCases = {
      Case{"platform_ID", "1.5", "platform_ID must be a whole number, not '1.5'"},
      Case{"platform_ID", "", "a whole number"},
      Case{"platform_ID", "0x10", "a whole number"},
      Case{"platform_ID", "9223372036854775808", "a whole number"},
      Case{"latitude", "north", "latitude must be a number, not 'north'"},
      Case{"latitude", "nan", "a number"},
      Case{"latitude", "inf", "a number"},
      Case{"latitude", "1e999", "a number"},
      Case{"latitude", "50,37", "a number"},
      Case{"sensor_on", "1", "true or false"},
      Case{"platform_state", "\xFF", "UTF-8"},
      Case{"status_source", "Usbl", "one of usbl, onboard_platform, not 'Usbl'"},
      Case{"status_source", "", "one of usbl"},
      Case{"platform_timestamp", "yesterday", "a date-time"},
      Case{"sensor_data", "{", "additional_data"},
  };
  for (const auto& [field, text, why] : kCases) {
    const auto member = ParseField(Named(ListFields(MessageType::kPlatformStatus), field), text);
    ASSERT_FALSE(member) << field << text;
    EXPECT_EQ(member.error().kind, ErrorKind::kInvalid);
    EXPECT_THAT(member.error().message, HasSubstr(why));
  }
}

TEST(SoarItem, IsReadFromAList) {
  const auto item =
      ParseItem(WaypointFields(), "action=move, lon=-4.1872,lat=50.3707,activate_payload=true");
  ASSERT_TRUE(item) << item.error().message;
  EXPECT_THAT(
      *item,
      ElementsAre(Member{"latitude_waypoint", "50.3707"}, Member{"longitude_waypoint", "-4.1872"},
                  Member{"action", R"("move")"}, Member{"activate_payload", "true"}));
  const std::array items = {*item, Item{{"a", "1"}}, Item{}};
  EXPECT_EQ(ItemsJson(items),
            R"([{"latitude_waypoint":50.3707,"longitude_waypoint":-4.1872,"action":"move",)"
            R"("activate_payload":true},{"a":1},{}])");
  EXPECT_EQ(ItemsJson({}), "[]");
}

TEST(SoarItem, RefusesWhatIsUnknownDoubleOrMissing) {
  struct Case {
    std::string_view text;
    std::string_view why;
  };
  constexpr std::array kCases = {
      Case{"", "not a KEY=VALUE"},
      Case{"lat", "'lat' is not a KEY=VALUE"},
      Case{"lat=1", "longitude_waypoint is missing"},
      Case{"lon=1", "latitude_waypoint is missing"},
      Case{"lat=1,lon=2,latitude=3", "latitude_waypoint is given twice"},
      Case{"lat=1,lon=2,deph=3", "'deph' is not known here: there are lat, lon, depth"},
      Case{"lat=,lon=2", "latitude_waypoint must be a number, not ''"},
      Case{"lat=1,lon=2,", "not a KEY=VALUE"},
      Case{"lat=1,lon=2,=3", "'' is not known"},
  };
  for (const auto& [text, why] : kCases) {
    const auto item = ParseItem(WaypointFields(), text);
    ASSERT_FALSE(item) << text;
    EXPECT_THAT(item.error().message, HasSubstr(why));
  }
}

TEST(SoarItem, TakesDefaultsWhereItSaysNothing) {
  const auto defaults = ParseItem(WaypointFields(), "depth=15,action=move", Completeness::kPart);
  ASSERT_TRUE(defaults);
  std::vector<Item> items = {{{"depth", "3"}}, {}};
  AddDefaults(*defaults, items);
  EXPECT_EQ(ItemsJson(items), R"([{"depth":3,"action":"move"},{"depth":15,"action":"move"}])");
}

}  // namespace
}  // namespace fleetpub::soar
