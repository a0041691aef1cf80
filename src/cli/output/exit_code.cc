#include "cli/output/exit_code.h"

#include <algorithm>
#include <array>

namespace fleetpub::cli {
namespace {

using enum ExitCode;

constexpr std::array kWorstFirst = {kInterrupted, kTerminated, kUnexpected,  kLedger,
                                    kBroker,      kRejected,   kUnconfirmed, kPreflight,
                                    kInvalid,     kUsage,      kDone};

constexpr auto kMeanings = std::to_array<ExitCodeMeaning>({
    {kDone, "done"},
    {kUnexpected, "unexpected: please report it"},
    {kUsage, "wrong arguments or configuration; nothing was sent"},
    {kInvalid, "invalid message; nothing was sent"},
    {kBroker, "broker out of reach, login or access refused, connection lost"},
    {kRejected, "the robot refused or failed"},
    {kUnconfirmed, "the robot did not confirm in time"},
    {kPreflight, "refused by the check before sending"},
    {kLedger, "trouble with the ledger or a file"},
    {kInterrupted, "interrupted (Ctrl-C)"},
    {kTerminated, "terminated (SIGTERM)"},
});

}  // namespace

std::span<const ExitCodeMeaning> ExitCodeMeanings() { return kMeanings; }

ExitCode GetExitCode(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kUnexpected:
      return kUnexpected;
    case ErrorKind::kUsage:
      return kUsage;
    case ErrorKind::kInvalid:
      return kInvalid;
    case ErrorKind::kBroker:
      return kBroker;
    case ErrorKind::kRejected:
      return kRejected;
    case ErrorKind::kUnconfirmed:
      return kUnconfirmed;
    case ErrorKind::kPreflight:
      return kPreflight;
    case ErrorKind::kLedger:
      return kLedger;
  }
  return kUnexpected;
}

ExitCode GetExitCode(const message::Report& report) {
  return report.error ? GetExitCode(*report.error) : kDone;
}

ExitCode Worse(ExitCode a, ExitCode b) {
  return *std::find_if(kWorstFirst.begin(), kWorstFirst.end(),
                       [&](ExitCode code) { return code == a || code == b; });
}

}  // namespace fleetpub::cli
