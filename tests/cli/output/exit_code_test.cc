#include "cli/output/exit_code.h"

#include <gmock/gmock.h>

#include <array>

namespace fleetpub::cli {
namespace {

using enum ExitCode;

// As the manual lists them: over several targets the first that occurred.
constexpr std::array kPrecedence = {kInterrupted, kUnexpected, kLedger,  kBroker, kRejected,
                                    kUnconfirmed, kPreflight,  kInvalid, kUsage,  kDone};

TEST(ExitCode, HasTheDocumentedNumbers) {
  std::vector<int> numbers;
  for (const ExitCode code : kPrecedence) numbers.push_back(static_cast<int>(code));
  EXPECT_THAT(numbers, ::testing::ElementsAre(130, 1, 8, 4, 5, 6, 7, 3, 2, 0));
  EXPECT_EQ(static_cast<int>(kTerminated), 143);
}

TEST(Worse, IsTheOneThatStandsEarlier) {
  for (std::size_t i = 0; i < kPrecedence.size(); ++i) {
    for (std::size_t j = i; j < kPrecedence.size(); ++j) {
      EXPECT_EQ(Worse(kPrecedence[i], kPrecedence[j]), kPrecedence[i]);
      EXPECT_EQ(Worse(kPrecedence[j], kPrecedence[i]), kPrecedence[i]);
    }
  }
}

TEST(Worse, KeepsTermination) {
  EXPECT_EQ(Worse(kTerminated, kDone), kTerminated);
  EXPECT_EQ(Worse(kBroker, kTerminated), kTerminated);
}

TEST(GetExitCode, FollowsTheKindOfTheError) {
  constexpr std::pair<ErrorKind, int> kCases[] = {
      {ErrorKind::kUnexpected, 1}, {ErrorKind::kUsage, 2},    {ErrorKind::kInvalid, 3},
      {ErrorKind::kBroker, 4},     {ErrorKind::kRejected, 5}, {ErrorKind::kUnconfirmed, 6},
      {ErrorKind::kPreflight, 7},  {ErrorKind::kLedger, 8},
  };
  for (const auto& [kind, code] : kCases) {
    EXPECT_EQ(static_cast<int>(GetExitCode(kind)), code);
    EXPECT_EQ(static_cast<int>(GetExitCode(message::Report{.error = kind})), code);
  }
}

// What a target's word is worth, whoever asked it and however it was named.
TEST(GetExitCode, FollowsTheStatus) {
  using enum message::CommandStatus;
  constexpr std::pair<message::CommandStatus, int> kCases[] = {
      {kAccepted, 0},  {kFinished, 0}, {kNoOrder, 5}, {kFailed, 5},  {kRejected, 5},
      {kRetriable, 6}, {kVanished, 6}, {kOffline, 6}, {kTimeout, 6}, {kInterrupted, 6},
  };
  for (const auto& [status, code] : kCases) {
    const message::Report report{.status = status, .error = message::ToErrorKind(status)};
    EXPECT_EQ(static_cast<int>(GetExitCode(report)), code) << message::GetName(status);
  }
}

TEST(GetExitCode, IsDoneForAReportWithoutTrouble) {
  EXPECT_EQ(GetExitCode(message::Report{.status = message::CommandStatus::kSent}), kDone);
}

}  // namespace
}  // namespace fleetpub::cli
