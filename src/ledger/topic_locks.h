// Locks that keep the messages of a topic in the order of their ids, between processes and threads.
//
// SQLite's own lock ends with COMMIT; the message is written after that. So each topic has one byte
// in a second file, `<ledger>.locks`, at an offset hashed from its name, and who sends holds a lock
// on that byte (fcntl(2), open file description locks). The system releases the lock when its
// holder dies, however it dies. What stands in the file is no part of this
// (header_id_checkpoints.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"
#include "ledger/ledger.h"

namespace fleetpub::ledger {

/// FNV-1a. Part of the file's format: all versions must agree on it.
[[nodiscard]] std::uint64_t TopicHash(std::string_view topic);

/// Locks all topics or none, each at least tried once. Who has locked a topic and asks again waits
/// for itself. Two topics may share a byte (one pair in 2^62): they then only wait for each other.
/// The kernel walks all locks of a file for each new one: 500 topics take 2 ms, 10,000 take 0.5 s.
[[nodiscard]] Result<std::unique_ptr<TopicLock>> LockTopics(const std::filesystem::path& ledger,
                                                            std::span<const std::string> topics,
                                                            Deadline deadline);

/// Held while the tables are made.
[[nodiscard]] Result<std::unique_ptr<TopicLock>> LockCreation(const std::filesystem::path& ledger,
                                                              Deadline deadline);

}  // namespace fleetpub::ledger
