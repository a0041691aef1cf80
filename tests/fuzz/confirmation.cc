// What a robot says while we wait. The first line names the action; each further one is `c`, `s` or
// `f` (connection, state, factsheet; upper case: retained) and a payload.
#include <cctype>
#include <memory>
#include <vector>

#include "base/json.h"
#include "fuzz/fuzz.h"
#include "vda5050/messages/user_message.h"
#include "vda5050/tracking/action_tracker.h"

using namespace fleetpub;

namespace {

const vda5050::RobotAddress kRobot{"K", "1"};

std::vector<std::shared_ptr<message::ResponseTracker>> AllFor(std::string_view action) {
  std::vector<std::shared_ptr<message::ResponseTracker>> all;
  static const auto order =
      base::ParseJson(R"({"orderId":"o","orderUpdateId":1,"nodes":[{"nodeId":"n"}],"edges":[]})");
  for (const vda5050::Version version : vda5050::kVersions) {
    vda5050::Dialect dialect;
    dialect.version = version;
    for (const auto end : {vda5050::WaitFor::kAccepted, vda5050::WaitFor::kFinished}) {
      if (auto one = vda5050::TrackInstantAction(kRobot, dialect,
                                                 {std::string(action), "a", "", "", {}}, end))
        all.push_back(std::move(*one));
      if (auto one = vda5050::TrackUserMessage(kRobot, dialect, "order", *order, end))
        all.push_back(std::move(*one));
    }
  }
  return all;
}

}  // namespace

FUZZ(text) {
  auto [action, rest] = fuzz::Cut(text, '\n');
  for (const auto& tracker : AllFor(action)) {
    tracker->Published(7);
    for (std::string_view lines = rest; !lines.empty();) {
      const auto [line, others] = fuzz::Cut(lines, '\n');
      lines = others;
      if (line.empty()) continue;
      for (const std::string& topic : tracker->Topics()) {
        const std::string name = topic.substr(topic.rfind('/') + 1);
        if (name[0] != std::tolower(static_cast<unsigned char>(line[0]))) continue;
        const bool ended = tracker->progress().ended;
        const auto status = tracker->progress().status;
        tracker->Receive({topic, line.substr(1), line[0] < 'a'});
        // An end is final.
        fuzz::Require(!ended ||
                      (tracker->progress().ended && tracker->progress().status == status));
      }
    }
  }
}
