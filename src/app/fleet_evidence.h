// What a fleet was heard to say, folded into what a diagnosis needs: of each topic counts and
// extremes, no messages. Memory grows with robots, not with time.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/time.h"
#include "mqtt/transport.h"
#include "vda5050/reports/discovery.h"
#include "vda5050/rules/conformance.h"

namespace fleetpub::app {

/// When a message came: by our clock, and since the listening began.
struct Arrival {
  base::WallTime at;
  std::chrono::nanoseconds elapsed{0};
};

/// How the header ids of live messages follow each other.
struct HeaderIds {
  std::size_t messages = 0;  ///< that have one
  std::size_t missing = 0;   ///< messages that have none
  std::size_t skipped = 0;   ///< ids that lie between two messages
  std::size_t repeated = 0;  ///< of another message than the one before
  std::size_t falls = 0;
  std::size_t resumed =
      0;  ///< after a fall the count went on where it had been before: two publish
  std::optional<std::uint64_t> last = {};
  std::optional<std::uint64_t> before_fall = {};

  void Take(std::optional<std::uint64_t> id);
};

/// Silences between live messages. Each counts from `since` at the earliest.
struct Rhythm {
  std::chrono::nanoseconds longest{0};
  std::chrono::nanoseconds last{0};

  void Take(std::chrono::nanoseconds elapsed, std::chrono::nanoseconds since);
  /// The longest, that at the end included.
  [[nodiscard]] std::chrono::nanoseconds FindSilence(std::chrono::nanoseconds end,
                                                     std::chrono::nanoseconds since) const;
};

/// Timestamps of live messages against our clock.
struct Clock {
  std::size_t backwards = 0;                            ///< older than the message before
  std::optional<std::chrono::nanoseconds> offset = {};  ///< theirs less ours, where it is least
  std::optional<base::WallTime> last = {};

  void Take(const vda5050::MessageHeader& header, base::WallTime ours);
};

/// One topic of one robot.
struct TopicEvidence {
  std::string topic;
  bool is_retained = false;  ///< the broker has a message for whoever comes
  std::size_t live = 0;
  HeaderIds ids;
  Rhythm rhythm;
  Clock clock;
  std::set<std::string> versions;  ///< in which its messages are; a few
  /// What is wrong with members of the header, by pointer (`/version`): the first of each.
  std::map<std::string, std::string, std::less<>> header_faults;
  std::size_t invalid = 0;       ///< messages that break their schema otherwise
  std::string violation;         ///< the first
  std::size_t last_payload = 0;  ///< its hash
};

/// What a factsheet says that is judged.
struct FactsheetEvidence {
  std::string fault;  ///< why it cannot be read
  std::size_t actions = 0;
  std::optional<std::chrono::nanoseconds> usual_interval = {};  ///< between states
};

/// A robot at one place: `uagv/v2`.
struct PlaceEvidence {
  vda5050::TopicLevels levels;                  ///< of the last topic that was heard
  std::map<std::string, TopicEvidence> topics;  ///< by name: `state`
  std::optional<vda5050::ConnectionMessage> connection = {};
  std::optional<FactsheetEvidence> factsheet = {};
  /// Its connection message came then, or our connection was opened again: what was not heard before
  /// is no fault.
  std::chrono::nanoseconds since{0};
  std::set<std::string> full_lists;  ///< errors of its last state that say that a list is full

  [[nodiscard]] const TopicEvidence* Find(const std::string& topic_name) const;
  [[nodiscard]] bool IsOnline() const;
  [[nodiscard]] bool SendsStates() const;
  [[nodiscard]] bool IsThere() const { return IsOnline() || SendsStates(); }
};

using RobotEvidence = std::map<std::string, PlaceEvidence>;  ///< by TopicLevels::Place

class FleetEvidence {
 public:
  /// `conformance` must outlive it.
  explicit FleetEvidence(const vda5050::Conformance& conformance) : conformance_(&conformance) {}

  void Take(const mqtt::Message& message, const vda5050::TopicLevels& levels,
            const Arrival& arrival);
  /// At the end. What is retained comes in one burst, and a broker drops what is not read at once.
  void ValidateRetained();
  /// The connection was lost until now: what was missed meanwhile is no robot's fault.
  void Resume(std::chrono::nanoseconds elapsed);

  [[nodiscard]] const std::map<vda5050::RobotAddress, RobotEvidence>& robots() const {
    return robots_;
  }

 private:
  void Validate(const mqtt::Message& message, TopicEvidence& evidence) const;

  const vda5050::Conformance* conformance_;
  std::map<vda5050::RobotAddress, RobotEvidence> robots_;
  std::vector<std::pair<mqtt::Message, TopicEvidence*>> retained_;  // not validated yet
};

}  // namespace fleetpub::app
