#include "dispatch/verdict.h"

#include <gmock/gmock.h>

namespace fleetpub::dispatch {
namespace {

TEST(Verdict, IsNamedAsTheManualNamesIt) {
  using enum Verdict;
  constexpr std::pair<Verdict, std::string_view> kCases[] = {
      {kDryRun, "DRY_RUN"},    {kSent, "SENT"},           {kPublished, "PUBLISHED"},
      {kAccepted, "ACCEPTED"}, {kFinished, "FINISHED"},   {kFailed, "FAILED"},
      {kRejected, "REJECTED"}, {kRetriable, "RETRIABLE"}, {kVanished, "VANISHED"},
      {kOffline, "OFFLINE"},   {kTimeout, "TIMEOUT"},     {kRefused, "REFUSED"},
      {kInvalid, "INVALID"},   {kError, "ERROR"},
  };
  for (const auto& [verdict, name] : kCases) EXPECT_EQ(NameOf(verdict), name);
}

}  // namespace
}  // namespace fleetpub::dispatch
