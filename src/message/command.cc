#include "message/command.h"

#include <fmt/format.h>

#include <limits>
#include <string_view>

#include "message/report.h"

namespace fleetpub::message {

std::string PayloadTemplate::Render(std::uint32_t header_id, base::WallTime now) const {
  const std::string id = counted ? fmt::format("{}", header_id) : std::string();
  return before_id + id + before_time + base::FormatTimestamp(now) + rest;
}

std::size_t PayloadTemplate::LargestSize() const {
  constexpr std::size_t kHeaderId = std::numeric_limits<std::uint32_t>::digits10 + 1;
  constexpr std::size_t kTimestamp = std::string_view("2026-01-02T03:04:05.678Z").size();
  return before_id.size() + kHeaderId + before_time.size() + kTimestamp + rest.size();
}

Report ReportOn(const Command& command) {
  return {.reference = command.reference,
          .target = command.target,
          .protocol = command.protocol,
          .version = command.version,
          .version_assumed = command.version_assumed,
          .topic = command.topic,
          .actions = command.actions};
}

}  // namespace fleetpub::message
