#include "app/doctor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <utility>

#include "app/listen.h"
#include "base/text.h"
#include "delivery/retained.h"

namespace fleetpub::app {
namespace {

using std::chrono::steady_clock;
using vda5050::RobotAddress;
using vda5050::RobotPattern;
using vda5050::TopicLevels;

constexpr std::size_t kMostAskedByName = 1'000;

// Without these a fleet control is blind.
bool IsNeeded(std::string_view topic_name) {
  return topic_name == "connection" || topic_name == "state" || topic_name == "factsheet";
}

// Whoever examines one site.
class Doctor final : private ListenObserver {
 public:
  Doctor(const DoctorRequest& request, const Environment& environment, const DiagnosisHook& tell,
         Log& log)
      : request_(request),
        environment_(environment),
        tell_(tell),
        log_(log),
        registry_(environment.schema_directory) {}

  Result<std::size_t> Run() {
    if (auto ok = ReadRequest(); !ok) return Fail(std::move(ok.error()));
    if (environment_.recording) {
      Tell("broker", Health::kUnknown, "a recording is read in its place");
    } else if (auto is_there = ExamineBroker(); !is_there || !*is_there) {
      return is_there ? Result<std::size_t>(0) : Fail(std::move(is_there.error()));
    }
    if (!request_.listens) return 0;
    conformance_.emplace(vda5050::ConformanceOptions{.scheme = scheme_}, registry_);
    evidence_.emplace(*conformance_);
    if (auto ok = ListenToRobots(); !ok) return Fail(std::move(ok.error()));
    evidence_->ValidateRetained();
    if (!environment_.recording) TellPublishing();
    ExamineFleet(*evidence_, listening_, tell_);
    return evidence_->robots().size();
  }

 private:
  Status Begin(const mqtt::ServerInfo& /*server*/,
               const std::vector<std::string>& /*filters*/) override {
    start_ = steady_clock::now();
    if (!environment_.recording) {
      log_.Wait("listening to the robots", start_ + request_.duration,
                "Ctrl-C: judge by what was heard");
    }
    if (request_.begin) request_.begin();
    return {};
  }
  Status Take(const mqtt::Message& message, const TopicLevels* levels) override {
    if (levels != nullptr) evidence_->Take(message, *levels, {environment_.Now(), elapsed()});
    return {};
  }
  void Lost(const Error& error) override { log_.Lost(error); }
  void ConnectedAgain() override {
    evidence_->Resume(elapsed());
    log_.ConnectedAgain();
  }
  Result<bool> GoesOn() override {
    if (!environment_.recording && elapsed() >= request_.duration) return false;
    return request_.goes_on ? request_.goes_on() : true;
  }
  [[nodiscard]] std::chrono::nanoseconds elapsed() const {
    return environment_.recording ? environment_.recording->elapsed()
                                  : steady_clock::now() - start_;
  }

  void Tell(std::string_view check, Health health, std::string text, Remedy remedy = {},
            ErrorKind kind = ErrorKind::kBroker) const {
    tell_({check, health, environment_.site, std::move(text), std::move(remedy), kind});
  }

  Status ReadRequest() {
    TargetRequest words;
    words.words = request_.targets.words;
    words.except = request_.targets.except;
    words.all = words.words.empty();
    auto targets = ResolveTargets(std::move(words), environment_.config, log_);
    if (!targets) return Fail(std::move(targets.error()));
    targets_ = *std::move(targets);
    const auto resolver = DialectResolver::Make(request_.vda, environment_.config);
    if (!resolver) return Fail(resolver.error());
    scheme_ = resolver->common().topics;
    listening_.named = targets_.include.robots;
    patterns_ = targets_.include.patterns;
    for (const RobotAddress& robot : listening_.named) {
      patterns_.push_back(RobotPattern::Of(robot));
      words_.push_back(robot.ToString());
    }
    // Standard input has been read by now.
    std::copy_if(
        request_.targets.words.begin(), request_.targets.words.end(), std::back_inserter(words_),
        [](const std::string& word) { return word.find_first_of("*?") != std::string::npos; });
    return {};
  }

