// What a person or a script gets to see while commands are sent.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "app/observer.h"
#include "cli/output/exit_code.h"
#include "cli/output/fleet_summary.h"
#include "cli/output/interrupt.h"
#include "cli/output/output.h"
#include "cli/output/reporter.h"
#include "cli/output/stop_signal.h"

namespace fleetpub::cli {

/// Prints a result for each command as it becomes known; on a terminal, of more than ten robots,
/// only what went wrong, by reasons, at the end. While messages travel, Ctrl-C stops waiting.
class SendingObserver final : public app::Observer {
 public:
  /// kPayloads: of a dry run, with everything else on standard error.
  enum class Show { kResults, kResultsAndProgress, kPayloads };

  /// `site`: where they are sent, as a person reads it. With `no_order_is_fine` a robot that had
  /// nothing to cancel is no trouble.
  SendingObserver(Output& output, Show show, std::string site, bool no_order_is_fine = false)
      : output_(output),
        show_(show),
        site_(std::move(site)),
        no_order_is_fine_(no_order_is_fine),
        reporter_(output) {}

  void Warn(std::string_view text) override { output_.Warn(text); }
  void Info(std::string_view text) override { output_.Info(text); }
  void Debug(std::string_view text) override { output_.Debug(text); }
  [[nodiscard]] Status Consent(const app::ConsentRequest& request) override;
  void Chosen(std::span<const std::string> targets) override;
  void WillSend(std::size_t total) override;
  void Sent() override;
  void Report(const message::Report& report) override;
  void NothingSent(const message::Report& report) override;
  void Waits(const delivery::CommandSession& session) override;
  void Wait(std::string_view what, std::chrono::steady_clock::time_point limit,
            std::string_view hint) override {
    output_.Wait(what, limit, hint);
  }
  [[nodiscard]] bool IsStopped() const override {
    return stop_ && StopSignal::Received().has_value();
  }
  [[nodiscard]] int stop_descriptor() const override { return stop_ ? stop_->descriptor() : -1; }

  /// From now on Ctrl-C stops what is under way and is told of: as from the first Waits() on.
  void ListenForStop();

  /// Once all is done; a summary when progress is shown. Returns the worst result's.
  ExitCode Conclude();

 private:
  Output& output_;
  Show show_;
  std::string site_;
  bool no_order_is_fine_;
  const InterruptGuard interrupt_;
  std::optional<StopSignal> stop_;  // once somebody is waited for
  Reporter reporter_;
  FleetSummary summary_;
  bool is_brief_ = false;             // reasons are told at the end
  std::optional<std::size_t> total_;  // once messages leave
  std::chrono::steady_clock::time_point start_{};
};

}  // namespace fleetpub::cli
