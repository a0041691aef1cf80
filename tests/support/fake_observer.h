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

/// Remembers what is told, and consents unless told otherwise.
class FakeObserver : public app::Observer {
 public:
  Status consent;

  std::vector<std::string> warnings;
  std::vector<vda5050::RobotAddress> asked_for;  ///< whom consent was asked for
  std::size_t offline = 0;
  std::vector<std::string> chosen;
  std::vector<message::Report> reports;
  std::vector<message::Report> nothing_sent;
  std::size_t total = 0;
  std::size_t sent = 0;

  void Warn(std::string_view text) override { warnings.emplace_back(text); }
  void Info(std::string_view /*text*/) override {}
  void Debug(std::string_view /*text*/) override {}
  Status Consent(const app::ConsentRequest& request) override {
    asked_for.assign(request.robots.begin(), request.robots.end());
    offline = request.offline;
    return consent;
  }
  void Chosen(std::span<const std::string> targets) override {
    chosen.assign(targets.begin(), targets.end());
  }
  void WillSend(std::size_t count) override { total = count; }
  void Sent() override { ++sent; }
  void Report(const message::Report& report) override { reports.push_back(report); }
  void NothingSent(const message::Report& report) override { nothing_sent.push_back(report); }
};

}  // namespace fleetpub::testing
