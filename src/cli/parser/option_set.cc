#include "cli/parser/option_set.h"

#include <fmt/format.h>
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

std::vector<std::string_view> LongNames(const CLI::App& app) {
  std::vector<std::string_view> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back(name);
  }
  return names;
}

// `--tiemout` → the sentence with the nearest option.
Error UnknownArguments(const CLI::App& app, const std::string& command) {
  const std::string first = app.remaining(true).front();
  std::string hint = fmt::format("fleetpub {} --help lists its options", command);
  if (first.starts_with("--")) {
    const std::string name = first.substr(2, first.find('=') - 2);
    if (const auto nearest = base::Nearest(name, LongNames(app))) {
      hint = fmt::format("did you mean --{}?", *nearest);
    }
  }
  return {ErrorKind::kUsage,
          fmt::format("{}: '{}' is not understood: {}", command, base::Printable(first), hint)};
}

// CLI11's sentence names the option somewhere; ours says what it was given.
Error NotTaken(const CLI::App& app, const std::string& command, std::string_view what) {
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = option->get_name();
    if (name.empty() || what.find(name) == std::string_view::npos) continue;
    const std::string given = base::Printable(base::Join(option->results(), " "));
    const std::string why = option->get_expected_max() == 0
                                ? "takes no value"
                                : fmt::format("does not take '{}'", given);
    return {ErrorKind::kUsage,
            fmt::format("{0}: {1} {2}: fleetpub {0} --help says what it takes", command, name, why),
            std::string(what)};
  }
  return {ErrorKind::kUsage,
          fmt::format("{0}: the arguments are not understood: fleetpub {0} --help", command),
          std::string(what)};
}

}  // namespace

OptionSet::OptionSet(Extent extent, std::span<const std::string> arguments)
    : app_(std::make_unique<CLI::App>()),
      all_(extent == Extent::kAll),
      unmentioned_(std::make_unique<CLI::App>()),
      nobody_(unmentioned_->add_option("--unmentioned")) {
  app_->set_help_flag();
  if (all_) {
    app_->set_help_flag("-h,--help", "Print this help")->group("Output");
    app_->set_version_flag("--version", std::string(), "Print the version")->group("Output");
  }
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
Option OptionSet::AddOption(const std::string& names, T& value, const std::string& help) {
  return Option(IsMentioned(names) ? app_->add_option(names, value, help) : nobody_);
}

Option OptionSet::AddFlag(const std::string& names, bool& value, const std::string& help) {
  return Option(IsMentioned(names) ? app_->add_flag(names, value, help) : nobody_);
}

// What the subcommands' options are.
template Option OptionSet::AddOption(const std::string&, std::string&, const std::string&);
template Option OptionSet::AddOption(const std::string&, std::vector<std::string>&,
                                     const std::string&);
template Option OptionSet::AddOption(const std::string&, std::optional<std::string>&,
                                     const std::string&);
template Option OptionSet::AddOption(const std::string&, int&, const std::string&);
template Option OptionSet::AddOption(const std::string&, std::int64_t&, const std::string&);
template Option OptionSet::AddOption(const std::string&, std::uint64_t&, const std::string&);

void OptionSet::Mention(std::string_view argument) {
  if (argument.starts_with("--")) {
    long_names_.emplace(argument.substr(2, argument.find('=') - 2));
  } else if (argument.starts_with('-')) {
    for (const char letter : argument) letters_.set(static_cast<unsigned char>(letter));
  }
}

Result<OptionSet::Asked> OptionSet::Parse(const std::string& command,
                                          const std::vector<std::string>& arguments) {
  app_->allow_extras();
  try {
    app_->parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::CallForVersion&) {
    return Asked::kVersion;
  } catch (const CLI::Success&) {
    return Asked::kHelp;
  } catch (const CLI::ArgumentMismatch& error) {
    const std::string_view what = error.what();
    const bool too_many = what.find("At Most") != std::string_view::npos;
    return Fail(ErrorKind::kUsage,
                fmt::format("{}: {} {}", command, base::Printable(what.substr(0, what.find(':'))),
                            too_many ? "is given more than once" : "needs a value"));
  } catch (const CLI::ParseError& error) {
    return Fail(NotTaken(*app_, command, error.what()));
  }
  auto left = app_->remaining(true);
  std::erase(left, "--");  // behind it, words may begin with a dash
  if (!left.empty()) return Fail(UnknownArguments(*app_, command));
  return Asked::kRun;
}

std::vector<Option> OptionSet::options() const {
  std::vector<Option> options;
  for (CLI::Option* option : app_->get_options()) options.emplace_back(option);
  return options;
}

Option OptionSet::Find(const std::string& name) const {
  return Option(app_->get_option_no_throw(name));
}

bool OptionSet::IsDeclared(const std::string& name) const { return Find(name).option_ != nullptr; }

// What the environment sets, CLI11 does not count as parsed.
bool OptionSet::IsByFlag(const Option& option) const {
  const auto& parsed = app_->parse_order();
  return std::find(parsed.begin(), parsed.end(), option.option_) != parsed.end();
}

bool OptionSet::IsByFlag(const std::string& name) const {
  return IsDeclared(name) && IsByFlag(Find(name));
}

std::string OptionSet::Origin(const Option& option) const {
  if (!IsByFlag(option)) return fmt::format("environment variable {}", option.variable());
  return fmt::format("flag --{}", option.long_names().front());
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
