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

using vda5050::RobotAddress;

bool Agrees(std::span<const RobotAddress> robots) {
  Print(stderr, fmt::format("{}\nSend to these {} robots? [y/N] ", app::FormatRobotList(robots),
                            robots.size()));
  std::fflush(stderr);
  std::string answer;
  char c = 0;
  while (answer.size() < 16 && read(STDIN_FILENO, &c, 1) == 1 && c != '\n') answer += c;
  return base::EqualsIgnoringCase(answer, "y") || base::EqualsIgnoringCase(answer, "yes");
}

}  // namespace

Status AskForConsent(std::span<const RobotAddress> robots, std::string_view set) {
  if (isatty(STDIN_FILENO) == 0 || isatty(STDERR_FILENO) == 0) {
    return Fail(ErrorKind::kUsage,
                fmt::format("nothing was sent: {} means {} robots ({}): --yes sends to all of them",
                            base::Printable(set), robots.size(), app::FormatRobotList(robots)));
  }
  if (Agrees(robots)) return {};
  return Fail(ErrorKind::kUsage, "nothing was sent: not confirmed");
}

}  // namespace fleetpub::cli
