// Commands that begin before their broker does.
#include <gmock/gmock.h>

#include <chrono>

#include "mqtt/connecting.h"
#include "support/broken_broker.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;

class LateBroker : public EndToEnd {
 protected:
  LateBroker() { broker_.Kill(); }

  // Once it is known to wait, the broker comes.
  [[nodiscard]] std::unique_ptr<Process> StartBefore(const std::vector<std::string>& arguments,
                                                     const std::string& input = {}) {
    Command command = operator_.Prepare(arguments);
    command.input = input;
    auto process = std::make_unique<Process>(std::move(command));
    EXPECT_TRUE(process->AwaitErrors(arguments.front() == "simulate" ? "connecting again"
                                                                     : "trying again for"))
        << process->Errors();
    broker_.Restart();
    return process;
  }
};

TEST_F(LateBroker, IsWaitedForByAPing) {
  const auto ping = StartBefore({"ping", "--wait", "20s"});
  EXPECT_EQ(ping->Wait(), 0) << ping->Errors();
  EXPECT_THAT(ping->Output(), HasSubstr("reachable"));
}

TEST_F(LateBroker, IsWaitedForByRobotsAndByWhoAwaitsThem) {
  const auto await = StartBefore({"await", "KIT/0001", "operatingMode=AUTOMATIC", "-W", "60s"});
  broker_.Kill();
  const auto robot = StartBefore({"simulate", "KIT/0001", "--state-interval", "100ms"});
  EXPECT_TRUE(robot->AwaitErrors("1 robot online"));
  EXPECT_EQ(await->Wait(), 0) << await->Errors();
  EXPECT_THAT(await->Output(),
              ::testing::StartsWith("KIT/0001  state: operatingMode=AUTOMATIC  after "));
}

TEST_F(LateBroker, IsWaitedForByABatch) {
  const auto batch = StartBefore({"batch", "--vda", "3.0", "--no-check"},
                                 R"({"target":"KIT/0001","action":"startPause"})");
  EXPECT_EQ(batch->Wait(), 0) << batch->Errors();
  EXPECT_THAT(batch->Output(), HasSubstr(R"("status":"SENT")"));
}

TEST_F(LateBroker, IsWaitedForNoLongerThanAllowed) {
  const std::vector<std::vector<std::string>> commands = {
      {"ping", "--wait", "600ms"},
      {"await", "KIT/0001", "paused=true", "-W", "600ms"},
      {"batch", "--reconnect", "600ms"},
      {"simulate", "KIT/0001", "--connect-timeout", "600ms"}};
  for (const auto& command : commands) {
    const Finished run = Fleetpub(command);
    EXPECT_EQ(run.exit_code, 4) << command.front();
    EXPECT_THAT(run.errors, HasSubstr("connection refused")) << command.front();
  }
}

TEST(WhatDoesNotHeal, EndsAtOnce) {
  const Mosquitto broker({"allow_anonymous false", "password_file {}/users"},
                         {{"users", PasswordFile("ann", "right")}});
  Operator ann;
  ann.UseBroker(broker.Url());
  const std::vector<std::vector<std::string>> commands = {{"ping", "--wait", "60s"},
                                                          {"await", "KIT/0001", "paused=true"},
                                                          {"batch"},
                                                          {"simulate", "KIT/0001"}};
  for (const auto& command : commands) {
    const Finished run = ann.Fleetpub(command);
    EXPECT_EQ(run.exit_code, 4) << command.front() << run.errors;
    EXPECT_THAT(run.errors, ::testing::Not(HasSubstr("again")));
  }
}

TEST(WhatDoesNotHeal, IsAProxyThatRefuses) {
  using mqtt::PahoCall;
  FLEETPUB_NEEDS_FAST_CONNECT();
  for (const std::string status : {"407 Proxy Authentication Required", "403 Forbidden"}) {
    const BrokenBroker proxy(BrokenBroker::Answers({"HTTP/1.1 " + status + "\r\n\r\n"}));
    Operator ann;
    ann.UseBroker("mqtt://broker.invalid");
    const std::string url = "http://127.0.0.1:" + std::to_string(proxy.port());
    const Finished run = ann.Fleetpub({"ping", "--wait", "60s", "--proxy", url});
    EXPECT_EQ(run.exit_code, 4) << run.errors;
    EXPECT_THAT(run.errors, ::testing::Not(HasSubstr("again")));
  }
}

}  // namespace
}  // namespace fleetpub::testing
