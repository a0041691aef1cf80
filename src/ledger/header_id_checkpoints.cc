#include "ledger/header_id_checkpoints.h"

#include <fcntl.h>
#include <unistd.h>

#include <string>

#include "ledger/ledger_files.h"
#include "ledger/topic_locks.h"

namespace fleetpub::ledger {
namespace {

/// Part of the file's format, as the hash is.
constexpr std::uint64_t kPlaces = 65'536;

struct Mark {
  std::uint32_t last = 0;
  std::uint32_t check = 0;
};
static_assert(sizeof(Mark) == 8, "as in the file");

off_t ComputeOffset(std::string_view topic) {
  return static_cast<off_t>(TopicHash(topic) % kPlaces * sizeof(Mark));
}

/// Of topic and id together: whoever else took the place, and whatever damaged it, has another.
std::uint32_t ComputeCheck(std::string_view topic, std::uint32_t last) {
  const std::uint64_t hash = TopicHash(std::to_string(last).append(" ").append(topic));
  return static_cast<std::uint32_t>(hash >> 32) ^ static_cast<std::uint32_t>(hash);
}

}  // namespace

HeaderIdCheckpoints::HeaderIdCheckpoints(const std::filesystem::path& ledger) {
  const std::string path = ledger.string() + ".locks";
  fd_ = OpenRegular(path.c_str(), O_RDWR);
  if (fd_ < 0) fd_ = OpenRegular(path.c_str(), O_RDONLY);
}

HeaderIdCheckpoints::~HeaderIdCheckpoints() {
  if (fd_ >= 0) close(fd_);
}

std::optional<std::uint32_t> HeaderIdCheckpoints::Read(std::string_view topic) const {
  Mark mark;
  if (pread(fd_, &mark, sizeof mark, ComputeOffset(topic)) != sizeof mark) return std::nullopt;
  if (mark.check != ComputeCheck(topic, mark.last)) return std::nullopt;
  return mark.last;
}

void HeaderIdCheckpoints::Write(std::string_view topic, std::uint32_t last) const {
  const Mark mark{last, ComputeCheck(topic, last)};
  [[maybe_unused]] const auto unmarked = pwrite(fd_, &mark, sizeof mark, ComputeOffset(topic));
}

std::optional<std::uint32_t> LaterId(std::optional<std::uint32_t> recorded,
                                     std::optional<std::uint32_t> marked) {
  if (!recorded) return marked;
  if (!marked) return recorded;
  const bool ahead = static_cast<std::int32_t>(*marked - *recorded) > 0;
  return ahead ? marked : recorded;
}

}  // namespace fleetpub::ledger
