#include "app/expected_robots.h"

#include <fmt/format.h>

#include <chrono>
#include <map>
#include <utility>

#include "app/targets.h"
#include "base/text.h"
#include "vda5050/reports/discovery.h"

namespace fleetpub::app {
namespace {

using vda5050::RobotAddress;

constexpr std::chrono::days kWeek{7};
constexpr int kNewestRows = 10'000;
constexpr std::size_t kFew = 5;

std::vector<RobotAddress> FindCommanded(const Environment& environment,
                                        const mqtt::ServerInfo& server) {
  std::vector<RobotAddress> robots;
  for (const ledger::Record& row : FindRecentRows(environment, server.ListSite())) {
    if (!base::EqualsIgnoringCase(row.protocol, "vda5050")) continue;
    if (auto robot = vda5050::ParseRobotAddress(row.target)) robots.push_back(*std::move(robot));
  }
  return robots;
}

}  // namespace

std::vector<ledger::Record> FindRecentRows(const Environment& environment,
                                           std::vector<std::string> brokers) {
  const auto ledger = environment.ledger(ledger::OpenMode::kReadOnly);
  if (!ledger) return {};
  auto rows = (*ledger)->History({.brokers = std::move(brokers),
                                  .since = std::chrono::system_clock::now() - kWeek,
                                  .limit = kNewestRows});
  if (!rows) return {};
  return *std::move(rows);
}

std::vector<ExpectedRobot> FindExpectedRobots(const Environment& environment,
                                              const mqtt::ServerInfo& server,
                                              const SchemeHook& scheme_of) {
  if (environment.recording) return {};
  std::map<RobotAddress, bool> known;  // whether it was commanded
  const config::Config& config = environment.config;
  for (const auto& [robot, table] : config.robots) known[robot];
  for (const auto& [group, robots] : config.group_robots) {
    for (const RobotAddress& robot : robots) known[robot];
  }
  for (const RobotAddress& robot : FindCommanded(environment, server)) known[robot] = true;
  std::vector<ExpectedRobot> expected;
  for (const auto& [robot, was_commanded] : known) {
    if (auto scheme = scheme_of(robot)) {
      expected.push_back({robot, *std::move(scheme), was_commanded});
    }
  }
  return expected;
}

std::vector<ExpectedRobot> FindUnheard(std::vector<ExpectedRobot> expected,
                                       const std::function<bool(const RobotAddress&)>& was_heard) {
  std::erase_if(expected, [&](const ExpectedRobot& one) { return was_heard(one.robot); });
  return expected;
}

bool AreAskedByName(const std::vector<ExpectedRobot>& unheard, bool is_partial) {
  return !unheard.empty() && (is_partial || unheard.size() <= kFew);
}

Result<std::vector<std::string>> TopicsByName(const std::vector<ExpectedRobot>& robots,
                                              std::string_view topic_name) {
  std::vector<std::string> filters;
  for (const ExpectedRobot& one : robots) {
    auto topics = vda5050::SpecifiedTopics(one.scheme, one.robot, {&topic_name, 1});
    if (!topics) return topics;
    filters.insert(filters.end(), topics->begin(), topics->end());
  }
  return filters;
}

void WarnOfUnheard(const std::vector<ExpectedRobot>& unheard, Log& log) {
  for (const bool was_commanded : {true, false}) {
    std::vector<RobotAddress> robots;
    for (const ExpectedRobot& one : unheard) {
      if (one.was_commanded == was_commanded) robots.push_back(one.robot);
    }
    if (robots.empty()) continue;
    const std::string text =
        fmt::format("{} {} did not answer: {}", base::Counted(robots.size(), "robot"),
                    was_commanded ? "commanded in the last 7 days" : "of the configuration",
                    FormatRobotList(robots));
    // A configuration may name robots of several sites.
    if (was_commanded) {
      log.Warn(text);
    } else {
      log.Info(text);
    }
  }
}

void WarnOfWildcards(const mqtt::BrokerUrl& broker, Log& log) {
  log.Warn(fmt::format(
      "{} hands out no retained messages for wildcards, as RabbitMQ: the only robots found are "
      "those that the "
      "configuration names, that were commanded in the last 7 days, or that send a state now",
      broker.ToString()));
}

}  // namespace fleetpub::app
