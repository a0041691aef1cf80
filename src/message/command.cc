#include "message/command.h"

#include <fmt/format.h>

#include <limits>
#include <string_view>

namespace fleetpub::delivery {

std::string PayloadTemplate::Render(std::uint32_t header_id, base::WallTime now) const {
  const std::string id = counted ? fmt::format("{}", header_id) : std::string();
  return before_id + id + before_time + base::FormatTimestamp(now) + rest;
}

std::size_t PayloadTemplate::LargestSize() const {
  constexpr std::size_t kHeaderId = std::numeric_limits<std::uint32_t>::digits10 + 1;
  constexpr std::size_t kTimestamp = std::string_view("2026-01-02T03:04:05.678Z").size();
  return before_id.size() + kHeaderId + before_time.size() + kTimestamp + rest.size();
}

}  // namespace fleetpub::delivery
