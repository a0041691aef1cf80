#include "app/recent_targets.h"

#include <set>

#include "base/text.h"

namespace fleetpub::app {

std::vector<std::string> FindRecentTargets(const LedgerHook& open, std::string_view protocol) {
  const auto ledger = open(ledger::OpenMode::kReadOnly);
  if (!ledger) return {};
  constexpr int kNewestRows = 1'000;
  const auto rows = (*ledger)->History({.limit = kNewestRows});
  if (!rows) return {};
  std::vector<std::string> targets;
  std::set<std::string> seen;
  for (const ledger::Record& row : *rows) {
    const bool asked = base::EqualsIgnoringCase(row.protocol, protocol);
    if (asked && seen.insert(row.target).second) targets.push_back(row.target);
  }
  return targets;
}

}  // namespace fleetpub::app
