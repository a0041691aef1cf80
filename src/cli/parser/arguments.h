// Finds the subcommand among the arguments.
//
// Each subcommand has an OptionSet of its own that holds the global options too, so that they may
// stand before or behind it, and so that a call declares the options of one subcommand only:
// declaring them all would cost a one-shot command a third of its time.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {

struct SubcommandMatch {
  std::string name;                        ///< `pause`, `schema show`; empty: none was named
  const Subcommand* subcommand = nullptr;  ///< null for a predefined action
  const CommandFamily* family = nullptr;   ///< `schema` alone; the name is empty then
  std::vector<std::string> arguments;      ///< everything else, in order
};

/// The positions of the arguments before `--` that are neither options nor their values.
[[nodiscard]] std::vector<std::size_t> WordPositions(const OptionSet& set,
                                                     const std::vector<std::string>& arguments);

/// Whether this argument is an option whose value is the next argument: `--broker`, `-b`, `-vb`,
/// but not `-bURL`.
[[nodiscard]] bool TakesNext(const OptionSet& set, const std::string& argument);

/// `set` has the global options declared, which tells which of them take a value. A word that is no
/// subcommand is refused with what it probably means: ErrorKind::kUsage.
[[nodiscard]] Result<SubcommandMatch> FindSubcommand(const OptionSet& set,
                                                     std::vector<std::string> arguments);

}  // namespace fleetpub::cli
