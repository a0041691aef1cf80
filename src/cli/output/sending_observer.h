// What a person or a script gets to see while commands are sent.
#pragma once

#include <chrono>
#include <memory>

#include "app/observer.h"
#include "cli/output/exit_code.h"
#include "cli/output/fleet_summary.h"
#include "cli/output/interrupt.h"
#include "cli/output/output.h"
#include "cli/output/reporter.h"

namespace fleetpub::cli {

/// Prints a result for each command as it becomes known. While it lives, Ctrl-C tells what was
/// sent.
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
  [[nodiscard]] std::function<void()> tick() override;

  /// Once all is done; a summary when progress is shown. Returns the worst result's.
  ExitCode Conclude();

 private:
  Output& output_;
  Show show_;
  std::string site_;
  bool no_order_is_fine_;
  const InterruptGuard interrupt_;
  Reporter reporter_;
  FleetSummary summary_;
  std::unique_ptr<ProgressBar> bar_;
  std::chrono::steady_clock::time_point start_{};
};

}  // namespace fleetpub::cli
