// What a use case tells while it runs. Who called it decides what a person gets to see.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "base/file.h"
#include "base/result.h"
#include "delivery/command_session.h"
#include "message/report.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::app {

/// Sentences for people.
class Log {
 public:
  Log() = default;
  Log(const Log&) = default;
  Log& operator=(const Log&) = default;
  virtual ~Log() = default;

  virtual void Warn(std::string_view text) = 0;
  /// What happens meanwhile.
  virtual void Info(std::string_view text) = 0;
  virtual void Debug(std::string_view text) = 0;
  /// What is waited for from now on (`connecting to mqtt://north`), until when at most, and what a
  /// person may do meanwhile; "": nothing any more.
  virtual void Wait(std::string_view /*what*/,
                    std::chrono::steady_clock::time_point /*limit*/ =
                        std::chrono::steady_clock::time_point::max(),
                    std::string_view /*hint*/ = "") {}

  /// What is read now, and may have to be typed.
  void Reads(const std::filesystem::path& path) {
    if (base::IsTyped(path))
      Info("reading from this terminal: Ctrl-D on a line of its own ends it");
  }
  /// The connection was lost and is opened again.
  void Lost(const Error& error) { Warn(error.message + ": connecting again"); }
  void ConnectedAgain() { Warn("connected again"); }
};

/// What somebody has to agree to.
struct ConsentRequest {
  std::span<const vda5050::RobotAddress> robots;
  std::size_t offline = 0;  ///< so many of them
  std::string_view set;     ///< the word that stands for them
  std::string_view title;   ///< what they are told: `stopPause`
  std::string_view site;    ///< where: `mqtts://north (profile north)`
  /// Returns once the answer can be read there, and keeps the connection until then; may be empty.
  std::function<void(int descriptor)> await = {};
};

/// Whoever sends commands.
class Observer : public Log {
 public:
  /// Whether all of these are meant. Errors: they are not.
  [[nodiscard]] virtual Status Consent(const ConsentRequest& request) = 0;
  /// It is known which targets get the message; a report on each follows.
  virtual void Chosen(std::span<const std::string> targets) = 0;
  /// From now on messages leave, so many in all.
  virtual void WillSend(std::size_t total) = 0;
  /// One more has left.
  virtual void Sent() = 0;
  /// What became of one command, as it becomes known.
  virtual void Report(const message::Report& report) = 0;
  /// Of each target, when nothing at all was sent: the error that says why is returned.
  virtual void NothingSent(const message::Report& report) = 0;
  /// Answers are waited for, or the rate: called before each wait.
  virtual void Waits(const delivery::CommandSession& /*session*/) {}
  /// Whether to stop: what has not left stays, and nobody is waited for any more.
  [[nodiscard]] virtual bool IsStopped() const { return false; }
  /// Readable from then on; asked after Waits.
  [[nodiscard]] virtual int stop_descriptor() const { return -1; }
};

}  // namespace fleetpub::app
