// A connection to a broker that is not there, through the production interface.
#pragma once

#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "delivery/topic_filter.h"
#include "mqtt/transport.h"
#include "support/journal.h"

namespace fleetpub::testing {

/// Notes `publish TOPIC` and `await` in the journal. Acknowledges everything unless told otherwise.
class FakeTransport : public mqtt::Transport {
 public:
  explicit FakeTransport(Journal& journal) : journal_(journal) { server_.broker.host = "broker"; }

  /// From this message on (counted from 0) publishing fails with `publish_error`.
  std::optional<std::size_t> publish_fails_at;
  Error publish_error{ErrorKind::kBroker, "broker: connection lost"};
  /// Decides on the acknowledgement of a token; nothing: the broker stays silent.
  std::function<std::optional<mqtt::Acknowledgement>(int token)> acknowledge = [](int token) {
    return mqtt::Acknowledgement{.token = token};
  };
  /// Acknowledgements come only when they are waited for, and no more than are waited for.
  bool is_distant = false;
  std::optional<Error> await_error;
  std::optional<Error> ready_error;
  std::size_t largest = 1'000'000;                    ///< payload that is admitted
  std::string forbidden;                              ///< the filter that may not be subscribed
  std::map<std::string, std::string> retained;        ///< payloads by topic, for whoever subscribes
  std::map<std::string, std::string> exact_retained;  ///< the same, but not for wildcards
  std::deque<mqtt::Message> arriving;  ///< what is published behind this subscription:
  int arrives_behind = 1;

  [[nodiscard]] const std::vector<mqtt::Message>& published() const { return published_; }
  [[nodiscard]] const std::set<std::string>& subscribed() const { return subscribed_; }

  /// What a published message brings forth, for whoever is subscribed. May be empty.
  std::function<std::vector<mqtt::Message>(const mqtt::Message&)> answers;

  bool keeps_nothing = false;  ///< and says so

  const mqtt::ServerInfo& server() const override {
    server_.retain_available = !keeps_nothing;
    return server_;
  }
  Status Subscribe(std::span<const std::string> filters, mqtt::Qos /*qos*/,
                   mqtt::Deadline /*deadline*/) override {
    for (const std::string& filter : filters) {
      if (filter == forbidden) return Fail(ErrorKind::kBroker, "broker refuses " + filter);
    }
    subscribed_.insert(filters.begin(), filters.end());
    for (const auto& [topic, payload] : retained) {
      if (std::any_of(filters.begin(), filters.end(), [&name = topic](const std::string& filter) {
            return delivery::Matches(filter, name);
          })) {
        incoming_.push_back({.topic = topic, .payload = payload, .retained = true});
      }
    }
    for (const std::string& filter : filters) {
      if (const auto exact = exact_retained.find(filter); exact != exact_retained.end()) {
        incoming_.push_back({.topic = filter, .payload = exact->second, .retained = true});
      }
    }
    if (--arrives_behind == 0) {
      std::move(arriving.begin(), arriving.end(), std::back_inserter(incoming_));
    }
    return {};
  }
  Status Unsubscribe(std::span<const std::string> filters, mqtt::Deadline /*deadline*/) override {
    for (const std::string& filter : filters) subscribed_.erase(filter);
    return {};
  }

  Status Admits(const std::string& /*topic*/, std::size_t payload_size,
                mqtt::Qos /*qos*/) const override {
    if (payload_size > largest) return Fail(ErrorKind::kBroker, "too large");
    return {};
  }
  Status AwaitReady(mqtt::Deadline /*deadline*/) override {
    if (ready_error) return Fail(*ready_error);
    return {};
  }

  Result<int> Publish(const mqtt::Message& message, mqtt::Deadline /*deadline*/) override {
    journal_.Record("publish " + message.topic);
    if (publish_fails_at && published_.size() >= *publish_fails_at) return Fail(publish_error);
    published_.push_back(message);
    if (answers) {
      for (mqtt::Message& answer : answers(message)) Hand(std::move(answer));
    }
    if (message.qos == mqtt::Qos::kAtMostOnce) return 0;
    in_flight_.push_back(static_cast<int>(published_.size()));
    return in_flight_.back();
  }

  Result<std::vector<mqtt::Acknowledgement>> AwaitAcknowledgements(mqtt::Deadline deadline,
                                                                   std::size_t left) override {
    if (is_distant && deadline <= std::chrono::steady_clock::now()) {
      return std::vector<mqtt::Acknowledgement>();
    }
    journal_.Record("await");
    if (await_error) return Fail(*await_error);
    std::vector<mqtt::Acknowledgement> acknowledgements;
    std::vector<int> silent;
    for (const int token : in_flight_) {
      const bool enough = is_distant && in_flight_.size() - acknowledgements.size() <= left;
      const auto acknowledgement = enough ? std::nullopt : acknowledge(token);
      if (acknowledgement) acknowledgements.push_back(*acknowledgement);
      if (!acknowledgement) silent.push_back(token);
    }
    in_flight_ = std::move(silent);
    return acknowledgements;
  }

  int in_flight() const override { return static_cast<int>(in_flight_.size()); }
  Result<std::optional<mqtt::Message>> Receive(mqtt::Deadline /*deadline*/) override {
    if (incoming_.empty()) return std::optional<mqtt::Message>();
    std::optional<mqtt::Message> next = std::move(incoming_.front());
    incoming_.pop_front();
    return next;
  }
  void Cork(bool /*on*/) override {}
  void WakeOn(std::span<const int> /*descriptors*/) override {}
  void Disconnect() override { journal_.Record("disconnect"); }

 protected:
  std::deque<mqtt::Message> incoming_;

 private:
  void Hand(mqtt::Message message) {
    const bool is_wanted = std::any_of(
        subscribed_.begin(), subscribed_.end(),
        [&](const std::string& filter) { return delivery::Matches(filter, message.topic); });
    if (is_wanted) incoming_.push_back(std::move(message));
  }

  Journal& journal_;
  mutable mqtt::ServerInfo server_;
  std::set<std::string> subscribed_;
  std::vector<mqtt::Message> published_;
  std::vector<int> in_flight_;
};

}  // namespace fleetpub::testing
