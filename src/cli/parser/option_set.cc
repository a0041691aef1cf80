#include "cli/parser/option_set.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <vector>

#include "base/decimal.h"
#include "base/text.h"
#include "cli/parser/try_command.h"

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

// What other programs call it; a password may follow, and is not repeated.
std::optional<std::string> AnswerOption(std::string_view name, const std::string& command,
                                        std::vector<std::string> arguments) {
  constexpr std::array<std::string_view, 5> kPasswords = {"password", "passwd", "pass", "pw",
                                                          "pwd"};
  if (std::find(kPasswords.begin(), kPasswords.end(), name) != kPasswords.end()) {
    return fmt::format(
        "{}: --{}: a password does not belong in the arguments, which every user of this machine "
        "can read: use --ask-password, --password-file FILE or FLEETPUB_PASSWORD",
        command, name);
  }
  if (name != "json") return std::nullopt;
  std::erase(arguments, "--json");
  arguments.insert(arguments.begin(), {"-o", "json"});
  return fmt::format("{}: there is no option --json; {}", command, TryCommand(command, arguments));
}

// `--tiemout` → the sentence with the nearest option.
Error UnknownArguments(const CLI::App& app, const std::string& command,
                       const std::vector<std::string>& arguments) {
  const std::string first = app.remaining(true).front();
  std::string hint = fmt::format("fleetpub {} --help lists its options", command);
  if (first.starts_with("--")) {
    const std::string name = first.substr(2, first.find('=') - 2);
    if (auto answer = AnswerOption(name, command, arguments)) {
      return {ErrorKind::kUsage, *std::move(answer)};
    }
    if (const auto nearest = base::Nearest(name, LongNames(app))) {
      hint = fmt::format("did you mean --{}?", *nearest);
    }
  }
  const std::string what =
      first.starts_with('-') ? "unknown option " + base::Printable(first.substr(0, first.find('=')))
                             : fmt::format("unexpected argument '{}'", base::Printable(first));
  return {ErrorKind::kUsage, fmt::format("{}: {}: {}", command, what, hint)};
}

Error Refusal(const ValueKind& kind, std::string_view name, const std::vector<std::string>& texts) {
  // The command ends here all the same: what is stored is used by nobody.
  const auto alone = std::find_if(texts.begin(), texts.end(), [&](const std::string& one) {
    return kind.is_list && !kind.store({one});
  });
  const std::string text = alone != texts.end() ? *alone : base::Join(texts, " ");
  const auto right = base::WithDecimalPoint(text);
  const bool may_be_right = right && kind.store({*right});
  return {ErrorKind::kUsage,
          fmt::format("{} takes {}, not '{}'{}", name, kind.Takes(), base::Printable(text),
                      may_be_right ? fmt::format("; write {}", *right) : "")};
}

}  // namespace

OptionSet::OptionSet(Extent extent, std::span<const std::string> arguments)
    : app_(std::make_unique<CLI::App>()), all_(extent == Extent::kAll) {
  app_->set_help_flag();
  if (all_) {
    Declare(app_->set_help_flag("-h", "Print what matters most"), {}).Group("Output");
    Declare(app_->set_help_all_flag("--help", "Print all there is; with -o json for programs"), {})
        .Group("Output");
    Declare(app_->set_version_flag("--version", std::string(), "Print the version"), {})
        .Group("Output");
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

Option OptionSet::Declare(CLI::Option* option, ValueKind kind) {
  return Option(&records_.emplace_back(Option::Record{std::move(kind), option}));
}

Option OptionSet::AddOption(const std::string& names, ValueKind kind, std::string help) {
  const Option option = Declare(nullptr, std::move(kind));
  if (!IsMentioned(names)) return option;
  Option::Record& record = *option.record_;
  if (const auto place = help.find("{}"); place != std::string::npos) {
    help.replace(place, 2, record.kind.Takes());
  }
  record.option = app_->add_option(
      names,
      [this, option](const std::vector<std::string>&) {
        const ValueKind& taker = option.record_->kind;
        // Whatever is refused, the others are stored: they say how errors are shown.
        if (!taker.store(option.texts()) && !refused_) {
          refused_ = Refusal(taker, FormatGiver(option), option.texts());
        }
        return true;
      },
      help);
  record.option->type_name(std::string(record.kind.type));
  if (record.kind.is_list) record.option->expected(CLI::detail::expected_max_vector_size);
  return option;
}

Option OptionSet::AddFlag(const std::string& names, bool& value, const std::string& help) {
  return Declare(IsMentioned(names) ? app_->add_flag(names, value, help) : nullptr, Flag(value));
}

Option OptionSet::AddFlag(const std::string& names, ValueKind kind, std::string implied,
                          std::string help) {
  kind.store = [store = std::move(kind.store),
                implied = std::move(implied)](const std::vector<std::string>& texts) {
    return store(texts.front() == "true" ? std::vector{implied} : texts);
  };
  const Option option = AddOption(names, std::move(kind), std::move(help));
  if (option.record_->option != nullptr) option.record_->option->expected(0);
  return option;
}

void OptionSet::AddSetting(std::string_view key, ValueKind kind) {
  Declare(nullptr, std::move(kind)).Key(key);
}

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
  } catch (const CLI::CallForAllHelp&) {
    return Asked::kHelp;
  } catch (const CLI::Success&) {
    return Asked::kBriefHelp;
  } catch (const CLI::ArgumentMismatch& error) {
    const std::string_view what = error.what();
    const std::string name(what.substr(0, what.find(':')));
    const bool too_many = what.find("At Most") != std::string_view::npos;
    if (too_many) {
      return Fail(ErrorKind::kUsage, fmt::format("{}: {} is given more than once", command, name));
    }
    const Option option = Find(name);
    const ValueKind& kind = option.record_->kind;
    const bool is_text = kind.type == "TEXT";  // its placeholder says what it is
    return Fail(ErrorKind::kUsage,
                fmt::format("{}: {} needs a value: {}", command, name,
                            is_text ? name + " " + option.type() : kind.Takes()));
  } catch (const CLI::ParseError& error) {  // `--quiet=maybe`
    return Fail(ErrorKind::kUsage, fmt::format("{}: a flag takes no value: {}", command,
                                               base::Printable(error.what())));
  }
  auto left = app_->remaining(true);
  std::erase(left, "--");  // behind it, words may begin with a dash
  if (!left.empty()) return Fail(UnknownArguments(*app_, command, arguments));
  if (refused_) return Fail(*refused_);
  return Asked::kRun;
}

