#include "app/listen.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"
#include "delivery/subscription.h"
#include "delivery/topic_filter.h"

namespace fleetpub::app {
namespace {

using vda5050::RobotPattern;
using vda5050::TopicLevels;

// Whether every topic of `filter` is one of `other`: a broker would send its messages twice.
bool IsCovered(const std::string& filter, const std::string& other) {
  if (filter.ends_with('#') && !other.ends_with('#')) return false;
  return delivery::Matches(other, filter);
}

std::vector<std::string> WithoutCovered(std::vector<std::string> filters) {
  std::sort(filters.begin(), filters.end());
  filters.erase(std::unique(filters.begin(), filters.end()), filters.end());
  const auto all = filters;
  std::erase_if(filters, [&](const std::string& filter) {
    return std::any_of(all.begin(), all.end(), [&](const std::string& other) {
      return other != filter && IsCovered(filter, other);
    });
  });
  return filters;
}

// Which messages are meant.
class Choice {
 public:
  static Result<Choice> Make(ListenRequest& request, const config::Config& config, Log& log) {
    Choice choice(request);
    TargetRequest words = std::move(request.targets);
    if (words.words.empty()) words.all = true;
    if (auto ok = choice.CheckTopics(); !ok) return Fail(std::move(ok.error()));
    auto targets = ResolveTargets(std::move(words), config, log);
    if (!targets) return Fail(std::move(targets.error()));
    choice.targets_ = *std::move(targets);
    auto resolver = DialectResolver::Make(request.vda, config);
    if (!resolver) return Fail(std::move(resolver.error()));
    auto schemes = resolver->Schemes();
    if (!schemes) return Fail(std::move(schemes.error()));
    choice.schemes_ = *std::move(schemes);
    choice.patterns_ = choice.targets_.include.patterns;
    for (const auto& robot : choice.targets_.include.robots) {
      choice.patterns_.push_back(RobotPattern::Of(robot));
      auto addressed = resolver->Resolve(robot);
      if (!addressed) return Fail(std::move(addressed.error()));
      choice.AddScheme(addressed->dialect->topics);
    }
    return choice;
  }

  [[nodiscard]] Result<std::vector<std::string>> Filters() const {
    if (!request_->filters.empty()) return WithoutCovered(request_->filters);
    std::vector<std::string_view> topics(request_->topics.begin(), request_->topics.end());
    if (topics.empty()) topics.assign(vda5050::kTopicNames.begin(), vda5050::kTopicNames.end());
    std::vector<std::string> filters;
    for (const vda5050::TopicScheme& scheme : schemes_) {
      for (const RobotPattern& pattern : patterns_) {
        auto some = vda5050::DiscoveryFilters(scheme, pattern.Filter(), topics);
        if (!some) return some;
        filters.insert(filters.end(), some->begin(), some->end());
      }
    }
    return WithoutCovered(std::move(filters));
  }

  /// The levels of a robot's topic. One that tells no manufacturer is of a robot that is named.
  [[nodiscard]] std::optional<TopicLevels> Read(const std::string& topic) const {
    for (const vda5050::TopicScheme& scheme : schemes_) {
      if (scheme.Names("{manufacturer}")) {
        if (auto levels = Read(scheme, topic, "")) return levels;
        continue;
      }
      for (const vda5050::RobotAddress& robot : targets_.include.robots) {
        auto levels = Read(scheme, topic, robot.manufacturer);
        if (levels && levels->robot == robot) return levels;
      }
    }
    return std::nullopt;
  }

  /// Filters find more than patterns do.
  [[nodiscard]] bool IsMeant(const std::optional<TopicLevels>& levels) const {
    if (!request_->filters.empty()) return true;
    if (!levels || targets_.IsExcepted(levels->robot)) return false;
    return std::any_of(patterns_.begin(), patterns_.end(),
                       [&](const RobotPattern& pattern) { return pattern.Matches(levels->robot); });
  }

 private:
  explicit Choice(const ListenRequest& request) : request_(&request) {}

