// Plays the steps of one test. Time, broker and processes are the Stage's, so that tests run in
// virtual time.
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/conformance/run.h"
#include "app/scenario/scenario.h"

namespace fleetpub::app::scenario {

using conformance::CaseFinding;
using conformance::Heard;
using conformance::TimePoint;

/// How a command ended.
struct CommandEnd {
  enum class Kind : std::uint8_t { kDone, kFailed, kTrouble };
  Kind kind = Kind::kDone;            ///< kTrouble: it says nothing of the robot
  std::vector<std::string> outcomes;  ///< `FINISHED`, for each message
  std::string why;                    ///< when it is not done; printable
  std::vector<std::string> evidence;  ///< `KIT/0001 instantActions headerId 5`
};

/// A command that runs. It has ended when the destructor returns.
class RunningCommand {
 public:
  RunningCommand() = default;
  RunningCommand(const RunningCommand&) = delete;
  RunningCommand& operator=(const RunningCommand&) = delete;
  virtual ~RunningCommand() = default;

  /// Whether its virtual robots are there.
  [[nodiscard]] virtual bool IsOnline() const = 0;
  /// Nothing while it runs.
  [[nodiscard]] virtual std::optional<CommandEnd> Poll() = 0;
  /// Asks it to end.
  virtual void Terminate() = 0;
};

/// Whose message it is.
struct Said {
  vda5050::RobotAddress robot;
  Heard heard;
};

class Stage {
 public:
  Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;
  virtual ~Stage() = default;

  /// Errors: it cannot be started.
  [[nodiscard]] virtual Result<std::unique_ptr<RunningCommand>> Start(
      const std::vector<std::string>& words, const std::string& input) = 0;
  /// The next message; nothing at the deadline.
  [[nodiscard]] virtual std::optional<Said> Next(TimePoint until) = 0;
  [[nodiscard]] virtual TimePoint Now() const = 0;
  /// How often the connection was lost.
  [[nodiscard]] virtual std::size_t losses() const { return 0; }
  [[nodiscard]] virtual bool IsStopped() const { return false; }
};

struct TestEnd {
  CaseFinding finding;
  const Step* step = nullptr;  ///< which decided it; null: all were played
  std::chrono::nanoseconds elapsed{0};
};

class Player {
 public:
  /// The stage outlives it.
  explicit Player(Stage& stage) : stage_(stage) {}

  /// Until the first step that does not pass. Its virtual robots are gone then.
  [[nodiscard]] TestEnd Play(const Test& test);

 private:
  // What a robot said on a topic.
  struct Track {
    std::deque<Heard> heard;
    std::size_t next = 0;  // the first one that an await may look at

    [[nodiscard]] bool HasHole(std::size_t from) const;
  };
  using Finding = std::optional<CaseFinding>;  // nothing: the step passes

  void Begin();
  void Mark();
  void Take(Said said);
  template <class Done>
  bool Listen(std::chrono::milliseconds time, Done done);
  void AwaitLatecomers();
  [[nodiscard]] Track& Of(const Step& step) { return tracks_[{step.robot, step.topic}]; }

  [[nodiscard]] Finding Do(const Step& step);
  [[nodiscard]] Finding Simulate(const Step& step);
  [[nodiscard]] Finding Send(const Step& step);
  [[nodiscard]] Finding Expect(const Step& step);
  [[nodiscard]] Finding Await(const Step& step);
  [[nodiscard]] Finding Capture(const Step& step);
  [[nodiscard]] Result<std::unique_ptr<RunningCommand>> Start(const Step& step);
  [[nodiscard]] const Heard* FindLast(const Step& step);
  [[nodiscard]] std::string FindUnmet(const Step& step, const Heard& heard) const;
  [[nodiscard]] CaseFinding Missing(const Step& step, const Track& track, std::string what) const;

  Stage& stage_;
  std::map<std::pair<vda5050::RobotAddress, std::string>, Track> tracks_;
  Variables variables_;
  std::vector<std::unique_ptr<RunningCommand>> robots_;
  std::size_t losses_ = 0;  // when the step began
  bool has_sent_ = false;   // what came of it may still be on its way
};

}  // namespace fleetpub::app::scenario
