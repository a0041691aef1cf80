#include "app/confirm_times.h"

#include <algorithm>
#include <chrono>

#include "base/text.h"
#include "message/command_status.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::app {
namespace {

constexpr std::chrono::hours kWindow{1};
constexpr int kPage = 1'000;
constexpr int kPages = 10;

// Where it stands in the topic is a matter of the template; empty: it is none of VDA 5050's.
std::string FindTopicName(const std::string& topic) {
  for (const std::string& level : base::Split(topic, '/')) {
    const auto& known = vda5050::kCommandTopics;
    if (std::find(known.begin(), known.end(), level) != known.end()) return level;
  }
  return {};
}

void Add(const ledger::Record& row, ConfirmTimes& times) {
  if (!row.outcome_at || row.status != GetName(message::CommandStatus::kFinished)) return;
  const std::string name = FindTopicName(row.topic);
  if (name.empty()) return;
  const std::chrono::duration<double> took = *row.outcome_at - row.recorded_at;
  times[name].push_back(std::max(took.count(), 0.0));
}

}  // namespace

// The newest page by page: the ledger finds rows by their number quickly, by their time it does not.
Result<ConfirmTimes> ReadConfirmTimes(
    ledger::Ledger& ledger, ledger::WallTime now,
    const std::function<bool(const ledger::Record& row)>& wanted) {
  ConfirmTimes times;
  ledger::HistoryFilter filter{.limit = kPage};
  for (int page = 0; page < kPages; ++page) {
    const auto rows = ledger.History(filter);
    if (!rows) return Fail(rows.error());
    for (const ledger::Record& row : *rows) {
      if (row.recorded_at >= now - kWindow && wanted(row)) Add(row, times);
    }
    if (rows->size() < kPage || rows->front().recorded_at < now - kWindow) break;
    filter.below = rows->front().id;
  }
  return times;
}

}  // namespace fleetpub::app
