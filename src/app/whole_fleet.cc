#include "app/whole_fleet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "vda5050/reports/discovery.h"

namespace fleetpub::app {
namespace {

constexpr std::array<std::string_view, 1> kConnection = {"connection"};

// Brokers' limits are round numbers; of mosquitto's queue one place is taken.
bool LooksLikeALimit(std::size_t robots) { return robots > 0 && (robots + 1) % 1'000 <= 1; }

// Who has left a connection message, by the parts of the fleet for which a broker can be asked.
class Census {
 public:
  explicit Census(const FleetQuery& query) : query_(query) {
    for (const ExpectedRobot& one : query.expected) manufacturers_.insert(one.robot.manufacturer);
  }

  void Take(const mqtt::Message& message) {
    any_ = any_ || message.retained;
    if (!message.retained) return;
    for (const vda5050::TopicScheme& scheme : query_.schemes) {
      const auto levels = vda5050::ReadTopic(scheme, message.topic);
      if (!levels || levels->topic_name != kConnection[0]) continue;
      if (!topics_.insert(message.topic).second) return;
      manufacturers_.insert(levels->robot.manufacturer);
      places_.insert(levels->Place());
      largest_ = std::max(largest_, ++parts_[{levels->Place(), levels->robot.manufacturer}]);
      return;
    }
  }

  [[nodiscard]] bool any() const { return any_; }
  [[nodiscard]] std::size_t size() const { return topics_.size(); }
  /// Robots of the largest part.
  [[nodiscard]] std::size_t largest() const { return largest_; }

  /// Filters for each part.
  [[nodiscard]] Result<std::vector<std::string>> Parts() const {
    std::vector<std::string> filters;
    for (const vda5050::TopicScheme& scheme : query_.schemes) {
      for (const std::string& manufacturer : manufacturers_) {
        auto some =
            vda5050::FiltersByPlace(scheme, places_, {.manufacturer = manufacturer}, kConnection);
        if (!some) return some;
        filters.insert(filters.end(), some->begin(), some->end());
      }
    }
    return filters;
  }

 private:
  const FleetQuery& query_;
  bool any_ = false;
  std::size_t largest_ = 0;
  std::set<std::string> topics_;
  std::set<std::string> manufacturers_;
  std::set<std::string> places_;
  std::map<std::pair<std::string, std::string>, std::size_t> parts_;
};

}  // namespace

Result<HandedOut> ReadWholeFleet(mqtt::Transport& transport, const FleetQuery& query,
                                 delivery::RetainedOptions options,
                                 const std::function<void(const mqtt::Message&)>& take,
                                 const std::function<std::size_t()>& known) {
  Census census(query);
  const auto read = [&](const std::vector<std::string>& filters) {
    return delivery::ReadAllRetained(
        transport, filters, options,
        [&](const mqtt::Message& message) {
          census.Take(message);
          take(message);
        },
        known);
  };
  if (auto ok = read(query.filters); !ok) return Fail(std::move(ok.error()));
  options.behind.clear();
  HandedOut handed_out{.any = census.any()};
  const std::size_t limit = census.size();
  if (!LooksLikeALimit(limit)) return handed_out;
  std::set<std::string> asked(query.filters.begin(), query.filters.end());
  for (;;) {
    auto parts = census.Parts();
    if (!parts) return Fail(std::move(parts.error()));
    std::erase_if(*parts, [&](const std::string& filter) { return !asked.insert(filter).second; });
    if (parts->empty()) break;
    if (auto ok = read(*parts); !ok) return Fail(std::move(ok.error()));
  }
  if (census.largest() >= limit) handed_out.limit = limit;
  return handed_out;
}

void WarnOfLimit(const HandedOut& handed_out, Log& log) {
  if (handed_out.limit == 0) return;
  log.Warn(
      fmt::format("the broker has handed out exactly {} robots, which looks like a limit of its "
                  "own: there may be more. Raise it (ejabberd hands out 1,000 for a subscription, "
                  "mosquitto queues as many over WebSockets), or add --expect N",
                  handed_out.limit));
}

}  // namespace fleetpub::app
