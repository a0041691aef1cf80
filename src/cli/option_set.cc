#include "cli/option_set.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/text.h"

namespace fleetpub::cli {
namespace {

constexpr std::string_view kVariablePrefix = "FLEETPUB_";

// FLEETPUB_PASSWORD_FILE=… → password-file
std::string OptionFor(std::string_view variable) {
  const std::string_view name = variable.substr(0, variable.find('='));
  std::string option = base::ToLower(name.substr(kVariablePrefix.size()));
  std::replace(option.begin(), option.end(), '_', '-');
  return option;
}

}  // namespace

OptionSet::OptionSet(CLI::App& app, Extent extent, std::span<const std::string> arguments)
    : app_(app),
      all_(extent == Extent::kAll),
      unmentioned_(std::make_unique<CLI::App>()),
      nobody_(unmentioned_->add_option("--unmentioned")) {
  for (const std::string& argument : arguments) Mention(argument);
  for (char** variable = environ; variable != nullptr && *variable != nullptr; ++variable) {
    if (std::string_view(*variable).starts_with(kVariablePrefix)) {
      const std::string name = OptionFor(*variable);
      long_names_.insert(name);
      if (const auto hyphen = name.find('-'); hyphen != std::string::npos) {
        long_names_.insert(name.substr(hyphen + 1));  // FLEETPUB_SOAR_SOURCE: --source
      }
    }
  }
}

OptionSet::~OptionSet() = default;

template <class T>
CLI::Option* OptionSet::AddOption(const std::string& names, T& value, const std::string& help) {
  return IsMentioned(names) ? app_.add_option(names, value, help) : nobody_;
}

CLI::Option* OptionSet::AddFlag(const std::string& names, bool& value, const std::string& help) {
  return IsMentioned(names) ? app_.add_flag(names, value, help) : nobody_;
}

// What the subcommands' options are.
template CLI::Option* OptionSet::AddOption(const std::string&, std::string&, const std::string&);
template CLI::Option* OptionSet::AddOption(const std::string&, std::vector<std::string>&,
                                           const std::string&);
template CLI::Option* OptionSet::AddOption(const std::string&, std::optional<std::string>&,
                                           const std::string&);
template CLI::Option* OptionSet::AddOption(const std::string&, int&, const std::string&);
template CLI::Option* OptionSet::AddOption(const std::string&, std::int64_t&, const std::string&);
template CLI::Option* OptionSet::AddOption(const std::string&, std::uint64_t&, const std::string&);

void OptionSet::Mention(std::string_view argument) {
  if (argument.starts_with("--")) {
    long_names_.emplace(argument.substr(2, argument.find('=') - 2));
  } else if (argument.starts_with('-')) {
    for (const char letter : argument) letters_.set(static_cast<unsigned char>(letter));
  }
}

bool OptionSet::IsByFlag(const std::string& name) const {
  const CLI::Option* option = app_.get_option_no_throw(name);
  return option != nullptr && cli::IsByFlag(app_, *option);
}

bool OptionSet::IsMentioned(std::string_view names) const {
  if (all_ || !names.starts_with('-')) return true;
  while (!names.empty()) {
    const std::string_view name = names.substr(0, names.find(','));
    names.remove_prefix(std::min(names.size(), name.size() + 1));
    const bool mentioned = name.starts_with("--")
                               ? long_names_.contains(name.substr(2))
                               : letters_.test(static_cast<unsigned char>(name[1]));
    if (mentioned) return true;
  }
  return false;
}

}  // namespace fleetpub::cli
