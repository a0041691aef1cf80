// Whoever called a use case, through the production interface.
#pragma once

#include <string>
#include <vector>

#include "app/observer.h"

namespace fleetpub::testing {

/// Remembers what is said.
class FakeLog : public app::Log {
 public:
  std::vector<std::string> warnings;

  void Warn(std::string_view text) override { warnings.emplace_back(text); }
  void Info(std::string_view /*text*/) override {}
  void Debug(std::string_view /*text*/) override {}
};

}  // namespace fleetpub::testing
