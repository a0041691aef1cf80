#include "app/validate_live.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "app/targets.h"
#include "delivery/subscription.h"

namespace fleetpub::app {
namespace {

using vda5050::RobotAddress;
using vda5050::ValidationResult;

class Inspector {
 public:
  Inspector(const vda5050::Conformance& conformance, Fleet& fleet, std::size_t count,
            const std::vector<std::string>& filters, LiveObserver& observer, Log& log)
      : conformance_(conformance),
        fleet_(fleet),
        count_(count),
        subscribed_(filters.begin(), filters.end()),
        observer_(observer),
        log_(log) {}

  void Take(const mqtt::Message& message) {
    const bool ask_all = fleet_.targets().AskAll();
    if (ask_all) fleet_.Take(message);
    const auto result =
        IsWanted(message) ? conformance_.Validate(message.topic, message.payload) : std::nullopt;
    if (!result || fleet_.targets().IsExcepted(result->robot)) return;
    if (ask_all && !fleet_.Shows(result->robot)) return;
    NoteConnection(message, *result);
    if (IsFull()) return;
    if (vda5050::IsWrittenOtherwise(result->robot) && escaped_.insert(result->robot).second) {
      WarnOfEscapedNames({&result->robot, 1}, log_);
    }
    for (LiveSummary::Tally* tally : {&summary_.all, &summary_.by_topic[result->topic_name]}) {
      ++tally->messages;
      if (!result->findings.errors.empty()) ++tally->invalid;
    }
    observer_.Checked(message, *result);
  }

  // Asks where no connection message came of robots that send states. Some brokers have nothing
  // retained for a filter with wildcards.
  void LookForConnections(mqtt::Transport* transport) {
    if (unknown_.empty() || transport == nullptr) return;
    if (transport->HasEnded()) return ReportUnknown();
    std::vector<std::string> topics;
    for (const auto& [topic, robot] : unknown_) topics.push_back(topic);
    const auto asked =
        delivery::ReadRetained(*transport, topics, {.keep = 0, .subscribed = &subscribed_},
                               [this](const mqtt::Message& message) {
                                 Take(message);
                                 return unknown_.empty();
                               });
    if (asked) return ReportUnknown();
    spoken_.clear();  // the next states ask again
    unknown_.clear();
  }

  [[nodiscard]] bool IsFull() const { return summary_.all.messages >= count_; }
  [[nodiscard]] LiveSummary summary() const { return summary_; }

 private:
  void ReportUnknown() {
    for (const auto& [topic, robot] : std::exchange(unknown_, {})) {
      ++summary_.without_connection;
      observer_.Checked({.topic = topic}, conformance_.MissingConnection(robot));
    }
  }

  // Retained messages come again with each new connection.
  bool IsWanted(const mqtt::Message& message) {
    if (!message.retained) return true;
    const std::size_t hash = std::hash<std::string>()(message.payload);
    const auto [known, added] = retained_.try_emplace(message.topic, hash);
    return added || std::exchange(known->second, hash) != hash;
  }

  void NoteConnection(const mqtt::Message& message, const ValidationResult& result) {
    if (result.topic_name == "connection") {
      connections_.insert(message.topic);
      unknown_.erase(message.topic);
    } else if (!message.retained && result.topic_name == "state" &&
               spoken_.insert(message.topic).second) {
      const auto topic = conformance_.ConnectionTopic(message.topic);
      if (topic && !connections_.contains(*topic)) unknown_.emplace(*topic, result.robot);
    }
  }

  const vda5050::Conformance& conformance_;
  Fleet& fleet_;
  std::size_t count_;
  delivery::Subscribed subscribed_;
  LiveObserver& observer_;
  Log& log_;
  LiveSummary summary_;
  std::set<RobotAddress> escaped_;                         // whose names were warned of
  std::unordered_map<std::string, std::size_t> retained_;  // by topic, the payload's hash
  std::unordered_set<std::string> spoken_;                 // topics of states
  std::unordered_set<std::string> connections_;            // topics of connection messages
  std::map<std::string, RobotAddress> unknown_;            // by topic: whose was not seen
};

}  // namespace

Result<LiveSummary> ValidateLive(LiveRequest request, const Environment& environment,
                                 LiveObserver& observer, Log& log) {
  auto fleet = Fleet::Make(std::move(request.robots), environment.config, log);
  if (!fleet) return Fail(std::move(fleet.error()));
  request.conformance.patterns = fleet->targets().include.patterns;
  for (const RobotAddress& robot : fleet->targets().include.robots) {
    request.conformance.patterns.push_back(vda5050::RobotPattern::Of(robot));
  }
  schema::Registry registry(environment.schema_directory);
  const vda5050::Conformance conformance(std::move(request.conformance), registry);
  auto found = conformance.Filters();
  if (!found) return Fail(std::move(found.error()));
  std::vector<std::string> filters = *std::move(found);
  if (fleet->targets().AskAll()) {
    const auto more = fleet->Filters();
    if (!more) return Fail(more.error());
    std::copy_if(more->begin(), more->end(), std::back_inserter(filters), [&](const auto& filter) {
      return std::find(filters.begin(), filters.end(), filter) == filters.end();
    });
  }
  auto link = Connect(environment, log);
  if (!link) return Fail(std::move(link.error()));
  auto subscription = delivery::Subscription::Open(
      std::move(link->transport), filters, MakeReconnectHooks(link->connection, log), request.end);
  if (!subscription) return Fail(std::move(subscription.error()));
  observer.Begin();
  Inspector inspector(conformance, *fleet, request.count, filters, observer, log);
  const auto read = subscription->Read(
      [&](const mqtt::Message& message) {
        inspector.Take(message);
        return inspector.IsFull();
      },
      [&]() -> Result<bool> {
        if (!environment.recording) inspector.LookForConnections(subscription->transport());
        return observer.GoesOn();
      });
  if (!read) return Fail(read.error());
  inspector.LookForConnections(subscription->transport());
  subscription->Disconnect();
  return inspector.summary();
}

}  // namespace fleetpub::app
