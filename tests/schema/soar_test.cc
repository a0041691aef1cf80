// The schema of SoAR messages: one good message of each type (tests/data/soar/messages.json), and
// everything that a single change to one of them makes of it.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <functional>

#include "base/file.h"
#include "base/json.h"
#include "schema/schema.h"

namespace fleetpub::schema {
namespace {

using Document = base::JsonDocument;
using Pointer = base::JsonPointer;
using Value = base::JsonValue;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr const char* kData = FLEETPUB_SOURCE_DIR "/tests/data/soar/";
// The document as the programme published it, where it lies beside the checkout.
constexpr const char* kPublished =
    FLEETPUB_SOURCE_DIR "/../shared/reference/seeds/soar-1.0-messages.openapi.json";
constexpr std::string_view kWhole = "/components/schemas/MESSAGE";

Document ReadData(const std::string& file) {
  const auto text = base::ReadFile(kData + file);
  auto document = base::ParseJson(text.value());
  return std::move(document.value());
}

const Schema& Ours() {
  static Registry registry;
  return *registry.Find("soar/1.0/messages#/components/schemas/MESSAGE").value();
}

std::vector<std::string> Faults(const Value& message) {
  std::vector<std::string> faults;
  for (const auto& [path, text] : Ours().Validate(message)) faults.push_back(path + ": " + text);
  return faults;
}

TEST(SoarSchema, TakesAMessageOfEachType) {
  const Document messages = ReadData("messages.json");
  EXPECT_EQ(messages.MemberCount(), 5U);
  for (const auto& [type, message] : messages.GetObject()) {
    EXPECT_THAT(Faults(message), IsEmpty()) << type.GetString();
    EXPECT_STREQ(message["payload"]["message_type"].GetString(), type.GetString());
  }
}

// A mission_plan satisfies observation as well: `oneOf` read literally would refuse it.
TEST(SoarSchema, DoesNotCountTheAlternativesThatAMessageSatisfies) {
  const Document messages = ReadData("messages.json");
  Registry registry;
  const auto observation = registry.Find("soar/1.0/messages#/components/schemas/observation");
  for (const char* type : {"mission_plan", "platform_status"}) {
    const Value& payload = messages[type]["payload"];
    EXPECT_THAT((*observation)->Validate(payload), IsEmpty()) << type;
    EXPECT_THAT(Faults(messages[type]), IsEmpty()) << type;
  }
}

// And each is checked by its own schema, not by any that it happens to satisfy.
TEST(SoarSchema, ChecksAMessageByItsOwnType) {
  Document messages = ReadData("messages.json");
  Value& plan = messages["mission_plan"];
  plan["payload"].RemoveMember("plan");
  EXPECT_THAT(Faults(plan), ElementsAre("/payload: plan is required but missing"));
  plan["payload"]["message_type"] = "observation";
  EXPECT_THAT(Faults(plan), IsEmpty());
}

TEST(SoarSchema, ListsTheTypesWhenOneIsUnknown) {
  Document messages = ReadData("messages.json");
  Value& message = messages["mission_plan"];
  message["payload"]["message_type"] = "mission_plans";
  EXPECT_THAT(Faults(message),
              ElementsAre("/payload/message_type: must be one of acknowledgement, mission_plan, "
                          "observation, planning_configuration, platform_status, not "
                          "\"mission_plans\""));
  message["payload"].RemoveMember("message_type");
  EXPECT_THAT(Faults(message), ElementsAre("/payload: message_type is required but missing"));
}

TEST(SoarSchema, LetsAnythingStandWhereItHasNoType) {
  Document messages = ReadData("messages.json");
  Value& payload = messages["observation"]["payload"];
  for (const char* json : {"null", "7", "\"\"", "[]", "{}"}) {
    const Document value = std::move(base::ParseJson(json).value());
    payload["region_surveyed"].CopyFrom(value, messages.GetAllocator());
    payload["additional_data"].CopyFrom(value, messages.GetAllocator());
    EXPECT_THAT(Faults(messages["observation"]), IsEmpty()) << json;
  }
}

// --- single changes

void EachPointer(const Value& value, const std::string& pointer,
                 const std::function<void(const std::string&)>& visit) {
  if (!pointer.empty()) visit(pointer);
  if (value.IsObject()) {
    for (const auto& [name, member] : value.GetObject()) {
      EachPointer(member, pointer + "/" + name.GetString(), visit);
    }
  } else if (value.IsArray()) {
    for (rapidjson::SizeType i = 0; i < value.Size(); ++i) {
      EachPointer(value[i], fmt::format("{}/{}", pointer, i), visit);
    }
  }
}

constexpr std::array<std::string_view, 9> kChanges = {
    "removed", "null", "true", "7", "1.5", R"("text")", R"("2026-02-30T00:00:00Z")", "[]", "{}"};

Document Changed(const Value& message, const std::string& pointer, std::string_view change) {
  Document copy;
  copy.CopyFrom(message, copy.GetAllocator());
  const Pointer place(pointer);
  if (change == "removed") {
    place.Erase(copy);
  } else {
    place.Set(copy, std::move(base::ParseJson(change).value()));
  }
  return copy;
}

// What a schema refuses: `pointer change` for each, by message.
Document Validity(const Schema& schema) {
  Document validity(rapidjson::kObjectType);
  auto& allocator = validity.GetAllocator();
  const Document messages = ReadData("messages.json");
  for (const auto& [type, message] : messages.GetObject()) {
    Value refused(rapidjson::kObjectType);
    const Value& whole = message;
    EachPointer(message, "", [&](const std::string& pointer) {
      std::string list;
      for (const std::string_view change : kChanges) {
        if (schema.Validate(Changed(whole, pointer, change)).empty()) continue;
        list += fmt::format("{}{}", list.empty() ? "" : " ", change);
      }
      refused.AddMember(Value(pointer, allocator), Value(list, allocator), allocator);
    });
    validity.AddMember(Value(type, allocator), refused, allocator);
  }
  return validity;
}

// FLEETPUB_RECORD=1 writes the file anew.
TEST(SoarSchema, ValidatesEveryChangeAsRecorded) {
  const Document validity = Validity(Ours());
  if (std::getenv("FLEETPUB_RECORD") != nullptr) {
    std::ofstream(kData + std::string("validity.json")) << base::ToPrettyJson(validity) << '\n';
  }
  const Document recorded = ReadData("validity.json");
  EXPECT_EQ(base::ToPrettyJson(validity), base::ToPrettyJson(recorded));
}

// Where it is not at hand, the recorded results, which were its own, stand for it.
TEST(SoarSchema, ValidatesEveryChangeAsThePublishedDocument) {
  const auto text = base::ReadFile(kPublished);
  if (!text) return;
  const auto published = Schema::Compile(*text, "published", kWhole);
  ASSERT_TRUE(published) << published.error().message;
  EXPECT_EQ(base::ToPrettyJson(Validity(Ours())), base::ToPrettyJson(Validity(*published)));
}

}  // namespace
}  // namespace fleetpub::schema
