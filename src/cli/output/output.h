// What a person or a script gets to see. Results go to standard output, everything else to standard
// error.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "app/observer.h"
#include "base/result.h"
#include "cli/output/exit_code.h"
#include "cli/output/records.h"
#include "message/report.h"

namespace fleetpub::cli {

/// What a word means, as its colour tells on a terminal.
enum class Tone { kPlain, kGood, kWarn, kBad, kDim };

/// Unlike fmt::print() it does not throw when nothing can be written; of standard output
/// Output::Flush() tells.
void Print(std::FILE* session, std::string_view text);

class WaitingLine;

/// The columns of the terminal behind a descriptor; without limit when it is none.
[[nodiscard]] std::size_t TerminalWidth(int descriptor);

class Output final : public app::Log {
 public:
  struct Settings {
    Format format = Format::kText;
    Records records = {};
    bool quiet = false;               ///< no result lines in text format, no warnings
    bool verbose = false;             ///< the details of errors, and what is done
    std::string_view color = "auto";  ///< `auto`, `always`, `never`
  };

  explicit Output(Settings settings);
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  ~Output() override;

  /// Whether results are objects, in whichever format they are shown.
  [[nodiscard]] bool json() const { return settings_.format != Format::kText; }
  [[nodiscard]] bool verbose() const { return settings_.verbose; }
  [[nodiscard]] bool quiet() const { return settings_.quiet; }

  /// A line of results on standard output.
  void Line(std::string_view text);
  /// The same, of JSON in any format: with nothing in it that a person would not see.
  void JsonLine(std::string_view json);
  /// The same when it is only for people: suppressed by `--quiet`. Too long for the terminal, it is
  /// broken between words.
  void PeopleLine(std::string_view text);
  /// What `--quiet` does not suppress, on standard error.
  void Important(std::string_view text);

  void Warn(std::string_view text) override;
  /// What happens meanwhile; on standard error, suppressed by `--quiet`.
  void Info(std::string_view text) override;
  void Debug(std::string_view text) override;  ///< with `--verbose` only
  /// After a second, a line that counts the seconds, if anyone can see it (CanPass).
  void Wait(std::string_view what, std::chrono::steady_clock::time_point limit,
            std::string_view hint) override;
  void Trace(std::string_view line);
  void PrintError(const Error& error);
  /// The error that ends the command. With `-o json` it also is an object on standard output, unless
  /// results there say it already.
  void PrintFinalError(const Error& error, ExitCode code);

  /// Whether there is anyone to see a passing line: standard error is a terminal, and standard
  /// output no pipe, whose other end may write to the same terminal at any time.
  [[nodiscard]] bool CanPass() const;
  /// A line on standard error that the next one replaces, such as a progress bar, no wider than the
  /// terminal. It is cleared before anything else is written.
  void Pass(std::string_view text);
  /// The same of several lines, each no wider than the terminal.
  void Pass(std::span<const std::string> lines);
  void ClearPassing();
  /// Whether one is shown. Safe in a signal handler.
  [[nodiscard]] static bool HasPassing();

  /// The text in colour: always, never, or when standard output is a terminal and NO_COLOR is not
  /// set.
  [[nodiscard]] std::string Toned(Tone tone, std::string_view text) const;

  /// Remembers that a command has left: from now on trouble with files changes no exit code.
  void SomethingWasSent() { something_was_sent_ = true; }
  [[nodiscard]] bool something_was_sent() const { return something_was_sent_; }

  /// Shows what is buffered to whoever watches, without looking for errors.
  static void FlushNow();

  /// Writes out what is buffered. Nothing could be written (a full disk, a closed pipe): an error.
  [[nodiscard]] Status Flush();

 private:
  Settings settings_;
  bool colour_;
  bool something_was_sent_ = false;
  bool has_lines_ = false;
  std::unique_ptr<WaitingLine> waiting_;
};

/// Broken between words where the terminal behind the descriptor is narrower.
[[nodiscard]] std::string WrappedFor(int descriptor, std::string_view text);

/// One result line for a person. `target_width` aligns several.
[[nodiscard]] std::string ReportText(const message::Report& report, std::size_t target_width,
                                     const Output& output);

/// One result object (docs/manual.md, "JSON").
[[nodiscard]] std::string ReportJson(const message::Report& report);

}  // namespace fleetpub::cli
