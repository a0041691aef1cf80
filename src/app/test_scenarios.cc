#include "app/test_scenarios.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <thread>

#include "app/listen.h"
#include "base/text.h"
#include "delivery/recorded.h"

namespace fleetpub::app {
namespace {

using scenario::Step;
using scenario::StepKind;
using std::chrono::steady_clock;

constexpr mqtt::Qos kQos = mqtt::Qos::kAtLeastOnce;

// Whose messages the steps look at, and which; of a recording all of everybody's.
ListenRequest MakeListenRequest(const ScenarioRequest& request) {
  std::set<std::string> robots;
  std::set<std::string> topic_names;
  for (const auto& suite : request.suites) {
    for (const auto& test : suite.tests) {
      for (const Step& step : test.steps) {
        robots.insert(step.targets.begin(), step.targets.end());
        if (step.kind == StepKind::kSend || step.kind == StepKind::kSimulate) continue;
        robots.insert(step.robot.ToString());
        topic_names.insert(step.topic);
      }
    }
  }
  std::erase_if(robots,
                [](const std::string& robot) { return !vda5050::ParseRobotAddress(robot); });
  if (!request.recording.empty()) topic_names.clear();
  return {.targets = {.words = {robots.begin(), robots.end()}},
          .vda = request.vda,
          .topics = {topic_names.begin(), topic_names.end()},
          .filters = {},
          .qos = kQos};
}

class BrokerStage final : public scenario::Stage {
 public:
  BrokerStage(const ScenarioRequest& request, Observer& observer)
      : request_(request), observer_(observer) {}

  Status Open(const Environment& environment) {
    auto listening = Listening::Open(MakeListenRequest(request_), environment,
                                     {.open = {},
                                      .lost =
                                          [this](const Error& error) {
                                            ++losses_;
                                            observer_.Lost(error);
                                          },
                                      .again = [this] { observer_.ConnectedAgain(); }},
                                     observer_);
    if (!listening) return Fail(std::move(listening.error()));
    listening_.emplace(*std::move(listening));
    return recorder_.Begin(request_.recording, request_.tool, listening_->server(),
                           listening_->filters(), kQos);
  }

  Status Close() {
    listening_->subscription().Disconnect();
    return recorder_.End();
  }

  Result<std::unique_ptr<scenario::RunningCommand>> Start(const std::vector<std::string>& words,
                                                          const std::string& input) override {
    observer_.Debug("fleetpub " + base::Printable(base::Join(words, " ")));
    return request_.start(words, input);
  }

  std::optional<scenario::Said> Next(scenario::TimePoint until) override {
    while (auto message = listening_->subscription().Next(until)) {
      recorder_.Add(*message);
      std::optional<vda5050::TopicLevels> levels;
      if (!listening_->IsMeant(message->topic, levels) || !levels) continue;
      return scenario::Said{levels->robot,
                            conformance::MakeHeard(levels->topic_name, *std::move(message), Now(),
                                                   base::WallTime::clock::now())};
    }
    // Where there is no connection, it may be early.
    if (losses_ > 0) std::this_thread::sleep_until(std::min(until, Now() + kPause));
    return std::nullopt;
  }

  [[nodiscard]] scenario::TimePoint Now() const override { return steady_clock::now(); }
  [[nodiscard]] std::size_t losses() const override { return losses_; }
  [[nodiscard]] bool IsStopped() const override { return observer_.IsStopped(); }

 private:
  static constexpr std::chrono::milliseconds kPause{10};

  const ScenarioRequest& request_;
  Observer& observer_;
  delivery::Recorder recorder_;
  std::optional<Listening> listening_;
  std::size_t losses_ = 0;
};

}  // namespace

Status TestScenarios(const ScenarioRequest& request, const Environment& environment,
                     const ScenarioProgress& progress, Observer& observer) {
  BrokerStage stage(request, observer);
  if (auto open = stage.Open(environment); !open) return open;
  scenario::Player player(stage);
  for (const auto& suite : request.suites) {
    for (const auto& test : suite.tests) {
      scenario::TestEnd end;
      if (!test.skip.empty() || stage.IsStopped()) {
        end.finding = conformance::Skipped(test.skip.empty() ? "interrupted before" : test.skip);
      } else {
        observer.Wait("testing " + base::Printable(test.name), steady_clock::time_point::max(),
                      "Ctrl-C ends it");
        end = player.Play(test);
        observer.Wait("");
      }
      progress(suite, test, end);
    }
  }
  return stage.Close();
}

}  // namespace fleetpub::app
