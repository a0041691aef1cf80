// The last header id of each topic a second time, beside the database.
//
// A write-ahead log that is damaged ends early: SQLite then takes what stood behind for never
// written, without a word, and ids would be given again. So would they by a ledger that was lost,
// or put back from a copy. The topics' lock file (topic_locks.h) has room for a mark per topic,
// which tells: ids go on above the higher of the two.
//
// Marks are an aid, never the truth: not synced, left out when they cannot be written, and a later
// topic may take the place of an earlier one (65,536 places). Damage to one is noticed, and it
// counts for nothing.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

namespace fleetpub::ledger {

/// The file is open as long as this lives.
class HeaderIdCheckpoints {
 public:
  /// Without a lock file beside this ledger there are no marks. One that this user may only read
  /// can be read.
  explicit HeaderIdCheckpoints(const std::filesystem::path& ledger);
  HeaderIdCheckpoints(const HeaderIdCheckpoints&) = delete;
  HeaderIdCheckpoints& operator=(const HeaderIdCheckpoints&) = delete;
  ~HeaderIdCheckpoints();

  [[nodiscard]] std::optional<std::uint32_t> Read(std::string_view topic) const;
  /// The caller holds the topic's lock, and the id is durable in the ledger.
  void Write(std::string_view topic, std::uint32_t last) const;

 private:
  int fd_;
};

/// The later of what the ledger and the mark say. Ids wrap: later is what lies less than half of
/// their range ahead.
[[nodiscard]] std::optional<std::uint32_t> LaterId(std::optional<std::uint32_t> recorded,
                                                   std::optional<std::uint32_t> marked);

}  // namespace fleetpub::ledger
