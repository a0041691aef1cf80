#include "cli/output/exit_code.h"

#include <algorithm>
#include <array>

namespace fleetpub::cli {
namespace {

using enum ExitCode;

constexpr std::array kWorstFirst = {kInterrupted, kTerminated, kUnexpected,  kLedger,
                                    kBroker,      kRejected,   kUnconfirmed, kPreflight,
                                    kInvalid,     kUsage,      kDone};

}  // namespace

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
