#include "app/robot_listener.h"

#include <fmt/format.h>

#include "app/ask_states.h"
#include "app/deliver.h"
#include "base/text.h"

namespace fleetpub::app {

Status RobotListener::Connect() {
  auto link = app::Connect(environment_, observer_);
  if (!link) return Fail(std::move(link.error()));
  connection_ = link->connection;
  server_ = link->transport->server();
  delivery::RetainedOptions discover = request_.discover;
  discover.subscribe = connection_.timeout;
  discover.keep = 0;  // a broker may send a copy for each subscription that matches (MQTT §3.3.5)
  auto ok = DiscoverRobots(*link->transport, request_.targets,
                           {.all = true, .factsheets = true, .discover = discover}, directory_,
                           observer_);
  if (!ok) return ok;
  robot_ = &*directory_.robots().begin();
  if (ok = CheckPresence(); !ok) return ok;
  for (const std::string_view name : topics_.names) {
    auto topic = vda5050::TopicFor(dialect().topics, dialect().version, address(), name);
    if (!topic) return Fail(std::move(topic.error()));
    filters_.push_back(*std::move(topic));
  }
  end_ = std::chrono::steady_clock::now() + request_.timeout;
  auto subscription =
      delivery::Subscription::Open(std::move(link->transport), filters_,
                                   MakeReconnectHooks(connection_, observer_), end_, topics_.qos);
  if (!subscription) return Fail(std::move(subscription.error()));
  subscription_ = *std::move(subscription);
  if (request_.ask) Ask();
  return {};
}

void RobotListener::Ask() {
  Lend([&](Link& link) {
    AskForStates({&robot_, 1}, request_.targets.state_wait, link, environment_, observer_);
  });
}

void RobotListener::Lend(const std::function<void(Link& link)>& use) {
  subscription_->Lend([&](std::unique_ptr<mqtt::Transport>& transport) {
    Link lent{connection_, std::move(transport)};
    use(lent);
    transport = std::move(lent.transport);
  });
}

std::string RobotListener::name() const { return base::Printable(address().ToString()); }

Status RobotListener::CheckPresence() const {
  const vda5050::RobotEntry& entry = robot_->second;
  if (!entry.WasHeard()) {
    return Fail(ErrorKind::kPreflight,
                fmt::format("{} is unknown to {}. try: fleetpub fleet", name(),
                            FormatSite(server_.broker, environment_.config.profile)));
  }
  if (entry.IsAlive() || !entry.connection) return {};
  return Fail(ErrorKind::kPreflight,
              fmt::format("{} is {}", name(), vda5050::ConnectionText(*entry.connection)));
}

Status RobotListener::Send(const message::Command& command, mqtt::Qos qos) {
  auto ledger = environment_.ledger(ledger::OpenMode::kCreate);
  if (!ledger) return Fail(std::move(ledger.error()));
  Status outcome;
  const auto report = [&](const message::Report& done) {
    if (done.error) outcome = Fail(*done.error, done.message);
  };
  Status sent = Fail(ErrorKind::kBroker, "not sent: there is no connection");
  Lend([&](Link& link) {
    sent = SendBeside({&command, 1}, link, **ledger,
                      {.qos = qos, .acknowledge_timeout = link.connection.timeout}, {}, report,
                      observer_);
  });
  return sent ? outcome : sent;
}

}  // namespace fleetpub::app
