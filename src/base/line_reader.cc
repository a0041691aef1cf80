#include "base/line_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace fleetpub::base {

Result<LineReader> LineReader::Open(const std::filesystem::path& path) {
  if (path == "-") return LineReader(STDIN_FILENO, "standard input");
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    return Fail(ErrorKind::kLedger,
                fmt::format("cannot open {}: {}", path.string(), std::strerror(errno)));
  }
  return LineReader(descriptor, path.string());
}

LineReader::LineReader(int descriptor, std::string name)
    : descriptor_(descriptor), name_(std::move(name)) {}

LineReader::LineReader(LineReader&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      name_(std::move(other.name_)),
      buffer_(std::move(other.buffer_)),
      next_(other.next_),
      scanned_(other.scanned_),
      ended_(other.ended_) {}

LineReader::~LineReader() {
  if (descriptor_ > STDIN_FILENO) close(descriptor_);
}

Result<std::optional<std::string_view>> LineReader::Next(std::size_t longest) {
  for (;;) {
    const std::size_t end = buffer_.find('\n', scanned_);
    if (end != std::string::npos || (ended_ && next_ < buffer_.size())) {
      const std::size_t stop = std::min(end, buffer_.size());
      const std::string_view line = std::string_view(buffer_).substr(next_, stop - next_);
      next_ = scanned_ = std::min(stop + 1, buffer_.size());
      return line;
    }
    if (ended_) return std::nullopt;
    scanned_ = buffer_.size();
    if (scanned_ - next_ > longest) {
      return Fail(ErrorKind::kLedger,
                  fmt::format("{} has a line of more than {} bytes", name_, longest));
    }
    if (auto filled = Fill(); !filled) return Fail(std::move(filled.error()));
  }
}

Status LineReader::Fill() {
  constexpr std::size_t kChunk = 256 * std::size_t{1024};
  buffer_.erase(0, next_);
  scanned_ -= next_;
  next_ = 0;
  const std::size_t kept = buffer_.size();
  buffer_.resize(kept + kChunk);
  ssize_t count = 0;
  do {
    count = read(descriptor_, buffer_.data() + kept, kChunk);
  } while (count < 0 && errno == EINTR);
  const int reason = errno;
  buffer_.resize(kept + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  ended_ = count <= 0;
  if (count >= 0) return {};
  return Fail(ErrorKind::kLedger, fmt::format("cannot read {}: {}", name_, std::strerror(reason)));
}

}  // namespace fleetpub::base
