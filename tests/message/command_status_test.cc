#include "message/command_status.h"

#include <gmock/gmock.h>

namespace fleetpub::message {
namespace {

TEST(CommandStatus, IsNamedAsTheManualNamesIt) {
  using enum CommandStatus;
  constexpr std::pair<CommandStatus, std::string_view> kCases[] = {
      {kDryRun, "DRY_RUN"},    {kSent, "SENT"},           {kPublished, "PUBLISHED"},
      {kAccepted, "ACCEPTED"}, {kFinished, "FINISHED"},   {kFailed, "FAILED"},
      {kRejected, "REJECTED"}, {kRetriable, "RETRIABLE"}, {kVanished, "VANISHED"},
      {kOffline, "OFFLINE"},   {kTimeout, "TIMEOUT"},     {kRefused, "REFUSED"},
      {kInvalid, "INVALID"},   {kError, "ERROR"},
  };
  for (const auto& [status, name] : kCases) EXPECT_EQ(GetName(status), name);
}

}  // namespace
}  // namespace fleetpub::message
