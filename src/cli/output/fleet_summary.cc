#include "cli/output/fleet_summary.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/json.h"
#include "base/text.h"
#include "base/time.h"

namespace fleetpub::cli {
namespace {

using message::StatusGroup;
using std::chrono::nanoseconds;

constexpr std::size_t kNamed = 50;
constexpr std::size_t kSlowNamed = 5;
constexpr std::size_t kReasons = 100;

// In the order of StatusGroup; as people read them, and in JSON.
constexpr std::array<std::string_view, 8> kGroupNames = {
    "finished", "sent", "no order", "failed", "unconfirmed", "offline", "refused", "errors"};
constexpr std::array<std::string_view, 8> kGroupKeys = {
    "finished", "sent", "noOrder", "failed", "unconfirmed", "offline", "refused", "errors"};
static_assert(kGroupNames.size() == static_cast<std::size_t>(StatusGroup::kErrors) + 1);

std::string SecondsJson(nanoseconds elapsed) {
  return fmt::format("{:.3f}", static_cast<double>(elapsed.count()) / 1e6);
}

}  // namespace

void FleetSummary::Add(const message::Report& report) {
  const StatusGroup group = message::GetFacts(report.status).group;
  const auto index = static_cast<std::size_t>(group);
  ++counts_[index];
  elapsed_.push_back(std::chrono::duration<float>(report.elapsed).count());
  if (group == StatusGroup::kFinished) {
    const auto place = std::find_if(slowest_.begin(), slowest_.end(),
                                    [&](const Slow& slow) { return slow.first < report.elapsed; });
    slowest_.insert(place, {report.elapsed, report.target});
    if (slowest_.size() > kSlowNamed) slowest_.pop_back();
  } else if (group != StatusGroup::kSent) {
    names_[index].Add(report.target);
    const std::pair reason(report.status, report.message);
    const bool has_room = reasons_.size() < kReasons || reasons_.contains(reason);
    reasons_[has_room ? reason : std::pair(report.status, std::string())].Add(report.target);
  }
}

void FleetSummary::Named::Add(const std::string& name) {
  ++count;
  if (names.size() < kNamed) names.push_back(name);
}

std::string FleetSummary::Format(std::string_view title, const Named& named) {
  std::vector<std::string> names;
  for (const std::string& name : named.names) names.push_back(base::Printable(name));
  std::sort(names.begin(), names.end());
  const std::size_t more = named.count - names.size();
  return fmt::format("  {:<11} {}{}", title, base::Join(names, ", "),
                     more > 0 ? fmt::format(" and {} more", more) : "");
}

std::string FleetSummary::Counts() const {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < kGroups; ++i) {
    if (counts_[i] > 0) parts.push_back(fmt::format("{} {}", counts_[i], kGroupNames[i]));
  }
  return base::Join(parts, ", ");
}

std::vector<FleetSummary::Slow> FleetSummary::TheSlow() const {
  std::vector<float> sorted = elapsed_;
  if (sorted.empty()) return {};
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const float limit = std::max(1.0F, 3 * *middle);
  std::vector<Slow> slow = slowest_;
  std::erase_if(slow, [&](const Slow& one) {
    return std::chrono::duration<float>(one.first).count() < limit;
  });
  return slow;
}

std::vector<std::string> FleetSummary::Lines(nanoseconds elapsed, std::string_view site,
                                             Names names) const {
  std::vector<std::string> lines = {fmt::format("{} at {}: {}  {}",
                                                base::Counted(robots(), "robot"), site, Counts(),
                                                base::FormatElapsed(elapsed))};
  if (names == Names::kByReason) {
    for (const auto& [what, named] : reasons_) {
      const auto& [status, reason] = what;
      lines.push_back(Format(GetName(status), named) + (reason.empty() ? "" : "  " + reason));
    }
  } else {
    for (std::size_t i = 0; i < kGroups; ++i) {
      if (names_[i].count > 0) lines.push_back(Format(kGroupNames[i], names_[i]));
    }
  }
  std::vector<std::string> slow;
  for (const auto& [took, name] : TheSlow()) {
    slow.push_back(fmt::format("{} {}", base::Printable(name), base::FormatElapsed(took)));
  }
  if (!slow.empty()) lines.push_back(fmt::format("  {:<11} {}", "slow", base::Join(slow, ", ")));
  return lines;
}

std::string FleetSummary::Json(nanoseconds elapsed, ExitCode code, std::string_view site) const {
  std::string json =
      fmt::format(R"({{"summary":{{"site":{},"robots":{})", base::JsonString(site), robots());
  for (std::size_t i = 0; i < kGroups; ++i) {
    json += fmt::format(R"(,"{}":{})", kGroupKeys[i], counts_[i]);
  }
  std::vector<std::string> slow;
  for (const auto& [took, name] : TheSlow()) {
    slow.push_back(fmt::format(R"({{"target":{},"elapsedMs":{}}})", base::JsonString(name),
                               SecondsJson(took)));
  }
  return json + fmt::format(R"(,"slow":[{}],"elapsedMs":{},"exitCode":{}}}}})",
                            base::Join(slow, ","), SecondsJson(elapsed), static_cast<int>(code));
}

std::string FormatProgress(const FleetSummary& summary, std::size_t total) {
  constexpr std::size_t kWidth = 24;
  const std::size_t done = total == 0 ? kWidth : summary.robots() * kWidth / total;
  return fmt::format("[{:<{}}] {} of {}  {}", std::string(std::min(done, kWidth), '='), kWidth,
                     summary.robots(), total, summary.Counts());
}

}  // namespace fleetpub::cli
