#include "cli/output/sending_observer.h"

#include "cli/output/consent.h"

namespace fleetpub::cli {

Status SendingObserver::Consent(const app::ConsentRequest& request) {
  return AskForConsent(request);
}

void SendingObserver::Chosen(std::span<const std::string> targets) {
  for (const std::string& target : targets) reporter_.Fit(target);
  start_ = std::chrono::steady_clock::now();
}

void SendingObserver::WillSend(std::size_t total) {
  InterruptGuard::Begin(total);
  if (show_ == Show::kResultsAndProgress) bar_ = std::make_unique<ProgressBar>(total, output_);
}

void SendingObserver::Sent() {
  InterruptGuard::CountSent();
  output_.SomethingWasSent();
}

void SendingObserver::Report(const message::Report& report) {
  if (report.status == message::CommandStatus::kDryRun) {
    output_.JsonLine(output_.json() ? ReportJson(report) : report.payload);
    return Output::FlushNow();
  }
  if (show_ == Show::kPayloads && !output_.json()) return reporter_.Explain(report);
  summary_.Add(report);
  if (no_order_is_fine_ && report.status == message::CommandStatus::kNoOrder) {
    message::Report fine = report;
    fine.error.reset();
    reporter_.Show(fine);
  } else {
    reporter_.Show(report);
  }
  Output::FlushNow();
}

void SendingObserver::NothingSent(const message::Report& report) {
  if (output_.json()) output_.Line(ReportJson(report));
}

std::function<void()> SendingObserver::tick() {
  if (!bar_ || !bar_->IsPossible()) return {};
  return [this] { bar_->Draw(summary_); };
}

ExitCode SendingObserver::Conclude() {
  const bool has_sent = bar_ != nullptr;
  bar_.reset();
  if (show_ != Show::kResultsAndProgress || !has_sent) return reporter_.worst();
  const auto elapsed = std::chrono::steady_clock::now() - start_;
  if (output_.json()) {
    output_.Line(summary_.Json(elapsed, reporter_.worst(), site_));
  } else {
    for (const std::string& line : summary_.Lines(elapsed, site_)) output_.PeopleLine(line);
  }
  return reporter_.worst();
}

}  // namespace fleetpub::cli