  static std::optional<TopicLevels> Read(const vda5050::TopicScheme& scheme,
                                         const std::string& topic,
                                         const std::string& manufacturer) {
    auto levels = vda5050::ReadTopic(scheme, topic, manufacturer);
    const auto& names = vda5050::kTopicNames;
    const bool is_one =
        levels && std::find(names.begin(), names.end(), levels->topic_name) != names.end();
    return is_one ? levels : std::nullopt;
  }

  [[nodiscard]] Status CheckTopics() const {
    for (const std::string& topic : request_->topics) {
      const auto& names = vda5050::kTopicNames;
      if (std::find(names.begin(), names.end(), topic) != names.end()) continue;
      const auto nearest = base::Nearest(topic, names);
      return Fail(
          ErrorKind::kUsage,
          fmt::format("VDA 5050 has no topic {}{}; --filter takes others", base::Printable(topic),
                      nearest ? fmt::format(": did you mean {}?", *nearest) : ""));
    }
    return {};
  }

  void AddScheme(const vda5050::TopicScheme& scheme) {
    if (std::find(schemes_.begin(), schemes_.end(), scheme) == schemes_.end()) {
      schemes_.push_back(scheme);
    }
  }

  const ListenRequest* request_;
  Targets targets_;
  std::vector<vda5050::TopicScheme> schemes_;
  std::vector<RobotPattern> patterns_;
};

}  // namespace

struct Listening::Parts {
  ListenRequest request;
  std::optional<Choice> choice = {};
  mqtt::ServerInfo server = {};
  std::vector<std::string> filters = {};
  std::optional<delivery::Subscription> subscription = {};
};

Listening::Listening(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Listening::Listening(Listening&& other) noexcept = default;
Listening::~Listening() = default;

const mqtt::ServerInfo& Listening::server() const { return parts_->server; }
const std::vector<std::string>& Listening::filters() const { return parts_->filters; }
delivery::Subscription& Listening::subscription() { return *parts_->subscription; }

bool Listening::IsMeant(const std::string& topic,
                        std::optional<vda5050::TopicLevels>& levels) const {
  levels = parts_->choice->Read(topic);
  return parts_->choice->IsMeant(levels);
}

Result<Listening> Listening::Open(ListenRequest request, const Environment& environment,
                                  delivery::ReconnectHooks hooks, Log& log) {
  auto parts = std::make_unique<Parts>(Parts{.request = std::move(request)});
  auto choice = Choice::Make(parts->request, environment.config, log);
  if (!choice) return Fail(std::move(choice.error()));
  parts->choice = *std::move(choice);
  auto filters = parts->choice->Filters();
  if (!filters) return Fail(std::move(filters.error()));
  parts->filters = *std::move(filters);
  auto link = Connect(environment, log);
  if (!link) return Fail(std::move(link.error()));
  parts->server = link->transport->server();
  hooks.open = link->connection.open;
  auto subscription =
      delivery::Subscription::Open(std::move(link->transport), parts->filters, std::move(hooks),
                                   parts->request.end, parts->request.qos);
  if (!subscription) return Fail(std::move(subscription.error()));
  parts->subscription = *std::move(subscription);
  return Listening(std::move(parts));
}

Status Listen(ListenRequest request, const Environment& environment, ListenObserver& observer,
              Log& log) {
  auto listening = Listening::Open(std::move(request), environment,
                                   {.open = {},
                                    .lost = [&](const Error& error) { observer.Lost(error); },
                                    .again = [&] { observer.ConnectedAgain(); }},
                                   log);
  if (!listening) return Fail(std::move(listening.error()));
  if (auto begun = observer.Begin(listening->server(), listening->filters()); !begun) return begun;
  Status taken;
  auto read = listening->subscription().Read(
      [&](const mqtt::Message& message) {
        std::optional<TopicLevels> levels;
        if (!listening->IsMeant(message.topic, levels)) return false;
        taken = observer.Take(message, levels ? &*levels : nullptr);
        return !taken.has_value();
      },
      [&] { return observer.GoesOn(); });
  if (read && taken) listening->subscription().Disconnect();
  return taken ? read : taken;
}

}  // namespace fleetpub::app
