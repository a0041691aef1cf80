#include "cli/output/pager.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

namespace fleetpub::cli {
namespace {

bool IsWanted(std::string_view pager) {
  const char* const terminal = std::getenv("TERM");
  const bool is_dumb = terminal == nullptr || std::string_view(terminal) == "dumb";
  return isatty(STDOUT_FILENO) == 1 && !is_dumb && !pager.empty() && pager != "cat";
}

}  // namespace

bool ShowInPager(std::string_view text) {
  const char* const wished = std::getenv("PAGER");
  const char* const pager = wished == nullptr ? "less" : wished;
  if (!IsWanted(pager)) return false;
  setenv("LESS", "FRX", 0);  // as git does: what fits into the screen is only printed
  std::FILE* const stream = popen(pager, "w");  // NOLINT(cert-env33-c): the user's own choice
  if (stream == nullptr) return false;
  std::signal(SIGINT, SIG_IGN);  // that is for the pager
  std::fwrite(text.data(), 1, text.size(), stream);
  const int status = pclose(stream);
  // Of the shell: not executable, not found.
  return !WIFEXITED(status) || (WEXITSTATUS(status) != 126 && WEXITSTATUS(status) != 127);
}

}  // namespace fleetpub::cli
