// `fleetpub test`: plays scenarios at a broker.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "app/scenario/player.h"
#include "base/result.h"

namespace fleetpub::app {

/// Starts fleetpub with these words. Errors: it cannot be started.
using StartCommand = std::function<Result<std::unique_ptr<scenario::RunningCommand>>(
    const std::vector<std::string>& words, const std::string& input)>;

struct ScenarioRequest {
  std::vector<scenario::Suite> suites;
  VdaOptions vda;                        ///< whose topics are listened to
  std::filesystem::path recording = {};  ///< takes all that is heard; empty: none
  std::string tool;                      ///< `fleetpub 1.0.0`, for the recording
  StartCommand start;
};

/// As each test has ended.
using ScenarioProgress = std::function<void(
    const scenario::Suite& suite, const scenario::Test& test, const scenario::TestEnd& end)>;

/// Tests that are skipped, and those behind an interruption, are told of, too. Errors:
/// ErrorKind::kUsage, kBroker; kLedger: the recording.
[[nodiscard]] Status TestScenarios(const ScenarioRequest& request, const Environment& environment,
                                   const ScenarioProgress& progress, Observer& observer);

}  // namespace fleetpub::app
