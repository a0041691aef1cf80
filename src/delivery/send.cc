#include "delivery/send.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "delivery/publish_pipeline.h"

namespace fleetpub::delivery {
void ReportNotSent(std::span<const message::Command> commands, const Error& error,
                   const ReportSink& sink) {
  for (const message::Command& command : commands) {
    message::Report report = message::ReportOn(command);
    report.error = error.kind;
    report.message = "not sent: " + error.message;
    sink(report);
  }
}

Status RecordOutcomes(std::span<const message::Report> reports, ledger::Ledger& ledger) {
  std::vector<ledger::Outcome> outcomes;
  outcomes.reserve(reports.size());
  for (const message::Report& report : reports) {
    if (report.ledger_row == 0) continue;  // it came to nothing before it was recorded
    outcomes.push_back({report.ledger_row, std::string(NameOf(report.status)), report.message});
  }
  return ledger.RecordOutcomes(outcomes);
}

Status Send(std::span<const message::Command> commands, mqtt::Transport& transport,
            ledger::Ledger& ledger, const SendOptions& options, const ReportSink& report,
            const SentHook& sent) {
  Status trouble;
  std::optional<Error> broken;
  PublishPipeline pipeline(
      ledger, options, sent, [&](PublishPipeline::Key /*key*/, BatchResult result) {
        if (auto recorded = RecordOutcomes(result.reports, ledger); !recorded && trouble) {
          trouble = std::move(recorded);
        }
        for (const message::Report& done : result.reports) report(done);
        if (result.broken && !broken) broken = std::move(result.broken);
      });
  while (!commands.empty() && !broken) {
    const std::size_t count = std::min(options.batch, commands.size());
    auto left = pipeline.Send(transport, commands.first(count), 0);
    if (left) {
      commands = commands.subspan(count);
      pipeline.Await(transport, commands.empty() ? 0 : PublishPipeline::kMostUnderWay);
    } else {
      broken = std::move(left.error());
    }
  }
  pipeline.Await(transport, 0);
  if (broken) ReportNotSent(commands, *broken, report);
  return trouble;
}

}  // namespace fleetpub::delivery
