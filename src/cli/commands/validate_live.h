// `fleetpub validate --live`: listens, and holds whatever is published against the schemas.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/options/target_options.h"
#include "cli/options/vda_options.h"
#include "cli/output/exit_code.h"

namespace fleetpub::cli {

class OptionSet;

struct LiveOptions {
  bool live = false;
  std::optional<std::chrono::milliseconds> duration;
  std::optional<std::size_t> count;
  TargetOptions targets;
  app::VdaOptions vda;  ///< interface and topic template
  std::string from;     ///< a recording; empty: the broker

  /// What belongs to `--live` alone was given.
  [[nodiscard]] bool AreGiven() const {
    return duration || count || targets.all || targets.patterns || targets.online ||
           !targets.except.empty() || !targets.where.empty();
  }
  // What `validate` is told besides.
  std::string version;  ///< empty: as each header says
  std::string topic;    ///< empty: all
  bool strict = false;
  std::vector<std::string> reports;
};

void DeclareLive(OptionSet& set, LiveOptions& options);

/// kInvalid when any message was, kUnconfirmed when there was none.
[[nodiscard]] Result<ExitCode> ValidateLive(const LiveOptions& options, const Context& context);

}  // namespace fleetpub::cli
