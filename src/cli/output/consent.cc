#include "cli/output/consent.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <string>

#include "app/targets.h"
#include "base/text.h"
#include "cli/output/output.h"

namespace fleetpub::cli {
namespace {

// `Resume 46 of 49 robots (3 offline) at mqtts://north (profile north)`.
std::string FormatQuestion(const app::ConsentRequest& request) {
  const std::size_t all = request.robots.size();
  const std::string what = request.title == "stopPause" ? "Resume"
                           : request.title == "startPause"
                               ? "Pause"
                               : fmt::format("Send {} to", base::Printable(request.title));
  const std::string many = request.offline == 0
                               ? fmt::format("{}", all)
                               : fmt::format("{} of {}", all - request.offline, all);
  const std::string offline =
      request.offline == 0 ? "" : fmt::format(" ({} offline)", request.offline);
  return fmt::format("{} {} robots{} at {}", what, many, offline, request.site);
}

bool Agrees(const std::string& question, const std::function<void(int)>& await) {
  Print(stderr, question + "? [y/N] ");
  std::fflush(stderr);
  if (await) await(STDIN_FILENO);
  std::string answer;
  char c = 0;
  while (answer.size() < 16 && read(STDIN_FILENO, &c, 1) == 1 && c != '\n') answer += c;
  return base::EqualsIgnoringCase(answer, "y") || base::EqualsIgnoringCase(answer, "yes");
}

}  // namespace

Status AskOnTerminal(const std::string& question, const std::string& refusal,
                     const std::function<void(int)>& await) {
  if (isatty(STDIN_FILENO) == 0 || isatty(STDERR_FILENO) == 0) {
    return Fail(ErrorKind::kUsage, refusal);
  }
  if (Agrees(question, await)) return {};
  return Fail(ErrorKind::kUsage, "nothing was sent: not confirmed");
}

Status AskForConsent(const app::ConsentRequest& request) {
  return AskOnTerminal(
      fmt::format("{}\n{}", app::FormatRobotList(request.robots), FormatQuestion(request)),
      fmt::format("nothing was sent: {} means {} robots at {} ({}): --yes sends to all of "
                  "them",
                  base::Printable(request.set), request.robots.size(), request.site,
                  app::FormatRobotList(request.robots)),
      request.await);
}

}  // namespace fleetpub::cli
