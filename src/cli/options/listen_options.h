// The options that say which messages are listened to.
#pragma once

#include <string>
#include <vector>

#include "app/listen.h"
#include "base/result.h"
#include "cli/options/target_options.h"

namespace fleetpub::cli {

class OptionSet;

struct ListenOptions {
  TargetOptions targets;  ///< none: all
  app::VdaOptions vda;
  std::vector<std::string> topics;
  std::vector<std::string> filters;
};

void DeclareListenOptions(OptionSet& set, ListenOptions& options);

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<app::ListenRequest> ParseListenOptions(const ListenOptions& options);

}  // namespace fleetpub::cli
