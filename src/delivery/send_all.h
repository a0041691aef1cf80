// Sends commands as they are made, through a CommandSession, and waits for their ends: as fast as
// the rate, the batches and those that are still waited for allow.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <utility>

#include "base/result.h"
#include "delivery/command_session.h"
#include "delivery/rate_limiter.h"
#include "message/command.h"

namespace fleetpub::delivery {

/// So many wait for their targets at once: no further one is commanded before some have answered.
inline constexpr std::size_t kMostWaiting = 10'000;

/// Where the commands come from.
class CommandSource {
 public:
  CommandSource() = default;
  CommandSource(const CommandSource&) = delete;
  CommandSource& operator=(const CommandSource&) = delete;
  virtual ~CommandSource() = default;

  /// How many targets still have to get theirs.
  [[nodiscard]] virtual std::size_t left() const = 0;
  /// Valid commands for the next targets, `most` at most, until the next call. Reports on targets
  /// that get none.
  [[nodiscard]] virtual Result<std::span<const message::Command>> Next(std::size_t most) = 0;
  /// Reports that those left get nothing, and why.
  virtual void GiveUp(const Error& reason) = 0;
};

/// Commands that are there already. They and the sink must outlive it.
class CommandList final : public CommandSource {
 public:
  explicit CommandList(std::span<const message::Command> commands, ReportSink report = {})
      : commands_(commands), report_(std::move(report)) {}

  [[nodiscard]] std::size_t left() const override { return commands_.size(); }
  [[nodiscard]] Result<std::span<const message::Command>> Next(std::size_t most) override;
  void GiveUp(const Error& reason) override;

 private:
  std::span<const message::Command> commands_;
  ReportSink report_;
};

struct SendAllOptions {
  std::size_t batch = SendOptions{}.batch;
  RateLimiter rate;
  /// Called before each wait. May be empty.
  std::function<void(const CommandSession& session)> waits;
  /// Whether to stop: what is left is given up, and nobody is waited for any more. May be empty.
  std::function<bool()> is_stopped;
  /// Readable from then on; asked before each wait. May be empty.
  std::function<int()> stop_descriptor;
};

/// Sends what the source makes and waits until nothing is waited for. When the connection is lost,
/// the source gives up what is left, and those that wait are waited for. Errors: the source's own;
/// or all fit one batch and could not be subscribed to, so that nothing was sent.
[[nodiscard]] Status SendAll(CommandSource& source, CommandSession& session,
                             SendAllOptions options);

}  // namespace fleetpub::delivery
