#include "delivery/retained.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace fleetpub::delivery {

namespace {

using std::chrono::steady_clock;

constexpr std::size_t kBrokersQueue = 1'000;

// What many have left takes its time, and it ends.
constexpr std::chrono::seconds kMaxReadTime{60};

// A broker hands out what it has retained in one go: what follows the last wanted message within
// this belongs to it, such as another message of the same robot at another topic.
constexpr std::chrono::milliseconds kBurstGap{2};

Status ReadBurst(mqtt::Transport& transport, const RetainedOptions& options,
                 const MessageCallback& take) {
  const mqtt::Deadline end = steady_clock::now() + options.quiet;
  mqtt::Deadline gap = steady_clock::now() + kBurstGap;
  if (options.meanwhile) options.meanwhile();
  do {
    const auto message = transport.Receive(gap);
    if (!message) return Fail(message.error());
    if (!*message) return {};
    take(**message);
    if (!(*message)->retained) return {};
    gap = steady_clock::now() + kBurstGap;
  } while (steady_clock::now() < end);
  return {};
}

// A tenth of a silence may be a pause in what a broker hands out: then what follows comes while the
// filters behind are listened to.
constexpr int kPausesInASilence = 10;

// Decides what is the end of what a broker has retained.
class Silence {
 public:
  // A broker may take long to grant a subscription; what it has retained follows then.
  Silence(const RetainedOptions& options, steady_clock::duration round_trip)
      : options_(options),
        quiet_(std::max<steady_clock::duration>(options.quiet, 2 * round_trip)),
        marked_(options.marker.empty()) {
    const auto now = steady_clock::now();
    most_ = now + std::max<steady_clock::duration>(options.most, quiet_);
    Renew(now);
  }

  void Begin() {
    most_ += steady_clock::now() - start_;
    Renew(steady_clock::now());
  }

  void Hear(const mqtt::Message& message) {
    if (!message.retained) return;
    const auto now = steady_clock::now();
    if (!marked_ && message.topic == options_.marker) {
      marked_ = true;
      most_ = now + quiet_;
    }
    Renew(now);
  }
  [[nodiscard]] mqtt::Deadline end() const { return end_; }
  /// The end of a pause.
  [[nodiscard]] mqtt::Deadline pause() const { return std::min(end_, pause_); }

 private:
  void Renew(mqtt::Deadline now) {
    pause_ = now + quiet_ / kPausesInASilence;
    end_ = marked_ ? std::min(now + quiet_, most_)
                   : std::min(now + std::max<steady_clock::duration>(options_.subscribe, quiet_),
                              start_ + kMaxReadTime);
  }

  const RetainedOptions& options_;
  steady_clock::duration quiet_;
  bool marked_;
  mqtt::Deadline start_ = steady_clock::now();
  mqtt::Deadline most_;
  mqtt::Deadline pause_;
  mqtt::Deadline end_;
};

Status ReadInto(mqtt::Transport& transport, std::span<const std::string> filters,
                const RetainedOptions& options, const auto& subscribe,
                const MessageCallback& take) {
  steady_clock::duration round_trip{0};
  while (!filters.empty()) {
    const auto some = filters.first(std::min(kFiltersAtOnce, filters.size()));
    filters = filters.subspan(some.size());
    const auto asked = steady_clock::now();
    if (auto ok = subscribe(some); !ok) return ok;
    round_trip = steady_clock::now() - asked;
    while (!filters.empty()) {
      const auto message = transport.Receive(steady_clock::now());
      if (!message) return Fail(message.error());
      if (!*message) break;
      if (take(**message)) {
        return ReadBurst(transport, options, take);
      }
    }
  }
  Silence silence(options, round_trip);
  bool is_all = options.behind.empty();
  while (true) {
    const auto message = transport.Receive(is_all ? silence.end() : silence.pause());
    if (!message) return Fail(message.error());
    if (*message) {
      if (take(**message)) return ReadBurst(transport, options, take);
      silence.Hear(**message);
      if (steady_clock::now() < (is_all ? silence.end() : silence.pause())) continue;
    }
    if (std::exchange(is_all, true)) return {};
    if (auto ok = subscribe(options.behind); !ok) return ok;
    silence.Begin();
  }
}

}  // namespace

Status ReadRetained(mqtt::Transport& transport, std::span<const std::string> filters,
                    const RetainedOptions& options, const MessageCallback& take) {
  const auto take_all = [&](const mqtt::Message& message) {
    if (options.also) options.also(message);
    return take(message);
  };
  Subscribed ours;
  Subscribed& subscribed = options.subscribed != nullptr ? *options.subscribed : ours;
  std::vector<std::string> added;
  const auto subscribe = [&](std::span<const std::string> some) -> Status {
    auto ok =
        transport.Subscribe(some, mqtt::kListeningQos, steady_clock::now() + options.subscribe);
    if (!ok) return ok;
    std::copy_if(some.begin(), some.end(), std::back_inserter(added),
                 [&](const std::string& filter) { return subscribed.insert(filter).second; });
    return {};
  };
  auto ok = ReadInto(transport, filters, options, subscribe, take_all);
  if (ok && added.size() <= options.keep) return ok;
  for (const std::string& filter : added) subscribed.erase(filter);
  return ok ? transport.Unsubscribe(added, steady_clock::now() + options.subscribe) : ok;
}

Status ReadAllRetained(mqtt::Transport& transport, std::span<const std::string> filters,
                       RetainedOptions options,
                       const std::function<void(const mqtt::Message&)>& take,
                       const std::function<std::size_t()>& known) {
  options.most = kMaxReadTime;
  for (;;) {
    const std::size_t before = known();
    std::size_t messages = 0;
    auto ok = ReadRetained(transport, filters, options, [&](const mqtt::Message& message) {
      take(message);
      ++messages;
      return false;
    });
    if (!ok || messages < kBrokersQueue || known() == before) return ok;
    options.behind.clear();
  }
}

}  // namespace fleetpub::delivery
