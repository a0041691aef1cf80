#include "base/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace fleetpub::base {

Result<std::string> ReadAll(int descriptor, std::string_view name, std::size_t limit) {
  std::string content;
  std::array<char, 65536> chunk{};
  for (;;) {
    const ssize_t count = read(descriptor, chunk.data(), chunk.size());
    if (count == 0) return content;
    if (count < 0) {
      if (errno == EINTR) continue;
      return Fail(ErrorKind::kLedger,
                  fmt::format("cannot read {}: {}", name, std::strerror(errno)));
    }
    content.append(chunk.data(), static_cast<std::size_t>(count));
    if (content.size() > limit) {
      return Fail(ErrorKind::kLedger,
                  fmt::format("{} is too large: more than {} bytes", name, limit));
    }
  }
}

bool IsTyped(const std::filesystem::path& path) { return path == "-" && isatty(STDIN_FILENO) == 1; }

Result<std::string> ReadFile(const std::filesystem::path& path, std::size_t limit) {
  if (path == "-") return ReadAll(STDIN_FILENO, "standard input", limit);
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    return Fail(ErrorKind::kLedger,
                fmt::format("cannot open {}: {}", path.string(), std::strerror(errno)));
  }
  auto content = ReadAll(descriptor, path.string(), limit);
  close(descriptor);
  return content;
}

}  // namespace fleetpub::base
