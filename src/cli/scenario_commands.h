// The commands of scenarios: which may stand there, and fleetpub itself as a child that runs them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "app/scenario/player.h"
#include "base/result.h"
#include "cli/options/global_options.h"

namespace fleetpub::cli {

class OptionSet;

class ScenarioCommands {
 public:
  /// Before anybody connects. Both outlive it.
  ScenarioCommands(const OptionSet& set, const Context& context);

  /// As app::scenario::CommandCheck.
  [[nodiscard]] Status Check(app::scenario::Step& step) const;

  /// With the broker, ledger and configuration of this process. Errors: ErrorKind::kUnexpected.
  [[nodiscard]] Result<std::unique_ptr<app::scenario::RunningCommand>> Start(
      const std::vector<std::string>& words, const std::string& input) const;

 private:
  const Context& context_;
  std::vector<std::string> handed_on_;  // options
  std::string password_;                // of the environment, which forgets it
  mutable int started_ = 0;
};

}  // namespace fleetpub::cli
