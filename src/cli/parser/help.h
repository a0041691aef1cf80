// The help texts, no wider than 80 columns. Option lines come from the declarations themselves.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/parser/arguments.h"

namespace fleetpub::cli {

/// The group of an action's own parameters among the options.
inline constexpr const char* kParameters = "Parameters";

/// `fleetpub`, alone, and `fleetpub -h`: the commands of every day.
[[nodiscard]] std::string EverydayHelp();

/// `fleetpub --help`: every command, and the global options.
[[nodiscard]] std::string GeneralHelp(const OptionSet& set);

/// `fleetpub soar`: the commands that begin with this word.
[[nodiscard]] std::string FamilyHelp(const CommandFamily& family);

/// `fleetpub pause -h`: usage, examples, parameters, the options that matter most.
[[nodiscard]] std::string BriefHelp(const OptionSet& set, const SubcommandMatch& match);

/// `fleetpub pause --help`: usage, own options by group, examples.
[[nodiscard]] std::string CommandHelp(const OptionSet& set, const SubcommandMatch& match);

/// What is said of a command.
struct Explained {
  std::string summary;
  std::string usage;
  std::vector<std::string> examples;  ///< without the program's name
};
[[nodiscard]] Explained Explain(const SubcommandMatch& match);

/// A line `  left    right`, the right side broken between words and kept in its column.
[[nodiscard]] std::string TwoColumns(std::string_view left, std::string_view right);

}  // namespace fleetpub::cli
