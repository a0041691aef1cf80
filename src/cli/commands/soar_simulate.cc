#include "cli/commands/soar_simulate.h"

#include <fmt/format.h>

#include "base/text.h"
#include "simulator/platform_runner.h"
#include "soar/message.h"

namespace fleetpub::cli {
namespace {

Result<simulator::PlatformSettings> MakeSettings(const SoarSimulation& simulation) {
  simulator::PlatformSettings settings;
  auto prefix = soar::ParsePrefix(simulation.prefix);
  if (!prefix) return Fail(std::move(prefix.error()));
  settings.prefix = *std::move(prefix);
  settings.stop_at = simulation.stop_at;
  settings.delay = simulation.delay;
  settings.status_interval = simulation.status_interval;
  settings.silent = simulation.silent;
  return settings;
}

}  // namespace

void ShowEvent(std::string_view name, const simulator::Event& event, Output& output) {
  const std::string line = base::Printable(fmt::format("{}: {}", name, event.text));
  if (event.kind == simulator::Event::Kind::kFault) {
    output.Warn(line);
  } else {
    output.Debug(line);
  }
}

Result<ExitCode> RunSoarSimulation(const SoarSimulation& simulation, const Context& context) {
  Output& output = context.output;
  if (simulation.destinations.empty()) {
    return Fail(ErrorKind::kUsage,
                "name at least one platform, such as soar.planet-ocean.ecosub.eco1");
  }
  auto settings = MakeSettings(simulation);
  if (!settings) return Fail(std::move(settings.error()));
  schema::Registry registry(context.options.schema_directory);
  const auto fleet =
      simulator::PlatformFleet::Make(*std::move(settings), simulation.destinations, registry,
                                     [&](std::string_view name, const simulator::Event& event) {
                                       ShowEvent(name, event, output);
                                     });
  if (!fleet) return Fail(fleet.error());
  auto connect = MakeConnectOptions(context);
  if (!connect) return Fail(std::move(connect.error()));

  simulator::RunOptions run{.connect = *std::move(connect)};
  run.connect.properties = {};  // they are a command's; where a platform is does not expire
  run.duration = simulation.duration;
  run.stopped = simulation.stopped;
  run.on_lost = [&](const Error& error) { output.Lost(error); };
  run.on_ready = [&] {
    simulation.on_ready();
    const std::size_t count = (*fleet)->size();
    Print(stderr,
          fmt::format("fleetpub: {} online at {}, SoAR {}\n", base::Counted(count, "platform"),
                      run.connect.brokers.front().ToString(), soar::kFormatVersion));
  };
  if (auto ended = simulator::RunPlatforms(**fleet, run); !ended) return Fail(ended.error());
  return ExitCode::kDone;
}

}  // namespace fleetpub::cli
