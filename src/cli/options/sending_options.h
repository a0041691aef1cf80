// The options of everything that sends: dry run, quality of service, consent and rate.
#pragma once

#include <optional>

#include "app/deliver.h"
#include "base/result.h"

namespace fleetpub::cli {

class OptionSet;

struct SendingOptions {
  bool dry_run = false;
  bool offline = false;
  mqtt::Qos qos = mqtt::Qos::kAtMostOnce;
  bool yes = false;            ///< many robots may be commanded unasked
  std::optional<double> rate;  ///< messages per second; nothing: no limit
};

void DeclareSendingOptions(OptionSet& set, SendingOptions& options);
/// `--yes` and `--rate`, where there may be many targets.
void DeclareOffline(OptionSet& set, SendingOptions& options);
void DeclareManyOptions(OptionSet& set, SendingOptions& options);
void DeclareRate(OptionSet& set, SendingOptions& options);
/// `--qos` alone.
void DeclareQos(OptionSet& set, mqtt::Qos& qos);

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<app::SendSettings> ParseSendingOptions(const SendingOptions& options);

}  // namespace fleetpub::cli
