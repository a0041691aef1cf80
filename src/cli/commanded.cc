#include "cli/commanded.h"

#include <set>

#include "base/text.h"

namespace fleetpub::cli {

std::vector<std::string> RecentTargets(const Context& context, std::string_view protocol) {
  const auto ledger = OpenLedger(context, ledger::OpenMode::kReadOnly);
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

}  // namespace fleetpub::cli
