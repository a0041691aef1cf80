// A line of a batch. What it makes has been validated, and is JSON whatever id and time it gets.
#include "app/batch_line.h"

#include "base/json.h"
#include "fuzz/fuzz.h"

using namespace fleetpub;

FUZZ(text) {
  static app::LineParser parser({.check = false}, "");
  app::LineOrigin origin;
  const auto line = parser.Parse(text, origin);
  if (!line) {
    fuzz::Require(!line.error().message.empty());
    return;
  }
  fuzz::Require(!line->commands.empty());
  for (const app::LineCommand& command : line->commands) {
    if (!command.command) continue;  // its robot is asked first
    const std::string payload =
        command.command->payload.Render(4'294'967'295, std::chrono::system_clock::now());
    fuzz::Require(base::ParseJson(payload).has_value());
  }
}
