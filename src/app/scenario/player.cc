#include "app/scenario/player.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "vda5050/reports/condition.h"

namespace fleetpub::app::scenario {
namespace {

using conformance::Fault;
using conformance::Inconclusive;
using std::chrono::milliseconds;

std::vector<std::string> Evidence(const Step& step, const Heard& heard) {
  return {base::Printable(step.robot.ToString()) + " " + heard.Evidence()};
}

// What a robot leaves at the broker counts as it is, whenever it was said.
bool IsKept(std::string_view topic) { return topic == "connection" || topic == "factsheet"; }

// A captured value comes from a robot: it must be neither an option nor the name of a file.
bool IsHarmless(const std::string& word) {
  const bool is_number = word.size() > 1 && word.front() == '-' && std::isdigit(word[1]) != 0;
  const auto value = word.find_last_of('=') + 1;  // 0: there is none
  return (is_number || !word.starts_with('-')) && word.substr(0, 1) != "@" &&
         word.substr(value, 1) != "@" && base::Printable(word) == word;
}

}  // namespace

bool Player::Track::HasHole(std::size_t from) const {
  const Heard* before = nullptr;
  for (std::size_t i = from > 0 ? from - 1 : 0; i < heard.size(); ++i) {
    if (heard[i].message.retained) continue;
    if (before != nullptr && conformance::IsHole(*before, heard[i])) return true;
    before = &heard[i];
  }
  return false;
}

// Of what was heard before, only what is kept at the broker still counts.
void Player::Begin() {
  for (auto& [key, track] : tracks_) {
    if (!IsKept(key.second)) track.heard.clear();
    while (track.heard.size() > 1) track.heard.pop_front();
    track.next = 0;
  }
  variables_.clear();
  has_sent_ = false;
}

// What comes from now on may be the answer to what is said now.
void Player::Mark() {
  for (auto& [key, track] : tracks_) {
    const std::size_t size = track.heard.size();
    track.next = IsKept(key.second) && size > 0 ? size - 1 : size;
  }
  has_sent_ = true;
}

void Player::Take(Said said) {
  Track& track = tracks_[{said.robot, said.heard.topic_name}];
  if (!said.heard.message.payload.empty()) return track.heard.push_back(std::move(said.heard));
  track = {};  // a retained message was deleted
}

// Whether it was done by then.
template <class Done>
bool Player::Listen(milliseconds time, Done done) {
  constexpr milliseconds kGlance{20};  // at a command that runs, and at whether somebody stops it
  const TimePoint end = stage_.Now() + time;
  for (;;) {
    if (done()) return true;
    if (stage_.IsStopped() || stage_.Now() >= end) return false;
    if (auto said = stage_.Next(std::min(end, stage_.Now() + kGlance))) Take(*std::move(said));
  }
}

// Whoever sent has heard the robot's answer; it may come here a little later.
void Player::AwaitLatecomers() {
  constexpr milliseconds kOnItsWay{100};
  if (has_sent_) (void)Listen(kOnItsWay, [] { return false; });
  has_sent_ = false;
}

TestEnd Player::Play(const Test& test) {
  const TimePoint start = stage_.Now();
  TestEnd end{.finding = conformance::Pass(fmt::format("{} steps", test.steps.size()))};
  Begin();
  for (const Step& step : test.steps) {
    losses_ = stage_.losses();
    Finding finding = Do(step);
    if (stage_.IsStopped()) finding = Inconclusive("interrupted");
    if (!finding) continue;
    end.finding = *std::move(finding);
    end.step = &step;
    break;
  }
  for (const auto& robot : robots_) robot->Terminate();
  robots_.clear();
  end.elapsed = stage_.Now() - start;
  return end;
}

Player::Finding Player::Do(const Step& step) {
  switch (step.kind) {
    case StepKind::kSimulate:
      return Simulate(step);
    case StepKind::kSend:
      return Send(step);
    case StepKind::kExpect:
      return Expect(step);
    case StepKind::kAwait:
      return Await(step);
    case StepKind::kCapture:
      break;
  }
  return Capture(step);
}

Result<std::unique_ptr<RunningCommand>> Player::Start(const Step& step) {
  std::vector<std::string> words;
  for (const std::string& word : step.words) {
    words.push_back(Expand(word, variables_, Into::kText));
    if (words.back() == word || IsHarmless(words.back())) continue;
    return Fail(ErrorKind::kInvalid, fmt::format("{} makes it {}, which is not put into a command",
                                                 word, base::Printable(words.back())));
  }
  Mark();
  return stage_.Start(words, Expand(step.payload, variables_, Into::kJson));
}

Player::Finding Player::Simulate(const Step& step) {
  auto robots = Start(step);
  if (!robots) return Inconclusive(robots.error().message);
  std::optional<CommandEnd> end;
  const bool is_decided = Listen(step.within, [&] {
    end = (*robots)->Poll();
    return end || (*robots)->IsOnline();
  });
  if (end) return Inconclusive("there is no virtual robot: " + end->why);
  if (!is_decided) {
    return Inconclusive("no virtual robot within " + base::FormatElapsed(step.within));
  }
  robots_.push_back(*std::move(robots));
  return std::nullopt;
}

Player::Finding Player::Send(const Step& step) {
  auto command = Start(step);
  if (!command) return Inconclusive(command.error().message);
  std::optional<CommandEnd> end;
  (void)Listen(step.within, [&] { return (end = (*command)->Poll()).has_value(); });
  if (!end) {
    (*command)->Terminate();
    return Fault("not done within " + base::FormatElapsed(step.within));
  }
  if (end->kind == CommandEnd::Kind::kTrouble) return Inconclusive(end->why, end->evidence);
  if (step.outcome.empty()) {
    if (end->kind == CommandEnd::Kind::kDone) return std::nullopt;
    return Fault(end->why, end->evidence);
  }
  const bool is_so = !end->outcomes.empty() &&
                     std::all_of(end->outcomes.begin(), end->outcomes.end(),
                                 [&](const std::string& one) { return one == step.outcome; });
  if (is_so) return std::nullopt;
  return Fault(fmt::format("{} in place of {}{}{}",
                           end->outcomes.empty() ? "nothing" : base::Join(end->outcomes, ", "),
                           step.outcome, end->why.empty() ? "" : ": ", end->why),
               end->evidence);
}

std::string Player::FindUnmet(const Step& step, const Heard& heard) const {
  if (!heard.json.IsObject()) return "it is no JSON object";
  std::vector<std::string> unmet;
  for (const std::string& text : step.conditions) {
    const auto condition = vda5050::ParseCondition(Expand(text, variables_, Into::kText));
    const auto why = condition ? vda5050::Unmet(*condition, heard.json)
                               : std::optional(condition.error().message);
    if (why) unmet.push_back(*why);
  }
  return base::Join(unmet, ", ");
}

CaseFinding Player::Missing(const Step& step, const Track& track, std::string what) const {
  if (stage_.losses() != losses_) {
    return Inconclusive(what + ", but the connection was lost meanwhile");
  }
  if (track.heard.empty()) {
    return Fault(fmt::format("no {} came within {}", step.topic, base::FormatElapsed(step.within)));
  }
  auto evidence = Evidence(step, track.heard.back());
  if (track.HasHole(track.next)) return Inconclusive(what + ", but messages are missing", evidence);
  return Fault(std::move(what), std::move(evidence));
}

Player::Finding Player::Await(const Step& step) {
  Track& track = Of(step);
  std::size_t looked = track.next;
  std::string unmet;
  const bool came = Listen(step.within, [&] {
    looked = std::min(looked, track.heard.size());
    for (; looked < track.heard.size(); ++looked) {
      unmet = FindUnmet(step, track.heard[looked]);
      if (unmet.empty()) return true;
    }
    return false;
  });
  if (!came) {
    const std::string time = base::FormatElapsed(step.within);
    return Missing(step, track,
                   unmet.empty() ? fmt::format("no {} came within {}", step.topic, time)
                                 : fmt::format("not within {}: {}", time, unmet));
  }
  track.next = looked;
  return std::nullopt;
}

// The last message; null: none came within the step's time.
const Heard* Player::FindLast(const Step& step) {
  AwaitLatecomers();
  Track& track = Of(step);
  (void)Listen(step.within, [&] { return !track.heard.empty(); });
  return track.heard.empty() ? nullptr : &track.heard.back();
}

Player::Finding Player::Expect(const Step& step) {
  const Heard* last = FindLast(step);
  Track& track = Of(step);
  if (last == nullptr) return Missing(step, track, fmt::format("no {} came", step.topic));
  const std::size_t first = track.heard.size() - 1;
  std::size_t looked = first;
  std::string unmet;
  (void)Listen(step.hold, [&] {
    looked = std::min(looked, track.heard.size());
    while (unmet.empty() && looked < track.heard.size()) {
      last = &track.heard[looked++];
      unmet = FindUnmet(step, *last);
    }
    return !unmet.empty();
  });
  if (!unmet.empty()) return Fault(unmet, Evidence(step, *last));
  const bool is_whole = stage_.losses() == losses_ && !track.HasHole(first + 1);
  if (step.hold.count() == 0 || is_whole) return std::nullopt;
  return Inconclusive("kept as far as was heard, but messages are missing");
}

Player::Finding Player::Capture(const Step& step) {
  const Heard* last = FindLast(step);
  if (last == nullptr) return Missing(step, Of(step), fmt::format("no {} came", step.topic));
  const base::JsonValue* value = vda5050::FindByPath(step.path, last->json);
  if (value == nullptr || value->IsObject() || value->IsArray() || value->IsNull()) {
    return Fault(fmt::format("{} {}", base::Printable(step.path),
                             value == nullptr ? "is not there" : "is no text, number or boolean"),
                 Evidence(step, *last));
  }
  variables_[step.name].CopyFrom(*value, variables_[step.name].GetAllocator());
  return std::nullopt;
}

}  // namespace fleetpub::app::scenario
