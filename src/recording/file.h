// Files of lines, compressed or not.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

namespace fleetpub::recording {

/// A file that is written to its end, compressed when its name ends in `.gz` or `.zst`. One thread at
/// a time.
class OutputFile {
 public:
  /// A new one that only its owner may read. Errors: ErrorKind::kLedger, also when it is there.
  [[nodiscard]] static Result<OutputFile> Create(const std::filesystem::path& path);

  OutputFile(OutputFile&&) noexcept;
  OutputFile& operator=(OutputFile&&) noexcept;
  ~OutputFile();

  /// Whole lines. Uncompressed they are in the file then, whatever becomes of the process.
  [[nodiscard]] Status Write(std::string_view lines);
  /// What was written can be read, whatever becomes of the process.
  [[nodiscard]] Status Flush();
  [[nodiscard]] Status Close();
  /// Bytes of the file.
  [[nodiscard]] std::uint64_t size() const;

 private:
  struct Codec;
  explicit OutputFile(std::unique_ptr<Codec> codec);
  std::unique_ptr<Codec> codec_;
};

/// Lines of a file, whichever way it is compressed. One thread at a time.
class InputFile {
 public:
  static constexpr std::size_t kLongestLine = std::size_t{96} * 1024 * 1024;

  /// `-` is standard input. Errors: ErrorKind::kLedger.
  [[nodiscard]] static Result<InputFile> Open(const std::filesystem::path& path);

  InputFile(InputFile&&) noexcept;
  InputFile& operator=(InputFile&&) noexcept;
  ~InputFile();

  /// The next line without its end, valid until the next call; nothing at the end, be it that of a
  /// compressed file that was cut off. Errors: ErrorKind::kInvalid for a line that is too long, after
  /// which the next call gives the one behind it; kLedger, after which nothing comes.
  [[nodiscard]] Result<std::optional<std::string_view>> Next();
  /// The last line had no end, or the compressed data none.
  [[nodiscard]] bool is_cut_off() const;

 private:
  struct Codec;
  explicit InputFile(std::unique_ptr<Codec> codec);
  std::unique_ptr<Codec> codec_;
};

}  // namespace fleetpub::recording
