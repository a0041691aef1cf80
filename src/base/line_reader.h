// Reading lines as they arrive, however many there are.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

namespace fleetpub::base {

/// Holds the descriptor and the part of the input that has been read but not handed out. Blocks
/// until a line is whole. Belongs to one thread.
class LineReader {
 public:
  static constexpr std::size_t kLongestLine = std::size_t{64} * 1024 * 1024;

  /// `-` is standard input. Errors: as ReadFile.
  [[nodiscard]] static Result<LineReader> Open(const std::filesystem::path& path);

  LineReader(LineReader&& other) noexcept;
  LineReader& operator=(LineReader&&) = delete;
  ~LineReader();

  /// The next line without its end, valid until the next call; nothing after the last one. A last
  /// line need not have an end. Errors: ErrorKind::kLedger, with the name and the system's reason,
  /// or for a line longer than `longest`.
  [[nodiscard]] Result<std::optional<std::string_view>> Next(std::size_t longest = kLongestLine);

 private:
  LineReader(int descriptor, std::string name);
  [[nodiscard]] Status Fill();

  int descriptor_;
  std::string name_;
  std::string buffer_;
  std::size_t next_ = 0;     // of what is not handed out yet
  std::size_t scanned_ = 0;  // no line ends between next_ and here
  bool ended_ = false;
};

}  // namespace fleetpub::base
