// Reading lines as they arrive, however many there are.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

namespace fleetpub::base {

/// Holds the descriptor and the part of the input that has been read but not handed out. Belongs to
/// one thread.
class LineReader {
 public:
  static constexpr std::size_t kLongestLine = std::size_t{64} * 1024 * 1024;

  /// `-` is standard input. Errors: as ReadFile.
  [[nodiscard]] static Result<LineReader> Open(const std::filesystem::path& path);

  LineReader(LineReader&& other) noexcept;
  LineReader& operator=(LineReader&&) = delete;
  ~LineReader();

  /// The next line without its end, valid until the next call; nothing after the last one. Blocks
  /// until it is whole. A last line need not have an end. Errors: ErrorKind::kLedger, with the name
  /// and the system's reason, after which there is nothing more; kInvalid for a line longer than
  /// `longest`, after which the next call gives the line behind it.
  [[nodiscard]] Result<std::optional<std::string_view>> Next(std::size_t longest = kLongestLine);

  /// Whether Next(), with the same limit, would return without blocking. Reads what has arrived.
  [[nodiscard]] bool Ready(std::size_t longest = kLongestLine);

  /// Readable when Ready() may have become true.
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  LineReader(int descriptor, std::string name);
  [[nodiscard]] bool HasWhole(std::size_t longest);
  void Drop();
  void Fill();

  int descriptor_;
  std::string name_;
  std::string buffer_;
  std::size_t next_ = 0;     // of what is not handed out yet
  std::size_t scanned_ = 0;  // no line ends between next_ and here
  bool ended_ = false;
  bool dropping_ = false;  // the rest of a line that was too long
  bool is_first_ = true;   ///< nothing was handed out yet
  std::optional<Error> trouble_;
};

}  // namespace fleetpub::base
