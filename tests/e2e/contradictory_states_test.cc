// What a robot, or somebody in its place, says that confirms nothing: it is told, and is no
// success.
#include <gmock/gmock.h>

#include <fstream>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kStateTopic = "vda5050/v3/KIT/0001/state";

class ContradictoryStates : public EndToEnd {
 protected:
  void Say(const std::string& topic, const std::string& payload, bool retained = false) const {
    const std::string file = (operator_.home().path() / "payload.json").string();
    std::ofstream(file) << payload;
    Command command{{"mosquitto_pub", "-h", "127.0.0.1", "-p", std::to_string(broker_.port()), "-t",
                     topic, "-f", file}};
    if (retained) command.arguments.emplace_back("-r");
    ASSERT_EQ(testing::Run(command).exit_code, 0);
  }

  /// Pauses the robot, says this state once the command is out, and waits for the end.
  [[nodiscard]] Finished PauseAnd(const std::string& state, const char* timeout = "3s") const {
    const Subscriber subscriber(broker_, "+/+/KIT/0001/instantActions");
    Process run(operator_.Prepare({"pause", "KIT/0001", "--vda", "3.0.0", "--no-check", "--id",
                                   "a1", "--wait", "-W", timeout}));
    EXPECT_EQ(subscriber.Await(1).size(), 1U);
    Say(kStateTopic, state);
    const int exit_code = run.Wait().value_or(-1);
    return {exit_code, run.Output(), run.Errors()};
  }
};

TEST_F(ContradictoryStates, FinishedAndFailedAreAFailure) {
  const Finished run = PauseAnd(R"({"actionStates":[{"actionId":"a1","actionStatus":"FINISHED"}],
      "instantActionStates":[{"actionId":"a1","actionStatus":"FAILED"}]})");
  EXPECT_EQ(run.exit_code, 5) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("FAILED"), HasSubstr("FINISHED too")));
}

TEST_F(ContradictoryStates, AnotherRobotsHeaderConfirmsNothing) {
  const Finished run = PauseAnd(R"({"manufacturer":"KIT","serialNumber":"0002",
      "instantActionStates":[{"actionId":"a1","actionStatus":"FINISHED"}]})");
  EXPECT_EQ(run.exit_code, 6) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("TIMEOUT"), HasSubstr("KIT/0002")));
}

TEST_F(ContradictoryStates, AnotherActionsTypeConfirmsNothing) {
  const Finished run = PauseAnd(R"({"instantActionStates":[
      {"actionId":"a1","actionType":"stopPause","actionStatus":"FINISHED"}]})");
  EXPECT_EQ(run.exit_code, 6) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("TIMEOUT"), HasSubstr("stopPause")));
}

TEST_F(ContradictoryStates, AStateThatIsTooDeepOrTooLargeIsTold) {
  const std::string finished =
      R"({"instantActionStates":[{"actionId":"a1","actionStatus":"FINISHED"}],"x":)";
  const Finished deep = PauseAnd(finished + std::string(80, '[') + std::string(80, ']') + "}");
  EXPECT_EQ(deep.exit_code, 6) << deep.output;
  EXPECT_THAT(deep.output, AllOf(HasSubstr("TIMEOUT"), HasSubstr("64 levels")));
  const Finished large =
      PauseAnd(finished + '"' + std::string(std::size_t{33} << 19U, 'a') + "\"}", "10s");
  EXPECT_EQ(large.exit_code, 6) << large.output;
  EXPECT_THAT(large.output, AllOf(HasSubstr("TIMEOUT"), HasSubstr("too large")));
}

TEST_F(ContradictoryStates, AStateThatCannotBeReadIsSeenInTheFleetAndInConditions) {
  Say("vda5050/v3/KIT/0001/connection",
      R"({"version":"3.0.0","manufacturer":"KIT","serialNumber":"0001","connectionState":"ONLINE"})",
      true);
  const std::string state =
      R"({"paused":true,"x":)" + std::string(80, '[') + std::string(80, ']') + "}";
  Process fleet(operator_.Prepare({"fleet", "-o", "json", "--state-wait", "20s"}));
  ASSERT_TRUE(broker_.AwaitSubscription("+/+/+/+/state"));
  Say(kStateTopic, state);
  EXPECT_EQ(fleet.Wait(), 0) << fleet.Errors();
  EXPECT_THAT(Json(fleet.Output())["stateFault"].GetString(), HasSubstr("64 levels"));
  Process where(operator_.Prepare({"resume", "KIT/*", "--where", "paused=true", "--discover", "100",
                                   "--state-wait", "20s", "--yes"}));
  ASSERT_TRUE(broker_.AwaitSubscription("+/+/KIT/0001/state"));
  Say(kStateTopic, state);
  EXPECT_EQ(where.Wait(), 7) << where.Output() << where.Errors();
  EXPECT_THAT(where.Output(), AllOf(HasSubstr("REFUSED"), HasSubstr("64 levels")));
  Say(kStateTopic, state, true);
  const Finished await = Fleetpub({"await", "KIT/0001", "state", "paused=true", "-W", "500ms"});
  EXPECT_EQ(await.exit_code, 6);
  EXPECT_THAT(await.errors, HasSubstr("64 levels"));
}

}  // namespace
}  // namespace fleetpub::testing
