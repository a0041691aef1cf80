// The options that say which robots a command is for.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/targets.h"
#include "base/result.h"

namespace fleetpub::cli {

class OptionSet;

struct TargetOptions {
  std::vector<std::string> words;
  bool patterns = false;  ///< also in lines of standard input
  bool all = false;
  std::vector<std::string> except;
  std::vector<std::string> where;
  bool online = false;
  std::optional<std::chrono::milliseconds> state_wait;
  std::optional<std::size_t> expect;
};

/// For those who command.
void DeclareTargetOptions(OptionSet& set, TargetOptions& options);
/// For those who look on, and mean all robots when no word says otherwise.
void DeclareSelectionOptions(OptionSet& set, TargetOptions& options);
/// Only the words; `otherwise` is what they are when nobody gives any.
void DeclareTargetWords(OptionSet& set, TargetOptions& options, std::string_view otherwise = "");
/// The same without the words.
void DeclareSelectionFlags(OptionSet& set, TargetOptions& options);
/// `--online` alone.
void DeclareOnline(OptionSet& set, bool& online);

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<app::TargetRequest> ParseTargetOptions(const TargetOptions& options);

}  // namespace fleetpub::cli
