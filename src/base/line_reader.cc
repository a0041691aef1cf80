#include "base/line_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/text.h"

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
      ended_(other.ended_),
      dropping_(other.dropping_),
      is_first_(other.is_first_),
      trouble_(std::move(other.trouble_)) {}

LineReader::~LineReader() {
  if (descriptor_ > STDIN_FILENO) close(descriptor_);
}

Result<std::optional<std::string_view>> LineReader::Next(std::size_t longest) {
  while (!HasWhole(longest)) Fill();
  if (trouble_) return Fail(*std::exchange(trouble_, std::nullopt));
  if (ended_ && next_ == buffer_.size()) return std::nullopt;
  const std::size_t end = std::min(buffer_.find('\n', scanned_), buffer_.size());
  const std::size_t size = end - next_;
  if (size > longest) {
    Drop();
    return Fail(ErrorKind::kInvalid,
                fmt::format("{} has a line of more than {} bytes", name_, longest));
  }
  std::string_view line = std::string_view(buffer_).substr(next_, size);
  if (std::exchange(is_first_, false)) line = WithoutByteOrderMark(line);
  next_ = scanned_ = std::min(end + 1, buffer_.size());
  return line;
}

bool LineReader::Ready(std::size_t longest) {
  while (!HasWhole(longest)) {
    pollfd arrived{descriptor_, POLLIN, 0};
    if (poll(&arrived, 1, 0) <= 0) return false;
    Fill();
  }
  return true;
}

// Whether there is something to hand out: a line, the end, trouble.
bool LineReader::HasWhole(std::size_t longest) {
  if (dropping_) Drop();
  const std::size_t end = buffer_.find('\n', scanned_);
  if (end != std::string::npos || ended_ || trouble_) return true;
  scanned_ = buffer_.size();
  return !dropping_ && scanned_ - next_ > longest;
}

// Forgets the line that begins here, as far as it has come.
void LineReader::Drop() {
  const std::size_t end = buffer_.find('\n', scanned_);
  dropping_ = end == std::string::npos && !ended_;
  next_ = scanned_ = end == std::string::npos ? buffer_.size() : end + 1;
}

void LineReader::Fill() {
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
  if (count >= 0) return;
  trouble_ =
      Error{ErrorKind::kLedger, fmt::format("cannot read {}: {}", name_, std::strerror(reason))};
}

}  // namespace fleetpub::base