  // False: it cannot be listened to.
  Result<bool> ExamineBroker() {
    auto link = Connect(environment_, log_);
    if (!link) {  // it says what to do itself
      Tell("broker", Health::kProblem, link.error().message, {}, link.error().kind);
      return false;
    }
    const mqtt::ServerInfo server = link->transport->server();
    listening_.knows_retained = !server.KeepsNothing();
    listening_.broker = server.broker;
    TellServer(server);
    if (auto ok = ExamineRights(*link); !ok) return Fail(std::move(ok.error()));
    if (link->transport != nullptr) link->transport->Disconnect();
    if (!request_.listens) return true;
    listening_.expected = FindExpectedRobots(
        environment_, server, [&](const RobotAddress& robot) { return FindScheme(robot); });
    return true;
  }

  [[nodiscard]] std::optional<vda5050::TopicScheme> FindScheme(const RobotAddress& robot) const {
    const bool is_meant =
        !targets_.IsExcepted(robot) &&
        std::any_of(patterns_.begin(), patterns_.end(),
                    [&](const RobotPattern& pattern) { return pattern.Matches(robot); });
    return is_meant ? std::optional(scheme_) : std::nullopt;
  }

  void TellServer(const mqtt::ServerInfo& server) const {
    if (server.KeepsNothing()) {
      Tell("broker", Health::kProblem, "keeps no retained messages: who is there stays unknown",
           {.advice = "allow retained messages in the broker's configuration"});
    } else {
      Tell("broker", Health::kOk,
           fmt::format("reachable with MQTT {}",
                       server.version == mqtt::ProtocolVersion::k5 ? "5" : "3.1.1"));
    }
  }

  Status ExamineRights(Link& link) {
    for (const std::string_view topic_name : vda5050::kTopicNames) {
      std::vector<std::string> filters;
      for (const RobotPattern& pattern : patterns_) {
        auto some = vda5050::DiscoveryFilters(scheme_, pattern.Filter(), {&topic_name, 1});
        if (!some) return Fail(std::move(some.error()));
        filters.insert(filters.end(), some->begin(), some->end());
      }
      const auto granted = TrySubscription(link, filters);
      if (granted) continue;
      listening_.refused.emplace(topic_name);
      Tell("subscribe", IsNeeded(topic_name) ? Health::kProblem : Health::kWarning,
           granted.error().message,
           {.advice = "give the login the right to read these topics (docs/security.md)"});
    }
    if (listening_.refused.empty()) {
      Tell("subscribe", Health::kOk, "every subscription is granted");
    }
    return {};
  }

  // Some brokers end the connection when they refuse: the next topic gets one of its own.
  static Status TrySubscription(Link& link, const std::vector<std::string>& filters) {
    const auto deadline = [&] { return steady_clock::now() + link.connection.timeout; };
    if (link.transport == nullptr) {
      auto again = link.connection.open(deadline());
      if (!again) return Fail(std::move(again.error()));
      link.transport = *std::move(again);
    }
    auto ok = link.transport->Subscribe(filters, mqtt::kListeningQos, deadline());
    if (!ok) link.transport.reset();
    return ok;
  }

  // To try it would reach robots: what the ledger knows of robots that have answered must do.
  void TellPublishing() const {
    if (const auto row = FindAnswer()) {
      return Tell("publish", Health::kOk,
                  fmt::format("{} answered a command on {}", base::Printable(row->target),
                              base::FormatLocal(row->recorded_at)));
    }
    Remedy remedy;
    for (const auto& [robot, places] : evidence_->robots()) {
      if (!places.begin()->second.IsThere()) continue;
      remedy.command = {"fleetpub", "stateRequest", robot.ToString(), "--wait"};
      break;
    }
    Tell("publish", Health::kUnknown,
         "not tried, as it would reach robots; none has answered a command within a week", remedy);
  }

  [[nodiscard]] std::optional<ledger::Record> FindAnswer() const {
    constexpr auto kAnswers = std::to_array<std::string_view>(
        {"ACCEPTED", "FINISHED", "NO_ORDER", "FAILED", "REJECTED", "RETRIABLE"});
    const auto rows = FindRecentRows(environment_, {listening_.broker->ToString()});
    const auto row = std::find_if(rows.rbegin(), rows.rend(), [&](const ledger::Record& one) {
      return std::find(kAnswers.begin(), kAnswers.end(), one.status) != kAnswers.end();
    });
    return row == rows.rend() ? std::nullopt : std::optional(*row);
  }

