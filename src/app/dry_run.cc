#include "app/dry_run.h"

#include <utility>

#include "ledger/header_ids.h"

namespace fleetpub::app {

Result<DryRun> DryRun::Open(const LedgerHook& open) {
  auto ledger = open(ledger::OpenMode::kReadOnly);
  if (!ledger) return Fail(std::move(ledger.error()));
  return DryRun(std::move(*ledger));
}

DryRun::DryRun(std::unique_ptr<ledger::Ledger> ledger) : ledger_(std::move(ledger)) {}

Result<message::Report> DryRun::Report(const message::Command& command) {
  message::Report report = message::ReportOn(command);
  report.status = message::CommandStatus::kDryRun;
  if (command.payload.counted) {
    const auto id = NextId(command);
    if (!id) return Fail(id.error());
    report.header_id = *id;
  }
  report.payload =
      command.payload.Render(report.header_id.value_or(0), base::WallTime::clock::now());
  return report;
}

Result<std::uint32_t> DryRun::NextId(const message::Command& command) {
  const ledger::Draft draft{.topic = command.topic, .header_id = command.header_id};
  const auto last = last_ids_.find(command.topic);
  // Behind a last one no ledger's start counts.
  auto id = last == last_ids_.end()
                ? ledger_->Peek(draft)
                : ledger::ChooseId(draft, last->second, ledger::HeaderIdStart::kZero);
  if (id) last_ids_.insert_or_assign(command.topic, *id);
  return id;
}

Status ShowDryRun(delivery::CommandSource& source, const Environment& environment,
                  Observer& observer, const std::function<void(std::size_t)>& explain) {
  auto dry_run = DryRun::Open(environment.ledger);
  if (!dry_run) return Fail(std::move(dry_run.error()));
  while (source.left() > 0) {
    const auto commands = source.Next(delivery::SendOptions{}.batch);
    if (!commands) return Fail(commands.error());
    for (std::size_t i = 0; i < commands->size(); ++i) {
      const auto report = dry_run->Report((*commands)[i]);
      if (!report) return Fail(report.error());
      observer.Report(*report);
      if (explain) explain(i);
    }
  }
  return {};
}

}  // namespace fleetpub::app
