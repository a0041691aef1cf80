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

#include "cli/parser/option.h"
#include "config/config.h"

namespace fleetpub::cli {

class OptionSet;

class ConfigBindings {
 public:
  using Target = std::variant<std::string*, std::vector<std::string>*, bool*>;

  /// `option` and what the target points to must outlive the bindings. Option(): only the
  /// configuration sets it.
  void Bind(std::string_view key, const Option& option, Target target);

  /// Sets what was not given, but for the keys of `except`: something else was given instead. The
  /// keys that were set.
  [[nodiscard]] std::vector<std::string_view> Apply(const config::Config& config,
                                                    std::vector<std::string_view> except);

  struct Effective {
    std::string_view key;
    std::vector<std::string> texts;  ///< empty: the default
    std::string origin;              ///< `flag --qos`, `profile north of FILE:3`, `default`
  };
  /// After Apply. What was replaced by something else is left out.
  [[nodiscard]] std::vector<Effective> All(const OptionSet& set,
                                           const config::Config& config) const;

 private:
  struct Binding {
    std::string_view key;
    Option option;
    Target target;
  };

  [[nodiscard]] bool IsExcepted(std::string_view key) const;

  std::vector<Binding> bindings_;
  std::vector<std::string_view> except_;
};

}  // namespace fleetpub::cli
