#include "cli/output/sending_observer.h"

#include <fmt/format.h>
#include <unistd.h>

#include "base/text.h"
#include "cli/output/consent.h"

namespace fleetpub::cli {
namespace {

// More results than these a person does not read one by one.
constexpr std::size_t kMostLines = 10;

}  // namespace

Status SendingObserver::Consent(const app::ConsentRequest& request) {
  return AskForConsent(request);
}

void SendingObserver::Chosen(std::span<const std::string> targets) {
  for (const std::string& target : targets) reporter_.Fit(target);
  is_brief_ = targets.size() > kMostLines && show_ == Show::kResultsAndProgress &&
              !output_.json() && !output_.verbose() && isatty(STDOUT_FILENO) == 1;
  start_ = std::chrono::steady_clock::now();
}

void SendingObserver::WillSend(std::size_t total) {
  total_ = total;
  InterruptGuard::Begin();
}

void SendingObserver::Sent() { output_.SomethingWasSent(); }

void SendingObserver::Report(const message::Report& report) {
  if (report.status == message::CommandStatus::kDryRun) {
    output_.JsonLine(output_.json() ? ReportJson(report) : report.payload);
    return Output::FlushNow();
  }
  if (show_ == Show::kPayloads && !output_.json()) return reporter_.Explain(report);
  message::Report told = report;
  if (no_order_is_fine_ && report.status == message::CommandStatus::kNoOrder) told.error.reset();
  summary_.Add(told);
  if (is_brief_) return reporter_.Count(told);
  reporter_.Show(told);
  Output::FlushNow();
}

void SendingObserver::NothingSent(const message::Report& report) {
  if (output_.json()) output_.Line(ReportJson(report));
}

void SendingObserver::ListenForStop() {
  if (!stop_) stop_.emplace();
}

void SendingObserver::Waits(const delivery::CommandSession& session) {
  ListenForStop();
  if (!output_.CanPass()) return;
  const delivery::Waiting waiting = session.DescribeWaiting();
  const std::string name = base::Printable(waiting.target);
  std::string what;
  if (total_.value_or(0) > 1) {
    what = FormatProgress(summary_, *total_);
    if (waiting.commands > 0) what += "  waiting for " + name;
    if (waiting.commands > 1) what += fmt::format(" and {} more", waiting.commands - 1);
  } else if (waiting.commands > 0) {
    what = fmt::format("waiting for {}: {}", name,
                       waiting.seen && !waiting.message.empty() ? base::Printable(waiting.message)
                       : waiting.seen                           ? "seen"
                                                                : "sent, not yet seen");
  }
  output_.Wait(what, waiting.commands > 0 ? waiting.limit : mqtt::Deadline::max(),
               "Ctrl-C stops waiting, not the robot");
}

ExitCode SendingObserver::Conclude() {
  ExitCode code = reporter_.worst();
  if (const auto signal = StopSignal::Received(); stop_ && signal) code = Worse(code, *signal);
  if (show_ != Show::kResultsAndProgress || !total_) return code;
  const auto elapsed = std::chrono::steady_clock::now() - start_;
  if (output_.json()) {
    output_.Line(summary_.Json(elapsed, code, site_));
    return code;
  }
  const auto names = is_brief_ ? FleetSummary::Names::kByReason : FleetSummary::Names::kByGroup;
  for (const std::string& line : summary_.Lines(elapsed, site_, names)) {
    if (!output_.quiet()) {
      output_.PeopleLine(line);
    } else if (reporter_.worst() != ExitCode::kDone) {
      output_.Important(line);
    }
  }
  return code;
}

}  // namespace fleetpub::cli
