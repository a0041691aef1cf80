// Reads recordings: ours, whole or cut off, in one file or in parts, and those of other programs.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>

#include "base/result.h"
#include "recording/bytes.h"
#include "recording/entry.h"
#include "recording/file.h"

namespace fleetpub::recording {

/// What is to be told of a recording once it was read.
struct Faults {
  std::uint64_t unreadable = 0;  ///< lines that were passed over
  std::string first;             ///< where the first was, and why
  bool is_cut_off = false;       ///< it ends within a line, or without a foot where it has a head
  bool is_altered = false;       ///< it is not what its foot says
};

/// One thread at a time.
class Reader {
 public:
  /// Of `shift.jsonl`, where it is not there, `shift.0001.jsonl` and so on; `-` is standard input.
  /// Errors: ErrorKind::kLedger.
  [[nodiscard]] static Result<Reader> Open(const std::filesystem::path& path);

  /// The next entry, in the order of the file; nothing at the end. What cannot be read is passed over
  /// and noted. Errors: ErrorKind::kLedger; kInvalid: nothing in it could be read.
  [[nodiscard]] Result<std::optional<Entry>> Next();
  /// The same of messages alone.
  [[nodiscard]] Result<std::optional<Message>> NextMessage();

  [[nodiscard]] const Faults& faults() const { return faults_; }

 private:
  Reader(std::deque<std::filesystem::path> parts, InputFile file);
  [[nodiscard]] Result<std::optional<Entry>> Parse(std::string_view line);
  void Note(const Error& error);
  void EndFile();

  std::deque<std::filesystem::path> parts_;  // the first is being read
  InputFile file_;
  Moment last_;
  std::optional<base::WallTime> start_;  // of files that say no t
  std::uint64_t line_ = 0;
  std::uint64_t entries_ = 0;
  std::uint64_t count_ = 0;  // messages of this file
  bool has_head_ = false;    // this file
  bool has_foot_ = false;
  bool is_torn_ = false;  // its last line
  Sha256 sum_;
  std::string row_;  // of CSV, that goes on
  Faults faults_;
};

/// `shift.jsonl.zst` and 2 → `shift.0002.jsonl.zst`.
[[nodiscard]] std::filesystem::path PartPath(const std::filesystem::path& path, int part);

}  // namespace fleetpub::recording