std::vector<Option> OptionSet::options() const {
  std::vector<Option> options;
  for (Option::Record& record : records_) {
    if (record.option != nullptr) options.emplace_back(&record);
  }
  return options;
}

Option OptionSet::Find(const std::string& name) const {
  const CLI::Option* const wanted = app_->get_option_no_throw(name);
  for (const Option& option : options()) {
    if (option.record_->option == wanted) return option;
  }
  return {};
}

bool OptionSet::IsDeclared(const std::string& name) const {
  return app_->get_option_no_throw(name) != nullptr;
}

// What the environment sets, CLI11 does not count as parsed.
bool OptionSet::IsByFlag(const Option& option) const {
  const auto& parsed = app_->parse_order();
  return std::find(parsed.begin(), parsed.end(), option.record_->option) != parsed.end();
}

bool OptionSet::IsByFlag(const std::string& name) const {
  return IsDeclared(name) && IsByFlag(Find(name));
}

std::string OptionSet::Origin(const Option& option) const {
  if (!IsByFlag(option)) return fmt::format("environment variable {}", option.variable());
  return fmt::format("flag --{}", option.long_names().front());
}

std::string OptionSet::FormatGiver(const Option& option) const {
  if (option.IsPositional()) return option.type();
  return IsByFlag(option) ? "--" + option.long_names().front() : option.variable();
}

bool OptionSet::IsExcepted(std::string_view key) const {
  return std::find(except_.begin(), except_.end(), key) != except_.end();
}

Result<std::vector<std::string_view>> OptionSet::Configure(const config::Config& config,
                                                           std::vector<std::string_view> except) {
  except_ = std::move(except);
  std::vector<std::string_view> set;
  for (Option::Record& record : records_) {
    if (record.key.empty() || Option(&record).IsGiven() || IsExcepted(record.key)) continue;
    const config::ConfigValue* const value = config.Find(record.key);
    if (value == nullptr) continue;
    if (!record.kind.store(value->texts)) {
      return Fail(
          Refusal(record.kind, fmt::format("{}: {}", value->Origin(), record.key), value->texts));
    }
    set.push_back(record.key);
  }
  return set;
}

Status OptionSet::Check(std::string_view key, const std::vector<std::string>& texts) const {
  for (const Option::Record& record : records_) {
    if (record.key == key && !record.kind.store(texts)) {
      return Fail(Refusal(record.kind, key, texts));
    }
  }
  return {};
}

std::vector<OptionSet::Setting> OptionSet::Settings(const config::Config& config) const {
  std::vector<Setting> all;
  for (Option::Record& record : records_) {
    const Option option(&record);
    if (record.key.empty()) continue;
    if (option.IsGiven() && option.texts() != std::vector<std::string>{""}) {
      all.push_back({record.key, option.texts(), Origin(option)});
    } else if (IsExcepted(record.key)) {
      continue;
    } else if (const config::ConfigValue* value = config.Find(record.key)) {
      all.push_back({record.key, value->texts, value->Origin()});
    } else {
      all.push_back({record.key, {}, "default"});
    }
  }
  return all;
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
