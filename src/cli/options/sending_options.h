// The options of everything that sends: dry run, quality of service, consent and rate.
#pragma once

#include <string>

#include "app/deliver.h"
#include "base/result.h"

namespace fleetpub::cli {

class OptionSet;

struct SendingOptions {
  bool dry_run = false;
  bool offline = false;
  std::string qos = "0";
  bool yes = false;  ///< many robots may be commanded unasked
  std::string rate;  ///< messages per second; empty: no limit
};

void DeclareSendingOptions(OptionSet& set, SendingOptions& options);
/// `--yes` and `--rate`, where there may be many targets.
void DeclareOffline(OptionSet& set, SendingOptions& options);
void DeclareManyOptions(OptionSet& set, SendingOptions& options);
void DeclareRate(OptionSet& set, SendingOptions& options);
/// `--qos` alone.
void DeclareQos(OptionSet& set, std::string& qos);

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<app::SendSettings> ParseSendingOptions(const SendingOptions& options);

}  // namespace fleetpub::cli
