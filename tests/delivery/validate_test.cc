#include "delivery/validate.h"

#include <gmock/gmock.h>

#include "base/json.h"

namespace fleetpub::delivery {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::string_view kAction = R"([{"actionType":"a","actionId":"1","blockingType":"NONE"}])";

// A command whose message is the header and these members.
message::Command CommandWith(const std::string& members) {
  message::Command command;
  command.schema = "vda5050/2.0.0/instantActions";
  command.payload = {
      R"({"headerId":)", R"(,"timestamp":")",
      R"(","version":"2.0.0","manufacturer":"m","serialNumber":"s",)" + members + "}"};
  return command;
}

message::Command ValidCommand() { return CommandWith(R"("actions":)" + std::string(kAction)); }

message::TextRules Finding(bool is_error) {
  return [is_error](const base::JsonValue&) {
    return std::vector<message::TextFinding>{{{"/actions", "is odd"}, is_error}};
  };
}

Findings MustValidate(const message::Command& command) {
  schema::Registry registry;
  auto findings = Validate(command, registry);
  if (!findings) throw std::runtime_error(findings.error().message);
  return std::move(*findings);
}

TEST(Validate, FindsNothingInAValidMessage) {
  const Findings findings = MustValidate(ValidCommand());
  EXPECT_THAT(findings.errors, IsEmpty());
  EXPECT_THAT(findings.warnings, IsEmpty());
  EXPECT_TRUE(findings.satisfies_schema);
}

TEST(Validate, ListsViolationsOfTheSchema) {
  const Findings findings = MustValidate(CommandWith(R"("actions":[{"actionType":7}])"));
  EXPECT_GE(findings.errors.size(), 2U);
  EXPECT_FALSE(findings.satisfies_schema);
}

TEST(Validate, TellsErrorsOfTheTextFromWarnings) {
  message::Command command = ValidCommand();
  command.text_rules = Finding(true);
  EXPECT_THAT(MustValidate(command).errors, ElementsAre(schema::Violation{"/actions", "is odd"}));
  EXPECT_TRUE(MustValidate(command).satisfies_schema);
  command.text_rules = Finding(false);
  EXPECT_THAT(MustValidate(command).errors, IsEmpty());
  EXPECT_THAT(MustValidate(command).warnings, SizeIs(1));
}

TEST(Validate, AsksTheTextOnlyWhenTheSchemaIsSatisfied) {
  message::Command command = CommandWith(R"("actions":7)");
  bool asked = false;
  command.text_rules = [&](const base::JsonValue&) {
    asked = true;
    return std::vector<message::TextFinding>();
  };
  EXPECT_THAT(MustValidate(command).errors, SizeIs(1));
  EXPECT_FALSE(asked);
}

TEST(Validate, ReadsARenamedMemberUnderItsOwnName) {
  message::Command command = CommandWith(R"("instantActions":)" + std::string(kAction));
  EXPECT_THAT(MustValidate(command).errors, SizeIs(1)) << "without the quirk it lacks actions";
  command.renamed_member = {"instantActions", "actions"};
  command.text_rules = [](const base::JsonValue& message) {
    EXPECT_NE(base::FindMember(message, "actions"), nullptr);
    return std::vector<message::TextFinding>();
  };
  EXPECT_THAT(MustValidate(command).errors, IsEmpty());
}

TEST(Validate, ChecksTheHeaderIdAskedFor) {
  message::Command command = ValidCommand();
  command.header_id = 4'294'967'295U;
  EXPECT_THAT(MustValidate(command).errors, IsEmpty());
}

TEST(Validate, FailsWithoutTheSchema) {
  message::Command command = ValidCommand();
  command.schema = "vda5050/2.0.0/nonsense";
  schema::Registry registry;
  const auto findings = Validate(command, registry);
  ASSERT_FALSE(findings);
  EXPECT_EQ(findings.error().kind, ErrorKind::kUsage);
}

TEST(Validate, RefusesAPayloadThatIsNoJson) {
  schema::Registry registry;
  for (const std::string members : {"\"actions\":\xFF", R"("actions":[],"actions":[])", "]"}) {
    const auto findings = Validate(CommandWith(members), registry);
    ASSERT_FALSE(findings) << members;
    EXPECT_EQ(findings.error().kind, ErrorKind::kInvalid);
  }
}

TEST(Describe, NamesThePlacesInTheSchemasWords) {
  EXPECT_EQ(Describe({.errors = {{"/a/0", "must be a string"}, {"", "must have b"}},
                      .satisfies_schema = false}),
            "/a/0: must be a string; must have b");
}

TEST(Describe, LetsTheTextsRulesSpeakForThemselves) {
  EXPECT_EQ(Describe({.errors = {{"/actions/0", "logReport needs the parameter reason"}}}),
            "logReport needs the parameter reason");
  EXPECT_EQ(Describe({}), "");
}

TEST(Describe, NamesWhatIsWrongWithARealMessage) {
  EXPECT_THAT(Describe(MustValidate(CommandWith(R"("actions":[7])"))), HasSubstr("/actions/0: "));
}

}  // namespace
}  // namespace fleetpub::delivery
