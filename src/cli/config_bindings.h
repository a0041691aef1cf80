// Which option stands for which setting of the configuration.
//
// The configuration is read when the arguments are parsed, since they say where it is. What neither
// flag nor environment gave is then taken from it.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cli/config.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace fleetpub::cli {

/// Whether the arguments have the option; not only the environment.
[[nodiscard]] bool IsByFlag(const CLI::App& app, const CLI::Option& option);

/// Who gave an option that is not empty: `flag --qos`, `environment variable FLEETPUB_QOS`.
[[nodiscard]] std::string OriginOf(const CLI::App& app, const CLI::Option& option);

class ConfigBindings {
 public:
  using Target = std::variant<std::string*, std::vector<std::string>*, bool*>;

  /// `option` and what the target points to must outlive the bindings; without an option there is
  /// none: only the configuration sets it.
  void Bind(std::string_view key, const CLI::Option* option, Target target);

  /// Sets what was not given, but for the keys of `except`: something else was given instead. The
  /// keys that were set.
  [[nodiscard]] std::vector<std::string_view> Apply(const Config& config,
                                                    std::vector<std::string_view> except);

  struct Effective {
    std::string_view key;
    std::vector<std::string> texts;  ///< empty: the default
    std::string origin;              ///< `flag --qos`, `profile north of FILE:3`, `default`
  };
  /// After Apply. What was replaced by something else is left out.
  [[nodiscard]] std::vector<Effective> All(const CLI::App& app, const Config& config) const;

 private:
  struct Binding {
    std::string_view key;
    const CLI::Option* option;
    Target target;
  };

  [[nodiscard]] bool IsExcepted(std::string_view key) const;

  std::vector<Binding> bindings_;
  std::vector<std::string_view> except_;
};

}  // namespace fleetpub::cli
