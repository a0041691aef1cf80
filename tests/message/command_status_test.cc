#include "message/command_status.h"

#include <gmock/gmock.h>

namespace fleetpub::message {
namespace {

// What a summary counts it as and what a script gets, by its name.
TEST(CommandStatus, HasOneRowForWordSummaryAndTrouble) {
  using enum CommandStatus;
  using Group = StatusGroup;
  constexpr auto kNone = std::optional<ErrorKind>();
  constexpr auto kRefusal = std::optional(ErrorKind::kRejected);
  constexpr auto kOpen = std::optional(ErrorKind::kUnconfirmed);
  struct Row {
    CommandStatus status;
    std::string_view name;
    StatusGroup group;
    std::optional<ErrorKind> trouble;
  };
  constexpr Row kRows[] = {
      {kDryRun, "DRY_RUN", Group::kSent, kNone},
      {kSent, "SENT", Group::kSent, kNone},
      {kPublished, "PUBLISHED", Group::kSent, kNone},
      {kAccepted, "ACCEPTED", Group::kFinished, kNone},
      {kFinished, "FINISHED", Group::kFinished, kNone},
      {kNoOrder, "NO_ORDER", Group::kNoOrder, kRefusal},
      {kFailed, "FAILED", Group::kFailed, kRefusal},
      {kRejected, "REJECTED", Group::kFailed, kRefusal},
      {kRetriable, "RETRIABLE", Group::kUnconfirmed, kOpen},
      {kVanished, "VANISHED", Group::kUnconfirmed, kOpen},
      {kOffline, "OFFLINE", Group::kOffline, kOpen},
      {kTimeout, "TIMEOUT", Group::kUnconfirmed, kOpen},
      {kInterrupted, "INTERRUPTED", Group::kUnconfirmed, kOpen},
      {kRefused, "REFUSED", Group::kRefused, kNone},
      {kInvalid, "INVALID", Group::kRefused, kNone},
      {kError, "ERROR", Group::kErrors, kNone},
  };
  ASSERT_EQ(std::size(kRows), kCommandStatuses.size());
  for (const Row& row : kRows) {
    EXPECT_EQ(GetName(row.status), row.name);
    EXPECT_EQ(GetFacts(row.status).group, row.group) << row.name;
    EXPECT_EQ(ToErrorKind(row.status), row.trouble) << row.name;
  }
}

}  // namespace
}  // namespace fleetpub::message
