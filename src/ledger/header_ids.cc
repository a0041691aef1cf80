#include "ledger/header_ids.h"

#include <fmt/format.h>

#include <chrono>
#include <limits>

namespace fleetpub::ledger {
namespace {

std::uint32_t NextId(std::optional<std::uint32_t> last, HeaderIdStart start) {
  if (last) return *last + 1;  // wraps, as a uint32 headerId does
  if (start == HeaderIdStart::kZero) return 0;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::seconds>(now).count());
}

}  // namespace

Result<std::uint32_t> ChooseId(const Draft& draft, std::optional<std::uint32_t> last,
                               HeaderIdStart start) {
  if (draft.expected_header_id && last && *draft.expected_header_id != *last + 1) {
    return Fail(ErrorKind::kPreflight,
                fmt::format("somebody else sent to {} meanwhile, under header id {}: look again, "
                            "then try again",
                            draft.topic, *last));
  }
  if (!draft.header_id) return NextId(last, start);
  constexpr auto kHighest = std::numeric_limits<std::uint32_t>::max();
  if (!last || *last == kHighest || *draft.header_id > *last) return *draft.header_id;
  return Fail(
      ErrorKind::kUsage,
      fmt::format(
          "header id {} is not above {}, the last one on topic {}: give a higher one, or none",
          *draft.header_id, *last, draft.topic));
}

}  // namespace fleetpub::ledger
