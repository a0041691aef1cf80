// Waits for the targets' own word: feeds what arrives to the ResponseTrackers and tells each command's
// end.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/result.h"
#include "message/report.h"
#include "message/response_tracker.h"
#include "mqtt/transport.h"

namespace fleetpub::delivery {

struct WaitOptions {
  /// How long a target may take to show that it knows the command: a silent robot may take 30 s to
  /// report.
  std::chrono::milliseconds seen{35'000};
  /// How long it may then take to end.
  std::chrono::milliseconds done{600'000};
  /// Both together, from the first publishing on, however often it is sent again; instead of the two.
  std::optional<std::chrono::milliseconds> total;
  /// How often a command that was not seen is sent again, with the same action ids.
  int resend = 0;
};

/// Who is waited for, as somebody who looks on wants to know.
struct Waiting {
  std::size_t commands = 0;  ///< that are waited for
  /// Of these the one whose time is up next, and what it last said.
  std::string target;
  bool seen = false;
  std::string message;
  std::chrono::steady_clock::time_point published;
  std::chrono::steady_clock::time_point limit;
};

/// Follows commands that were published, any number of them one after the other: what has ended is
/// forgotten. Knows no connection: it is fed.
class PendingCommands {
 public:
  using Clock = std::chrono::steady_clock;
  using Key = std::uint64_t;
  /// Told once for each command when its end is known; the report is complete.
  using EndHook = std::function<void(Key key, message::Report report)>;
  /// What a target said before its end (ResponseTracker::TakeNews). May be empty.
  using NewsHook = std::function<void(std::string_view line)>;
  using Now = std::function<Clock::time_point()>;

  /// `now` is another one in tests.
  PendingCommands(const WaitOptions& options, EndHook ended, NewsHook news = {},
                  Now now = Clock::now);

  /// Registers a command under the caller's key before it is published.
  void Track(Key key, std::shared_ptr<message::ResponseTracker> tracker);

  [[nodiscard]] bool IsTracked(Key key) const { return tracked_.contains(key); }

  /// The command did not leave.
  void Forget(Key key);

  /// The topics and filters of the watched commands, each once.
  [[nodiscard]] std::vector<std::string> Topics() const;
  [[nodiscard]] std::size_t topics() const { return by_topic_.size() + by_filter_.size(); }
  [[nodiscard]] bool Follows(const std::string& topic) const {
    return by_topic_.contains(topic) || by_filter_.contains(topic);
  }

  /// The command left; `report` says how, and is completed when the end is known.
  void Published(Key key, message::Report report);

  /// A message arrived.
  void Deliver(const mqtt::Message& message);

  /// Ends those whose time is up. Returns those that were not seen in time and are to be sent
  /// again.
  [[nodiscard]] std::vector<Key> Expire();

  /// Ends all that are waited for: nothing more will be heard. Their reports say what they last
  /// said, too.
  void EndAll(message::CommandStatus status, const Error& reason);

  /// Published and not ended.
  [[nodiscard]] std::size_t waiting() const { return waiting_; }

  [[nodiscard]] Waiting DescribeWaiting() const;

  /// When somebody's time is up next; the end of time when nobody waits.
  [[nodiscard]] Clock::time_point NextLimit() const;

 private:
  struct Tracked {
    std::shared_ptr<message::ResponseTracker> tracker;
    message::Report report = {};
    Clock::time_point started = {};  // asking for the topic, as its report tells
    Clock::time_point published = {};
    Clock::time_point limit = {};
    int repeats = 0;
    bool open = false;
    bool seen = false;
  };
  using Entry = std::unordered_map<Key, Tracked>::value_type;

  using KeysByTopic = std::unordered_map<std::string, std::set<Key>>;
  KeysByTopic& MapFor(const std::string& topic);
  void Update(Entry& entry);
  void TellNews(message::ResponseTracker& tracker) const;
  void SetLimit(Entry& entry, Clock::time_point limit);
  void SetLimitToBeSeen(Entry& entry, Clock::time_point now);
  void End(Entry& entry, message::CommandStatus status, std::optional<ErrorKind> error,
           std::string message);
  [[nodiscard]] std::chrono::milliseconds PatienceToBeSeen() const;

  WaitOptions options_;
  EndHook ended_;
  NewsHook news_;
  Now now_;
  std::unordered_map<Key, Tracked> tracked_;
  KeysByTopic by_topic_;
  KeysByTopic by_filter_;                               // with wildcards
  std::set<std::pair<Clock::time_point, Key>> limits_;  // of those that are waited for
  std::size_t waiting_ = 0;
};

}  // namespace fleetpub::delivery