  Status ListenToRobots();
  [[nodiscard]] std::map<std::string, TopicLevels> FindMissing() const;
  [[nodiscard]] std::string FindRetainedTopic() const;
  Status AskByName();

  const DoctorRequest& request_;
  const Environment& environment_;
  const DiagnosisHook& tell_;
  Log& log_;
  schema::Registry registry_;
  std::optional<vda5050::Conformance> conformance_;
  std::optional<FleetEvidence> evidence_;
  steady_clock::time_point start_;
  Targets targets_;
  std::vector<std::string> words_;  // for whom they stand
  vda5050::TopicScheme scheme_;
  std::vector<RobotPattern> patterns_;
  ListeningFacts listening_;
};

Status Doctor::ListenToRobots() {
  ListenRequest listen{.vda = request_.vda};
  listen.targets.words = words_;
  listen.targets.except = request_.targets.except;
  for (const std::string_view name : vda5050::kTopicNames) {
    if (!listening_.refused.contains(name)) listen.topics.emplace_back(name);
  }
  if (listen.topics.empty()) return {};
  auto listened = Listen(std::move(listen), environment_, *this, log_);
  listening_.elapsed = elapsed();
  log_.Wait("");
  return !listened || environment_.recording ? listened : AskByName();
}

// What should be retained, and was not heard to be.
std::map<std::string, TopicLevels> Doctor::FindMissing() const {
  std::map<std::string, TopicLevels> missing;
  for (const auto& [robot, places] : evidence_->robots()) {
    for (const auto& [name, place] : places) {
      for (const char* const topic_name : {"connection", "factsheet"}) {
        const TopicEvidence* const known = place.Find(topic_name);
        const bool is_known = known != nullptr && known->is_retained;
        if (is_known || listening_.refused.contains(topic_name)) continue;
        auto topic = vda5050::TopicBeside(scheme_, place.levels, topic_name);
        TopicLevels levels = place.levels;
        levels.topic_name = topic_name;
        if (topic) missing.emplace(*std::move(topic), std::move(levels));
      }
    }
  }
  return missing;
}

// A topic of which the broker has a retained message; "" when none was heard.
std::string Doctor::FindRetainedTopic() const {
  for (const auto& [robot, places] : evidence_->robots()) {
    for (const auto& [name, place] : places) {
      for (const auto& [topic_name, known] : place.topics) {
        if (known.is_retained) return known.topic;
      }
    }
  }
  return "";
}

// Some brokers have nothing retained for a filter with wildcards, and a busy one may hand it out
// after we have stopped listening. Before anything is called missing, a message has come that is
// known to be there.
Status Doctor::AskByName() {
  auto missing = FindMissing();
  if (missing.empty() || missing.size() > kMostAskedByName || !listening_.knows_retained) return {};
  auto link = Connect(environment_, log_);
  if (!link) return Fail(std::move(link.error()));
  std::vector<std::string> topics;
  topics.reserve(missing.size() + 1);
  for (const auto& [topic, levels] : missing) topics.push_back(topic);
  const delivery::RetainedOptions options{.marker = FindRetainedTopic()};
  if (!options.marker.empty()) topics.push_back(options.marker);
  auto asked =
      delivery::ReadRetained(*link->transport, topics, options, [&](const mqtt::Message& message) {
        const auto levels = missing.find(message.topic);
        if (levels == missing.end() || !message.retained) return false;
        evidence_->Take(message, levels->second, {environment_.Now(), listening_.elapsed});
        missing.erase(levels);
        return missing.empty();
      });
  if (asked) link->transport->Disconnect();
  return asked;
}

}  // namespace

Result<std::size_t> Diagnose(const DoctorRequest& request, const Environment& environment,
                             const DiagnosisHook& tell, Log& log) {
  return Doctor(request, environment, tell, log).Run();
}

}  // namespace fleetpub::app
