#include "dispatch/command.h"

#include <fmt/format.h>

namespace fleetpub::dispatch {

std::string PayloadTemplate::Render(std::uint32_t header_id, base::WallTime now) const {
  const std::string id = counted ? fmt::format("{}", header_id) : std::string();
  return before_id + id + before_time + base::FormatTimestamp(now) + rest;
}

}  // namespace fleetpub::dispatch
