// A command on its way, in terms that no protocol owns. The protocols build Commands; delivery
// moves them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/time.h"
#include "message/finding.h"
#include "message/response_tracker.h"

namespace fleetpub::message {

/// A payload with holes for what is known only when it is sent: the header id and the timestamp.
/// It reads `before_id` id `before_time` timestamp `rest`; without ids, `before_id` is empty and
/// nothing stands for it.
struct PayloadTemplate {
  std::string before_id;
  std::string before_time;
  std::string rest;
  bool counted = true;

  [[nodiscard]] std::string Render(std::uint32_t header_id, base::WallTime now) const;
  /// Bytes at most, whatever the header id.
  [[nodiscard]] std::size_t LargestSize() const;
};

/// An action of a command, as the ledger and reports name it.
struct ActionRef {
  std::string type;
  std::string id;

  friend bool operator==(const ActionRef&, const ActionRef&) = default;
};

/// A payload that a target may understand which does not understand the first one.
struct OtherWay {
  PayloadTemplate payload;
  std::string note;  ///< what is different, for people
};

struct Command {
  std::string reference;  ///< the caller's own word for it, handed back with its report
  std::string target;     ///< as people name it: `KIT/0001`
  std::string protocol;   ///< `vda5050`, `soar`
  std::string version;
  bool version_assumed = false;  ///< nobody said that the robot speaks it
  std::string topic;             ///< the full MQTT topic
  std::string schema;            ///< by name: `vda5050/3.0.0/instantActions`
  TextRules text_rules;          ///< may be empty
  /// A robot's quirk: this member of the payload stands for that one of the schema. May be empty.
  std::pair<std::string, std::string> renamed_member;
  std::vector<ActionRef> actions;
  PayloadTemplate payload;
  /// How it is sent the first time that it is sent again. Never for what moves anything.
  std::optional<OtherWay> other_way = {};
  std::optional<std::uint32_t> header_id;  ///< asked for outright
  /// It was made of what was sent before: it leaves only under this header id, so that nothing else
  /// was sent on the topic meanwhile.
  std::optional<std::uint32_t> expected_header_id = {};
  std::vector<std::string> warnings;         ///< what the builder noticed
  std::shared_ptr<ResponseTracker> tracker;  ///< how its end is recognised; null: nobody waits
};

}  // namespace fleetpub::message
