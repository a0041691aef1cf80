#include "cli/output/output_kinds.h"

#include <gmock/gmock.h>
#include <gtest/gtest-spi.h>

#include "base/json.h"
#include "cli/parser/subcommand.h"
#include "message/command_status.h"
#include "schema/schema.h"
#include "support/described_output.h"
#include "support/operator.h"

namespace fleetpub::cli {
namespace {

using ::testing::AnyOfArray;
using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Value;

TEST(OutputSchemas, NameTheMembersOfEachKind) {
  const std::vector<std::string> live = {"--live"};
  EXPECT_EQ(FindOutputSchema("pause", {}), "fleetpub/output/result");
  EXPECT_EQ(FindOutputSchema("History Show", {}), "fleetpub/output/history");
  EXPECT_EQ(FindOutputSchema("validate", live), "fleetpub/output/violation");
  EXPECT_THAT(FindOutputSchema("completion", {}), IsEmpty());
  EXPECT_THAT(ListMembers("fleetpub/output/result"), Contains("elapsedMs"));
}

TEST(OutputSchemas, ExistForEachCommandThatPrintsObjectsOfItsOwn) {
  // They print files and scripts, or what others wrote: the message that was awaited, a schema.
  const std::vector<std::string_view> others = {"await", "completion", "config init", "schema show",
                                                "simulate"};
  schema::Registry registry;
  for (const Subcommand& subcommand : Subcommands()) {
    const std::string schema = FindOutputSchema(subcommand.name, {});
    if (Value(subcommand.name, AnyOfArray(others))) {
      EXPECT_THAT(schema, IsEmpty()) << subcommand.name;
      continue;
    }
    EXPECT_TRUE(registry.Find(schema)) << subcommand.name;
    EXPECT_THAT(ListMembers(schema), ::testing::Not(IsEmpty())) << subcommand.name;
  }
}

TEST(OutputSchemas, KnowEachStatus) {
  const auto document = base::ParseJson(*schema::Registry().Text("fleetpub/output/result"));
  std::vector<std::string> statuses;
  for (const auto& status : (*document)["properties"]["status"]["enum"].GetArray()) {
    statuses.emplace_back(status.GetString());
  }
  for (const auto& facts : message::kCommandStatuses) {
    EXPECT_THAT(statuses, Contains(std::string(facts.name)));
  }
  EXPECT_EQ(statuses.size(), std::size(message::kCommandStatuses));
}

TEST(OutputSchemas, AreWhatTestsHoldEachObjectAgainst) {
  const auto check = [](std::vector<std::string> arguments, std::string_view output) {
    arguments.insert(arguments.begin(), testing::Binary());
    testing::ExpectDescribed(arguments, output);
  };
  check({"ping", "-o", "json"}, "{\"reachable\":false,\"message\":\"no\"}\n");
  check({"ping", "-o", "json"}, "{\"error\":{\"exitCode\":4,\"message\":\"no\"}}\n");
  EXPECT_NONFATAL_FAILURE(check({"ping", "-o", "json"}, "{\"reachable\":1}\n"), "/reachable");
  EXPECT_NONFATAL_FAILURE(check({"ping", "-o", "json"}, "{\"error\":{}}\n"), "output/error");
  EXPECT_NONFATAL_FAILURE(check({"batch"}, "{\"line\":1}\n"), "output/result");
  check({"ping"}, "{\"reachable\":1}\n");
}

}  // namespace
}  // namespace fleetpub::cli
