#include "cli/output/output_kinds.h"

#include <gmock/gmock.h>

#include "base/json.h"
#include "cli/parser/subcommand.h"
#include "message/command_status.h"
#include "schema/schema.h"

namespace fleetpub::cli {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;

TEST(OutputSchemas, NameTheMembersOfEachKind) {
  const std::vector<std::string> live = {"--live"};
  EXPECT_EQ(FindOutputSchema("pause", {}), "fleetpub/output/result");
  EXPECT_EQ(FindOutputSchema("History Show", {}), "fleetpub/output/history");
  EXPECT_EQ(FindOutputSchema("validate", live), "fleetpub/output/violation");
  EXPECT_THAT(FindOutputSchema("completion", {}), IsEmpty());
  EXPECT_THAT(ListMembers("fleetpub/output/result"), Contains("elapsedMs"));
}

TEST(OutputSchemas, ExistForEachCommandThatHasOne) {
  schema::Registry registry;
  for (const Subcommand& subcommand : Subcommands()) {
    const std::string schema = FindOutputSchema(subcommand.name, {});
    if (schema.empty()) continue;
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

}  // namespace
}  // namespace fleetpub::cli
